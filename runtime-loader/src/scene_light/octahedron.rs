//! Any direction between three of few, so that what is known of those is known of all, without a jump anywhere.
//!
//! The faces of an octahedron, cut into [`PARTS`]^2 triangles each, cover all directions; a direction meets one
//! triangle, and its place in that gives the weights of the corners. Corners are integers, so that neighbouring
//! triangles name theirs alike.

/// Parts of an edge: corners are at most 14 degrees from the next, in the middle of a face.
const PARTS: i32 = 10;
/// Corners of all triangles.
#[cfg(test)]
const CORNERS: usize = (4 * PARTS * PARTS + 2) as usize;

/// A point of the octahedron: coordinates whose magnitudes add up to [`PARTS`].
pub(super) type Corner = [i32; 3];

/// The three corners around a direction (any finite length but 0), and how much each counts: from 0, together 1.
pub(super) fn around(direction: [f64; 3]) -> [(Corner, f32); 3] {
    let size: f64 = direction.iter().map(|c| c.abs()).sum();
    let place = direction.map(|c| c.abs() / size * f64::from(PARTS));
    let low = place.map(|c| (c as i32).clamp(0, PARTS));
    let part: [f64; 3] = std::array::from_fn(|axis| place[axis] - f64::from(low[axis]));
    let corner = |steps: Corner| -> Corner {
        std::array::from_fn(|axis| (low[axis] + steps[axis]) * if direction[axis] < 0.0 { -1 } else { 1 })
    };
    let unit = |at: usize| -> Corner { std::array::from_fn(|axis| i32::from(axis == at)) };
    let weights = match PARTS - low.iter().sum::<i32>() {
        1 => std::array::from_fn(|at| (corner(unit(at)), part[at])),
        2 => std::array::from_fn(|at| (corner(unit(at).map(|step| 1 - step)), 1.0 - part[at])),
        // On a corner, but for rounding.
        left => [(corner([left / 3; 3]), 1.0); 3].map(|(corner, weight)| (corner, weight / 3.0)),
    };
    let sum: f64 = weights.iter().map(|(_, weight)| weight.max(0.0)).sum();
    weights.map(|(corner, weight)| (corner, (weight.max(0.0) / sum) as f32))
}

/// The direction of a corner, not of unit length.
pub(super) fn direction(corner: Corner) -> [f64; 3] {
    corner.map(f64::from)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::plants::noise;

    fn anywhere(seed: u32) -> [f64; 3] {
        [1, 2, 3].map(|axis| f64::from(noise(seed, axis)) - 0.5)
    }

    fn unit(v: [f64; 3]) -> [f64; 3] {
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| c / length)
    }

    #[test]
    fn a_direction_lies_between_its_corners_and_they_are_few() {
        let mut used = BTreeSet::new();
        let axes = [[1.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 1e-9], [1.0, 1.0, 0.0], [-3.0, 4.0, 1.0]];
        for towards in (0..20_000).map(anywhere).chain(axes) {
            let found = around(towards);
            let mut met = [0.0; 3];
            for (corner, weight) in found {
                assert_eq!(corner.iter().map(|c| c.abs()).sum::<i32>(), PARTS, "{towards:?}");
                assert!((0.0..=1.0).contains(&weight));
                if weight > 1e-6 {
                    let along =
                        unit(direction(corner)).iter().zip(unit(towards)).map(|(a, b)| a * b).sum::<f64>();
                    assert!(along > libm::cos(14.1_f64.to_radians()), "{towards:?}: {corner:?}");
                    used.insert(corner);
                }
                met = std::array::from_fn(|axis| met[axis] + f64::from(weight) * direction(corner)[axis]);
            }
            let off = unit(met).iter().zip(unit(towards)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-6, "{towards:?}: {off}");
        }
        assert_eq!(used.len(), CORNERS);
    }

    #[test]
    fn weights_do_not_jump() {
        let weights = |towards: [f64; 3]| -> Vec<(Corner, f32)> { around(towards).into() };
        for seed in 0..20_000 {
            let (here, step) = (unit(anywhere(seed)), unit(anywhere(seed + 20_000)));
            let there = std::array::from_fn(|axis| here[axis] + 1e-6 * step[axis]);
            let (here, there) = (weights(here), weights(there));
            for (corner, weight) in here.iter().chain(&there) {
                let of = |all: &[(Corner, f32)]| {
                    all.iter().filter(|(other, _)| other == corner).map(|(_, weight)| weight).sum::<f32>()
                };
                assert!((of(&here) - of(&there)).abs() < 1e-4, "{seed}: {corner:?} of {weight}");
            }
        }
    }
}
