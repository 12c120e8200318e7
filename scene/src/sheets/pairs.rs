//! Leaf sheets that lie on each other, or nearly: the two sides of one leaf.
//!
//! A triangle is *covered* if nearly all of it, as alpha leaves it, lies before or behind other leaf triangles, near by
//! and nearly parallel, where alpha leaves those, too. Triangles that are covered by others that are covered make two
//! sheets of one leaf, however either is cut into triangles. Each looks away from the other: where they lie apart, by
//! where they are, else by the side from which their vertices run counter-clockwise, or, where these are the same, the
//! first of them keeps its own.

use glam::DVec3;
use rayon::prelude::*;

use super::grid::{Flat, Grid};
use super::set;
use crate::Mesh;
use crate::alpha::Coverage;
use crate::mesh::sides::{Sheets, Side};
use crate::rays::uv;

/// Rows of the pattern of points at which a triangle is looked at: as many squared points.
const ROWS: u32 = 4;

/// Share of its points at which a triangle is covered, at least.
const COVERED: f64 = 0.85;

/// Share of its points up to which a triangle that lies on another one may only cross it.
const CROSSING: f64 = 0.25;

/// Rounds in which triangles that are covered by what is not covered itself drop out.
const ROUNDS: u32 = 16;

/// Height of one sheet over another that is no more than rounding, as a share of the largest coordinate.
const ROUNDING: f64 = 3e-7;

/// A leaf triangle on another one, by their places in the list of leaves.
#[derive(Clone, Copy)]
struct On {
    this: u32,
    other: u32,
    /// Points of `this` that are on `other`.
    points: u32,
    /// Whether both wind alike.
    alike: bool,
    /// Sum over these points of how far `this` lies before `other`, in the direction of the normal of `this`, metres.
    height: f64,
}

/// A triangle that is looked at.
struct Covered {
    /// Its points that alpha leaves, and those of them that others lie on.
    points: u32,
    covered: u32,
    on: Vec<On>,
}

impl Covered {
    fn is_covered(&self) -> bool {
        self.points > 0 && f64::from(self.covered) >= COVERED * f64::from(self.points)
    }

    /// Whether so much of it lies on another one that this is no leaf which crosses it.
    fn lies_on(&self, on: &On) -> bool {
        f64::from(on.points) >= CROSSING * f64::from(self.points)
    }
}

/// Gives the leaf triangles that are one of two sheets their sides, and returns those that lie between two sheets or
/// twice on the same: they have no side left.
pub(super) fn find(mesh: &Mesh, leaves: &[u32], longest_m: f64, found: &mut Sheets) -> Vec<u32> {
    let open: Vec<u32> =
        leaves.iter().copied().filter(|&triangle| found.side(triangle as usize) == Side::Both).collect();
    let grid = Grid::new(mesh, &open, longest_m);
    let candidates = candidates(mesh, &open, &grid, longest_m);
    if candidates.is_empty() {
        return Vec::new();
    }
    // In a first look every point is there: few of the candidates are covered at all, and alpha takes time.
    let candidates: Vec<u32> = candidates
        .into_par_iter()
        .with_min_len(64)
        .filter(|&index| look_at(mesh, &open, &grid, None, index).is_covered())
        .collect();
    if candidates.is_empty() {
        return Vec::new();
    }
    let Some(coverage) = coverage(mesh, &open) else { return Vec::new() };
    let looked: Vec<Covered> = candidates
        .par_iter()
        .with_min_len(64)
        .map(|&index| look_at(mesh, &open, &grid, Some(&coverage), index))
        .collect();
    let mut of_index: Vec<Option<Covered>> = (0..open.len()).map(|_| None).collect();
    candidates.iter().zip(looked).for_each(|(&index, looked)| of_index[index as usize] = Some(looked));
    drop_half_covered(&mut of_index);
    let rounding_m = ROUNDING * largest_coordinate(mesh, &open);
    let (fronts, hidden) = colour(&of_index, rounding_m);
    for (index, front) in fronts.iter().enumerate() {
        let Some(front) = front else { continue };
        let triangle = open[index];
        set(found, mesh, triangle, if *front { Side::Front } else { Side::Back });
        if !hidden[index] {
            found.pairs.triangles += 1;
            found.pairs.area_m2 += Flat::new(mesh, triangle).map_or(0.0, |flat| flat.area_m2());
        }
    }
    (0..open.len()).filter(|&index| hidden[index]).map(|index| open[index]).collect()
}

/// Those whose middle lies on another one that is as large or larger, and these others; ascending.
fn candidates(mesh: &Mesh, open: &[u32], grid: &Grid, longest_m: f64) -> Vec<u32> {
    let contacts = |index: usize| {
        let mut met = Vec::new();
        if let Some(flat) = Flat::new(mesh, open[index]) {
            grid.near(flat.centroid(), flat.level(longest_m), |other, of_other, _, _| {
                if other as usize != index && flat.is_parallel(of_other) {
                    met.extend([index as u32, other]);
                }
            });
        }
        met
    };
    let mut candidates: Vec<u32> =
        (0..open.len()).into_par_iter().with_min_len(256).flat_map_iter(contacts).collect();
    candidates.par_sort_unstable();
    candidates.dedup();
    candidates
}

/// What alpha leaves, per material of the leaves; `None` where a picture cannot be used, which later stages tell.
fn coverage(mesh: &Mesh, open: &[u32]) -> Option<Vec<Coverage>> {
    let mut used = vec![false; mesh.materials.len()];
    open.iter().for_each(|&triangle| used[mesh.triangle_material[triangle as usize] as usize] = true);
    let of =
        |material: usize| if used[material] { Coverage::of(mesh, material) } else { Ok(Coverage::Nothing) };
    (0..mesh.materials.len()).map(of).collect::<Result<_, _>>().ok()
}

/// Without a coverage, every point is there, and what is not covered is left as soon as that is known.
fn look_at(mesh: &Mesh, open: &[u32], grid: &Grid, coverage: Option<&[Coverage]>, index: u32) -> Covered {
    let is_present = |index: u32, weights: [f64; 2]| {
        let Some(coverage) = coverage else { return true };
        let triangle = open[index as usize] as usize;
        let material = mesh.triangle_material[triangle] as usize;
        coverage[material].present_at(uv(mesh, triangle, weights.map(|weight| weight as f32)))
    };
    let mut looked = Covered { points: 0, covered: 0, on: Vec::new() };
    let Some(flat) = Flat::new(mesh, open[index as usize]) else { return looked };
    for weights in pattern().filter(|&weights| is_present(index, weights)) {
        looked.points += 1;
        let bare = f64::from(looked.points - 1 - looked.covered);
        if coverage.is_none() && bare > (1.0 - COVERED) * f64::from(ROWS * ROWS) {
            return looked;
        }
        let mut met: Vec<(u32, f64, bool)> = Vec::new();
        grid.near(flat.point(weights), i16::MIN, |other, of_other, height, at| {
            if other != index && flat.is_parallel(of_other) && is_present(other, at) {
                let alike = flat.normal().dot(of_other.normal()) > 0.0;
                met.push((other, if alike { height } else { -height }, alike));
            }
        });
        met.sort_unstable_by_key(|met| met.0);
        met.dedup_by_key(|met| met.0);
        looked.covered += u32::from(!met.is_empty());
        for (other, height, alike) in met {
            match looked.on.iter_mut().find(|on| on.other == other) {
                Some(on) => {
                    on.points += 1;
                    on.height += height;
                }
                None => looked.on.push(On { this: index, other, points: 1, alike, height }),
            }
        }
    }
    looked
}

/// Middles of the small triangles that a triangle is cut into, as weights of the second and third vertex.
fn pattern() -> impl Iterator<Item = [f64; 2]> {
    let cell = |at: u32, part: f64| (f64::from(at) + part) / f64::from(ROWS);
    (0..ROWS).flat_map(move |row| {
        let upright = (0..ROWS - row).map(move |place| [cell(place, 1.0 / 3.0), cell(row, 1.0 / 3.0)]);
        let turned = (0..ROWS - row - 1).map(move |place| [cell(place, 2.0 / 3.0), cell(row, 2.0 / 3.0)]);
        upright.chain(turned)
    })
}

/// Keeps those that are covered by what is kept.
fn drop_half_covered(of_index: &mut [Option<Covered>]) {
    for _ in 0..ROUNDS {
        let is_kept: Vec<bool> = of_index.iter().map(Option::is_some).collect();
        let mut drops = false;
        for slot in of_index.iter_mut() {
            let Some(looked) = slot else { continue };
            looked.on.retain(|on| is_kept[on.other as usize]);
            let on: u32 = looked.on.iter().map(|on| on.points).sum();
            looked.covered = looked.covered.min(on);
            if !looked.is_covered() {
                *slot = None;
                drops = true;
            }
        }
        if !drops {
            return;
        }
    }
    // What still drops out of a long chain after so many rounds is no leaf of two sheets.
    of_index.iter_mut().for_each(|slot| *slot = None);
}

fn largest_coordinate(mesh: &Mesh, open: &[u32]) -> f64 {
    let largest = |&triangle: &u32| {
        super::corners(mesh, triangle)
            .map(|corner: DVec3| corner.abs().max_element())
            .into_iter()
            .fold(0.0, f64::max)
    };
    open.iter().map(largest).fold(0.0, f64::max)
}

/// Per triangle whether it stands for the side from which its vertices run counter-clockwise, and whether it has no
/// side left because others that look the same way cover it.
fn colour(of_index: &[Option<Covered>], rounding_m: f64) -> (Vec<Option<bool>>, Vec<bool>) {
    let mut fronts: Vec<Option<bool>> = vec![None; of_index.len()];
    let mut hidden = vec![false; of_index.len()];
    // Contacts in both directions: one may have found the other alone.
    let mut starts = vec![0u32; of_index.len() + 1];
    let contacts =
        || of_index.iter().flatten().flat_map(|looked| looked.on.iter().filter(|on| looked.lies_on(on)));
    contacts().for_each(|on| [on.this, on.other].iter().for_each(|&end| starts[end as usize + 1] += 1));
    for index in 0..of_index.len() {
        starts[index + 1] += starts[index];
    }
    let mut next = starts.clone();
    let mut around = vec![(0u32, false); starts[of_index.len()] as usize];
    for on in contacts() {
        for (end, other) in [(on.this, on.other), (on.other, on.this)] {
            around[next[end as usize] as usize] = (other, on.alike);
            next[end as usize] += 1;
        }
    }
    let mut group = Vec::new();
    for first in 0..of_index.len() {
        if of_index[first].is_none() || fronts[first].is_some() {
            continue;
        }
        group.clear();
        group.push(first as u32);
        fronts[first] = Some(true);
        let mut at = 0;
        while let Some(&this) = group.get(at) {
            at += 1;
            let front = fronts[this as usize] == Some(true);
            for &(other, alike) in &around[starts[this as usize] as usize..starts[this as usize + 1] as usize]
            {
                // Outer sides look away from each other.
                if of_index[other as usize].is_some() && fronts[other as usize].is_none() {
                    fronts[other as usize] = Some(front != alike);
                    group.push(other);
                }
            }
        }
        // Positive where what was chosen looks away from the other sheet.
        let outwards: f64 = group
            .iter()
            .filter_map(|&index| of_index[index as usize].as_ref().map(|looked| (index, looked)))
            .flat_map(|(index, looked)| looked.on.iter().map(move |on| (index, looked, on)))
            .filter(|(_, looked, on)| looked.lies_on(on))
            .map(|(index, _, on)| (index, on))
            .filter(|(_, on)| on.height.abs() > rounding_m * f64::from(on.points))
            .map(|(index, on)| if fronts[index as usize] == Some(true) { on.height } else { -on.height })
            .sum();
        if outwards < 0.0 {
            group
                .iter()
                .for_each(|&index| fronts[index as usize] = fronts[index as usize].map(|front| !front));
        }
    }
    for index in 0..of_index.len() {
        let Some(looked) = &of_index[index] else { continue };
        let looks_the_same_way = |on: &&On| (fronts[on.other as usize] == fronts[index]) == on.alike;
        let before = looked.on.iter().filter(|on| (on.other as usize) < index && !hidden[on.other as usize]);
        let points: u32 = before.filter(looks_the_same_way).map(|on| on.points).sum();
        hidden[index] = f64::from(points) >= COVERED * f64::from(looked.points);
    }
    (fronts, hidden)
}
