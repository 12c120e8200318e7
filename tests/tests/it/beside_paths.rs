//! A default bake's picture beside the path traced one of the same view, and both as a golden.

use flb_render::picture::contact_sheet;
use flb_render::reference::render_reference;
use flb_render::{LightQuery, Lighting, Look, Picture, Portrait, Shading, Species, render_plant};
use flb_runtime::{Daylight, SpeciesLight, Transform};
use flb_scene::ClassedMesh;
use flb_tests::default_bake::DefaultBake;

use crate::pictures;

/// Fluence of the sky.
const SKY: f32 = 0.36;

/// Stops: bright enough to judge.
const EXPOSURE: f32 = 3.0;

/// Small pictures before black: by the file, and by paths.
pub(crate) fn relit_and_traced(bake: &DefaultBake, towards_sun: [f64; 3]) -> [Picture; 2] {
    let library = bake.library();
    let light = SpeciesLight::load(&library, 0).expect("a file of the default model");
    let lighting = Lighting::of(Daylight { towards_sun, sun: 1.0, sky: SKY });
    let lit = light.lit_by(&lighting.daylight, &Transform::IDENTITY).expect("a sun");
    let at = |query: LightQuery, phi: &mut [f32; 3]| lit.at(query.point, phi);
    let ClassedMesh { mesh, classes } = &bake.mesh;
    let plant = Species { mesh, classes, shading: Shading::Physical(bake.surfaces()) };
    let portrait = Portrait { width: 96, height: 96, samples: 8, has_ground: false, ..Portrait::default() };
    let look = Look { has_sky: false, ..Look::default() };
    let relit = render_plant(&plant, &portrait, &lighting, &look, &at, &|_| Ok(())).expect("a plant renders");
    let traced = render_reference(&plant, &portrait, &lighting, &look, &|_| Ok(())).expect("a plant renders");
    [relit, traced.picture]
}

/// Holds both against the golden of that name, or writes it anew.
pub(crate) fn check_golden(name: &str, pictures: &[Picture; 2]) {
    let sheet = contact_sheet(pictures, 0).expect("two pictures of one height");
    pictures::check_golden(name, &sheet, EXPOSURE);
}
