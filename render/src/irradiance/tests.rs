use flb_scene::MaterialClass::{Leaf, Wood};

use super::*;
use crate::tests::{add_quad, material, oak};

/// Standard errors that chance may lie off.
const SIGMAS: f32 = 4.0;

fn surfaces(leaf: [f32; 2], wood: f32) -> Surfaces {
    let [leaf_reflectance, leaf_transmittance] = leaf.map(|share| [share; 3]);
    Surfaces { leaf_reflectance, leaf_transmittance, wood_reflectance: [wood; 3], solid_offset_m: None }
}

fn point(triangle: u32, weights: [f32; 2]) -> SurfacePoint {
    SurfacePoint { triangle, weights, position_m: [0.0; 3] }
}

/// A black floor, a leaf, beside a wall of wood, 2 m high and far too long to matter: the wall faces +X.
fn ditch() -> Mesh {
    let materials = vec![material("floor", [0.5; 3]), material("wall", [0.5; 3])];
    let mut mesh = Mesh { materials, ..Mesh::default() };
    add_quad(&mut mesh, 0, [0.0, 0.0, -1.0], [[0.0, 0.0, 2.0], [2.0, 0.0, 0.0]], 1.0);
    add_quad(&mut mesh, 1, [0.0, 0.0, -500.0], [[0.0, 2.0, 0.0], [0.0, 0.0, 1000.0]], 1.0);
    mesh
}

#[test]
fn a_lit_wall_lights_a_floor_by_its_form_factor() {
    let mesh = ditch();
    // The middle of the floor, 1 m before the wall: a semi-infinite strip of height 2 has the form factor
    // (1 - 1 / sqrt(1 + 2^2)) / 2 there (Howell, C-9).
    let factor = (1.0 - 1.0 / 5.0f64.sqrt()) / 2.0;
    let suns = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let floor = point(0, [0.0, 0.5]);
    let found =
        irradiance((&mesh, &[Leaf, Wood]), surfaces([0.0; 2], 0.5), &[floor], &suns, 20_000, &|_| Ok(()))
            .unwrap();
    let [found] = &found[..] else { panic!("one point") };
    assert_eq!((found.class, found.material, found.normal), (Leaf, 0, [0.0, 1.0, 0.0]));
    let [up, down] = &found.sides;
    assert_eq!(up.sources.len(), 3);
    // The sun behind the wall lights nothing that the floor sees.
    for (source, expected) in [(0, 0.5 * 0.5f64.sqrt() * factor), (1, 0.0)] {
        let Estimate { mean, error, .. } = up.sources[source];
        assert!(
            (mean[1] - expected as f32).abs() <= SIGMAS * error[1] + 1e-6,
            "{source}: {mean:?} {error:?}"
        );
    }
    // Of the sky the floor sees what the wall leaves, and a part of what lights the wall.
    let sky = up.sources[2].mean[1];
    assert!(sky > 0.25 * (1.0 - factor as f32) && sky < 0.25 * (1.0 - factor as f32 / 2.0), "{sky}");
    assert!((up.open - (1.0 - factor as f32)).abs() < 0.01, "{}", up.open);
    assert_eq!((down.open, down.sources[2].mean), (1.0, [0.25; 3]), "nothing stands below");
}

#[test]
fn a_white_plant_in_an_even_sky_gets_the_skys_light_everywhere() {
    let mesh = oak(4_000);
    let points: Vec<SurfacePoint> = (0..40).map(|k| point(k * 97, [0.3, 0.3])).collect();
    let classes: Vec<_> = mesh.materials.iter().map(|_| Leaf).collect();
    let mut mesh = mesh;
    mesh.materials = mesh.materials.iter().map(|one| material(&one.name, [0.5; 3])).collect();
    let white = surfaces([0.5, 0.5], 1.0);
    let found = irradiance((&mesh, &classes), white, &points, &[], 64, &|_| Ok(())).unwrap();
    let sums = found.iter().flat_map(|point| &point.sides).map(|side| f64::from(side.sources[0].mean[0]));
    let mean = sums.sum::<f64>() / 80.0;
    // A path ends after 64 bounces at most, so a little is lost in the depths.
    assert!((0.24..=0.2501).contains(&mean), "{mean}");
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let mesh = ditch();
    let points = [point(0, [0.2, 0.5]), point(2, [0.5, 0.1]), point(3, [0.4, 0.4])];
    let trace = || {
        irradiance(
            (&mesh, &[Leaf, Wood]),
            surfaces([0.3, 0.3], 0.5),
            &points,
            &[[1.0, 1.0, 0.0]],
            16,
            &|_| Ok(()),
        )
        .unwrap()
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(trace);
    assert_eq!(one, trace());
}

#[test]
fn bad_input_is_named() {
    let mesh = ditch();
    let refusal = |point: SurfacePoint, sun: [f64; 3], samples| {
        let found =
            irradiance((&mesh, &[Leaf, Wood]), surfaces([0.3, 0.3], 0.5), &[point], &[sun], samples, &|_| {
                Ok(())
            });
        found.unwrap_err().to_string()
    };
    let up = [0.0, 1.0, 0.0];
    assert!(refusal(point(0, [0.1; 2]), up, 1).contains("`samples` is 1, expected 2 or more"));
    assert!(refusal(point(9, [0.1; 2]), up, 2).contains("triangle 9: a point of it, but the mesh has 4"));
    for sun in [[0.0; 3], [f64::NAN, 0.0, 1.0]] {
        assert!(refusal(point(0, [0.1; 2]), sun, 2).contains("`sun` is"), "{sun:?}");
    }
}
