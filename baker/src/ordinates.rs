//! Light transport of the `physical` model: a turbid medium and its optics -> fields for every sun.
//!
//! Discrete ordinates along long characteristics: light is marched through the plant along the directions of a quadrature
//! ([`Ordinates`]), with the exact integral of the source over every crossing of a site. The beam of a sun is followed apart, along
//! its own direction, and feeds the first scattering; what is solved for is scattered light only.
//!
//! ```text
//! Turbid + BandScatter -march, relax-> light of each sun -fit-> fields of harmonics and near beam
//! ```
//!
//! How the fields depend on the sun is the caller's choice ([`Suns`]).

mod fit;
mod march;
mod quadrature;
mod relax;

pub use fit::{Sun, evaluate, fit};
use flb_format::beam::Beam;
pub use march::March;
pub use quadrature::{Ordinate, Ordinates};
pub use relax::{Gains, Relaxed, relax};

use crate::lattice::kernel::LANES;
use crate::turbid::{BandScatter, Turbid};
use rayon::prelude::*;

/// What each site scatters of each degree, in one band.
pub fn gains(medium: &Turbid, sites: &[u32], scatter: &BandScatter) -> Gains {
    let of = |matter: &crate::turbid::Scatter| -> [f64; 3] {
        std::array::from_fn(|l| matter.albedo * matter.phase.moment(l))
    };
    let (leaf, wood) = (of(&scatter.leaf), of(&scatter.wood));
    let at = |&site: &u32| {
        let site = site as usize;
        let share = f64::from(medium.wood_per_m[site]) / f64::from(medium.extinction(site));
        std::array::from_fn(|l| (leaf[l] + share * (wood[l] - leaf[l])) as f32)
    };
    Gains(sites.iter().map(at).collect())
}

/// Scattered fluence per site of each beam.
pub fn scatter_beams<const M: usize>(
    march: &March,
    gains: &Gains,
    beams: &[&Beam],
    tolerance: f64,
    most: u32,
) -> (Vec<Vec<f32>>, Vec<(u32, f64)>) {
    let groups: Vec<_> = beams
        .par_chunks(LANES)
        .map(|group| {
            let first = march.first_scattering::<M>(gains, group);
            let relaxed = relax(march, gains, &first, tolerance, most);
            let fields: Vec<Vec<f32>> = (0..group.len())
                .map(|lane| relaxed.light.iter().map(|moments| moments[0].0[lane]).collect())
                .collect();
            (fields, (relaxed.passes, relaxed.error_estimate))
        })
        .collect();
    let (fields, reports): (Vec<_>, Vec<_>) = groups.into_iter().unzip();
    (fields.concat(), reports)
}
