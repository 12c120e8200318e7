//! The production solver: Gauss-Seidel over the non-empty sites only, f32, eight solves at a time.
//!
//! A site's outgoing light is computed from the light that its 18 links bring and is at once seen by
//! every site swept later. Sweeps alternate forwards and backwards, so that light of any direction runs with
//! one of the two. No entry of the operator is negative, so from darkness the light only grows towards the fixed
//! point, and from the light of another band it stays non-negative.

use std::sync::Mutex;

use flb_format::direction::{MOVING, opposite};
use flb_format::matter::Optics;
use flb_format::progress::{Cancelled, Progress};
use flb_format::{Field, Medium};
use prefetch_index::prefetch_index;
use rayon::prelude::*;

use super::collision::{self, Matrix};
use super::course::Course;
use super::dense::{self, Output};
use super::groups::{self, SolveGroup, Target};
use super::kernel::{Gain, LANES, Lanes};
use super::mixing::Mixing;
use super::sites::{self, Domain, Sites};
use super::{BaseReport, Solution, SolveSettings, finish, solved_bases};

/// Bytes of light under work at once. Groups beyond it wait; the result does not depend on it.
const STATE_BYTES: usize = 768 << 20;

/// Extra passes over a cluster that changed more than the average cluster of the sweep before: the slow modes sit in
/// clumps of near-solid sites, and a cluster's light is still in the cache.
const MAX_EXTRA: u32 = 4;

/// Sites ahead of the update, whose links are fetched from memory: processors cannot guess where links lead, and
/// waiting for them was a third of the time. 2 to 6 do as well.
const AHEAD: isize = 4;

/// Echoes that lose less than this per round are left to the sweeps: their sum would be mostly
/// rounding error, or, without any loss, infinite.
pub(super) const MIN_LOSS: f32 = 1e-3;

/// Lanes whose fields are written side by side: more share the reading, fewer leave more to do in parallel.
pub(super) const LANES_WRITTEN: usize = 4;

/// Light of one domain.
pub(super) struct State {
    /// Outgoing light, as [`Domain`] orders it.
    pub rows: Vec<Lanes>,
    /// phi at each site as of its last update.
    phi: Vec<Lanes>,
    /// Copies of the rows that other domains want.
    exports: Vec<Lanes>,
    /// Sums of (phi - before)^2 and phi^2 over the last sweep.
    change: [[f64; LANES]; 2],
}

/// All bases of all bands. Input as [`solve`](super::solve) has checked it.
pub(super) fn solve(
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
    domain_sites: usize,
    progress: &Progress<'_>,
) -> Result<Solution, Cancelled> {
    let bands = optics.bands.len() as u32;
    let sites = sites::find(medium, domain_sites);
    let mut fields: Vec<(u8, Field)> =
        solved_bases(settings).iter().map(|base| (base, Field::zeros(medium.grid.lattice, bands))).collect();
    let mut groups = groups::form(targets(&mut fields, medium.grid.sites()), optics);
    let state_bytes = (sites.count + 1) * (MOVING + 1) * size_of::<Lanes>();
    let together = (STATE_BYTES / state_bytes).max(1);
    let meter = Meter::new(groups.iter().map(|group| group.steps.len()).sum(), settings.tolerance, progress);
    let mut reports = Vec::new();
    let mut step = 0;
    for wave in groups.chunks_mut(together) {
        let first_steps = wave.iter().map(|group| {
            step += group.steps.len();
            step - group.steps.len()
        });
        let first_steps: Vec<usize> = first_steps.collect();
        let of_wave = wave.par_iter_mut().zip(first_steps);
        let of_wave = of_wave.map(|(group, step)| solve_group(&sites, optics, settings, group, step, &meter));
        reports.extend(of_wave.collect::<Result<Vec<_>, Cancelled>>()?.into_iter().flatten());
    }
    Ok(finish(medium, bands, settings, fields, reports))
}

/// Solves and writes the steps of a group, each from the light of the one before.
fn solve_group(
    sites: &Sites,
    optics: &Optics,
    settings: &SolveSettings,
    group: &mut SolveGroup,
    first_step: usize,
    meter: &Meter,
) -> Result<Vec<BaseReport>, Cancelled> {
    let Some(targets) = group.steps.first() else { return Ok(Vec::new()) };
    let mut states = dark(sites, targets);
    let mut reports = Vec::new();
    for (step, targets) in group.steps.iter_mut().enumerate() {
        let tick = |expected: f64, sweeps: u32| {
            meter.tick(first_step + step, expected, f64::from(sweeps) / f64::from(settings.max_sweeps))
        };
        let courses = relax(sites, optics, targets, settings, &mut states, &tick)?;
        let rows: Vec<&[Lanes]> = states.iter().map(|state| &state.rows[..]).collect();
        let mut outputs: Vec<Output> = targets
            .iter_mut()
            .enumerate()
            .map(|(lane, target)| Output { lane, base: usize::from(target.base), phi: target.output })
            .collect();
        outputs.par_chunks_mut(LANES_WRITTEN).for_each(|outputs| dense::write(sites, &rows, outputs));
        let of_step = targets.iter().zip(courses);
        reports.extend(of_step.map(|(target, course)| course.report(target.base, target.band, settings)));
    }
    Ok(reports)
}

/// Bands in order, bases inside.
pub(super) fn targets(fields: &mut [(u8, Field)], sites: usize) -> Vec<Target<'_>> {
    let mut targets: Vec<Target> = Vec::new();
    for (base, field) in fields {
        for (band, output) in field.values_mut().chunks_mut(sites).enumerate() {
            targets.push(Target { base: *base, band: band as u32, output });
        }
    }
    targets.sort_by_key(|target| (target.band, target.base));
    targets
}

/// The collisions of a group.
struct Gains {
    /// Of leaf and of wood.
    of_class: [Gain; 2],
    /// Share that wood of density 1 sends straight back, `[m - 1]`.
    wood_back: [Lanes; MOVING],
}

fn gains(optics: &Optics, targets: &[Target]) -> Gains {
    // Lanes without a target repeat the last one's band, without light.
    let band = |lane: usize| &optics.bands[targets[lane.min(targets.len() - 1)].band as usize];
    let of_lanes: [[Matrix; 2]; LANES] = std::array::from_fn(|lane| collision::gains(band(lane)));
    let [leaf, wood] = [0, 1].map(|class| of_lanes.map(|of_class| of_class[class]));
    let back = |m: usize| Lanes(std::array::from_fn(|lane| wood[lane][m + 1][opposite(m + 1)] as f32));
    Gains { wood_back: std::array::from_fn(back), of_class: [Gain::new(&leaf), Gain::new(&wood)] }
}

/// Sweeps on from `states` until every lane has reached the tolerance or cannot within the sweeps allowed.
pub(super) fn relax(
    sites: &Sites,
    optics: &Optics,
    targets: &[Target],
    settings: &SolveSettings,
    states: &mut [State],
    tick: &dyn Fn(f64, u32) -> Result<(), Cancelled>,
) -> Result<Vec<Course>, Cancelled> {
    let gains = gains(optics, targets);
    let mut courses = vec![Course::default(); targets.len()];
    let mut mixing: Option<Mixing> = None;
    let mut mixed = false;
    for sweep in 0..settings.max_sweeps {
        if sites.count == 0 {
            break;
        }
        states.par_iter_mut().zip(&sites.domains).for_each(|(state, domain)| {
            sweep_domain(domain, &gains, sweep % 2 == 1, state);
        });
        exchange(&sites.domains, states);
        for (lane, course) in courses.iter_mut().enumerate() {
            let [change, norm] = [0, 1].map(|k| states.iter().map(|s| s.change[k][lane]).sum::<f64>());
            match mixed {
                true => course.note_mixed(),
                false => course.note(change, norm),
            }
        }
        mixed = false;
        tick(courses.iter().map(Course::error_estimate).fold(0.0, f64::max), sweep + 1)?;
        if courses.iter().all(|course| course.is_over(settings)) {
            break;
        }
        // There and back.
        if sweep % 2 == 1 {
            if let Some(mixing) = &mut mixing {
                mixing.mix(&mut states.iter_mut().map(|state| &mut state.rows).collect::<Vec<_>>());
                mixed = true;
            } else if courses.iter().any(|course| course.creeps(settings)) {
                mixing = Some(Mixing::new(states.iter().map(|state| &state.rows)));
                courses.iter_mut().for_each(Course::quicken);
            }
        }
    }
    Ok(courses)
}

/// No light but that of the boundary.
pub(super) fn dark(sites: &Sites, targets: &[Target]) -> Vec<State> {
    let state = |domain: &Domain| {
        let mut rows = vec![Lanes::default(); domain.rows()];
        for (lane, target) in targets.iter().enumerate() {
            let boundary = &mut rows[domain.len() * MOVING..][..MOVING];
            for (m, row) in boundary.iter_mut().enumerate() {
                row.0[lane] = if dense::is_lit(usize::from(target.base), m + 1) { 1.0 } else { 0.0 };
            }
        }
        let phi = vec![Lanes::default(); domain.len()];
        let exports = vec![Lanes::default(); domain.exports.len()];
        State { rows, phi, exports, change: Default::default() }
    };
    sites.domains.iter().map(state).collect()
}

/// One pass over all sites of a domain.
fn sweep_domain(domain: &Domain, gains: &Gains, backwards: bool, state: &mut State) {
    let clusters = 0..domain.clusters.len();
    let usual = state.change[0].iter().sum::<f64>() / clusters.len() as f64;
    let State { rows, phi, change, .. } = state;
    *change = Default::default();
    let mut visit = |cluster: usize| {
        let start = if cluster == 0 { 0 } else { domain.clusters[cluster - 1] as usize };
        let sites = start..domain.clusters[cluster] as usize;
        let mut pass = |backwards: bool| {
            let sites = sites.clone();
            let ahead = if backwards { -AHEAD } else { AHEAD };
            if backwards {
                sweep_sites(domain, gains, sites.rev(), ahead, rows, phi)
            } else {
                sweep_sites(domain, gains, sites, ahead, rows, phi)
            }
        };
        let sums = pass(backwards);
        for (total, sum) in change.as_flattened_mut().iter_mut().zip(sums.iter().flat_map(|s| s.0)) {
            *total += f64::from(sum);
        }
        let restless = |sums: &[Lanes; 2]| sums[0].0.iter().map(|c| f64::from(*c)).sum::<f64>() > usual;
        let mut last = sums;
        for extra in 0..MAX_EXTRA {
            if usual == 0.0 || !restless(&last) {
                break;
            }
            last = pass(backwards ^ (extra % 2 == 0));
        }
    };
    if backwards {
        clusters.rev().for_each(&mut visit);
    } else {
        clusters.for_each(&mut visit);
    }
    for (copy, &row) in state.exports.iter_mut().zip(&domain.exports) {
        *copy = state.rows[row as usize];
    }
}

/// Updates sites in the given order, in which `ahead` leads to a later site. Sums of (phi - before)^2 and phi^2.
fn sweep_sites(
    domain: &Domain,
    gains: &Gains,
    sites: impl Iterator<Item = usize>,
    ahead: isize,
    rows: &mut [Lanes],
    phi: &mut [Lanes],
) -> [Lanes; 2] {
    let mut change = Lanes::default();
    let mut norm = Lanes::default();
    let mut arriving = [Lanes::default(); MOVING];
    let mut light = Lanes::default();
    for site in sites {
        let soon = domain.links.get(site.wrapping_add_signed(ahead));
        soon.into_iter().flatten().for_each(|&row| prefetch_index(&*rows, row as usize));
        for (arriving, &row) in arriving.iter_mut().zip(&domain.links[site]) {
            *arriving = rows[row as usize];
        }
        let rho = Lanes([domain.rho[site]; LANES]);
        let sent: &mut [Lanes; MOVING] = rows[site * MOVING..].first_chunk_mut().expect("18 rows per site");
        if domain.echoes[site] == 0 {
            let gain = &gains.of_class[usize::from(domain.wood[site])];
            gain.collide(&rho, &arriving, sent, &mut light);
        } else {
            let before = *sent;
            gains.of_class[1].collide(&rho, &arriving, sent, &mut light);
            settle_echoes(domain, &gains.wood_back, site, rows, &before);
        }
        let before = phi[site];
        for lane in 0..LANES {
            let step = light.0[lane] - before.0[lane];
            change.0[lane] += step * step;
            norm.0[lane] += light.0[lane] * light.0[lane];
        }
        phi[site] = light;
    }
    [change, norm]
}

/// Light caught between two wood sites that throw it back at each other is summed at once.
///
/// Say this site sends u along m to a wood site that sends v back: u = a v + p, v = b u + q. Plain sweeps
/// approach the limit of that echo by a factor of a b per sweep, 0.8 for the papers' wood: by far the slowest
/// part of a plant. With q = v - b u as of that site's last update, u = (p + a q) / (1 - a b), and v follows.
/// Unknowns are p and q then; all terms stay non-negative, and the fixed point is the same.
fn settle_echoes(
    domain: &Domain,
    wood_back: &[Lanes; MOVING],
    site: usize,
    rows: &mut [Lanes],
    before: &[Lanes; MOVING],
) {
    let mut left = domain.echoes[site];
    while left != 0 {
        let m = left.trailing_zeros() as usize;
        left &= left - 1;
        // Opposites are neighbours, so m ^ 1 is opposite to m when counted from 0.
        let echo = domain.links[site][m ^ 1] as usize;
        let (rho, rho_other) = (domain.rho[site], domain.rho[echo / MOVING]);
        let mut sent = rows[site * MOVING + m];
        let mut returned = rows[echo];
        for lane in 0..LANES {
            let share = wood_back[m].0[lane];
            let back = rho_other * share;
            let lost = 1.0 - rho * share * back;
            let step = (sent.0[lane] - before[m].0[lane]) / lost;
            let sums = lost >= MIN_LOSS;
            // The start may be brighter than what it goes to: a step down must not overshoot darkness.
            sent.0[lane] = if sums { (before[m].0[lane] + step).max(0.0) } else { sent.0[lane] };
            returned.0[lane] =
                if sums { (returned.0[lane] + step * back).max(0.0) } else { returned.0[lane] };
        }
        rows[site * MOVING + m] = sent;
        rows[echo] = returned;
    }
}

/// Gives every domain the light that its neighbours sent in the last sweep.
fn exchange(domains: &[Domain], states: &mut [State]) {
    let exports: Vec<Vec<Lanes>> =
        states.iter_mut().map(|state| std::mem::take(&mut state.exports)).collect();
    states.par_iter_mut().zip(domains).for_each(|(state, domain)| {
        let halo = &mut state.rows[(domain.len() + 1) * MOVING..];
        for (copy, &(owner, at)) in halo.iter_mut().zip(&domain.halo) {
            *copy = exports[owner as usize][at as usize];
        }
    });
    for (state, exports) in states.iter_mut().zip(exports) {
        state.exports = exports;
    }
}

/// Progress of all groups together, reported only when it grows.
pub(super) struct Meter<'a> {
    tolerance: f64,
    progress: &'a Progress<'a>,
    /// Per group, and what was reported last.
    done: Mutex<(Vec<f64>, f64)>,
}

impl<'a> Meter<'a> {
    pub(super) fn new(groups: usize, tolerance: f64, progress: &'a Progress<'a>) -> Meter<'a> {
        Meter { tolerance, progress, done: Mutex::new((vec![0.0; groups], 0.0)) }
    }

    /// The residual falls by about a constant factor per sweep, so its logarithm tells how far a group is.
    pub(super) fn tick(&self, group: usize, residual: f64, spent: f64) -> Result<(), Cancelled> {
        let fallen = if residual > 0.0 { libm::log(residual) / libm::log(self.tolerance) } else { 1.0 };
        let Ok(mut done) = self.done.lock() else { return Ok(()) };
        done.0[group] = fallen.max(spent).clamp(done.0[group], 1.0);
        let share = done.0.iter().sum::<f64>() / done.0.len() as f64;
        if share > done.1 + 0.001 {
            done.1 = share;
            (self.progress)(share.min(1.0))?;
        }
        Ok(())
    }
}
