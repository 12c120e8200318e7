//! The papers' iteration as it is written, f64, over every site: medium -> fields. The oracle that the
//! fast solver is held against; nothing here is clever on purpose.
//!
//! Steele 2009, eq. 2.12 and listing 5.1, without its clamp (lighting model, section 4).

use flb_format::direction::DIRECTIONS;
use flb_format::matter::{Class, Optics};
use flb_format::progress::{Cancelled, Progress};
use flb_format::{Field, Medium};
use rayon::prelude::*;

use super::collision::{self, Matrix};
use super::course::Course;
use super::{Solution, SolveSettings, Steps, finish, solved_bases};

/// Rule by which the iteration ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// Stops after so many updates, rest density kept at wood as the papers do.
    Count(u32),
    /// Stops when the largest change of any f_m in one update is below `change`, or after `limit` updates. The rest
    /// density at wood is eliminated (it would fill only as (1 - rho)^t); the fixed point is the same.
    Settled {
        /// Largest change, absolute; the boundary light is 1.
        change: f64,
        /// Largest number of updates.
        limit: u32,
    },
}

/// One field of the oracle.
#[derive(Debug, Clone, PartialEq)]
pub struct Literal {
    /// phi, `[z][y][x]`, x fastest.
    pub phi: Vec<f64>,
    /// f_m of every site, `[z][y][x][m]`, m = 0..=18.
    pub f: Vec<[f64; 19]>,
    /// Updates done.
    pub iterations: u32,
    /// Relative L2 change of phi over the non-empty sites, per update.
    pub(crate) course: Course,
}

/// Boundary light of base `j`: f_i = `[i = j]`; of base 0: f_i = 1 for i = 1..=18.
pub fn boundary_of_base(base: u8) -> [f64; 19] {
    std::array::from_fn(|i| if i > 0 && (base == 0 || i == usize::from(base)) { 1.0 } else { 0.0 })
}

/// All bases by the literal iteration, 2 x the lattice's edge each unless other steps are asked for.
pub(super) fn solve(
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
    progress: &Progress<'_>,
) -> Result<Solution, Cancelled> {
    let bands = optics.bands.len() as u32;
    let solved = solved_bases(settings);
    let total = (bands as usize * solved.len()) as f64;
    let mut reports = Vec::new();
    let mut others = Vec::new();
    for (at, base) in solved.iter().enumerate() {
        let mut field = Field::zeros(medium.grid.lattice, bands);
        for band in 0..bands {
            progress((at as f64 * f64::from(bands) + f64::from(band)) / total)?;
            let steps = settings.steps.unwrap_or(Steps::PAPERS);
            let until = Until::Count(steps.count(medium.grid.lattice));
            let literal = iterate(medium, optics, band, &boundary_of_base(base), until);
            let values = field.values_mut()[band as usize * medium.grid.sites()..].iter_mut();
            values.zip(&literal.phi).for_each(|(value, phi)| *value = *phi as f32);
            reports.push(literal.course.report(base, band, settings));
        }
        others.push((base, field));
    }
    Ok(finish(medium, bands, settings, others, reports))
}

/// Iterates one boundary light in one band from darkness. `medium` and `optics` as
/// [`solve`](super::solve) accepts them. Needs 2 x 152 bytes per site.
pub fn iterate(medium: &Medium, optics: &Optics, band: u32, boundary: &[f64; 19], until: Until) -> Literal {
    let n = medium.grid.lattice as usize;
    let settled = matches!(until, Until::Settled { .. });
    let of_band = &optics.bands[band as usize];
    let updates = [update(of_band.leaf, Class::Leaf, settled), update(of_band.wood, Class::Wood, settled)];
    let on_boundary =
        |index: usize| medium.grid.site(index).iter().any(|&c| c == 0 || c == medium.grid.lattice - 1);
    let mut f = vec![[0.0; 19]; n * n * n];
    for (index, site) in f.iter_mut().enumerate() {
        if on_boundary(index) {
            *site = *boundary;
        }
    }
    let mut given = f.clone();
    let (limit, wanted) = match until {
        Until::Count(count) => (count, -1.0),
        Until::Settled { change, limit } => (limit, change),
    };
    let (mut iterations, mut course) = (0, Course::default());
    while iterations < limit {
        given.par_iter_mut().enumerate().for_each(|(index, given)| {
            *given = match medium.class[index] {
                Class::Empty => f[index],
                Class::Leaf => collide(&updates[0], f64::from(medium.density[index]), &f[index]),
                Class::Wood => collide(&updates[1], f64::from(medium.density[index]), &f[index]),
            };
        });
        let changes: Vec<[f64; 3]> = f
            .par_chunks_mut(n * n)
            .enumerate()
            .map(|(z, plane)| {
                let mut changes = [0.0; 3];
                for (within, site) in plane.iter_mut().enumerate() {
                    let index = z * n * n + within;
                    if on_boundary(index) {
                        continue;
                    }
                    let arrived: [f64; 19] = std::array::from_fn(|m| given[upstream(index, m, n)][m]);
                    if medium.class[index] != Class::Empty {
                        let phi: f64 = arrived[1..].iter().sum();
                        let before: f64 = site[1..].iter().sum();
                        changes[0] += (phi - before) * (phi - before);
                        changes[1] += phi * phi;
                    }
                    for m in 0..19 {
                        changes[2] = f64::max(changes[2], (arrived[m] - site[m]).abs());
                    }
                    *site = arrived;
                }
                changes
            })
            .collect();
        iterations += 1;
        let sum = |k: usize| changes.iter().map(|c| c[k]).sum::<f64>();
        course.note(sum(0), sum(1));
        if changes.iter().map(|c| c[2]).fold(0.0, f64::max) < wanted {
            break;
        }
    }
    let phi = f.iter().map(|site| site[1..].iter().sum()).collect();
    Literal { phi, f, iterations, course }
}

/// One class' matrix and whether it forgets f_0 before each update.
struct Update {
    omega: Matrix,
    dumps_rest: bool,
}

fn update(optics: flb_format::matter::ClassOptics, class: Class, settled: bool) -> Update {
    let mut omega = collision::omega(optics);
    let dumps_rest = settled || class == Class::Leaf;
    if settled && class == Class::Wood {
        omega = collision::gain(optics, true);
        for (m, row) in omega.iter_mut().enumerate().skip(1) {
            row[m] -= 1.0;
        }
    }
    Update { omega, dumps_rest }
}

/// f + rho Omega f.
fn collide(update: &Update, rho: f64, f: &[f64; 19]) -> [f64; 19] {
    let mut f = *f;
    if update.dumps_rest {
        f[0] = 0.0;
    }
    std::array::from_fn(|m| {
        let sum: f64 = update.omega[m].iter().zip(&f).map(|(omega, f)| omega * f).sum();
        f[m] + rho * sum
    })
}

fn upstream(index: usize, m: usize, n: usize) -> usize {
    let [x, y, z] = DIRECTIONS[m].map(|c| c as isize);
    (index as isize - (x + n as isize * (y + n as isize * z))) as usize
}
