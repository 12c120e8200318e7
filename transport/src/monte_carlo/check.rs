//! Refuses what cannot be traced before any of it is used.

use crate::turbid::{BandScatter, Phase, TurbidMedium};

use super::{MonteCarloError, Settings};

/// The largest lattice of the format.
const MAX_LATTICE: u32 = 256;

/// Rays per edge of a site beyond which counting them is of no use.
const MAX_RAYS: u32 = 1024;

/// A direction may be this far from unit length: what three f32 leave, and some.
const UNIT_SLACK: f64 = 1e-4;

pub(super) fn medium(medium: &TurbidMedium) -> Result<(), MonteCarloError> {
    let grid = &medium.grid;
    if !(1..=MAX_LATTICE).contains(&grid.lattice) {
        return Err(MonteCarloError::Lattice { found: grid.lattice, limit: MAX_LATTICE });
    }
    if !(grid.spacing_m > 0.0 && grid.spacing_m.is_finite()) {
        return Err(MonteCarloError::Spacing { found: grid.spacing_m });
    }
    for (array, values) in [("leaf_per_m", &medium.leaf_per_m), ("wood_per_m", &medium.wood_per_m)] {
        if values.len() != grid.sites() {
            let (found, expected) = (values.len(), grid.sites());
            return Err(MonteCarloError::Length { array, found, expected, lattice: grid.lattice });
        }
        if let Some(index) = values.iter().position(|&value| !(value >= 0.0 && value.is_finite())) {
            let site = grid.site(index);
            return Err(MonteCarloError::Extinction { site, array, found: values[index] });
        }
    }
    if (0..grid.sites()).all(|site| medium.extinction(site) == 0.0) {
        return Err(MonteCarloError::Empty { sites: grid.sites() });
    }
    Ok(())
}

pub(super) fn scatter(scatter: &BandScatter) -> Result<(), MonteCarloError> {
    for (matter, scatter) in [("leaf", &scatter.leaf), ("wood", &scatter.wood)] {
        if !(0.0..=1.0).contains(&scatter.albedo) {
            return Err(MonteCarloError::Albedo { matter, found: scatter.albedo });
        }
        let refuse =
            |parameter, found, expected| Err(MonteCarloError::Phase { matter, parameter, found, expected });
        match scatter.phase {
            Phase::HenyeyGreenstein { g } if !(g > -1.0 && g < 1.0) => {
                refuse("g", g, "more than -1 and less than 1")?
            }
            Phase::BiLambert { transmitted } if !(0.0..=1.0).contains(&transmitted) => {
                refuse("transmitted", transmitted, "0 to 1")?
            }
            _ => (),
        }
    }
    Ok(())
}

pub(super) fn albedos(albedos: Option<&[[f32; 2]]>, medium: &TurbidMedium) -> Result<(), MonteCarloError> {
    let Some(albedos) = albedos else { return Ok(()) };
    let expected = medium.sites().len();
    if albedos.len() != expected {
        return Err(MonteCarloError::SiteAlbedos { found: albedos.len(), expected });
    }
    for of_site in albedos {
        for (matter, &albedo) in ["leaf", "wood"].into_iter().zip(of_site) {
            if !(0.0..=1.0).contains(&albedo) {
                return Err(MonteCarloError::Albedo { matter, found: f64::from(albedo) });
            }
        }
    }
    Ok(())
}

pub(super) fn settings(settings: &Settings) -> Result<(), MonteCarloError> {
    if settings.photons == 0 {
        return Err(MonteCarloError::Photons);
    }
    rays(settings.rays_per_site_edge)
}

pub(super) fn rays(found: u32) -> Result<(), MonteCarloError> {
    match (1..=MAX_RAYS).contains(&found) {
        true => Ok(()),
        false => Err(MonteCarloError::Rays { found, limit: MAX_RAYS }),
    }
}

/// The direction, made of unit length to the last bit.
pub(super) fn direction(toward: [f64; 3]) -> Result<[f64; 3], MonteCarloError> {
    let length = toward.iter().map(|c| c * c).sum::<f64>().sqrt();
    match (length - 1.0).abs() <= UNIT_SLACK {
        true => Ok(toward.map(|c| c / length)),
        false => Err(MonteCarloError::Direction { found: toward, length }),
    }
}
