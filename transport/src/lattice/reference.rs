//! The fixed point itself, f64: what the errors of the fast solvers are measured against.
//!
//! Gauss-Seidel over the links between non-empty sites, one solve at a time, matrix products, no shortcut but the
//! extrapolation that mixing.rs explains, once the plain sweeps have had their say. It shares the links with the sweep
//! solver; the [`literal`](super::literal) iteration, which shares nothing, is its oracle on lattices where that one
//! can be run to its end.

use flb_format::Medium;
use flb_format::direction::MOVING;
use flb_format::matter::Optics;
use rayon::prelude::*;

use super::collision::{self, Matrix};
use super::sites::{self, Domain};
use super::{SolveError, check, dense};

/// Sweeps before it extrapolates.
const PLAIN_SWEEPS: u32 = 64;

/// One base in one band, solved to the end.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Index of the base, 0..=18.
    pub base: u8,
    /// Index into the optics' bands.
    pub band: u32,
    /// phi of the non-empty sites, in the order of their lattice index (x fastest).
    pub phi: Vec<f64>,
    /// Sweeps done.
    pub sweeps: u32,
    /// Relative L2 change of phi over the non-empty sites in the last sweep.
    pub residual: f64,
}

/// Distance of a field from a [`Reference`], over the non-empty sites.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SolveDistance {
    /// `||phi - exact||_2 / ||exact||_2`.
    pub relative_l2: f64,
    /// The largest `|phi - exact| / exact` of any site.
    pub worst_site: f64,
}

impl Reference {
    /// Measures a field of the same medium, `[z][y][x]`. Sites without light in the reference count only if the field
    /// has some.
    pub fn distance(&self, medium: &Medium, phi: &[f32]) -> SolveDistance {
        let of_matter = medium.density.iter().zip(phi).filter(|(density, _)| **density > 0.0);
        let (mut error, mut norm, mut worst_site) = (0.0, 0.0, 0.0);
        for ((_, found), exact) in of_matter.zip(&self.phi) {
            let step = (f64::from(*found) - exact).abs();
            error += step * step;
            norm += exact * exact;
            if step > 0.0 {
                worst_site = f64::max(worst_site, step / exact);
            }
        }
        SolveDistance { relative_l2: if error > 0.0 { (error / norm).sqrt() } else { 0.0 }, worst_site }
    }
}

/// Solves (base, band) pairs until phi changes by less than `tolerance` (relative L2) in a sweep, or `max_sweeps`. All
/// cores; a solve needs 160 bytes per non-empty site. Tolerances below about 1e-14 are never met.
///
/// # Errors
/// Medium and optics as [`solve`](super::solve) refuses them.
///
/// # Panics
/// If a base is above 18 or a band is none of the optics'.
pub fn solve(
    medium: &Medium,
    optics: &Optics,
    wanted: &[(u8, u32)],
    tolerance: f64,
    max_sweeps: u32,
) -> Result<Vec<Reference>, SolveError> {
    check::medium(medium)?;
    check::optics(optics)?;
    let sites = sites::find(medium, usize::MAX);
    let domain = &sites.domains.first().cloned().unwrap_or_default();
    let places = || sites.planes.iter().flatten().map(|place| place.site as usize);
    let solve_one = |&(base, band): &(u8, u32)| {
        let gains = collision::gains(&optics.bands[band as usize]);
        let (by_sweep, sweeps, residual) = relax(domain, &gains, base, tolerance, max_sweeps);
        let phi = places().map(|site| by_sweep[site]).collect();
        Reference { base, band, phi, sweeps, residual }
    };
    Ok(wanted.par_iter().map(solve_one).collect())
}

/// phi per site of the domain, sweeps, last residual.
fn relax(
    domain: &Domain,
    gains: &[Matrix; 2],
    base: u8,
    tolerance: f64,
    max_sweeps: u32,
) -> (Vec<f64>, u32, f64) {
    let mut rows = vec![0.0; domain.rows()];
    for m in (1..=MOVING).filter(|&m| dense::is_lit(usize::from(base), m)) {
        rows[domain.len() * MOVING + m - 1] = 1.0;
    }
    let mut phi = vec![0.0; domain.len()];
    let (mut residual, mut sweeps) = (0.0, 0);
    // The start of this pair of sweeps, and start and end of the one before.
    let mut kept: Option<[Vec<f64>; 3]> = None;
    while sweeps < max_sweeps && domain.len() > 0 {
        let (mut change, mut norm) = (0.0, 0.0);
        for step in 0..domain.len() {
            let site = if sweeps % 2 == 0 { step } else { domain.len() - 1 - step };
            let arriving: [f64; MOVING] = domain.links[site].map(|row| rows[row as usize]);
            let light: f64 = arriving.iter().sum();
            change += (light - phi[site]) * (light - phi[site]);
            norm += light * light;
            phi[site] = light;
            let rho = f64::from(domain.rho[site]);
            let gain = &gains[usize::from(domain.wood[site])];
            for m in 0..MOVING {
                let scattered: f64 = gain[m + 1][1..].iter().zip(&arriving).map(|(gain, f)| gain * f).sum();
                rows[site * MOVING + m] = (1.0 - rho) * arriving[m] + rho * scattered;
            }
        }
        sweeps += 1;
        if sweeps % 2 == 1 {
            continue;
        }
        residual = if norm > 0.0 { (change / norm).sqrt() } else { 0.0 };
        if residual <= tolerance {
            break;
        }
        if sweeps >= PLAIN_SWEEPS {
            let kept = kept.get_or_insert_with(|| [rows.clone(), rows.clone(), rows.clone()]);
            mix(&mut rows, kept);
        }
    }
    (phi, sweeps, residual)
}

/// Ends a pair of sweeps; see [`mixing`](super::mixing).
fn mix(rows: &mut [f64], [start, start_before, end_before]: &mut [Vec<f64>; 3]) {
    let (mut along, mut square) = (0.0, 0.0);
    for (row, end) in rows.iter().enumerate() {
        let residual = end - start[row];
        let change = residual - (end_before[row] - start_before[row]);
        along += change * residual;
        square += change * change;
    }
    let step = if square > 0.0 { along / square } else { 0.0 };
    for (row, light) in rows.iter_mut().enumerate() {
        let end = *light;
        *light = (end - step * (end - end_before[row])).max(0.0);
        start_before[row] = start[row];
        end_before[row] = end;
        start[row] = *light;
    }
}

#[cfg(test)]
mod tests {
    use super::super::literal::{self, Until, boundary_of_base};
    use super::super::media;
    use super::*;

    #[test]
    fn reaches_the_literal_iterations_fixed_point() {
        let medium = media::tree(16, 5);
        let optics = Optics::paper();
        let wanted = [(0, 1), (4, 0), (11, 2)];
        for found in solve(&medium, &optics, &wanted, 1e-14, 2000).unwrap() {
            let until = Until::Settled { change: 1e-15, limit: 20_000 };
            let exact =
                literal::iterate(&medium, &optics, found.band, &boundary_of_base(found.base), until).phi;
            let of_matter = exact.iter().zip(&medium.density).filter(|(_, density)| **density > 0.0);
            assert_eq!(of_matter.clone().count(), found.phi.len());
            for ((exact, _), found) in of_matter.zip(&found.phi) {
                assert!((exact - found).abs() < 1e-12 * exact, "{exact} {found}");
            }
            let phi: Vec<f32> = exact.iter().map(|phi| *phi as f32 * 1.01).collect();
            let distance = found.distance(&medium, &phi);
            assert!((distance.relative_l2 - 0.01).abs() < 1e-6 && (distance.worst_site - 0.01).abs() < 1e-6);
        }
    }

    #[test]
    fn an_empty_medium_has_no_sites_to_solve() {
        let found = &solve(&media::empty(16), &Optics::paper(), &[(3, 0)], 1e-9, 10).unwrap()[0];
        assert!(found.phi.is_empty() && found.sweeps == 0);
        assert_eq!(found.distance(&media::empty(16), &[1.0; 4096]), SolveDistance::default());
    }
}
