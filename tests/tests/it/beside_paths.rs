//! A default bake's picture beside the path traced one of the same view, and both as a golden.

use flb_render::{Picture, RenderSettings, Shading, Surfaces, contact_sheet, render, render_reference};
use flb_runtime::{Daylight, SpeciesLight, Transform};
use flb_scene::ClassedMesh;
use flb_tests::default_bake::DefaultBake;
use flb_tests::describe::digest_of_floats;

use crate::pictures::{golden_path, read_png, verdict};

/// Fluence of the sky.
const SKY: f32 = 0.36;

/// Stops: bright enough to judge.
const EXPOSURE: f32 = 3.0;

pub fn surfaces(bake: &DefaultBake) -> Surfaces {
    let meta = &bake.baked.fields.meta;
    let (surfaces, _) = meta.physical().expect("the default model");
    Surfaces::of(surfaces, meta)
}

/// A small picture, before black.
pub fn settings(bake: &DefaultBake, towards_sun: [f64; 3]) -> RenderSettings {
    RenderSettings {
        width: 96,
        height: 96,
        samples: 8,
        sun: towards_sun,
        ambient: SKY,
        ground: false,
        sky: false,
        shading: Shading::Physical(surfaces(bake)),
        ..RenderSettings::default()
    }
}

/// By the file, and by paths.
pub fn relit_and_traced(bake: &DefaultBake, settings: &RenderSettings) -> [Picture; 2] {
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

/// Sums of R, G, B.
pub fn light(picture: &Picture) -> [f64; 3] {
    [0, 1, 2].map(|band| picture.rgb.iter().skip(band).step_by(3).map(|v| f64::from(*v)).sum::<f64>())
}

/// Holds both against the golden of that name, or writes it anew.
pub fn check_golden(name: &str, pictures: &[Picture; 2]) {
    let sheet = contact_sheet(pictures, 0).expect("two pictures of one height");
    let [png_path, digest_path] = ["png", "digest"].map(|kind| golden_path(&format!("{name}.{kind}")));
    if std::env::var_os("FLB_WRITE_GOLDEN").is_some() {
        std::fs::write(&png_path, sheet.to_png(EXPOSURE).expect("a picture is a PNG")).expect("writes");
        std::fs::write(&digest_path, digest_of_floats(&sheet.rgb) + "\n").expect("writes");
    }
    let digest = std::fs::read_to_string(digest_path).expect("the golden is there");
    let golden = read_png(&std::fs::read(png_path).expect("the golden is there"));
    assert_eq!(verdict(&sheet, EXPOSURE, digest.trim(), &golden), Ok(()));
}
