//! Whether leaves are larger or smaller than those of plants: of a mesh that states no unit, its leaves may tell.

use super::leaves::Leaves;
use super::{Doubt, Extents};
use crate::import::area;
use crate::sheets::corners;
use crate::unit::UNITS;
use crate::{ClassedMesh, MaterialClass};

/// Longest leaves that are not doubted, metres: bananas', and cards of a twig.
const MAX_M: f64 = 3.0;
/// The same of a plant whose leaves are longer than [`OF_PLANT`] of it, as a palm's fronds are.
const MAX_OF_PALMS_M: f64 = 8.0;
const OF_PLANT: f64 = 0.3;
/// Shortest leaves that are not doubted, metres, of a plant so many times as long: shorter ones are scales of mosses,
/// which are no larger themselves, and of heath, which no one models one by one.
const MIN_M: f64 = 1.5e-3;
const OF_LEAF: f64 = 50.0;
/// Plants whose leaves may be too short are no longer than this, metres.
const MAX_SMALL_M: f64 = 0.6;
/// Leaves whose triangles have shorter edges are many leaves that hold together.
const MIN_EDGE_M: f64 = 0.5;

/// The doubt, if half of the leaf area is of such leaves. `unit_m` is that by which the file was read.
pub(super) fn doubt(
    plant: &ClassedMesh,
    leaves: &Leaves,
    extents: &Extents,
    unit_m: Option<f64>,
) -> Option<Doubt> {
    let longest_m = extents.longest_m();
    // Most plants are shorter than a leaf that is too long, and longer than those whose leaves are too short.
    let is_small = longest_m <= MAX_SMALL_M;
    if longest_m <= MAX_M && !is_small {
        return None;
    }
    let count = leaves.blades.iter().max().map_or(0, |last| *last as usize + 1);
    let mut boxes = vec![[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; count];
    let mut areas_m2 = vec![0.0; count];
    let mut edges = Vec::with_capacity(leaves.triangles.len());
    for (&triangle, &blade) in leaves.triangles.iter().zip(&leaves.blades) {
        let points = corners(&plant.mesh, triangle);
        let area_m2 = area(points.map(|point| point.to_array()));
        let [a, b, c] = points;
        edges.push(((b - a).length().max((c - b).length()).max((a - c).length()), area_m2));
        areas_m2[blade as usize] += area_m2;
        let [low, high] = &mut boxes[blade as usize];
        for point in points {
            for axis in 0..3 {
                (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
            }
        }
    }
    let length = |[low, high]: &[[f64; 3]; 2]| (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let lengths = boxes.iter().map(length).zip(areas_m2).collect();
    let (length_m, edge_m) = (median(lengths)?, median(edges)?);
    if is_small {
        let is_short = length_m < MIN_M && OF_LEAF * length_m < longest_m;
        return is_short.then(|| Doubt::LeafSize { length_m, expected_m: [MIN_M, MAX_M], units: Vec::new() });
    }
    // A palm has a trunk, and a rosette has none.
    let has_wood = plant.classes.contains(&MaterialClass::Wood);
    let most_m = if has_wood && length_m > OF_PLANT * longest_m { MAX_OF_PALMS_M } else { MAX_M };
    if length_m <= most_m || edge_m < MIN_EDGE_M {
        return None;
    }
    let per_m = length_m / unit_m.unwrap_or(1.0);
    let would_be = UNITS.map(|(unit, unit_m)| (unit, per_m * unit_m));
    let units = would_be.into_iter().filter(|(_, length_m)| (1e-3..MAX_M).contains(length_m)).collect();
    Some(Doubt::LeafSize { length_m, expected_m: [MIN_M, most_m], units })
}

/// The value of which half of the weight is of smaller ones; `None` where there is none.
fn median(mut values: Vec<(f64, f64)>) -> Option<f64> {
    values.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let half = values.iter().map(|(_, weight)| weight).sum::<f64>() / 2.0;
    let mut sum = 0.0;
    values
        .into_iter()
        .find(|(_, weight)| {
            sum += weight;
            sum >= half
        })
        .map(|(value, _)| value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::soup;

    /// A trunk as high as this, and leaves about it of this length, of two triangles each.
    fn found(height: f32, leaf: f32) -> Option<Doubt> {
        found_with(height, leaf, MaterialClass::Wood)
    }

    fn found_with(height: f32, leaf: f32, trunk_is: MaterialClass) -> Option<Doubt> {
        let trunk = [[[-0.05 * height, 0.0, 0.0], [0.05 * height, 0.0, 0.0], [0.0, height, 0.0]]];
        let leaves = (0..200).flat_map(|at| {
            let place = |step: f32| height * (at as f32 * step).fract();
            let [x, y, z] = [place(0.618) - 0.5 * height, 0.5 * (height + place(0.414)), place(0.732)];
            let [a, b, c, d] =
                [[x, y, z], [x + leaf, y, z], [x + leaf, y, z + 0.4 * leaf], [x, y, z + 0.4 * leaf]];
            [[a, b, c], [a, c, d]]
        });
        let all: Vec<[[f32; 3]; 3]> = trunk.into_iter().chain(leaves).collect();
        let mut mesh = soup(&all);
        mesh.triangle_material = (0..all.len() as u32).map(|at| u32::from(at == 0)).collect();
        let plant = ClassedMesh { mesh, classes: vec![MaterialClass::Leaf, trunk_is] };
        let extents = Extents::of(&plant).expect("a box");
        doubt(&plant, &Leaves::of(&plant), &extents, None)
    }

    #[test]
    fn a_shrub_in_centimetres_is_told_by_its_leaves() {
        match found(80.0, 6.0) {
            Some(Doubt::LeafSize { length_m, units, .. }) => {
                assert!((length_m - 6.0).abs() < 1e-3, "{length_m}");
                let names: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
                assert!(names.contains(&"cm") && names.contains(&"in") && !names.contains(&"m"), "{names:?}");
            }
            other => panic!("{other:?}"),
        }
        assert!(found_with(9.0, 5.0, MaterialClass::Neither).is_some(), "a rosette in centimetres");
        // A tree of 13 m, centimetres taken for metres once too often.
        assert!(matches!(found(0.13, 0.0012), Some(Doubt::LeafSize { .. })));
        // A tree with cards of its twigs, a banana, a palm, and herbs; moss and thyme.
        let right =
            [(30.0, 2.0), (4.0, 2.7), (9.0, 5.0), (0.3, 0.1), (1.0, 0.6), (0.04, 0.002), (0.2, 0.005)];
        for (height, leaf) in right {
            assert_eq!(found(height, leaf), None, "{height} {leaf}");
        }
    }
}
