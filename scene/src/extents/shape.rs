//! Whether the parts of a plant fit together: one scale, no far scrap, leaves on the wood.

use flb_format::meta::Bounds;

use super::{Doubt, Extents};
use crate::import::area;
use crate::mesh::Part;
use crate::plant::bounds_where;
use crate::{ClassedMesh, MaterialClass};

/// Share of the area that is left off either end of each axis: a scrap far off is less.
const SCRAP: f64 = 0.005;
/// What is left of the plant without scraps is shorter than this share of its longest edge.
const MAX_REST: f64 = 0.5;
/// Bins along each axis.
const BINS: usize = 1024;
/// Leaves span so many times what the wood spans at most, and wood what the leaves span.
const MAX_OF_WOOD: f64 = 8.0;
const MAX_OF_LEAVES: f64 = 20.0;
/// Air between leaves and wood, as a share of the plant's longest edge.
const MAX_AIR: f64 = 0.1;
/// The second longest edge of a plant is this share of the longest one at least.
const MIN_SIDE: f64 = 1e-3;

/// Doubts of that kind, at most one: what is wrong at large is the cause of the rest.
pub(super) fn doubt(plant: &ClassedMesh, extents: &Extents) -> Option<Doubt> {
    let mut sides_m = extents.size_m();
    sides_m.sort_by(f64::total_cmp);
    let [_, second, longest_m] = sides_m;
    if second < MIN_SIDE * longest_m {
        return Some(Doubt::Thin { size_m: extents.size_m() });
    }
    if let Some(doubt) = scrap(plant, extents) {
        return Some(doubt);
    }
    let bounds = |of: MaterialClass| bounds_where(&plant.mesh, &plant.classes, |class| class == of);
    let [leaves, wood] = [MaterialClass::Leaf, MaterialClass::Wood].map(bounds);
    if let (Some(leaves), Some(wood)) = (leaves, wood) {
        let [leaf_m, wood_m] = [leaves, wood].map(|bounds| longest(&bounds));
        if leaf_m > MAX_OF_WOOD * wood_m || wood_m > MAX_OF_LEAVES * leaf_m {
            return Some(Doubt::Scales { leaf_m, wood_m });
        }
        let gap_m = gap(&leaves, &wood);
        if gap_m > MAX_AIR * longest_m {
            return Some(Doubt::Air { gap_m });
        }
    }
    None
}

fn longest(bounds: &Bounds) -> f64 {
    (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f64::max)
}

/// Length of the air between two boxes along the axis that has most.
fn gap(a: &Bounds, b: &Bounds) -> f64 {
    let along = |axis: usize| (a.min[axis] - b.max[axis]).max(b.min[axis] - a.max[axis]);
    (0..3).map(along).fold(0.0, f64::max)
}

/// A scrap far off, by which the plant's box is over twice as long as the rest.
fn scrap(plant: &ClassedMesh, extents: &Extents) -> Option<Doubt> {
    let (mesh, low, size_m) = (&plant.mesh, extents.bounds_m.min, extents.size_m());
    let longest_m = extents.longest_m();
    // `[axis][bin]`: area of triangles, a third at each corner.
    let mut bins = vec![[0.0f64; BINS]; 3];
    let is_plant = |triangle: &usize| {
        plant.classes[mesh.triangle_material[*triangle] as usize] != MaterialClass::Neither
    };
    let of_plant = || (0..mesh.triangles.len()).filter(is_plant).map(|triangle| mesh.corners_m(triangle));
    let mut all_m2 = 0.0;
    for points in of_plant() {
        let area_m2 = area(points);
        all_m2 += area_m2;
        for (axis, bins) in bins.iter_mut().enumerate() {
            for point in points {
                let share = (point[axis] - low[axis]) / longest_m;
                bins[((share * BINS as f64) as usize).min(BINS - 1)] += area_m2 / 3.0;
            }
        }
    }
    let bin_m = longest_m / BINS as f64;
    let ends = |axis: usize| {
        let first = ends_of(bins[axis].iter(), SCRAP * all_m2);
        let last = BINS - ends_of(bins[axis].iter().rev(), SCRAP * all_m2);
        [low[axis] + first as f64 * bin_m, low[axis] + last as f64 * bin_m]
    };
    let rest: [[f64; 2]; 3] = std::array::from_fn(ends);
    let rest_m = rest.iter().map(|[from, to]| to - from).fold(0.0, f64::max);
    if rest_m >= MAX_REST * longest_m {
        return None;
    }
    let axis = (0..3).max_by(|a, b| size_m[*a].total_cmp(&size_m[*b]))?;
    let beyond = |point: &[f64; 3]| (rest[axis][0] - point[axis]).max(point[axis] - rest[axis][1]);
    let at_m = of_plant().flatten().max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
    let holds =
        |bounds: &Bounds| (0..3).all(|axis| (bounds.min[axis]..=bounds.max[axis]).contains(&at_m[axis]));
    let parts = mesh.parts.iter().filter(|part| part.bounds_m().is_some_and(|bounds| holds(&bounds)));
    let smallest = parts.min_by(|a, b| {
        let of = |part: &Part| part.bounds_m().map_or(f64::INFINITY, |bounds| longest(&bounds));
        of(a).total_cmp(&of(b))
    });
    Some(Doubt::Scrap { part: smallest.map(|part| part.label()), at_m, longest_m, rest_m })
}

/// Bins from an end that together hold less than `share_m2`.
fn ends_of<'b>(bins: impl Iterator<Item = &'b f64>, share_m2: f64) -> usize {
    let mut sum = 0.0;
    bins.take_while(|area_m2| {
        sum += **area_m2;
        sum < share_m2
    })
    .count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::soup;

    /// A trunk 2 m high and 200 leaves around its top, their corners changed by `of_leaf`; then some more triangles.
    fn plant(of_leaf: impl Fn([f32; 3]) -> [f32; 3], more: &[[[f32; 3]; 3]]) -> ClassedMesh {
        let trunk = [[[-0.05, 0.0, 0.0], [0.05, 0.0, 0.0], [0.0, 2.0, 0.05]]];
        let leaves = (0..200).map(|at| {
            let place = |step: f32| (at as f32 * step).fract();
            let [x, y, z] = [place(0.618) - 0.5, 1.2 + place(0.414), place(0.732) - 0.5];
            [[x, y, z], [x + 0.1, y, z], [x, y, z + 0.1]].map(&of_leaf)
        });
        let all: Vec<[[f32; 3]; 3]> = trunk.into_iter().chain(leaves).chain(more.iter().copied()).collect();
        let mut mesh = soup(&all);
        mesh.triangle_material = (0..all.len() as u32).map(|at| u32::from(at == 0)).collect();
        ClassedMesh { mesh, classes: vec![MaterialClass::Leaf, MaterialClass::Wood] }
    }

    fn found(plant: &ClassedMesh) -> Option<Doubt> {
        doubt(plant, &Extents::of(plant).expect("a box"))
    }

    #[test]
    fn a_scrap_far_off_is_a_doubt_with_its_place() {
        assert_eq!(found(&plant(|point| point, &[])), None);
        let scrap = |x: f32| [[[x, 1.0, 0.0], [x + 0.1, 1.0, 0.0], [x, 1.0, 0.1]]];
        assert_eq!(found(&plant(|point| point, &scrap(1.5))), None);
        match found(&plant(|point| point, &scrap(40.0))) {
            Some(Doubt::Scrap { at_m, longest_m, rest_m, .. }) => {
                assert!((at_m[0] - 40.1).abs() < 1e-3 && (longest_m - 40.6).abs() < 0.1, "{at_m:?}");
                assert!((1.0..2.5).contains(&rest_m), "{rest_m}");
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn parts_of_other_scales_and_parts_apart_are_a_doubt() {
        let scaled = |by: f32| found(&plant(|point| point.map(|c| by * c), &[]));
        assert!(matches!(scaled(0.01), Some(Doubt::Scales { .. })));
        // The trunk is a scrap of such a crown.
        assert!(matches!(scaled(20.0), Some(Doubt::Scales { .. } | Doubt::Scrap { .. })));
        assert_eq!(scaled(0.9), None);
        match found(&plant(|[x, y, z]| [x, y + 2.0, z], &[])) {
            Some(Doubt::Air { gap_m }) => assert!((gap_m - 1.2).abs() < 0.05, "{gap_m}"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn degrees_beside_metres_are_a_doubt() {
        let mut plant = plant(|point| point, &[]);
        plant.mesh.positions.iter_mut().for_each(|[x, _, z]| (*x, *z) = (*x * 1e-5, *z * 1e-5));
        assert!(matches!(found(&plant), Some(Doubt::Thin { .. })));
    }
}
