//! Painters on a GPU, shot after shot, beside fresh ones and the CPU's.

use std::time::Duration;

use flb_format::light::SunBasis;
use flb_gpu::Gpu;
use flb_runtime::scene_light::SceneLight;
use flb_testkit::scenes;

use super::{Painted, Painter, Shot, Show};
use crate::tests::{look, stand, stand_of};
use crate::{Stage, StageError, StageSky};

const SIZE: [u32; 2] = [64, 48];
const LONGEST: Duration = Duration::from_secs(300);

fn gpu() -> Gpu {
    // The message says what to install.
    Gpu::open(Default::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn painter(stage: &Stage) -> Painter<'_> {
    Painter::new(stage, look(stage, StageSky::EVEN), 8 << 20).expect("a painter")
}

fn shot(side: f64, sun_deg: [f64; 2]) -> Shot {
    let mut eye = scenes::view(SIZE, 1, 14.0).eye;
    eye.position_m[0] *= side;
    Shot { eye, sun_deg, show: Show::Indirect }
}

fn paint(painter: &mut Painter, shot: &Shot) -> Painted {
    painter.paint_whole(shot, SIZE, LONGEST).unwrap_or_else(|error| panic!("{error}"))
}

/// Largest difference of two pictures.
fn apart(one: &Painted, other: &Painted) -> f32 {
    let values = one.picture.rgb.iter().zip(&other.picture.rgb);
    values.fold(0.0, |worst: f32, (a, b)| worst.max((a - b).abs()))
}

#[test]
fn a_gpu_that_kept_camera_and_shade_paints_each_shot_as_a_fresh_one() {
    let (alone, mut among, gpu) = (stand(), stand(), gpu());
    // Of another stand, which does not matter here.
    let light = SceneLight::load(&scenes::scene_light(&["a", "b"], Some(&SunBasis::Lattice18)));
    among.scene_light = Some(light.expect("scene light"));
    let fresh = || {
        let mut painter = painter(&among);
        painter.send(&gpu, true).unwrap_or_else(|error| panic!("{error}"));
        painter
    };
    let mut kept = fresh();
    let first = shot(1.0, [120.0, 40.0]);
    let (sun, eye) = (shot(1.0, [250.0, 15.0]), shot(-1.0, [250.0, 15.0]));
    let mut before: Option<Painted> = None;
    for shot in [first, sun, eye, first] {
        let found = paint(&mut kept, &shot);
        assert!(found.progress.is_final && found.progress.adapter.is_some());
        let off = apart(&found, &paint(&mut fresh(), &shot));
        assert!(off < 1e-6, "{off} from a fresh painter");
        let alone = apart(&found, &paint(&mut painter(&alone), &shot));
        assert!(alone > 1e-3, "neighbours change the light by {alone}");
        if let Some(before) = before.replace(found.clone()) {
            let moved = apart(&found, &before);
            assert!(moved > 5e-4, "another shot is another picture: {moved}");
        }
    }
}

#[test]
fn under_a_clear_sky_a_gpu_paints_what_the_cpu_does() {
    let (stand, gpu) = (stand_of(&SunBasis::Harmonics { degree: 2, single: true, leaning: true }), gpu());
    let clear = || Painter::new(&stand, look(&stand, StageSky::clear(3.0).expect("a sky")), 8 << 20);
    let [mut on_gpu, mut on_cpu] = [clear(), clear()].map(|painter| painter.expect("a painter"));
    on_gpu.send(&gpu, true).unwrap_or_else(|error| panic!("{error}"));
    let mean = |painted: &Painted, band: usize| {
        painted.picture.rgb.chunks_exact(3).map(|rgb| f64::from(rgb[band])).sum::<f64>()
    };
    for sun_deg in [[120.0, 40.0], [250.0, 15.0]] {
        let shot = Shot { show: Show::Whole, ..shot(1.0, sun_deg) };
        let [found, expected] = [paint(&mut on_gpu, &shot), paint(&mut on_cpu, &shot)];
        assert!(found.progress.adapter.is_some() && expected.progress.adapter.is_none());
        let even = paint(&mut painter(&stand), &shot);
        // The near beam of the sun has noise, which is not the same.
        for band in 0..3 {
            let [off, even] =
                [&found, &even].map(|one| (mean(one, band) / mean(&expected, band) - 1.0).abs());
            assert!(off < 0.01 && even > 3.0 * off, "band {band}: {off}, of an even sky {even}");
        }
    }
}

#[test]
fn where_a_gpu_is_lost_the_cpu_goes_on_unless_the_gpu_is_needed() {
    let stand = stand();
    let shot = shot(1.0, [120.0, 40.0]);
    let expected = paint(&mut painter(&stand), &shot);
    for is_needed in [false, true] {
        let (gpu, mut painter) = (gpu(), painter(&stand));
        painter.send(&gpu, is_needed).unwrap_or_else(|error| panic!("{error}"));
        assert!(paint(&mut painter, &shot).progress.adapter.is_some());
        gpu.device.destroy();
        match painter.paint(&shot, SIZE, 1) {
            Ok(painted) => {
                assert!(!is_needed);
                assert_eq!((apart(&painted, &expected), &painted.progress.adapter), (0.0, &None));
                let reason = painted.progress.left_gpu.expect("it says why");
                assert!(reason.contains("lost") || reason.contains("destroyed"), "{reason}");
            }
            Err(error) => assert!(is_needed && matches!(error, StageError::Forest(_)), "{error}"),
        }
    }
}

#[test]
fn a_gpu_follows_the_light_of_one_file() {
    let (mut stand, gpu) = (stand(), gpu());
    let refused = |stand: &Stage| painter(stand).send(&gpu, true).expect_err("it is refused").to_string();
    stand.plants[1].light = crate::tests::stand().plants[1].light.take();
    assert!(refused(&stand).contains("2 files"));
    stand.plants.iter_mut().for_each(|plant| plant.light = None);
    assert!(refused(&stand).contains("no species of the scene has light"));
}
