//! Painters on a GPU, shot after shot, beside fresh ones and the CPU's.

use std::sync::Arc;
use std::time::Duration;

use flb_fixtures::PlantKind;
use flb_format::{Codec, Placement, SunBasis};
use flb_gpu::Gpu;
use flb_render::forest::{Forest, Search, Species};
use flb_runtime::scene_light::SceneLight;
use flb_testkit::scenes;

use crate::paint::{LightOfSpecies, Painted, Painter, ViewOptions};
use crate::{Shot, Show, ViewError};

const SIZE: [u32; 2] = [64, 48];
const LONGEST: Duration = Duration::from_secs(300);

fn gpu() -> Gpu {
    // The message says what to install.
    Gpu::open(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}"))
}

/// Six plants of two species, and their light.
struct Stand {
    meshes: [flb_scene::Mesh; 2],
    instances: Vec<Placement>,
    lights: Vec<Option<LightOfSpecies>>,
}

impl Stand {
    fn new() -> Stand {
        let lit = [("a", Some(SunBasis::Lattice18)), ("b", Some(SunBasis::Lattice18))];
        let library = Arc::new(scenes::library(&lit, Codec::Classed));
        let light = |species| Some(LightOfSpecies { library: Arc::clone(&library), species });
        Stand {
            meshes: [PlantKind::Oak, PlantKind::Shrub].map(|kind| scenes::plant(kind, 600)),
            instances: scenes::stand(6, 12.0, [0.0; 3]),
            lights: vec![light(0), light(1)],
        }
    }

    fn forest(&self) -> Forest<'_> {
        let shading = scenes::physical();
        let species = self.meshes.each_ref().map(|mesh| Species { mesh, classes: &scenes::CLASSES, shading });
        let ground = Some(scenes::plane());
        Forest::prepare(&species, &self.instances, ground, Search::default()).expect("a forest")
    }

    fn painter<'f>(&'f self, forest: &'f Forest<'f>) -> Painter<'f> {
        let look = ViewOptions {
            ambient: 0.4,
            indirect_scale: 0.5,
            samples: 1,
            budget_bytes: 8 << 20,
            has_ground: true,
        };
        Painter::new(forest, &self.instances, &self.lights, look).expect("a painter")
    }
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
    let (stand, gpu) = (Stand::new(), gpu());
    let forest = stand.forest();
    let light =
        SceneLight::load(&scenes::scene_light(&["a", "b"], &SunBasis::Lattice18)).expect("scene light");
    let prepared = light.prepare(["a", "b"]);
    let fresh = || {
        let mut painter = stand.painter(&forest).among(&prepared);
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
        let alone = apart(&found, &paint(&mut stand.painter(&forest), &shot));
        assert!(alone > 1e-3, "neighbours change the light by {alone}");
        if let Some(before) = before.replace(found.clone()) {
            let moved = apart(&found, &before);
            assert!(moved > 5e-4, "another shot is another picture: {moved}");
        }
    }
}

#[test]
fn where_a_gpu_is_lost_the_cpu_goes_on_unless_the_gpu_is_needed() {
    let stand = Stand::new();
    let forest = stand.forest();
    let shot = shot(1.0, [120.0, 40.0]);
    let expected = paint(&mut stand.painter(&forest), &shot);
    for is_needed in [false, true] {
        let (gpu, mut painter) = (gpu(), stand.painter(&forest));
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
            Err(error) => assert!(is_needed && matches!(error, ViewError::Forest(_)), "{error}"),
        }
    }
}

#[test]
fn a_gpu_follows_the_light_of_one_file() {
    let mut stand = Stand::new();
    let gpu = gpu();
    let refused = |stand: &Stand| {
        let forest = stand.forest();
        stand.painter(&forest).send(&gpu, true).expect_err("it is refused").to_string()
    };
    stand.lights[1] = Stand::new().lights[1].take();
    assert!(refused(&stand).contains("2 files"));
    stand.lights = vec![None, None];
    assert!(refused(&stand).contains("no species of the scene has light"));
}
