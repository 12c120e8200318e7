//! Meshes that are not as they should be: solids inside out, open below or without thickness.

use std::fmt::Write;

use crate::flb::{FEW, Folder};
use crate::picture::{pixels, rms};

/// A crown of 200 leaves over a trunk, whose walls are given: corners, four a wall, in metres.
fn plant(walls: &[[[f64; 3]; 4]]) -> String {
    let mut mesh = String::new();
    let mut count = 0;
    let mut quad = |mesh: &mut String, material: &str, corners: [[f64; 3]; 4]| {
        let _ = writeln!(mesh, "usemtl {material}");
        for [x, y, z] in corners {
            let _ = writeln!(mesh, "v {x} {y} {z}");
        }
        let _ = writeln!(mesh, "f {} {} {} {}", count + 1, count + 2, count + 3, count + 4);
        count += 4;
    };
    for leaf in 0..200 {
        // Even over a ball, turned this way and that.
        let along = |step: f64| libm::fmod(f64::from(leaf) * step, 1.0);
        let (level, turn) = (1.0 - 2.0 * along(0.754_877_666), std::f64::consts::TAU * along(0.569_840_291));
        let radius = 0.6 * libm::cbrt(along(0.434_958_5));
        let (sin, cos) = libm::sincos(turn);
        let across = libm::sqrt(1.0 - level * level);
        let middle = [radius * across * cos, 1.6 + radius * level, radius * across * sin];
        let (a, b) = libm::sincos(9.0 * turn);
        let (u, v) = ([0.06 * a, 0.06 * b, 0.0], [-0.03 * b, 0.03 * a, 0.05]);
        let corner = |s: f64, t: f64| std::array::from_fn(|axis| middle[axis] + s * u[axis] + t * v[axis]);
        quad(&mut mesh, "leaf", [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
    }
    walls.iter().for_each(|wall| quad(&mut mesh, "bark", *wall));
    mesh
}

/// A box of walls that face outward; the last one is its bottom.
fn trunk() -> Vec<[[f64; 3]; 4]> {
    let (low, high) = ([-0.15, 0.0, -0.15], [0.15, 1.2, 0.15]);
    let corner =
        |x: usize, y: usize, z: usize| [[low[0], high[0]][x], [low[1], high[1]][y], [low[2], high[2]][z]];
    vec![
        [corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)],
        [corner(1, 0, 0), corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0)],
        [corner(1, 0, 1), corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1)],
        [corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0)],
        [corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0), corner(0, 1, 0)],
        [corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1)],
    ]
}

#[test]
fn solids_inside_out_open_below_or_without_thickness_have_the_light_in_front_of_them() {
    let outward = trunk();
    let inward: Vec<_> = outward.iter().map(|[a, b, c, d]| [*d, *c, *b, *a]).collect();
    let thin = [[[-0.8, 0.0, -0.3], [0.8, 0.0, -0.3], [0.8, 1.2, -0.3], [-0.8, 1.2, -0.3]]];
    let folder = Folder::new();
    for (name, walls) in
        [("outward", &outward[..]), ("inward", &inward), ("open", &outward[..5]), ("thin", &thin)]
    {
        let (mesh, file) = (format!("{name}.obj"), format!("{name}.flb"));
        folder.write(&mesh, plant(walls));
        let bake = ["bake", &mesh, "--lattice", "32", "--voxels", "128", "-o", &file];
        folder.flb_with(&bake, &FEW).expect_code(0);
        let judge = ["judge", &file, "--mesh", &mesh, "--suns", "1", "--points", "600", "--json"];
        let judged = folder.flb(&judge).expect_code(0).json();
        let ratio = judged["wood"]["sky"]["ratio"][0].as_f64().expect("a ratio");
        assert!((0.93..1.07).contains(&ratio), "{name}: {ratio}");
        let rms = judged["wood"]["sky"]["rms"][0].as_f64().expect("a number");
        assert!(rms < 0.15, "{name}: {rms}");
    }
    // What is seen of a trunk that is inside out is what is seen of the other.
    let [outward, inward] = ["outward", "inward"].map(|name| {
        let (mesh, file, picture) = (format!("{name}.obj"), format!("{name}.flb"), format!("{name}.png"));
        let words = ["render", &file, "--mesh", &mesh, "--sun", "90,30", "--size", "96x128", "-o", &picture];
        folder.flb(&words).expect_code(0);
        pixels(&folder.read(&picture))
    });
    assert!(rms(&outward, &inward) < 4.0, "{}", rms(&outward, &inward));
}
