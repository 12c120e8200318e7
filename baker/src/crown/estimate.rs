//! From what rays met in the sites to extinction, and the factor that makes a crown as open as its mesh.

use super::directions::Axis;
use super::measure::SiteLight;
use super::view::View;
use flb_transport::turbid::TurbidMedium;

/// Rays that arrive which all rays through a site, blocked before or not, count for.
const PRIOR_ARRIVED: f64 = 8.0;

/// Rays that the formula counts for beside the rays measured: it decides only where none is blocked, or all are.
const PRIOR_RAYS: f64 = 1.0;

/// Largest extinction times the edge of a site, before the factor. A site of it stops all but 4 % of the light, which
/// grazes its edges; a site that stops every ray would give any number.
const MAX_DEPTH: f64 = 16.0;

/// Replaces the extinctions of `sites` by measured ones.
pub(super) fn estimate(
    unclumped: TurbidMedium,
    sites: &[u32],
    light: &[SiteLight],
    axes: &[Axis],
) -> TurbidMedium {
    let cubes = Cubes::new(axes);
    let edge_m = unclumped.grid.spacing_m;
    let mut turbid = unclumped;
    for (&site, light) in sites.iter().zip(light) {
        let site = site as usize;
        let formula = f64::from(turbid.extinction(site));
        let leaf_share = f64::from(turbid.leaf_per_m[site]) / formula;
        let of_all =
            (light.blocked + PRIOR_RAYS * cubes.stopped(formula * edge_m)) / (light.rays + PRIOR_RAYS);
        let arrived = light.arrived + PRIOR_ARRIVED;
        let prior = PRIOR_ARRIVED * of_all;
        let leaf = light.first[0] + prior * leaf_share;
        let wood = light.first[1] + prior * (1.0 - leaf_share);
        let extinction = cubes.depth((leaf + wood) / arrived) / edge_m;
        // Leaves that face most of the light that arrives stop more of it than their mean extinction says.
        let facing = (light.arrived_leaf + PRIOR_ARRIVED) / arrived;
        turbid.leaf_per_m[site] = (extinction * leaf / (leaf + wood) / facing) as f32;
        turbid.wood_per_m[site] = (extinction * wood / (leaf + wood)) as f32;
    }
    turbid
}

/// The share of light that a cube of even extinction stops, in the mean over the measured rays.
pub(super) struct Cubes {
    /// Pairs of extinction times edge, and share stopped; both rise.
    table: Vec<(f64, f64)>,
}

impl Cubes {
    pub(super) fn new(axes: &[Axis]) -> Cubes {
        /// Rays along an edge of the cube, steps of the table, and steps in which the depth doubles.
        const FINE: (f64, i32, f64) = (24.0, 160, 10.0);
        let mut chords: Vec<(f64, f64)> = Vec::new();
        for axis in axes {
            let view = View::new(*axis, [0.5; 3], [0.5; 3], 1.0 / FINE.0);
            view.for_each_ray([0.0; 3], 1.0, |_, enter, leave| chords.push((axis.weight, leave - enter)));
        }
        let all: f64 = chords.iter().map(|(weight, _)| weight).sum();
        let entry = |step: i32| {
            let depth = MAX_DEPTH * libm::exp2(f64::from(step - FINE.1) / FINE.2);
            let stopped: f64 =
                chords.iter().map(|(weight, chord)| -weight * libm::expm1(-depth * chord)).sum();
            (depth, stopped / all)
        };
        Cubes { table: std::iter::once((0.0, 0.0)).chain((0..=FINE.1).map(entry)).collect() }
    }

    /// Share stopped at an extinction times edge.
    pub(super) fn stopped(&self, depth: f64) -> f64 {
        let at = self.table.partition_point(|entry| entry.0 < depth);
        self.between(at, |entry| *entry, depth)
    }

    /// Extinction times edge at which a share is stopped.
    fn depth(&self, stopped: f64) -> f64 {
        let at = self.table.partition_point(|entry| entry.1 < stopped);
        self.between(at, |&(depth, share)| (share, depth), stopped)
    }

    /// Linear between the entries before `at` and there; the last beyond the table.
    fn between(&self, at: usize, pair: impl Fn(&(f64, f64)) -> (f64, f64), x: f64) -> f64 {
        let Some(upper) = self.table.get(at) else { return pair(&self.table[self.table.len() - 1]).1 };
        let (upper, lower) = (pair(upper), pair(&self.table[at.saturating_sub(1)]));
        if upper.0 <= lower.0 {
            return upper.1;
        }
        lower.1 + (upper.1 - lower.1) * (x - lower.0) / (upper.0 - lower.0)
    }
}

/// The factor at which `passing`, which falls, is `gap`; from 1/8 to 8.
pub(super) fn factor(gap: f64, passing: impl Fn(f64) -> f64) -> f64 {
    /// Halvings of the interval of the logarithm: to 1e-6.
    const HALVINGS: usize = 22;
    let (mut low, mut high) = (-3.0, 3.0);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if passing(libm::exp2(middle)) > gap {
            low = middle;
        } else {
            high = middle;
        }
    }
    libm::exp2(f64::midpoint(low, high))
}
