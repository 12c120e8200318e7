//! Energy over the links between sites: what enters a medium must be absorbed or leave it.

use flb_format::Medium;
use flb_format::direction::MOVING;
use flb_format::matter::Optics;

use super::groups::Target;
use super::kernel::{LANES, Lanes};
use super::sites::{self, Domain};
use super::sweep;
use super::{SolveError, SolveSettings, check, solved_bases};

/// Energy balance of one base in one band by a sweep solve: light that enters, leaves and is absorbed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance {
    /// Index of the base, 0..=18.
    pub base: u8,
    /// Index into the optics' bands.
    pub band: u32,
    /// Boundary light that meets the medium, in units of one boundary site's.
    pub entered: f64,
    /// Light that leaves the medium for good.
    pub left: f64,
    /// Light that leaf absorbs; wood gives everything back.
    pub absorbed: f64,
    /// Light that leaves along each direction, `[m - 1]`; they sum to `left`.
    pub left_along: [f64; MOVING],
}

impl Balance {
    /// `(entered - left - absorbed) / entered`: 0 at the fixed point. 0 if nothing enters.
    pub fn imbalance(&self) -> f64 {
        if self.entered > 0.0 { (self.entered - self.left - self.absorbed) / self.entered } else { 0.0 }
    }
}

/// Solves with sweeps as [`solve`](super::solve) does and adds up where the light goes. Bases and bands in order, base
/// 0 only where it is solved by itself.
///
/// # Errors
/// As [`solve`](super::solve).
pub fn balances(
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
) -> Result<Vec<Balance>, SolveError> {
    check::medium(medium)?;
    check::optics(optics)?;
    check::settings(settings)?;
    let sites = sites::find(medium, usize::MAX);
    let Some(domain) = sites.domains.first() else { return Ok(Vec::new()) };
    let mut targets: Vec<Target> = Vec::new();
    for base in solved_bases(settings).iter() {
        targets.extend((0..optics.bands.len() as u32).map(|band| Target { base, band, output: &mut [] }));
    }
    let mut balances = Vec::new();
    for group in targets.chunks(LANES) {
        let mut states = sweep::dark(&sites, group);
        sweep::relax(&sites, optics, group, settings, &mut states, &|_, _| Ok(()))?;
        let Some(state) = states.first() else { continue };
        for (lane, target) in group.iter().enumerate() {
            let leaf = optics.bands[target.band as usize].leaf;
            balances.push(add_up(domain, &state.rows, lane, target, leaf.sigma_a));
        }
    }
    Ok(balances)
}

fn add_up(domain: &Domain, rows: &[Lanes], lane: usize, target: &Target, sigma_a: f64) -> Balance {
    let light = |row: usize| f64::from(rows[row].0[lane]);
    let (mut entered, mut absorbed, mut left_along) = (0.0, 0.0, [0.0; MOVING]);
    for (site, links) in domain.links.iter().enumerate() {
        let mut arriving = 0.0;
        for (m, &row) in links.iter().enumerate() {
            let arrives = light(row as usize);
            arriving += arrives;
            left_along[m] += light(site * MOVING + m);
            match row as usize / MOVING == domain.len() {
                true => entered += arrives,
                false => left_along[m] -= arrives,
            }
        }
        if !domain.wood[site] {
            absorbed += f64::from(domain.rho[site]) * sigma_a * arriving;
        }
    }
    let left = left_along.iter().sum();
    Balance { base: target.base, band: target.band, entered, left, absorbed, left_along }
}
