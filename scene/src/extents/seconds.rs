//! Second sheets that lie too far behind their leaves to be taken for the other side: whether the leaf area is stated
//! twice, only the maker of the mesh knows.
//!
//! Some leaf triangles are looked at, spread over all, and the blades that they are part of: a leaf may be cut into
//! small triangles. One is doubled where other parallel leaves lie before each of its points that are looked at, or
//! behind each, all about as far away, or where nearly all of its blade is: either sheet may be cut into triangles in
//! its own way. Sheets that lie on each other count point by point. What is nearer than [`crate::sheets`] looks for is
//! one leaf already.

mod gaps;
mod near;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;

use super::Doubt;
use super::leaves::Leaves;
use crate::alpha::Coverage;
use crate::mesh::sides::Side;
use crate::sheets::corners;
use crate::{ClassedMesh, MaterialClass, Mesh};
use gaps::{Among, Gaps, Probe};

/// Leaf triangles that are looked at.
const LOOKED_AT: usize = 1024;
/// Points of a triangle that are looked at: weights of its corners. They lie off its edges, so that a second sheet may
/// be a little smaller or turned.
const POINTS: [[f64; 3]; 3] = [[0.7, 0.15, 0.15], [0.15, 0.7, 0.15], [0.15, 0.15, 0.7]];
/// The one point of a triangle of a blade.
const MIDDLE: [[f64; 3]; 1] = [[1.0 / 3.0; 3]];
/// Triangles of a blade that are looked at, and blades.
const OF_BLADE: usize = 16;
const BLADES: usize = 256;
/// Sheets lie on each other that are no further apart than this share of how far a second sheet may lie. They count
/// point by point: one may cover a part of the other.
const CLOSE: f64 = 0.02;
/// Share of the points of a blade that have a second sheet, at least.
const MIN_COVERED: f64 = 0.85;
/// How far a second sheet lies at most, as a share of the longest edge and of the least height of a triangle, or of a
/// blade's length and width: a leaf beside a leaf, or the far side of a needle, lies farther.
const APART: [f64; 2] = [0.06, 0.25];
/// That distance is at most so many times the mean over the leaf area, and for a blade so many times its triangle's.
const MAX_REACH: f64 = 4.0;
const MAX_BLADE: f64 = 16.0;
/// A blade is looked at where its reach is so many times that of its triangle.
const WORTH: f64 = 1.5;
/// Gaps at the points of one triangle or blade differ by no more than this factor.
const ALIKE: f64 = 1.5;
/// Sheets lie on each other up to what coordinates are rounded by, as a share of the plant's longest edge.
const ROUNDING: f64 = 1e-6;
/// Least share of the leaf area that is worth a doubt.
const MIN_SHARE: f64 = 0.05;

/// How far a second sheet may lie from a leaf of this area and length.
fn reach_of(area_m2: f64, longest_m: f64) -> f64 {
    (APART[0] * longest_m).min(APART[1] * area_m2 / longest_m)
}

/// A triangle that is looked at.
#[derive(Clone, Copy)]
struct Flat {
    triangle: u32,
    normal: DVec3,
    area_m2: f64,
    reach_m: f64,
}

impl Flat {
    fn of(mesh: &Mesh, triangle: u32) -> Option<Flat> {
        let [a, b, c] = corners(mesh, triangle);
        let cross = (b - a).cross(c - a);
        let longest_m = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let (twice_m2, normal) = (cross.length(), cross.try_normalize()?);
        let reach_m = reach_of(twice_m2, longest_m);
        let is_flat = reach_m > 0.0 && reach_m.is_finite();
        is_flat.then_some(Flat { triangle, normal, area_m2: 0.5 * twice_m2, reach_m })
    }
}

/// Blades that are looked at.
struct Blades<'l> {
    /// `[leaf]`: its blade.
    numbers: &'l [u32],
    of_number: HashMap<u32, Blade>,
}

/// A blade that is looked at.
#[derive(Default)]
struct Blade {
    leaves: Vec<u32>,
    /// How far a second sheet may lie from it; known once it was looked at.
    reach_m: Option<f64>,
    /// Its points among all.
    points: Range<usize>,
}

impl<'l> Blades<'l> {
    /// The blades of some leaves, by their places among all.
    fn of(leaves: &'l Leaves, some: impl Iterator<Item = usize>) -> Blades<'l> {
        let numbers = &leaves.blades;
        let mut of_number: HashMap<u32, Blade> =
            some.map(|place| (numbers[place], Blade::default())).collect();
        for (&leaf, number) in leaves.triangles.iter().zip(numbers) {
            if let Some(blade) = of_number.get_mut(number) {
                blade.leaves.push(leaf);
            }
        }
        Blades { numbers, of_number }
    }

    /// Looks at the blade of a leaf, unless that was done or its triangle tells as much.
    fn look_at(&mut self, mesh: &Mesh, place: usize, flat: &Flat, probes: &mut Vec<Probe>) {
        let number = self.numbers[place];
        let blade = self.of_number.get_mut(&number).expect("the blades of these leaves");
        let of_blade = *blade.reach_m.get_or_insert_with(|| reach_of_blade(mesh, &blade.leaves));
        let reach_m = of_blade.min(MAX_BLADE * flat.reach_m);
        if blade.points.end > 0 || reach_m < WORTH * flat.reach_m {
            return;
        }
        let first = probes.len();
        let wanted = blade.leaves.len().min(OF_BLADE);
        for at in 0..wanted {
            let flat = Flat::of(mesh, blade.leaves[at * blade.leaves.len() / wanted]);
            let of_triangle =
                flat.map(|flat| Probe::of(mesh, Flat { reach_m, ..flat }, Some(number), &MIDDLE));
            probes.extend(of_triangle.into_iter().flatten());
        }
        blade.points = first..probes.len();
    }

    /// The points of a leaf's blade; none where it was not looked at.
    fn points(&self, place: usize) -> Range<usize> {
        self.of_number.get(&self.numbers[place]).map_or(0..0, |blade| blade.points.clone())
    }
}

/// How far a second sheet may lie from a blade of these leaves.
fn reach_of_blade(mesh: &Mesh, leaves: &[u32]) -> f64 {
    let (mut low, mut high, mut area_m2) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0);
    for &leaf in leaves {
        let [a, b, c] = corners(mesh, leaf);
        (low, high) = (low.min(a).min(b).min(c), high.max(a).max(b).max(c));
        area_m2 += 0.5 * (b - a).cross(c - a).length();
    }
    reach_of(area_m2, low.distance(high))
}

/// Doubts a plant of whose leaves a good part has a second sheet.
pub(super) fn doubt(plant: &ClassedMesh, of_plant: &Leaves, longest_m: f64) -> Option<Doubt> {
    let mesh = &plant.mesh;
    let leaves = &of_plant.triangles;
    // What is one side of a leaf has its other side.
    let is_whole = |place: &usize| mesh.sheets.side(leaves[*place] as usize) == Side::Both;
    let wholes: Vec<usize> = (0..leaves.len()).filter(is_whole).collect();
    let wanted = wholes.len().min(LOOKED_AT);
    let places = (0..wanted).map(|at| wholes[at * wholes.len() / wanted]);
    let mut flats: Vec<(usize, Flat)> =
        places.filter_map(|place| Some((place, Flat::of(mesh, leaves[place])?))).collect();
    let looked_m2: f64 = flats.iter().map(|(_, flat)| flat.area_m2).sum();
    if flats.is_empty() {
        return None;
    }
    let mean = |of: &dyn Fn(&Flat) -> f64| {
        flats.iter().map(|(_, flat)| flat.area_m2 * of(flat)).sum::<f64>() / looked_m2
    };
    // The reach of a few large triangles is not searched around all.
    let (most_m, size_m) = (MAX_REACH * mean(&|flat| flat.reach_m), mean(&|flat| flat.area_m2.sqrt()));
    flats.iter_mut().for_each(|(_, flat)| flat.reach_m = flat.reach_m.min(most_m));
    let mut probes: Vec<Probe> =
        flats.iter().flat_map(|(_, flat)| Probe::of(mesh, *flat, None, &POINTS)).collect();
    let step = flats.len().div_ceil(BLADES);
    let some = || flats.iter().step_by(step);
    let mut blades = Blades::of(of_plant, some().map(|(place, _)| *place));
    some().for_each(|(place, flat)| blades.look_at(mesh, *place, flat, &mut probes));
    let rounding_m = ROUNDING * longest_m;
    let among = Among { mesh, leaves, blades: blades.numbers, size_m, longest_m, rounding_m };
    let gaps = among.gaps(&probes, None);
    let points = |at: usize| at * POINTS.len()..(at + 1) * POINTS.len();
    let by_triangle = |at: usize| Some((1.0, common_gap(&gaps[points(at)], 1.0)?));
    let by_blade = |at: usize| Some((1.0, common_gap(&gaps[blades.points(flats[at].0)], MIN_COVERED)?));
    let by_point =
        |gaps: &[Gaps]| share(&flats, 1, |at| close_gap(&gaps[points(at)], CLOSE * flats[at].1.reach_m));
    let mut of_points = by_point(&gaps);
    if of_points[0] > MIN_SHARE {
        // What lies on each other may have alpha that cuts the one where the other is.
        let of_triangles = &probes[..flats.len() * POINTS.len()];
        of_points = match coverage(plant) {
            Some(coverage) if coverage.iter().all(|of| *of == Coverage::Full) => of_points,
            Some(coverage) => by_point(&among.gaps(of_triangles, Some(&coverage))),
            None => [0.0; 2],
        };
    }
    let of_triangles = share(&flats, 1, by_triangle);
    let of_blades = share(&flats, step, |at| by_triangle(at).or_else(|| by_blade(at)));
    let most = |a: [f64; 2], b: [f64; 2]| if b[0] > a[0] { b } else { a };
    let [share, gap_m] = most(most(of_triangles, of_blades), of_points);
    if share <= MIN_SHARE {
        return None;
    }
    let area_m2 = |&leaf: &u32| Flat::of(mesh, leaf).map_or(0.0, |flat| flat.area_m2);
    let leaf_m2 = plant.area_m2(MaterialClass::Leaf);
    let whole_m2: f64 = wholes.iter().map(|place| area_m2(&leaves[*place])).sum();
    let gap_m = if gap_m > rounding_m { gap_m } else { 0.0 };
    Some(Doubt::SecondSheets { sheets_m2: share * whole_m2, leaf_m2, gap_m })
}

/// The share of area with a second sheet, of every `step`th triangle, and the mean gap there. `found` gives the share
/// of a triangle that has one, and the gap.
fn share(flats: &[(usize, Flat)], step: usize, found: impl Fn(usize) -> Option<(f64, f64)>) -> [f64; 2] {
    let (mut looked_m2, mut doubled_m2, mut gap_sum) = (0.0, 0.0, 0.0);
    for (at, (_, flat)) in flats.iter().enumerate().step_by(step) {
        let (share, gap_m) = found(at).unwrap_or_default();
        looked_m2 += flat.area_m2;
        doubled_m2 += share * flat.area_m2;
        gap_sum += gap_m * share * flat.area_m2;
    }
    [doubled_m2 / looked_m2, gap_sum / doubled_m2.max(f64::MIN_POSITIVE)]
}

/// What alpha leaves of the leaves' materials, all of others; `None` where a picture cannot be used, which later stages
/// tell.
fn coverage(plant: &ClassedMesh) -> Option<Vec<Coverage>> {
    let of = |(material, class): (usize, &MaterialClass)| match class {
        MaterialClass::Leaf => Coverage::of(&plant.mesh, material),
        _ => Ok(Coverage::Full),
    };
    plant.classes.iter().enumerate().map(of).collect::<Result<_, _>>().ok()
}

/// The gap that a share of all points have to one side, alike, if so many have.
fn common_gap(gaps: &[Gaps], share: f64) -> Option<f64> {
    let wanted = libm::ceil(share * gaps.len() as f64).max(1.0) as usize;
    let to_side = |side: usize| {
        let of_side = || gaps.iter().map(move |gaps| gaps.sides[side]).filter(|gap| gap.is_finite());
        let is_common =
            |least: &f64| of_side().filter(|gap| (*least..=ALIKE * least).contains(gap)).count() >= wanted;
        of_side().filter(is_common).reduce(f64::min)
    };
    [0, 1].into_iter().filter_map(to_side).reduce(f64::min)
}

/// The share of points that have a leaf this near, and their mean gap; `None` for none.
fn close_gap(gaps: &[Gaps], close_m: f64) -> Option<(f64, f64)> {
    let close: Vec<f64> = gaps.iter().map(|gaps| gaps.least).filter(|gap| *gap <= close_m).collect();
    let count = close.len() as f64;
    (count > 0.0).then(|| (count / gaps.len() as f64, close.iter().sum::<f64>() / count))
}
