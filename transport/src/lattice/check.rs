//! Refuses what cannot be solved, before any work. What passes here needs no further checks.

use flb_format::Medium;
use flb_format::matter::{Class, Optics};
use flb_format::sample::site_of;

use super::{SolveError, SolveSettings, SolverKind, Steps};

/// Largest number of bands.
pub(super) const MAX_BANDS: usize = 64;

/// Grid size, array lengths, densities, classes, empty outer layers.
pub(super) fn medium(medium: &Medium) -> Result<(), SolveError> {
    let lattice = medium.grid.lattice;
    if !lattice.is_power_of_two() || !(16..=256).contains(&lattice) {
        return Err(SolveError::Lattice { found: lattice });
    }
    let expected = medium.grid.sites();
    for (array, found) in [("density", medium.density.len()), ("class", medium.class.len())] {
        if found != expected {
            return Err(SolveError::Length { array, found, expected, lattice });
        }
    }
    for (index, (&density, &class)) in medium.density.iter().zip(&medium.class).enumerate() {
        let site = || site_of(index, lattice);
        if !(0.0..=1.0).contains(&density) {
            return Err(SolveError::Density { site: site(), found: density });
        }
        if (density == 0.0) != (class == Class::Empty) {
            return Err(SolveError::Class { site: site(), class, density });
        }
        if density > 0.0 && site().iter().any(|&c| !(2..lattice - 2).contains(&c)) {
            return Err(SolveError::Border { site: site(), density, lattice });
        }
    }
    Ok(())
}

/// Number of bands, and sigma_a and g of each class within the region where all entries of
/// `1 + rho Omega` are non-negative and its column sums are at most 1, for every density in 0..=1: with
/// sigma_t = sigma_a + sigma_s = 1 that is 0 <= sigma_a <= 1 (lighting model, section 4).
pub(super) fn optics(optics: &Optics) -> Result<(), SolveError> {
    if optics.bands.is_empty() || optics.bands.len() > MAX_BANDS {
        return Err(SolveError::Bands { found: optics.bands.len(), limit: MAX_BANDS });
    }
    for (band, of_band) in optics.bands.iter().enumerate() {
        for (class, of_class) in [(Class::Leaf, of_band.leaf), (Class::Wood, of_band.wood)] {
            let name = of_band.name.clone();
            if !(0.0..=1.0).contains(&of_class.sigma_a) {
                return Err(SolveError::Absorption { band, name, class, found: of_class.sigma_a });
            }
            if !(-1.0..=1.0).contains(&of_class.g) {
                return Err(SolveError::Asymmetry { band, name, class, found: of_class.g });
            }
        }
    }
    Ok(())
}

/// Tolerance, sweep limit and bases.
pub(super) fn settings(settings: &SolveSettings) -> Result<(), SolveError> {
    if !(settings.tolerance > 0.0 && settings.tolerance < 1.0) {
        return Err(SolveError::Tolerance { found: settings.tolerance });
    }
    if settings.max_sweeps == 0 {
        return Err(SolveError::MaxSweeps);
    }
    match (settings.steps, settings.solver) {
        (Some(Steps::Count(0) | Steps::PerEdge(0)), _) => return Err(SolveError::NoSteps),
        (Some(_), solver @ (SolverKind::Sweep | SolverKind::Gpu { .. })) => {
            return Err(SolveError::Steps { solver });
        }
        _ => {}
    }
    if settings.bases.is_empty() {
        return Err(SolveError::NoBases);
    }
    Ok(())
}
