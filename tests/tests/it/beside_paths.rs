//! A default bake's picture beside the path traced one of the same view, and both as a golden.

use flb_render::{Picture, RenderSettings, Shading, contact_sheet, render, render_reference};
use flb_runtime::{Daylight, SpeciesLight, Transform};
use flb_scene::ClassedMesh;
use flb_tests::default_bake::DefaultBake;

use crate::pictures;

/// Fluence of the sky.
const SKY: f32 = 0.36;

/// Stops: bright enough to judge.
const EXPOSURE: f32 = 3.0;

/// A small picture, before black.
pub(crate) fn settings(bake: &DefaultBake, towards_sun: [f64; 3]) -> RenderSettings {
    RenderSettings {
        width: 96,
        height: 96,
        samples: 8,
        sun: towards_sun,
        ambient: SKY,
        ground: false,
        sky: false,
        shading: Shading::Physical(bake.surfaces()),
        ..RenderSettings::default()
    }
}

/// By the file, and by paths.
pub(crate) fn relit_and_traced(bake: &DefaultBake, settings: &RenderSettings) -> [Picture; 2] {
    let library = bake.library();
    let light = SpeciesLight::load(&library, 0).expect("a file of the default model");
    let daylight = Daylight { towards_sun: settings.sun, sun: 1.0, sky: SKY };
    let lit = light.under(&daylight, &Transform::IDENTITY).expect("a sun");
    let at = |point: [f32; 3], phi: &mut [f32; 3]| lit.at(point, phi);
    let ClassedMesh { mesh, classes } = &bake.mesh;
    let relit = render(mesh, classes, &at, settings, &|_| {}).expect("a plant renders");
    let traced = render_reference(mesh, classes, settings, &|_| {}).expect("a plant renders").picture;
    [relit, traced]
}

/// Holds both against the golden of that name, or writes it anew.
pub(crate) fn check_golden(name: &str, pictures: &[Picture; 2]) {
    let sheet = contact_sheet(pictures, 0).expect("two pictures of one height");
    pictures::check_golden(name, &sheet, EXPOSURE);
}
