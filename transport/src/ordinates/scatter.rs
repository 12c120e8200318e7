//! From the beams of many suns to the light that the plant scatters, in several bands.

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_format::beam::Beam;
use flb_format::matter::TurbidMedium;
use flb_format::progress::{Cancelled, Progress};
use rayon::prelude::*;

use super::OrdinatesSettings;
use super::lanes::LANES;
use super::march::{March, SiteScattering};
use super::moments::{Moments, ScatteringMoments};
use super::source_iteration::source_iteration;
use crate::turbid::{BandScatter, Phase};

/// One band: what sites scatter, and how many moments that takes.
pub(super) struct Band {
    matter: SiteScattering,
    gains: ScatteringMoments,
    moments: usize,
}

/// Light that is scattered more than once is taken for even in direction, where albedo x mean cosine is no more than
/// this. (The first scattering goes by the phase functions themselves.)
const NEARLY_EVEN: f64 = 0.15;

/// Second moments of phase functions up to this are left out: facets have 1/16.
const SLIGHT: f64 = 0.1;

impl Band {
    /// For the medium's non-empty sites; what they have of their own is in place of `scatter`.
    pub(super) fn new(medium: &TurbidMedium, sites: &[u32], scatter: &BandScatter, own: &Own) -> Band {
        match own.transmitted {
            None => Band::alike(medium, sites, scatter, own.albedos),
            Some(transmitted) => Band::mixed(medium, sites, scatter, own.albedos, transmitted),
        }
    }

    /// Leaf and wood that scatter by one phase function each.
    fn alike(
        medium: &TurbidMedium,
        sites: &[u32],
        scatter: &BandScatter,
        albedos: Option<&[[f32; 2]]>,
    ) -> Band {
        let both = [&scatter.leaf, &scatter.wood];
        let wood_share =
            |site: usize| f64::from(medium.wood_per_m[site]) / f64::from(medium.extinction(site));
        let shares: Vec<[f64; 2]> = sites
            .iter()
            .map(|&site| {
                let wood = wood_share(site as usize);
                [1.0 - wood, wood]
            })
            .collect();
        let moments = if both.iter().any(|matter| matter.phase.moment(2).abs() > SLIGHT) {
            9
        } else if both.iter().any(|matter| (matter.albedo * matter.phase.moment(1)).abs() > NEARLY_EVEN) {
            4
        } else {
            1
        };
        let moment: [[f64; 3]; 2] = both.map(|matter| std::array::from_fn(|l| matter.phase.moment(l)));
        let albedo = |place: usize, i: usize| albedos.map_or(both[i].albedo, |of| f64::from(of[place][i]));
        let gains = shares.iter().enumerate().map(|(place, share)| {
            let gain = |i: usize, l: usize| share[i] * (albedo(place, i) * moment[i][l]);
            std::array::from_fn(|l| (gain(0, l) + gain(1, l)) as f32)
        });
        let albedos = shares
            .iter()
            .enumerate()
            .map(|(place, share)| std::array::from_fn(|i| (share[i] * albedo(place, i)) as f32));
        let matter = SiteScattering { albedos: albedos.collect(), phases: both.map(|matter| matter.phase) };
        Band { matter, gains: ScatteringMoments(gains.collect()), moments }
    }

    /// Facets of which each site's leaves let another share through. All that is scattered either passes a facet or
    /// comes back from one, of leaf or of wood alike: two phase functions again.
    fn mixed(
        medium: &TurbidMedium,
        sites: &[u32],
        scatter: &BandScatter,
        albedos: Option<&[[f32; 2]]>,
        transmitted: &[f32],
    ) -> Band {
        let phases = [1.0, 0.0].map(|transmitted| Phase::BiLambert { transmitted });
        let both = [scatter.leaf.albedo, scatter.wood.albedo];
        let shares = sites.iter().zip(transmitted).enumerate().map(|(place, (&site, &passes))| {
            let wood =
                f64::from(medium.wood_per_m[site as usize]) / f64::from(medium.extinction(site as usize));
            let [of_leaf, of_wood] = albedos.map_or(both, |of| of[place].map(f64::from));
            let (leaf, passes) = ((1.0 - wood) * of_leaf, f64::from(passes));
            [leaf * passes, leaf * (1.0 - passes) + wood * of_wood]
        });
        let shares: Vec<[f64; 2]> = shares.collect();
        let moment: [[f64; 3]; 2] = phases.map(|phase| std::array::from_fn(|l| phase.moment(l)));
        let gain = |share: &[f64; 2], l: usize| share[0] * moment[0][l] + share[1] * moment[1][l];
        let gains: Vec<[f32; 3]> =
            shares.iter().map(|share| std::array::from_fn(|l| gain(share, l) as f32)).collect();
        let slanted = gains.iter().any(|gain| f64::from(gain[1].abs()) > NEARLY_EVEN);
        let albedos = shares.iter().map(|share| share.map(|share| share as f32)).collect();
        let matter = SiteScattering { albedos, phases };
        Band { matter, gains: ScatteringMoments(gains), moments: if slanted { 4 } else { 1 } }
    }
}

/// What the sites of a band have of their own.
pub(super) struct Own<'a> {
    /// `[site][leaf, wood]`, in place of the band's.
    pub albedos: Option<&'a [[f32; 2]]>,
    /// `[site]`: share of what leaves scatter that comes out of the far side.
    pub transmitted: Option<&'a [f32]>,
}

/// Scattered light of one band.
pub(super) struct Lit {
    /// Scattered fluence `[sun][site]`, the sky last where it is wanted.
    pub light: Vec<Vec<f32>>,
    pub passes: u32,
    pub error_estimate: f64,
}

/// Scattered light of all suns, and of a sky of fluence 1 (`below` times that below the horizon) where that is wanted,
/// in each band.
pub(super) fn scatter(
    march: &March,
    bands: &[Band],
    beams: &[&Beam],
    below: f32,
    settings: &OrdinatesSettings,
    progress: &Progress<'_>,
) -> Result<Vec<Lit>, Cancelled> {
    // The sky goes with the last suns, or by itself where they fill their lanes.
    let mut groups: Vec<&[&Beam]> = beams.chunks(LANES).collect();
    if settings.sky() && beams.len().is_multiple_of(LANES) {
        groups.push(&[]);
    }
    let sets = sets(bands, groups.len());
    let work: Vec<(&[usize], usize)> =
        sets.iter().flat_map(|set| (0..groups.len()).map(move |group| (set.as_slice(), group))).collect();
    let done = AtomicUsize::new(0);
    let made = work
        .par_iter()
        .map(|&(set, group)| {
            let sky = (settings.sky() && group + 1 == groups.len()).then_some(below);
            let set: Vec<&Band> = set.iter().map(|&band| &bands[band]).collect();
            let lit = match set[0].moments {
                1 => of_bands::<1>(march, &set, groups[group], sky, settings),
                4 => of_bands::<4>(march, &set, groups[group], sky, settings),
                _ => of_bands::<9>(march, &set, groups[group], sky, settings),
            };
            progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / work.len() as f64)?;
            Ok(lit)
        })
        .collect::<Result<Vec<Vec<Lit>>, Cancelled>>()?;
    // Groups of each band in their order.
    let mut of_bands: Vec<Vec<Lit>> = bands.iter().map(|_| Vec::new()).collect();
    for ((set, _), made) in work.iter().zip(made) {
        set.iter().zip(made).for_each(|(&band, lit)| of_bands[band].push(lit));
    }
    let joined = |of_band: Vec<Lit>| {
        let passes = of_band.iter().map(|lit| lit.passes).max().unwrap_or(0);
        let error_estimate = of_band.iter().map(|lit| lit.error_estimate).fold(0.0, f64::max);
        Lit { light: of_band.into_iter().flat_map(|lit| lit.light).collect(), passes, error_estimate }
    };
    Ok(of_bands.into_iter().map(joined).collect())
}

/// Most bands that go together.
const TOGETHER: usize = 3;

/// Numbers of the bands that go together: of one number of moments, and no more than leave work for every thread.
/// Results do not depend on it.
fn sets(bands: &[Band], groups: usize) -> Vec<Vec<usize>> {
    let wanted = rayon::current_num_threads().div_ceil(groups.max(1));
    let most = (bands.len() / wanted).clamp(1, TOGETHER);
    let mut sets: Vec<Vec<usize>> = Vec::new();
    for (number, band) in bands.iter().enumerate() {
        match sets.iter_mut().find(|set| set.len() < most && bands[set[0]].moments == band.moments) {
            Some(set) => set.push(number),
            None => sets.push(vec![number]),
        }
    }
    sets
}

/// Up to [`TOGETHER`] bands under up to [`LANES`] suns, or fewer and the sky.
fn of_bands<const M: usize>(
    march: &March,
    bands: &[&Band],
    beams: &[&Beam],
    sky: Option<f32>,
    settings: &OrdinatesSettings,
) -> Vec<Lit> {
    match *bands {
        [a] => of_group::<M, 1>(march, [a], beams, sky, settings),
        [a, b] => of_group::<M, 2>(march, [a, b], beams, sky, settings),
        [a, b, c] => of_group::<M, 3>(march, [a, b, c], beams, sky, settings),
        _ => unreachable!("a set has up to {TOGETHER} bands"),
    }
}

fn of_group<const M: usize, const B: usize>(
    march: &March,
    bands: [&Band; B],
    beams: &[&Beam],
    sky: Option<f32>,
    settings: &OrdinatesSettings,
) -> Vec<Lit> {
    let mut first = march.first_scattering::<M, B>(bands.map(|band| &band.matter), beams);
    if let Some(below) = sky {
        for (band, first) in bands.iter().zip(&mut first) {
            march.add_first_of_sky(&band.gains, below, beams.len(), first);
        }
    }
    let lanes = beams.len() + usize::from(sky.is_some());
    let lit = |(band, first): (&Band, Moments<M>)| {
        let solved = source_iteration(march, &band.gains, &first, settings.tolerance, settings.max_passes);
        let of_lane = |lane: usize| solved.light.iter().map(|moments| moments[0].0[lane]).collect();
        Lit {
            light: (0..lanes).map(of_lane).collect(),
            passes: solved.passes,
            error_estimate: solved.error_estimate,
        }
    };
    bands.into_iter().zip(first).map(lit).collect()
}
