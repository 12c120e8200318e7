//! A band: what the sites of a medium scatter of its light.

use flb_format::matter::{LeafAngles, TurbidMedium};

use super::first::SiteScattering;
use super::moments::ScatteringMoments;
use crate::turbid::{BandScatter, Phase, extinction_moment, most_unlike_mean};

/// One band: what sites scatter, and how many moments that takes.
pub(super) struct Band {
    pub matter: SiteScattering,
    pub gains: ScatteringMoments,
    pub moments: usize,
    /// Guess of the scattered fluence under each sun of a plan, the sky last, `[sun][site]`, where there is one.
    pub guess: Option<Vec<Vec<f32>>>,
}

/// Light that is scattered more than once is taken for even in direction, where albedo x mean cosine is no more than
/// this. (The first scattering goes by the phase functions themselves.)
const NEARLY_EVEN: f64 = 0.15;

/// Leaves are taken to meet light that is scattered more than once alike from all sides, where the sum over all
/// scatterings of what they meet more or less of it is no more than this.
const NEARLY_ALIKE: f64 = 0.25;

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
        let albedo = |place: usize, i: usize| albedos.map_or(both[i].albedo, |of| f64::from(of[place][i]));
        let leaves = shares.iter().enumerate().map(|(place, share)| share[0] * albedo(place, 0));
        let (leaning, lean) = leaning(&medium.angles, leaves);
        let moments = if lean || both.iter().any(|matter| matter.phase.moment(2).abs() > SLIGHT) {
            9
        } else if both.iter().any(|matter| (matter.albedo * matter.phase.moment(1)).abs() > NEARLY_EVEN) {
            4
        } else {
            1
        };
        let moment: [[f64; 3]; 2] = both.map(|matter| std::array::from_fn(|l| matter.phase.moment(l)));
        let gains = shares.iter().enumerate().map(|(place, share)| {
            let gain = |i: usize, l: usize| share[i] * (albedo(place, i) * moment[i][l]);
            std::array::from_fn(|l| (gain(0, l) + gain(1, l)) as f32)
        });
        let albedos = shares
            .iter()
            .enumerate()
            .map(|(place, share)| std::array::from_fn(|i| (share[i] * albedo(place, i)) as f32));
        let matter = SiteScattering {
            albedos: albedos.collect(),
            phases: both.map(|matter| matter.phase),
            are_leaves: [true, false],
        };
        let gains = ScatteringMoments { gains: gains.collect(), leaning };
        Band { matter, gains, moments, guess: None }
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
        let leaves = shares.iter().map(|share| share[0] + share[1]);
        let (leaning, lean) = leaning(&medium.angles, leaves);
        let slanted = gains.iter().any(|gain| f64::from(gain[1].abs()) > NEARLY_EVEN);
        let moments = match (lean, slanted) {
            (true, _) => 9,
            (false, true) => 4,
            (false, false) => 1,
        };
        let albedos = shares.iter().map(|share| share.map(|share| share as f32)).collect();
        let matter = SiteScattering { albedos, phases, are_leaves: [true, true] };
        Band { matter, gains: ScatteringMoments { gains, leaning }, moments, guess: None }
    }
}

/// What is scattered of the second moment of light, from what the leaves of each site scatter of all light; and whether
/// that is so much that it counts.
fn leaning(angles: &LeafAngles, leaves: impl Iterator<Item = f64>) -> (Vec<f32>, bool) {
    let (moment, most) = (extinction_moment(angles), most_unlike_mean(angles));
    let mut counts = false;
    let of_site = |leaves: f64| {
        counts |= leaves * most > NEARLY_ALIKE * (1.0 - leaves);
        (leaves * moment) as f32
    };
    (leaves.map(of_site).collect(), counts)
}

/// What the sites of a band have of their own.
pub(super) struct Own<'a> {
    /// `[site][leaf, wood]`, in place of the band's.
    pub albedos: Option<&'a [[f32; 2]]>,
    /// `[site]`: share of what leaves scatter that comes out of the far side.
    pub transmitted: Option<&'a [f32]>,
}
