//! What can be wrong with the input of a solve.

use flb_format::bases::BaseSet;
use flb_format::light::FieldKind;
use flb_format::matter::TurbidMedium;
use flb_format::progress::Cancelled;
use flb_format::sun::harmonics::MAX_DEGREE;

use super::{MAX_RAYS, OrdinatesSettings, SunBasis, Surroundings};
use crate::gpu::GpuError;
use crate::turbid::BandScatter;

/// Reason why nothing was solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OrdinatesError {
    /// An array does not cover the lattice.
    #[error("{array} has {found} values, expected one for each of the {expected} sites")]
    Length {
        /// Name of the array.
        array: &'static str,
        /// Length of the array.
        found: usize,
        /// Number of sites, N^3.
        expected: usize,
    },
    /// Extinction that is none.
    #[error("{array} at site {site} is {found} per metre, expected a finite number from 0 up")]
    Extinction {
        /// Name of the array.
        array: &'static str,
        /// Index of the site.
        site: usize,
        /// Extinction that was read, per metre.
        found: f32,
    },
    /// A lattice that is no power of two in 16..=256, or has no size.
    #[error(
        "a lattice of {lattice} sites of {spacing_m} m, expected a power of two from 16 to 256, and sites above 0 m"
    )]
    Grid {
        /// Sites per edge.
        lattice: u32,
        /// Edge of a site.
        spacing_m: f64,
    },
    /// Number of bands that is 0 or too large.
    #[error("{0} bands, expected 1 to 64")]
    Bands(usize),
    /// Albedo outside of 0..=1.
    #[error("band {band}: the albedo of {matter} is {found}, expected 0 to 1")]
    Albedo {
        /// Index of the band.
        band: usize,
        /// Leaf or wood.
        matter: &'static str,
        /// Albedo that was given.
        found: f64,
    },
    /// A setting outside of its range.
    #[error("{name} is {found}, expected {expected}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// Value that was given.
        found: String,
        /// The range.
        expected: &'static str,
    },
    /// The GPU cannot do it.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

pub(super) fn check(
    medium: &TurbidMedium,
    bands: &[BandScatter],
    settings: &OrdinatesSettings,
) -> Result<(), OrdinatesError> {
    let grid = &medium.grid;
    let sized = grid.spacing_m.is_finite() && grid.spacing_m > 0.0;
    if !(grid.lattice.is_power_of_two() && (16..=256).contains(&grid.lattice) && sized) {
        return Err(OrdinatesError::Grid { lattice: grid.lattice, spacing_m: grid.spacing_m });
    }
    for (array, values) in
        [("extinction of leaves", &medium.leaf_per_m), ("extinction of wood", &medium.wood_per_m)]
    {
        if values.len() != grid.sites() {
            return Err(OrdinatesError::Length { array, found: values.len(), expected: grid.sites() });
        }
        let bad = |value: &&f32| !(value.is_finite() && **value >= 0.0);
        if let Some((site, &found)) = values.iter().enumerate().find(|(_, value)| bad(value)) {
            return Err(OrdinatesError::Extinction { array, site, found });
        }
    }
    if !(1..=64).contains(&bands.len()) {
        return Err(OrdinatesError::Bands(bands.len()));
    }
    for (band, scatter) in bands.iter().enumerate() {
        for (matter, found) in [("leaf", scatter.leaf.albedo), ("wood", scatter.wood.albedo)] {
            if !(0.0..=1.0).contains(&found) {
                return Err(OrdinatesError::Albedo { band, matter, found });
            }
        }
    }
    let setting = |name, found: String, expected| Err(OrdinatesError::Setting { name, found, expected });
    if !(1..=MAX_RAYS).contains(&settings.rays) {
        return setting("rays", settings.rays.to_string(), "1 to 8");
    }
    if !(1..=2).contains(&settings.parts) {
        return setting("parts", settings.parts.to_string(), "1 or 2");
    }
    if !(settings.tolerance > 0.0 && settings.tolerance < 1.0) {
        return setting("tolerance", settings.tolerance.to_string(), "a number between 0 and 1");
    }
    if settings.max_passes == 0 {
        return setting("max_passes", "0".to_owned(), "1 or more");
    }
    if settings.bases.is_empty() {
        return setting("bases", "none".to_owned(), "one or more");
    }
    match settings.suns {
        SunBasis::Harmonics { .. } | SunBasis::Directions(_) if settings.bases != BaseSet::ALL => {
            let expected = "all, as only lattice directions may be left out";
            setting("bases", format!("{:?}", settings.bases), expected)
        }
        SunBasis::Harmonics { degree, .. } if !(1..=MAX_DEGREE).contains(&degree) => {
            setting("degree", degree.to_string(), "1 to 3")
        }
        SunBasis::Harmonics { leaning: true, .. } if settings.field == FieldKind::Total => {
            setting("leaning", "true".to_owned(), "false in fields that hold the beam")
        }
        _ => Ok(()),
    }
}

pub(super) fn check_surroundings(
    surroundings: &Surroundings,
    sites: usize,
    bands: usize,
) -> Result<(), OrdinatesError> {
    let setting = |name, found: String, expected| Err(OrdinatesError::Setting { name, found, expected });
    if !(0.0..=1.0).contains(&surroundings.below) {
        return setting("light from below", surroundings.below.to_string(), "0 to 1");
    }
    if let Some(transmitted) = surroundings.transmitted {
        if transmitted.len() != bands {
            let found = format!("those of {} bands", transmitted.len());
            return setting("transmitted shares of sites", found, "one list for each band");
        }
        if let Some(of_band) = transmitted.iter().find(|of_band| of_band.len() != sites) {
            let (array, found) = ("list of transmitted shares", of_band.len());
            return Err(OrdinatesError::Length { array, found, expected: sites });
        }
        if let Some(found) = transmitted.iter().flatten().find(|share| !(0.0..=1.0).contains(*share)) {
            return setting("transmitted share of a site", found.to_string(), "0 to 1");
        }
    }
    let Some(albedos) = surroundings.albedos else { return Ok(()) };
    if albedos.len() != bands {
        let found = format!("those of {} bands", albedos.len());
        return setting("albedos of sites", found, "one list for each band");
    }
    if let Some(of_band) = albedos.iter().find(|of_band| of_band.len() != sites) {
        let (array, found) = ("list of albedos", of_band.len());
        return Err(OrdinatesError::Length { array, found, expected: sites });
    }
    let bad = |albedo: &&f32| !(0.0..=1.0).contains(*albedo);
    match albedos.iter().flat_map(|of_band| of_band.as_flattened()).find(bad) {
        Some(found) => setting("albedo of a site", found.to_string(), "0 to 1"),
        None => Ok(()),
    }
}
