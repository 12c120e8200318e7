use proptest::prelude::*;

use super::*;
use crate::direction::MOVING;

/// f32 rounding of three weights that are at most 1 each.
const WEIGHT_ROUNDING: f32 = 4.0 * f32::EPSILON;
/// Two directions this far apart, in a blend whose weights change by less than 4 per unit, differ by less.
const NUDGE: f64 = 1e-7;
const NUDGED_WEIGHT: f32 = 8e-7;

fn unit(m: u8) -> [f64; 3] {
    let c = DIRECTIONS[m as usize].map(f64::from);
    let length = c.iter().map(|v| v * v).sum::<f64>().sqrt();
    c.map(|v| v / length)
}

/// Weight of each of the 18 bases for light that travels along `d`.
fn weights_of_light(d: [f64; 3]) -> [f32; MOVING + 1] {
    let blend = blend(d.map(|c| -c)).expect("a finite direction");
    let mut all = [0.0; MOVING + 1];
    for (base, weight) in blend.bases.iter().zip(blend.weights) {
        assert!((1..=18).contains(base));
        assert_eq!(all[*base as usize], 0.0, "bases are different");
        all[*base as usize] = weight;
    }
    all
}

/// The corners of all 32 triangles, listed from the lighting model's text, not from the code under test.
fn triangles() -> Vec<[u8; 3]> {
    let index = |v: [i32; 3]| DIRECTIONS.iter().position(|c| *c == v).unwrap() as u8;
    let mut triangles = Vec::new();
    for octant in 0..8 {
        let s: [i32; 3] = std::array::from_fn(|axis| if octant >> axis & 1 == 0 { 1 } else { -1 });
        let (x, y, z) = (index([s[0], 0, 0]), index([0, s[1], 0]), index([0, 0, s[2]]));
        let (xy, xz, yz) = (index([s[0], s[1], 0]), index([s[0], 0, s[2]]), index([0, s[1], s[2]]));
        triangles.extend([[x, xy, xz], [y, xy, yz], [z, xz, yz], [xy, yz, xz]]);
    }
    triangles
}

/// Barycentric coordinates of the ray along `d` in a triangle, by Cramer's rule: the oracle.
fn barycentric(triangle: [u8; 3], d: [f64; 3]) -> [f64; 3] {
    let det = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    let [p, q, r] = triangle.map(unit);
    let whole = det(p, q, r);
    let weights = [det(d, q, r) / whole, det(p, d, r) / whole, det(p, q, d) / whole];
    let sum: f64 = weights.iter().sum();
    if sum <= 0.0 { [-1.0; 3] } else { weights.map(|w| w / sum) }
}

fn assert_same(a: &[f32], b: &[f32], tolerance: f32, what: &str) {
    for m in 0..=MOVING {
        assert!((a[m] - b[m]).abs() <= tolerance, "{what}: base {m} weighs {} and {}", a[m], b[m]);
    }
}

#[test]
fn light_along_a_base_direction_is_that_base_alone() {
    for m in 1..=18u8 {
        let weights = weights_of_light(unit(m));
        for (base, weight) in weights.iter().enumerate() {
            let expected = if base == m as usize { 1.0 } else { 0.0 };
            assert!(
                (weight - expected).abs() <= WEIGHT_ROUNDING,
                "light along {m}: base {base} weighs {weight}"
            );
        }
        // Integer steps hold no rounding at all.
        let weights = weights_of_light(DIRECTIONS[m as usize].map(f64::from));
        assert_eq!(weights[m as usize], 1.0, "light along {m}");
        assert_eq!(weights.iter().filter(|w| **w != 0.0).count(), 1);
    }
}

#[test]
fn a_sun_overhead_takes_the_base_that_travels_down() {
    let weights = blend([0.0, 1.0, 0.0]).unwrap();
    let down = DIRECTIONS.iter().position(|c| *c == [0, -1, 0]).unwrap() as u8;
    let heaviest = (0..3).find(|&k| weights.weights[k] == 1.0).unwrap();
    assert_eq!(weights.bases[heaviest], down);
}

#[test]
fn the_polyhedron_is_closed_with_18_corners_and_48_edges() {
    let mut edges = std::collections::BTreeMap::new();
    for [p, q, r] in triangles() {
        for (a, b) in [(p, q), (q, r), (r, p)] {
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    assert_eq!(triangles().len(), 32);
    assert_eq!(edges.len(), 48);
    assert!(edges.values().all(|faces| *faces == 2));
}

#[test]
fn blend_is_continuous_across_all_48_edges() {
    let mut edges = std::collections::BTreeMap::new();
    for [p, q, r] in triangles() {
        for (a, b, inside) in [(p, q, r), (q, r, p), (r, p, q)] {
            edges.entry((a.min(b), a.max(b))).or_insert_with(Vec::new).push(inside);
        }
    }
    for ((a, b), sides) in edges {
        for step in 0..=16 {
            let t = f64::from(step) / 16.0;
            let on: [f64; 3] = std::array::from_fn(|i| unit(a)[i] * (1.0 - t) + unit(b)[i] * t);
            let weights = weights_of_light(on);
            assert!((weights[a as usize] - (1.0 - t) as f32).abs() <= WEIGHT_ROUNDING);
            assert!((weights[b as usize] - t as f32).abs() <= WEIGHT_ROUNDING);
            for inside in &sides {
                let near: [f64; 3] =
                    std::array::from_fn(|i| on[i] * (1.0 - NUDGE) + unit(*inside)[i] * NUDGE);
                assert_same(
                    &weights,
                    &weights_of_light(near),
                    NUDGED_WEIGHT,
                    &format!("edge {a}-{b}, side {inside}"),
                );
            }
        }
    }
}

#[test]
fn blend_is_continuous_around_all_18_corners() {
    for m in 1..=18u8 {
        let at = weights_of_light(unit(m));
        for turn in 0..64 {
            let angle = f64::from(turn) * std::f64::consts::TAU / 64.0;
            let offset = [libm::cos(angle), libm::sin(angle), libm::cos(2.0 * angle + 0.3)];
            let near: [f64; 3] = std::array::from_fn(|i| unit(m)[i] + 0.5 * NUDGE * offset[i]);
            assert_same(&at, &weights_of_light(near), NUDGED_WEIGHT, &format!("corner {m}, turn {turn}"));
        }
    }
}

#[test]
fn a_zero_of_either_sign_gives_the_same_blend() {
    for s in [[0.0, 0.6, 0.8], [0.3, 0.0, 0.5], [0.5, -0.2, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]] {
        let negated = s.map(|c: f64| if c == 0.0 { -0.0 } else { c });
        assert_eq!(blend(s), blend(negated), "{s:?}");
    }
}

#[test]
fn zero_and_non_finite_directions_have_no_blend() {
    assert_eq!(blend([0.0, -0.0, 0.0]), None);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(blend([bad, 0.0, 1.0]), None);
        assert_eq!(blend([1.0, bad, 0.0]), None);
        assert_eq!(blend([1.0, 0.0, bad]), None);
    }
}

#[test]
fn directions_of_extreme_length_blend_like_unit_ones() {
    let s = [0.48, 0.6, 0.64];
    let expected = blend(s).unwrap();
    for scale in [f64::MIN_POSITIVE, 1e-300, 1e300] {
        let scaled = blend(s.map(|c| c * scale)).unwrap();
        assert_eq!(scaled.bases, expected.bases);
        for k in 0..3 {
            assert!((scaled.weights[k] - expected.weights[k]).abs() <= WEIGHT_ROUNDING);
        }
    }
    assert!(blend([f64::from_bits(1), 0.0, 0.0]).is_some(), "the smallest subnormal is a direction");
}

#[test]
fn compass_points_are_exact() {
    assert_eq!(towards_sun(0.0, 0.0), [0.0, 0.0, -1.0], "north is -Z");
    assert_eq!(towards_sun(90.0, 0.0)[0], 1.0, "east is +X");
    assert_eq!(towards_sun(90.0, 0.0)[2], 0.0);
    assert_eq!(towards_sun(180.0, 0.0), [0.0, 0.0, 1.0]);
    assert_eq!(towards_sun(-90.0, 0.0), towards_sun(270.0, 0.0));
    for azimuth in [0.0, 37.0, 360.0] {
        let up = towards_sun(azimuth, 90.0);
        assert_eq!(up.map(f64::abs), [0.0, 1.0, 0.0]);
    }
    let morning = towards_sun(90.0, 30.0);
    assert!((morning[1] - 0.5).abs() < 1e-15 && morning[0] > 0.86);
    assert!(blend(towards_sun(f64::NAN, 0.0)).is_none());
}

fn direction() -> impl Strategy<Value = [f64; 3]> {
    // Uniform, and near-degenerate: components that nearly vanish, tie, or sum to another.
    let small = prop_oneof![Just(0.0), Just(-0.0), Just(1e-300), Just(-1e-17), Just(1e-9)];
    prop_oneof![
        prop::array::uniform3(-1.0f64..1.0),
        (small.clone(), -1.0f64..1.0, -1.0f64..1.0).prop_map(|(e, y, z)| [e, y, z]),
        (small.clone(), -1.0f64..1.0).prop_map(|(e, y)| [y, y + e, -y]),
        (small, 0.0f64..1.0, 0.0f64..1.0).prop_map(|(e, y, z)| [y + z + e, -y, z]),
    ]
    .prop_filter("a direction", |d| d.iter().any(|c| *c != 0.0))
}

proptest! {
    #[test]
    fn weights_are_non_negative_and_sum_to_one(d in direction()) {
        let blend = blend(d).unwrap();
        prop_assert!(blend.weights.iter().all(|w| (0.0..=1.0).contains(w)), "{blend:?}");
        prop_assert!((blend.weights.iter().sum::<f32>() - 1.0).abs() <= WEIGHT_ROUNDING, "{blend:?}");
    }

    #[test]
    fn weighted_bases_point_along_the_light(s in direction()) {
        let blend = blend(s).unwrap();
        let hit: [f64; 3] = std::array::from_fn(|i| (0..3).map(|k| f64::from(blend.weights[k]) * unit(blend.bases[k])[i]).sum());
        let length = s.iter().map(|c| c * c).sum::<f64>().sqrt();
        let along: f64 = (0..3).map(|i| -s[i] / length * hit[i]).sum();
        prop_assert!(along > 0.8, "the hit lies in front: {along}");
        for i in 0..3 {
            prop_assert!((hit[i] + s[i] / length * along).abs() < 1e-6, "off the ray: {hit:?}");
        }
    }

    #[test]
    fn blend_is_the_triangle_that_the_ray_meets(d in prop::array::uniform3(-1.0f64..1.0)) {
        let mut expected = [0.0f32; MOVING + 1];
        let (triangle, weights) = triangles().into_iter().map(|t| (t, barycentric(t, d)))
            .max_by(|a, b| least(a.1).total_cmp(&least(b.1))).unwrap();
        prop_assert!(least(weights) > -1e-12);
        for k in 0..3 { expected[triangle[k] as usize] = weights[k] as f32; }
        let found = weights_of_light(d);
        for m in 0..=MOVING {
            prop_assert!((found[m] - expected[m]).abs() <= WEIGHT_ROUNDING, "base {m}: {} for {}", found[m], expected[m]);
        }
    }
}

fn least(weights: [f64; 3]) -> f64 {
    weights.into_iter().fold(f64::INFINITY, f64::min)
}
