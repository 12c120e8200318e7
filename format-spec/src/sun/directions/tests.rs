use proptest::prelude::*;

use super::*;
use crate::direction::{DIRECTIONS, MOVING};
use crate::sun;

/// f32 rounding of three weights that are at most 1 each.
const WEIGHT_ROUNDING: f32 = 4.0 * f32::EPSILON;
/// Two directions this far apart, in a blend whose weights change by less than 4 per unit, differ by less.
const NUDGE: f64 = 1e-7;
const NUDGED_WEIGHT: f32 = 8e-7;
/// A sun from three weights of f32.
const DIRECTION_ROUNDING: f64 = 1e-6;

fn unit(v: [f64; 3]) -> [f64; 3] {
    v.map(|c| c / length(v))
}

/// Of an octahedron: +x, -x, +y, -y, +z, -z.
fn octahedron() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let axes = (0..6)
        .map(|i| std::array::from_fn(|axis| if axis != i / 2 { 0.0 } else { 1.0 - 2.0 * (i % 2) as f64 }));
    let triangles = [[0, 2, 4], [0, 3, 5], [0, 4, 3], [0, 5, 2], [1, 2, 5], [1, 3, 4], [1, 4, 2], [1, 5, 3]];
    (axes.collect(), triangles.to_vec())
}

/// The suns of the lattice's directions: base j is that of light along direction j, in the triangles of SPEC.md, 10.3.
fn lattice() -> SunDirections {
    let index = |v: [i32; 3]| DIRECTIONS.iter().position(|c| *c == v).expect("a direction") as u32 - 1;
    let directions: Vec<[f64; 3]> =
        (1..=MOVING).map(|m| unit(DIRECTIONS[m].map(|c| -f64::from(c)))).collect();
    let mut triangles = Vec::new();
    for octant in 0..8 {
        let s: [i32; 3] = std::array::from_fn(|axis| if octant >> axis & 1 == 0 { 1 } else { -1 });
        let (x, y, z) = (index([s[0], 0, 0]), index([0, s[1], 0]), index([0, 0, s[2]]));
        let (xy, xz, yz) = (index([s[0], s[1], 0]), index([s[0], 0, s[2]]), index([0, s[1], s[2]]));
        triangles.extend([[x, xy, xz], [y, xy, yz], [z, xz, yz], [xy, yz, xz]]);
    }
    for triangle in &mut triangles {
        let [a, b, c] = *triangle;
        let outwards = determinant(triangle.map(|corner| directions[corner as usize])) > 0.0;
        *triangle = if outwards { [a, b, c] } else { [a, c, b] };
        let first = (0..3).min_by_key(|at| triangle[*at]).expect("three");
        triangle.rotate_left(first);
    }
    triangles.sort_unstable();
    SunDirections::new(directions, triangles).expect("they cover the sphere once")
}

/// `[base]`, base 0 left out.
fn weights(list: &SunDirections, towards_sun: [f64; 3]) -> Vec<f32> {
    let blend = list.blend(towards_sun).expect("a finite direction");
    let mut all = vec![0.0; list.directions().len()];
    for (base, weight) in blend.bases.into_iter().zip(blend.weights) {
        assert!((0.0..=1.0).contains(&weight), "{towards_sun:?}: base {base} weighs {weight}");
        all[usize::from(base) - 1] = weight;
    }
    all
}

fn assert_same(a: &[f32], b: &[f32], tolerance: f32, what: &str) {
    for (at, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= tolerance, "{what}: direction {at} weighs {a} and {b}");
    }
}

#[test]
fn a_sun_in_a_direction_of_the_list_is_that_direction_alone() {
    let list = lattice();
    for (at, direction) in list.directions().iter().enumerate() {
        let mut alone = vec![0.0; 18];
        alone[at] = 1.0;
        assert_same(&weights(&list, *direction), &alone, WEIGHT_ROUNDING, &format!("{direction:?}"));
    }
}

#[test]
fn blends_are_the_same_from_both_sides_of_every_edge() {
    let list = lattice();
    for &[a, b, c] in list.triangles() {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            let [a, b] = [a, b].map(|corner| list.directions()[usize::from(corner)]);
            let across = unit(std::array::from_fn(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                a[j] * b[k] - a[k] * b[j]
            }));
            for step in 1..8 {
                let t = f64::from(step) / 8.0;
                let on_edge: [f64; 3] = std::array::from_fn(|i| (1.0 - t) * a[i] + t * b[i]);
                let beside = |far: f64| -> [f64; 3] { std::array::from_fn(|i| on_edge[i] + far * across[i]) };
                let [left, right] = [NUDGE, -NUDGE].map(|far| weights(&list, beside(far)));
                assert_same(&left, &right, NUDGED_WEIGHT, &format!("edge {a:?} {b:?} at {t}"));
            }
        }
    }
}

#[test]
fn no_direction_has_no_blend() {
    for wrong in [[0.0; 3], [f64::NAN, 0.0, 1.0], [0.0, f64::INFINITY, 0.0]] {
        assert_eq!(lattice().blend(wrong), None, "{wrong:?}");
    }
}

proptest! {
    #[test]
    fn weights_reproduce_the_suns_direction(
        x in -1.0..1.0f64, y in -1.0..1.0f64, z in -1.0..1.0f64, scale in 1e-3..1e3f64,
    ) {
        prop_assume!(length([x, y, z]) > 1e-3);
        let list = lattice();
        let found = weights(&list, [x, y, z].map(|c| c * scale));
        prop_assert!((found.iter().sum::<f32>() - 1.0).abs() <= WEIGHT_ROUNDING);
        let mut sun = [0.0; 3];
        for (weight, direction) in found.iter().zip(list.directions()) {
            sun.iter_mut().zip(direction).for_each(|(sum, c)| *sum += f64::from(*weight) * c);
        }
        for (found, expected) in unit(sun).into_iter().zip(unit([x, y, z])) {
            prop_assert!((found - expected).abs() <= DIRECTION_ROUNDING, "{found} for {expected}");
        }
    }

    #[test]
    fn the_lattices_directions_as_a_list_blend_as_the_lattice_does(
        x in -1.0..1.0f64, y in -1.0..1.0f64, z in -1.0..1.0f64,
    ) {
        prop_assume!(length([x, y, z]) > 1e-3);
        let of_lattice = sun::blend([x, y, z]).expect("a direction");
        let mut expected = vec![0.0; 18];
        for (base, weight) in of_lattice.bases.into_iter().zip(of_lattice.weights) {
            expected[usize::from(base) - 1] = weight;
        }
        assert_same(&weights(&lattice(), [x, y, z]), &expected, WEIGHT_ROUNDING, "lattice");
    }
}

/// What is said of an octahedron after an edit.
fn refusal(edit: impl FnOnce(&mut Vec<[f64; 3]>, &mut Vec<[u32; 3]>)) -> String {
    let (mut directions, mut triangles) = octahedron();
    edit(&mut directions, &mut triangles);
    SunDirections::new(directions, triangles).expect_err("an edit breaks a clause").to_string()
}

#[test]
fn every_clause_of_m57_is_kept() {
    let (directions, triangles) = octahedron();
    SunDirections::new(directions, triangles).expect("an octahedron is sound");
    let diagonal = [1.0 / libm::sqrt(3.0); 3];
    let cases = [
        ("light.suns.directions is 3 vectors, expected 4 to 255", refusal(|d, _| d.truncate(3))),
        ("directions is 256 vectors", refusal(|d, _| d.resize(256, [1.0, 0.0, 0.0]))),
        (
            "directions[2], its length, is 1.00001, expected 1 within",
            refusal(|d, _| d[2] = [0.0, 1.00001, 0.0]),
        ),
        ("directions[5], its length, is NaN", refusal(|d, _| d[5][0] = f64::NAN)),
        ("triangles[7] is [1, 5, 6], expected indices of three", refusal(|_, t| t[7] = [1, 5, 6])),
        ("triangles[7] is [1, 5, 4294967295], expected", refusal(|_, t| t[7] = [1, 5, u32::MAX])),
        ("triangles[7] is [1, 5, 5], expected indices of three", refusal(|_, t| t[7] = [1, 5, 5])),
        ("triangles[0] is [2, 4, 0], expected indices of three", refusal(|_, t| t[0] = [2, 4, 0])),
        ("triangles[1] is [0, 2, 4], expected after the one before", refusal(|_, t| t.swap(0, 1))),
        ("triangles[1] is [0, 2, 4], expected after the one before", refusal(|_, t| t[1] = t[0])),
        ("triangles[0], its corners' determinant, is -1, expected at least 1e-6", {
            refusal(|d, _| d[0] = [-1.0, 0.0, 0.0])
        }),
        ("triangles[0], its corners' determinant, is 0.0000005", {
            refusal(|d, _| d[4] = [libm::sqrt(1.0 - 2.5e-13), 0.0, 5e-7])
        }),
        ("the edge [0, 2], is of two triangles, expected of one", {
            refusal(|d, t| {
                d.push(diagonal);
                t.insert(1, [0, 2, 6]);
            })
        }),
        ("the edge [1, 5], is of one triangle alone, expected an edge of another", {
            refusal(|_, t| {
                t.remove(4);
            })
        }),
        ("light.suns.directions[6] is of no triangle, expected a corner", refusal(|d, _| d.push(diagonal))),
        ("the sum of their solid angles, is 25.13", {
            refusal(|d, t| {
                d.extend_from_within(..);
                t.extend(t.clone().iter().map(|triangle| triangle.map(|corner| corner + 6)));
            })
        }),
    ];
    for (expected, found) in cases {
        assert!(found.contains(expected), "{found}: expected {expected}");
    }
}
