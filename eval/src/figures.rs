//! Baked light against irradiance that was traced on the mesh: how far a picture is from the truth, without a picture.
//!
//! What a renderer makes of a file's fluence phi is phi / 4 on each side of a leaf and phi / 2 on the open side of wood
//! (docs/lighting-model.md, section 10). Errors are relative to the mean truth of their group, so that dark points do
//! not rule. The truth's own noise is taken out of the root mean square: of two independent halves of the truth, the
//! errors against the one and against the other are multiplied, so that the figure does not depend on their paths.

use flb_render::Surfaces;
use flb_render::irradiance::{Estimate, PointIrradiance};
use flb_scene::MaterialClass;
use flb_scene::surface_points::SurfacePoint;
use rayon::prelude::*;
use serde::Serialize;

/// Shares of open sky at which groups of depth end: the inside of a crown first.
pub const OPENNESS: [f32; 4] = [0.05, 0.2, 0.5, 1.0];

/// The fluence that a file gives at a point of model space, per band R, G, B, of a source: a sun by its number, or the
/// sky, which comes after the last. Without the sun's own beam, as a renderer asks for it.
pub type BakedLight<'a> = dyn Fn(usize, [f32; 3], &mut [f32; 3]) + Sync + 'a;

/// Error of baked light against the truth on a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshJudgement {
    /// Error on leaves, if there are any: the mean of both sides, which is what a viewer of either side sees of a leaf
    /// that reflects as much as it transmits.
    pub leaf: Option<ClassJudgement>,
    /// Error on wood, if there is any: the side that sees more of the sky.
    pub wood: Option<ClassJudgement>,
}

/// The points of one class.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClassJudgement {
    /// Error under all suns.
    pub suns: Option<Figures>,
    /// Error under the sky.
    pub sky: Option<Figures>,
    /// Error under all sources, by how much of the sky a point sees: up to each of [`OPENNESS`]; `None` where no point
    /// is.
    pub by_openness: [Option<Figures>; 4],
    /// Error of each side of a leaf by itself, under all sources: what it costs that a site has one light for both.
    pub sides: Option<Figures>,
    /// Error of what a viewer of either side of a leaf sees, under all sources: the irradiance of both sides, weighted
    /// by what the leaf reflects of that side and transmits of the other.
    pub seen: Option<Figures>,
    /// Error as [`Self::seen`], if the light of the file were shared out between the sides as in truth: the most that
    /// knowledge of the sides could bring.
    pub seen_with_sides: Option<Figures>,
}

/// Errors of found irradiances against true ones. Per band R, G, B.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Pairs of a point (or a side of it) and a source.
    pub count: usize,
    /// Mean irradiance in truth, of sources of irradiance or fluence 1.
    pub truth: [f64; 3],
    /// Standard error of the true mean.
    pub truth_error: [f64; 3],
    /// Mean irradiance found over mean truth.
    pub ratio: [f64; 3],
    /// Root mean square of found less true, over the mean truth, the truth's noise taken out.
    pub rms: [f64; 3],
    /// Error that 99 of 100 pairs stay below, over the mean truth, in the mean of the bands; the truth's noise is in
    /// it.
    pub percentile_99: f64,
    /// The pair that is furthest off.
    pub worst: Worst,
}

/// A pair that is furthest off, in the mean of the bands.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Worst {
    /// Point of model space, metres.
    pub point_m: [f32; 3],
    /// Index into the mesh's materials.
    pub material: usize,
    /// Number of the source.
    pub source: usize,
    /// Irradiance in truth.
    pub truth: [f64; 3],
    /// Irradiance found.
    pub found: [f64; 3],
}

/// One point, or a side of one, under one source.
struct Pair {
    point: usize,
    source: usize,
    open: f32,
    truth: [f64; 3],
    variance: [f64; 3],
    found: [f64; 3],
}

/// Compares light with the truth of the same points ([`flb_render::irradiance::irradiance`]), which was traced with the
/// same surfaces.
pub fn compare(
    points: &[SurfacePoint],
    truth: &[PointIrradiance],
    surfaces: &Surfaces,
    light: &BakedLight<'_>,
) -> MeshJudgement {
    let solid_offset_m = surfaces.solid_offset_m;
    let sources = truth.first().map_or(0, |truth| truth.sides[0].sources.len());
    let fluence: Vec<Vec<[f64; 3]>> = points
        .par_iter()
        .zip(truth)
        .map(|(point, truth)| {
            let at = truth.asked_at(point.position_m, solid_offset_m);
            let of_source = |source| {
                let mut phi = [0.0; 3];
                light(source, at, &mut phi);
                phi.map(f64::from)
            };
            (0..sources).map(of_source).collect()
        })
        .collect();
    let of_solids = if solid_offset_m.is_some() { 0.25 } else { 0.5 };
    let given = Given { points, truth, fluence: &fluence };
    MeshJudgement { leaf: given.leaf(surfaces), wood: given.wood(of_solids) }
}

/// What was traced and what was found, at each point.
struct Given<'a> {
    points: &'a [SurfacePoint],
    truth: &'a [PointIrradiance],
    /// `[point][source]`
    fluence: &'a [Vec<[f64; 3]>],
}

impl Given<'_> {
    /// Calls with each point of a class and each source: number of the point, its truth, the source, what falls on
    /// each side in truth, and the fluence that was found.
    fn each(
        &self,
        class: MaterialClass,
        mut call: impl FnMut(usize, &PointIrradiance, usize, [&Estimate; 2], [f64; 3]),
    ) {
        let of_class = self.truth.iter().zip(self.fluence).enumerate().filter(|(_, (t, _))| t.class == class);
        for (point, (truth, fluence)) in of_class {
            for (source, phi) in fluence.iter().enumerate() {
                let sides = truth.sides.each_ref().map(|side| &side.sources[source]);
                call(point, truth, source, sides, *phi);
            }
        }
    }

    fn leaf(&self, surfaces: &Surfaces) -> Option<ClassJudgement> {
        let shares = |of: [f32; 3]| -> [f64; 3] {
            let of_leaf =
                |band: usize| f64::from(surfaces.leaf_reflectance[band] + surfaces.leaf_transmittance[band]);
            // A black leaf sends out nothing, so that any weights will do.
            std::array::from_fn(
                |band| if of_leaf(band) > 0.0 { f64::from(of[band]) / of_leaf(band) } else { 0.5 },
            )
        };
        let (reflected, passed) = (shares(surfaces.leaf_reflectance), shares(surfaces.leaf_transmittance));
        let [mut mean, mut by_side, mut seen, mut with_sides] = [const { Vec::new() }; 4];
        self.each(MaterialClass::Leaf, |point, truth, source, sides, phi| {
            let open = truth.sides[0].open.max(truth.sides[1].open);
            let found = phi.map(|phi| phi / 4.0);
            let pair =
                |open, weights: [[f64; 3]; 2], found| Pair::of(point, source, open, sides, weights, found);
            mean.push(pair(open, [[0.5; 3]; 2], found));
            for (side, weights, turned) in [
                (0, [[1.0; 3], [0.0; 3]], [reflected, passed]),
                (1, [[0.0; 3], [1.0; 3]], [passed, reflected]),
            ] {
                by_side.push(pair(truth.sides[side].open, weights, found));
                seen.push(pair(open, turned, found));
                let known = std::array::from_fn(|band| {
                    let [a, b] = sides.map(|side| f64::from(side.mean[band]));
                    let both = if a + b > 0.0 { [2.0 * a / (a + b), 2.0 * b / (a + b)] } else { [1.0; 2] };
                    found[band] * (turned[0][band] * both[0] + turned[1][band] * both[1])
                });
                with_sides.push(pair(open, turned, known));
            }
        });
        let judged = self.judgement(&mean)?;
        let figures =
            |pairs: &[Pair]| Figures::of(&pairs.iter().collect::<Vec<_>>(), self.points, self.truth);
        let (sides, seen, seen_with_sides) = (figures(&by_side), figures(&seen), figures(&with_sides));
        Some(ClassJudgement { sides, seen, seen_with_sides, ..judged })
    }

    fn wood(&self, of_fluence: f64) -> Option<ClassJudgement> {
        let mut pairs = Vec::new();
        self.each(MaterialClass::Wood, |point, truth, source, sides, phi| {
            let open = truth.sides[0].open.max(truth.sides[1].open);
            let weights = if truth.faces_back() { [[0.0; 3], [1.0; 3]] } else { [[1.0; 3], [0.0; 3]] };
            pairs.push(Pair::of(point, source, open, sides, weights, phi.map(|phi| of_fluence * phi)));
        });
        self.judgement(&pairs)
    }

    /// Of all pairs of a class, by source and by depth.
    fn judgement(&self, pairs: &[Pair]) -> Option<ClassJudgement> {
        let sky = self.fluence.first().map_or(0, Vec::len).checked_sub(1)?;
        let figures = |pairs: Vec<&Pair>| Figures::of(&pairs, self.points, self.truth);
        let least = |group: usize| if group == 0 { -1.0 } else { OPENNESS[group - 1] };
        let judged = ClassJudgement {
            suns: figures(pairs.iter().filter(|pair| pair.source < sky).collect()),
            sky: figures(pairs.iter().filter(|pair| pair.source == sky).collect()),
            by_openness: std::array::from_fn(|group| {
                let is_in = |pair: &&Pair| pair.open > least(group) && pair.open <= OPENNESS[group];
                figures(pairs.iter().filter(is_in).collect())
            }),
            sides: None,
            seen: None,
            seen_with_sides: None,
        };
        (!pairs.is_empty()).then_some(judged)
    }
}

impl Pair {
    /// The truth is a sum over both sides by weights per band.
    fn of(
        point: usize,
        source: usize,
        open: f32,
        sides: [&Estimate; 2],
        weights: [[f64; 3]; 2],
        found: [f64; 3],
    ) -> Pair {
        let sum = |of: &dyn Fn(usize, usize) -> f64| std::array::from_fn(|band| of(0, band) + of(1, band));
        let weighed = |side: usize, band: usize| weights[side][band] * f64::from(sides[side].mean[band]);
        let noise = |side: usize, band: usize| {
            let difference = weights[side][band] * f64::from(sides[side].difference[band]);
            difference * difference
        };
        Pair { point, source, open, truth: sum(&weighed), variance: sum(&noise), found }
    }
}

impl Figures {
    fn of(pairs: &[&Pair], points: &[SurfacePoint], of_points: &[PointIrradiance]) -> Option<Figures> {
        let count = pairs.len() as f64;
        let mean = |value: &dyn Fn(&Pair, usize) -> f64| -> [f64; 3] {
            [0, 1, 2].map(|band| pairs.iter().map(|pair| value(pair, band)).sum::<f64>() / count)
        };
        let truth = mean(&|pair, band| pair.truth[band]);
        // Nothing is relative to a truth that is dark.
        if pairs.is_empty() || truth.iter().any(|truth| *truth <= 0.0) {
            return None;
        }
        let found = mean(&|pair, band| pair.found[band]);
        let variance = mean(&|pair, band| pair.variance[band]);
        let squares = mean(&|pair, band| {
            let off = pair.found[band] - pair.truth[band];
            off * off
        });
        let off = |pair: &Pair| {
            (0..3).map(|band| (pair.found[band] - pair.truth[band]).abs() / truth[band]).sum::<f64>() / 3.0
        };
        let mut by_error: Vec<(f64, usize)> = pairs.iter().map(|pair| off(pair)).zip(0..).collect();
        by_error.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let (_, worst) = *by_error.last()?;
        let worst = pairs[worst];
        Some(Figures {
            count: pairs.len(),
            truth,
            truth_error: variance.map(|variance| libm::sqrt(variance / count)),
            ratio: [0, 1, 2].map(|band| found[band] / truth[band]),
            rms: [0, 1, 2].map(|band| libm::sqrt((squares[band] - variance[band]).max(0.0)) / truth[band]),
            percentile_99: by_error[(0.99 * (count - 1.0)) as usize].0,
            worst: Worst {
                point_m: points[worst.point].position_m,
                material: of_points[worst.point].material,
                source: worst.source,
                truth: worst.truth,
                found: worst.found,
            },
        })
    }
}

#[cfg(test)]
mod tests;
