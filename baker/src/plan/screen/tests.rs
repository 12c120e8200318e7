use flb_format::{Placement, Transform};

use super::*;

const UNIT: Bounds = Bounds { min: [-0.5, 0.0, -0.5], max: [0.5, 1.0, 0.5] };
const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn camera(path_m: &[[f64; 3]]) -> Camera {
    // 90 degrees: a metre at a distance of one metre fills half of the height.
    Camera { path_m: path_m.to_vec(), look_at_m: None, fov_deg: 90.0, height_px: 1024, pixels_per_site: 4.0 }
}

fn at(position_m: [f64; 3], scale: f64) -> Placement {
    Placement { species: 0, transform: Transform { rotation: IDENTITY, position_m, scale } }
}

fn seen(path_m: &[[f64; 3]], instances: &[Placement]) -> OnScreen {
    on_screen(&camera(path_m), &UNIT, instances.iter()).expect("there is an instance")
}

#[test]
fn a_tree_that_fills_512_pixels_gets_the_papers_128_sites() {
    // The front face is a metre away.
    let found = seen(&[[0.0, 0.5, 1.5]], &[at([0.0; 3], 1.0)]);
    assert!((found.size_px - 512.0).abs() < 1e-9 && (found.distance_m - 1.0).abs() < 1e-12, "{found:?}");
    assert_eq!((found.wanted, found.lattice), (128, 128));
}

#[test]
fn the_largest_picture_of_any_instance_decides_and_limits_are_said() {
    let far = at([0.0, 0.0, -1000.0], 1.0);
    let found = seen(&[[0.0, 0.5, 1.5]], &[far, at([0.0, 0.0, -7.0], 1.0), far]);
    assert!((found.distance_m - 8.0).abs() < 1e-12, "{found:?}");
    assert_eq!((found.wanted, found.lattice), (16, 16));
    assert_eq!(seen(&[[0.0, 0.5, 1.5]], &[far]).lattice, 16);
    assert_eq!(seen(&[[0.0, 0.5, 1.5]], &[far]).wanted, 1);
    // Ten times as large, ten times as far.
    let large = seen(&[[0.0, 5.0, 15.0]], &[far, at([0.0; 3], 10.0)]);
    assert!((large.size_px - 512.0).abs() < 1e-9, "{large:?}");
    let near = seen(&[[0.0, 0.5, 0.6]], &[far, at([0.0; 3], 1.0)]);
    assert_eq!((near.wanted, near.lattice), (2048, 256));
    let inside = seen(&[[0.0, 0.5, 0.0]], &[far, at([0.0; 3], 1.0)]);
    assert_eq!((inside.size_px, inside.wanted, inside.lattice), (f64::INFINITY, 0, 256));
    assert_eq!(on_screen(&camera(&[[0.0; 3]]), &UNIT, [].iter()), None);
}

#[test]
fn a_camera_is_followed_between_the_points_of_its_path() {
    // It passes a metre in front of the face, between points that are far away.
    let path = [[-50.0, 0.5, 1.5], [70.0, 0.5, 1.5], [70.0, 0.5, 90.0]];
    let found = seen(&path, &[at([0.0; 3], 1.0)]);
    assert!((found.distance_m - 1.0).abs() < 1e-9, "{found:?}");
    let through = seen(&[[-50.0, 0.5, 0.0], [70.0, 0.5, 0.1]], &[at([0.0; 3], 1.0)]);
    assert_eq!(through.lattice, 256);
    assert!(through.distance_m < 1e-9, "{through:?}");
}

#[test]
fn bounds_turn_with_their_instance() {
    let flat = Bounds { min: [-4.0, 0.0, -0.5], max: [4.0, 1.0, 0.5] };
    let eastward = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
    let distance = |rotation| {
        let instance =
            Placement { species: 0, transform: Transform { rotation, ..at([0.0; 3], 1.0).transform } };
        on_screen(&camera(&[[0.0, 0.5, 10.0]]), &flat, [instance].iter()).expect("one").distance_m
    };
    assert!((distance(IDENTITY) - 9.5).abs() < 1e-12 && (distance(eastward) - 6.0).abs() < 1e-12);
}
