use std::time::Duration;

use flb_format::light::SunBasis;
use flb_render::{Indirect, Look, Picture};
use flb_scene::Unobserved;
use flb_scene::scene::{AddedSun, Sunlight};

use crate::backend::GpuCount;
use crate::stream::{Painter, Shot, Show};
use crate::tests::{SIZE, SUN_DEG, apart, look, stand_of, stand_of_paper};
use crate::{
    Backend, FrameSettings, LookSettings, SceneFrame, SceneLook, SceneRenderer, SceneShow, Stage, StageSky,
    frames,
};

const COLOR: [f32; 3] = [2.0, 1.0, 0.25];
const OTHER: AddedSun = AddedSun { sun_deg: [250.0, 15.0], irradiance: [0.125, 0.25, 0.5] };
const NIGHT_DEG: [f64; 2] = [120.0, -5.0];

fn stands() -> [Stage; 3] {
    let harmonics = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
    [stand_of_paper(), stand_of(&SunBasis::Lattice18), stand_of(&harmonics)]
}

/// A frame under a sun in a light.
fn picture(stage: &Stage, sun_deg: [f64; 2], ambient: f32, sunlight: &Sunlight) -> Picture {
    let mut look = look(stage, StageSky::EVEN);
    (look.ambient, look.sunlight) = (ambient, sunlight.clone());
    of_look(stage, sun_deg, look)
}

fn of_look(stage: &Stage, sun_deg: [f64; 2], look: SceneLook) -> Picture {
    taken_by(Backend::Cpu, stage, sun_deg, look)
}

fn taken_by(backend: Backend, stage: &Stage, sun_deg: [f64; 2], look: SceneLook) -> Picture {
    let frame = SceneFrame { sun_deg: Some(sun_deg), ..frame(stage) };
    let renderer = SceneRenderer::new(stage, look, &[frame], backend, &Unobserved);
    renderer.expect("it is read").picture(&frame, &Unobserved).expect("a picture")
}

fn frame(stage: &Stage) -> SceneFrame {
    frames(&stage.scene, &FrameSettings::default()).expect("camera and sun")[0]
}

fn times(picture: &Picture, factor: [f32; 3]) -> Picture {
    let mut black = Picture { rgb: vec![0.0; picture.rgb.len()], ..*picture };
    black.add(picture, factor);
    black
}

fn sum(one: &Picture, other: &Picture) -> Picture {
    let mut sum = one.clone();
    sum.add(other, [1.0; 3]);
    sum
}

#[test]
fn a_sun_of_a_colour_and_a_further_sun_add_up_to_what_each_gives_alone() {
    for stage in stands() {
        let white = Sunlight::default();
        let [first, second] = [SUN_DEG, OTHER.sun_deg].map(|sun| picture(&stage, sun, 0.0, &white));
        let sky = picture(&stage, NIGHT_DEG, 0.4, &white);
        let coloured = Sunlight { irradiance: COLOR, added: Vec::new() };
        let found = picture(&stage, SUN_DEG, 0.4, &coloured);
        let expected = sum(&times(&first, COLOR), &sky);
        // A sky of no light is drawn in the papers' shading, where the sun stands alone.
        let drawn = picture(&stage, NIGHT_DEG, 0.0, &white);
        let expected = sum(&expected, &times(&drawn, COLOR.map(|band| -band)));
        assert!(apart(&found, &expected) < 2e-5, "{}", apart(&found, &expected));
        assert!(apart(&found, &picture(&stage, SUN_DEG, 0.4, &white)) > 0.01);

        let both = Sunlight { irradiance: COLOR, added: vec![OTHER] };
        let found = picture(&stage, SUN_DEG, 0.4, &both);
        let expected = sum(&expected, &times(&second, OTHER.irradiance));
        let expected = sum(&expected, &times(&drawn, OTHER.irradiance.map(|band| -band)));
        assert!(apart(&found, &expected) < 2e-5, "{}", apart(&found, &expected));

        // A further sun below the ground gives nothing, a grey one is no part of its own.
        let sunk = AddedSun { sun_deg: NIGHT_DEG, ..OTHER };
        let grey = Sunlight { irradiance: [3.0; 3], added: vec![sunk] };
        let found = picture(&stage, SUN_DEG, 0.0, &grey);
        let expected = sum(&times(&first, [3.0; 3]), &times(&drawn, [-2.0; 3]));
        assert!(apart(&found, &expected) < 2e-5, "{}", apart(&found, &expected));
    }
}

#[test]
fn a_colour_of_the_sun_is_multiplied_with_that_of_a_clear_sky() {
    let stage = stand_of(&SunBasis::Harmonics { degree: 2, single: true, leaning: true });
    let of = |irradiance| {
        let mut look = look(&stage, StageSky::clear(3.0).expect("a sky"));
        look.look = Look { indirect: Indirect::Off, has_sky: false, ..Look::default() };
        look.sunlight.irradiance = irradiance;
        of_look(&stage, SUN_DEG, look)
    };
    let [white, coloured] = [[1.0; 3], COLOR].map(of);
    assert!(apart(&coloured, &times(&white, COLOR)) < 1e-6);
    assert!(apart(&coloured, &white) > 0.01);
}

#[test]
fn streamed_light_of_several_suns_is_that_of_whole_files() {
    for stage in stands() {
        let sunlight = Sunlight { irradiance: COLOR, added: vec![OTHER] };
        let found = picture(&stage, SUN_DEG, 0.4, &sunlight);
        let mut look = look(&stage, StageSky::EVEN);
        look.sunlight = sunlight;
        let mut painter = Painter::new(&stage, look, 64 << 20).expect("a painter");
        let shot = Shot { eye: frame(&stage).eye, sun_deg: SUN_DEG, show: Show::Whole };
        let streamed = painter.paint_whole(&shot, SIZE, Duration::from_secs(300)).expect("a picture");
        assert!(streamed.progress.is_final);
        assert!(apart(&found, &streamed.picture) < 1e-5, "{}", apart(&found, &streamed.picture));
    }
}

#[test]
fn layers_of_a_frame_add_up_and_alpha_takes_the_sky_away() {
    for stage in &stands()[..2] {
        let mut look = look(stage, StageSky::EVEN);
        look.sunlight = Sunlight { irradiance: COLOR, added: vec![OTHER] };
        let shows = [SceneShow::Light, SceneShow::Direct, SceneShow::Indirect, SceneShow::Base(1)];
        let layers = |shows: &[SceneShow]| {
            let settings = LookSettings { shows: shows.to_vec(), samples: 1, ..LookSettings::default() };
            let mut made = SceneLook::new(stage, &settings, StageSky::EVEN).expect("a look");
            (made.size, made.sunlight) = (SIZE, look.sunlight.clone());
            let look = made;
            let frame = frame(stage);
            let renderer = SceneRenderer::new(stage, look, &[frame], Backend::Cpu, &Unobserved);
            renderer.expect("it is read").layers(&frame, &Unobserved).expect("pictures")
        };
        let with_sky = layers(&shows);
        assert_eq!(with_sky.iter().map(|(show, _)| *show).collect::<Vec<_>>(), shows);
        let light = |layers: &[(SceneShow, Picture)]| sum(&layers[1].1, &layers[2].1);
        assert!(apart(&with_sky[0].1, &light(&with_sky)) < 1e-5);
        assert!(apart(&with_sky[3].1, &with_sky[2].1) > 0.01);
        let alone = layers(&[&shows[..], &[SceneShow::Alpha]].concat());
        assert!(apart(&alone[0].1, &light(&alone)) < 1e-5);
        let alpha = &alone[4].1.rgb;
        let uncovered = alpha.iter().zip(&alone[0].1.rgb).filter(|(alpha, _)| **alpha == 0.0);
        assert!(uncovered.clone().count() > 20 && uncovered.clone().all(|(_, light)| *light == 0.0));
        assert!(alpha.iter().filter(|alpha| **alpha == 1.0).count() > 200);
        // The base is light on plants alone, whatever the sky.
        assert_eq!(apart(&alone[3].1, &with_sky[3].1), 0.0);
    }
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let stage = stand_of(&SunBasis::Lattice18);
    let refused = |shows: &[SceneShow]| {
        let settings = LookSettings { shows: shows.to_vec(), ..LookSettings::default() };
        SceneLook::new(&stage, &settings, StageSky::EVEN).expect_err("it is refused").to_string()
    };
    assert!(refused(&[]).starts_with("nothing is to be shown, expected each of light, direct"));
    assert!(refused(&[SceneShow::Alpha, SceneShow::Light, SceneShow::Alpha]).starts_with("alpha twice"));
    assert_eq!(refused(&[SceneShow::Base(19)]), "base 19 is to be shown: the species have bases 0 to 18");
    assert!(refused(&[SceneShow::Global]).contains("no scene light"));
    let shows = vec![SceneShow::Light, SceneShow::Alpha];
    let large = LookSettings { size: Some([8192, 8192]), shows, ..LookSettings::default() };
    let error = SceneLook::new(&stage, &large, StageSky::EVEN).expect_err("it is refused").to_string();
    assert_eq!(error, "134217728 pixels in all layers together, expected at most 67108864");
    let mut look = look(&stage, StageSky::EVEN);
    look.shows = vec![SceneShow::Light, SceneShow::Alpha];
    let on_gpu = Backend::Gpu(GpuCount::Exactly(1));
    let error = SceneRenderer::new(&stage, look, &[frame(&stage)], on_gpu, &Unobserved).err();
    assert!(error.expect("it is refused").to_string().contains("on the CPU alone"));
}

#[test]
fn a_gpu_adds_up_several_suns_as_the_cpu_does() {
    for stage in &stands()[..2] {
        let light = |sunlight: &Sunlight| {
            let mut look = look(stage, StageSky::EVEN);
            look.sunlight = sunlight.clone();
            look
        };
        let several = Sunlight { irradiance: COLOR, added: vec![OTHER] };
        let found = taken_by(Backend::Gpu(GpuCount::Exactly(1)), stage, SUN_DEG, light(&several));
        let far = |other: &Picture| {
            let apart = found.rgb.iter().zip(&other.rgb).map(|(a, b)| f64::from((a - b).abs()));
            apart.sum::<f64>() / found.rgb.len() as f64
        };
        let [several, white] = [several, Sunlight::default()].map(|sun| of_look(stage, SUN_DEG, light(&sun)));
        assert!(far(&several) < 5e-4, "{}", far(&several));
        assert!(far(&white) > 20.0 * far(&several), "{} {}", far(&white), far(&several));
    }
}
