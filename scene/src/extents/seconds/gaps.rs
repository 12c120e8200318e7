//! How far other leaves lie before and behind points of leaves.

use glam::DVec3;
use rayon::prelude::*;

use super::Flat;
use super::near::Near;
use crate::Mesh;
use crate::alpha::Coverage;
use crate::rays::uv;
use crate::sheets::corners;

/// Least cosine between the normals of two sheets.
const PARALLEL: f64 = 0.9;

/// A leaf triangle that may be a second sheet.
struct Other {
    triangle: u32,
    blade: u32,
    corners: [DVec3; 3],
    /// Of twice its area.
    cross: DVec3,
}

impl Other {
    fn of(mesh: &Mesh, triangle: u32, blade: u32) -> Other {
        let corners = corners(mesh, triangle);
        let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        Other { triangle, blade, corners, cross }
    }

    /// How far before a point that is looked at this triangle lies, if it is parallel, near and neither the same nor
    /// beside it; and where that is on it, as weights of its second and third corner.
    fn gap(&self, probe: &Probe) -> Option<(f64, [f64; 2])> {
        let facing = probe.flat.normal.dot(self.cross);
        let is_same = self.triangle == probe.flat.triangle || probe.blade == Some(self.blade);
        if is_same || facing.abs() < PARALLEL * self.cross.length() {
            return None;
        }
        let gap = (self.corners[0] - probe.point).dot(self.cross) / facing;
        if gap.abs() > probe.flat.reach_m {
            return None;
        }
        let at = probe.point + gap * probe.flat.normal;
        let [a, b, c] = self.corners.map(|corner| corner - at);
        let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|side| side.dot(self.cross));
        let sum: f64 = sides.iter().sum();
        sides.iter().all(|side| *side >= 0.0).then(|| (gap, [sides[2] / sum, sides[0] / sum]))
    }
}

/// A point that is looked at.
pub(super) struct Probe {
    point: DVec3,
    /// Of the second and third corner of its triangle.
    weights: [f64; 2],
    /// Its triangle; with the reach of its blade where that is looked at.
    flat: Flat,
    /// The blade, of which nothing is a second sheet, where that is looked at.
    blade: Option<u32>,
}

impl Probe {
    /// The points of a triangle with these weights of its corners.
    pub(super) fn of(
        mesh: &Mesh,
        flat: Flat,
        blade: Option<u32>,
        weights: &[[f64; 3]],
    ) -> impl Iterator<Item = Probe> {
        let [a, b, c] = corners(mesh, flat.triangle);
        let point = move |[of_a, of_b, of_c]: &[f64; 3]| *of_a * a + *of_b * b + *of_c * c;
        weights.iter().map(move |weights| Probe {
            point: point(weights),
            weights: [weights[1], weights[2]],
            flat,
            blade,
        })
    }
}

/// The least gaps to leaves around a point that is looked at, metres; infinite where there is none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gaps {
    /// To what lies before it and behind it, further off than coordinates are rounded by.
    pub sides: [f64; 2],
    /// To what lies anywhere, on it, too.
    pub least: f64,
}

impl Gaps {
    const NONE: Gaps = Gaps { sides: [f64::INFINITY; 2], least: f64::INFINITY };

    fn add(&mut self, gap: f64, rounding_m: f64) {
        self.least = self.least.min(gap.abs());
        if gap.abs() > rounding_m {
            let side = &mut self.sides[usize::from(gap < 0.0)];
            *side = side.min(gap.abs());
        }
    }

    fn with(self, other: Gaps) -> Gaps {
        let sides = [0, 1].map(|side| self.sides[side].min(other.sides[side]));
        Gaps { sides, least: self.least.min(other.least) }
    }
}

/// Among which leaves gaps are looked for.
pub(super) struct Among<'m> {
    pub mesh: &'m Mesh,
    pub leaves: &'m [u32],
    /// `[leaf]`: its blade.
    pub blades: &'m [u32],
    /// Size of most of their triangles, metres.
    pub size_m: f64,
    /// Longest edge of the plant, metres.
    pub longest_m: f64,
    /// Up to here two sheets lie on each other, metres.
    pub rounding_m: f64,
}

impl Among<'_> {
    /// The gaps at all points. With a coverage, per material, what alpha cuts away is not there.
    pub(super) fn gaps(&self, probes: &[Probe], coverage: Option<&[Coverage]>) -> Vec<Gaps> {
        let points: Vec<DVec3> = probes.iter().map(|probe| probe.point).collect();
        let reach_m = probes.iter().map(|probe| probe.flat.reach_m).fold(0.0, f64::max);
        let near = Near::of(&points, reach_m, self.size_m, self.longest_m);
        let nothing = || vec![Gaps::NONE; probes.len()];
        let is_present = |triangle: u32, weights: [f64; 2]| {
            coverage.is_none_or(|coverage| {
                let material = self.mesh.triangle_material[triangle as usize] as usize;
                coverage[material].present_at(uv(self.mesh, triangle as usize, weights.map(|w| w as f32)))
            })
        };
        // The least gap on either side: however many sheets lie there, a point has one number for each.
        let meet = |mut gaps: Vec<Gaps>, (&triangle, &blade): (&u32, &u32)| {
            let other = Other::of(self.mesh, triangle, blade);
            near.each(&other.corners, |number| {
                let probe = &probes[number as usize];
                if let Some((gap, at)) = other.gap(probe)
                    && is_present(triangle, at)
                    && is_present(probe.flat.triangle, probe.weights)
                {
                    gaps[number as usize].add(gap, self.rounding_m);
                }
            });
            gaps
        };
        let of_both = |a: Vec<Gaps>, b: Vec<Gaps>| a.into_iter().zip(b).map(|(a, b)| a.with(b)).collect();
        let all = self.leaves.par_iter().zip(self.blades).with_min_len(4096);
        all.fold(nothing, meet).reduce(nothing, of_both)
    }
}
