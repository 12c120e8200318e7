//! From the beams of many suns to the light that the plant scatters, in several bands.

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_format::beam::Beam;
use flb_format::turbid::Turbid;
use rayon::prelude::*;

use super::OrdinatesSettings;
use super::march::March;
use super::relax::{Gains, relax};
use crate::lattice::kernel::LANES;
use crate::turbid::{BandScatter, Scatter};

/// One band: what sites scatter, and how many moments that takes.
pub struct Band {
    gains: Gains,
    moments: usize,
}

/// Second moments of phase functions up to this are left out: facets have 1/16.
const SLIGHT: f64 = 0.1;

impl Band {
    /// For the medium's non-empty sites.
    pub fn new(medium: &Turbid, sites: &[u32], scatter: &BandScatter) -> Band {
        let moment = |matter: &Scatter, l| matter.albedo * matter.phase.moment(l);
        let of = |matter: &Scatter| -> [f64; 3] { std::array::from_fn(|l| moment(matter, l)) };
        let (leaf, wood) = (of(&scatter.leaf), of(&scatter.wood));
        let at = |&site: &u32| {
            let site = site as usize;
            let share = f64::from(medium.wood_per_m[site]) / f64::from(medium.extinction(site));
            std::array::from_fn(|l| (leaf[l] + share * (wood[l] - leaf[l])) as f32)
        };
        let matters = [&scatter.leaf, &scatter.wood];
        let moments = if matters.iter().any(|matter| matter.phase.moment(2).abs() > SLIGHT) {
            9
        } else if matters.iter().any(|matter| matter.phase.moment(1) != 0.0) {
            4
        } else {
            1
        };
        Band { gains: Gains(sites.iter().map(at).collect()), moments }
    }
}

/// Scattered light of one band.
pub struct Lit {
    /// Scattered fluence `[sun][site]`, the sky last.
    pub light: Vec<Vec<f32>>,
    pub passes: u32,
    pub error_estimate: f64,
}

/// Scattered light of all suns, and of an even sky of fluence 1, in each band.
pub fn scatter(
    march: &March,
    bands: &[Band],
    beams: &[&Beam],
    settings: &OrdinatesSettings,
    progress: &(dyn Fn(f64) + Sync),
) -> Vec<Lit> {
    // The sky goes with the last suns, or by itself where they fill their lanes.
    let mut groups: Vec<&[&Beam]> = beams.chunks(LANES).collect();
    if beams.len().is_multiple_of(LANES) {
        groups.push(&[]);
    }
    let work: Vec<(&Band, usize)> =
        bands.iter().flat_map(|band| (0..groups.len()).map(move |g| (band, g))).collect();
    let done = AtomicUsize::new(0);
    let made: Vec<Lit> = work
        .par_iter()
        .map(|&(band, group)| {
            let sky = group + 1 == groups.len();
            let lit = match band.moments {
                1 => of_group::<1>(march, &band.gains, groups[group], sky, settings),
                4 => of_group::<4>(march, &band.gains, groups[group], sky, settings),
                _ => of_group::<9>(march, &band.gains, groups[group], sky, settings),
            };
            progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / work.len() as f64);
            lit
        })
        .collect();
    let mut made = made.into_iter();
    let mut next = || {
        let of_band: Vec<Lit> = made.by_ref().take(groups.len()).collect();
        let passes = of_band.iter().map(|lit| lit.passes).max().unwrap_or(0);
        let error_estimate = of_band.iter().map(|lit| lit.error_estimate).fold(0.0, f64::max);
        Lit { light: of_band.into_iter().flat_map(|lit| lit.light).collect(), passes, error_estimate }
    };
    bands.iter().map(|_| next()).collect()
}

/// Up to [`LANES`] suns, or fewer and the sky.
fn of_group<const M: usize>(
    march: &March,
    gains: &Gains,
    beams: &[&Beam],
    sky: bool,
    settings: &OrdinatesSettings,
) -> Lit {
    let mut first = march.first_scattering::<M>(gains, beams);
    if sky {
        march.add_first_of_sky(gains, beams.len(), &mut first);
    }
    let relaxed = relax(march, gains, &first, settings.tolerance, settings.max_passes);
    let lanes = beams.len() + usize::from(sky);
    let of_lane = |lane: usize| relaxed.light.iter().map(|moments| moments[0].0[lane]).collect();
    Lit {
        light: (0..lanes).map(of_lane).collect(),
        passes: relaxed.passes,
        error_estimate: relaxed.error_estimate,
    }
}
