//! The plain dense solver: the papers' iteration over the whole lattice, f32, all cores.
//!
//! Every site, empty or not, is updated in every iteration from the iteration before: 18 values read and 18
//! written per site, so memory bandwidth is the bound (216 bytes per site with the write-allocate). It shares
//! the collision with the sweep solver and nothing else: a second way to the same fixed point.
//!
//! Sites hold what they send, `[z][y][m - 1][x]`, x fastest; an update pulls what the 18 neighbours sent. The
//! rest density of wood is eliminated, as in the sweep solver.

use flb_format::direction::{DIRECTIONS, MOVING};
use flb_format::{Class, Field, Medium, Optics};
use rayon::prelude::*;

use super::collision;
use super::course::{Course, TREND_SPAN};
use super::kernel::{Gain, LANES, Lanes};
use super::{Solution, SolveSettings, dense, finish, solved_bases};

/// All bases of all bands, one after the other. Input as [`solve`](super::solve) has checked it. An iteration counts
/// as a sweep.
pub(super) fn solve(
    medium: &Medium,
    optics: &Optics,
    settings: &SolveSettings,
    progress: &(dyn Fn(f64) + Sync),
) -> Solution {
    let bands = optics.bands.len() as u32;
    let sites = medium.grid.sites();
    let matter = matter(medium);
    let mut light = [vec![0.0; sites * MOVING], vec![0.0; sites * MOVING]];
    let (mut others, mut reports) = (Vec::new(), Vec::new());
    let solved = solved_bases(settings);
    for (at, base) in solved.iter().enumerate() {
        let mut field = Field::zeros(medium.grid.lattice, bands);
        for (band, of_band) in optics.bands.iter().enumerate() {
            let done = at * bands as usize + band;
            progress(done as f64 / (solved.len() * bands as usize) as f64);
            let gains = [collision::gain(of_band.leaf, false), collision::gain(of_band.wood, true)]
                .map(|gain| Gain::new(&[gain; LANES]));
            let phi = &mut field.values[band * sites..][..sites];
            let course = relax(&matter, &gains, base, settings, &mut light, phi);
            reports.push(course.report(base, band as u32, settings));
        }
        others.push((base, field));
    }
    finish(medium, bands, settings, others, reports)
}

/// Density of leaf and of wood per run of [`LANES`] sites along x, `[z][y][x / LANES]`.
struct Matter {
    /// N.
    lattice: usize,
    leaf: Vec<Lanes>,
    wood: Vec<Lanes>,
}

impl Matter {
    fn is_empty(&self, site: usize) -> bool {
        let (run, lane) = (site / LANES, site % LANES);
        self.leaf[run].0[lane] == 0.0 && self.wood[run].0[lane] == 0.0
    }
}

fn matter(medium: &Medium) -> Matter {
    let of = |class: Class| {
        let runs = medium.density.chunks(LANES).zip(medium.class.chunks(LANES));
        let density = |(density, classes): (&[f32], &[Class])| {
            Lanes(std::array::from_fn(|lane| if classes[lane] == class { density[lane] } else { 0.0 }))
        };
        runs.map(density).collect()
    };
    Matter { lattice: medium.grid.lattice as usize, leaf: of(Class::Leaf), wood: of(Class::Wood) }
}

/// Iterates from darkness until the residual is below the tolerance or no iteration is left, then leaves phi of
/// all sites in `phi`. What `light` holds before does not matter.
fn relax(
    matter: &Matter,
    gains: &[Gain; 2],
    base: u8,
    settings: &SolveSettings,
    light: &mut [Vec<f32>; 2],
    phi: &mut [f32],
) -> Course {
    let n = matter.lattice;
    light.iter_mut().for_each(|light| darken(light, n, base));
    phi.fill(0.0);
    let [mut old, mut new] = light.each_mut();
    let mut course = Course::default();
    for iteration in 1..=settings.max_sweeps as usize {
        let planes = new.par_chunks_mut(n * n * MOVING).zip(phi.par_chunks_mut(n * n)).enumerate();
        let sums: Vec<[f64; 2]> =
            planes.map(|(z, (new, phi))| update_plane(matter, gains, z, old, new, phi)).collect();
        let [change, norm] = [0, 1].map(|k| sums.iter().map(|sums| sums[k]).sum::<f64>());
        std::mem::swap(&mut old, &mut new);
        course.note(change, norm);
        // Before light has crossed the lattice, residuals say nothing: what is dark yet does not change.
        if iteration > n + TREND_SPAN && course.is_over(settings) {
            break;
        }
    }
    cross_empty_sites(matter, old);
    phi.par_chunks_mut(n).enumerate().for_each(|(row, phi)| {
        let (y, z) = (row % n, row / n);
        if [y, z].iter().any(|&c| c == 0 || c == n - 1) {
            return;
        }
        for x in (1..n - 1).filter(|&x| matter.is_empty(row * n + x)) {
            phi[x] = (1..=MOVING).map(|m| upstream(old, n, m, y, z, x)[0]).sum::<f32>().max(0.0);
        }
    });
    dense::hold_boundary(phi, n, dense::boundary_light(usize::from(base)));
    course
}

/// Carries light through empty sites all the way, direction by direction in the order of travel. What leaves the
/// plant last would else not have reached the lattice's far ends.
fn cross_empty_sites(matter: &Matter, light: &mut [f32]) {
    let n = matter.lattice;
    let order = |c: i32, at: usize| if c < 0 { n - 1 - at } else { at };
    for m in 1..=MOVING {
        let [cx, cy, cz] = DIRECTIONS[m];
        for (z, y) in (1..n - 1).flat_map(|z| (1..n - 1).map(move |y| (order(cz, z), order(cy, y)))) {
            for x in (1..n - 1).map(|x| order(cx, x)) {
                let row = z * n + y;
                if matter.is_empty(row * n + x) {
                    light[(row * MOVING + m - 1) * n + x] = upstream(light, n, m, y, z, x)[0];
                }
            }
        }
    }
}

/// Boundary light in the outermost layer, none inside.
fn darken(light: &mut [f32], n: usize, base: u8) {
    light.par_chunks_mut(n * MOVING).enumerate().for_each(|(row, light)| {
        light.fill(0.0);
        for m in (1..=MOVING).filter(|&m| dense::is_lit(usize::from(base), m)) {
            let lit = &mut light[(m - 1) * n..][..n];
            if [row % n, row / n].iter().all(|&c| c > 0 && c < n - 1) {
                (lit[0], lit[n - 1]) = (1.0, 1.0);
            } else {
                lit.fill(1.0);
            }
        }
    });
}

/// What sites x - c_x and on of the neighbouring row sent along m: what arrives at sites x and on of row (y, z).
#[inline(always)]
fn upstream(old: &[f32], n: usize, m: usize, y: usize, z: usize, x: usize) -> &[f32] {
    let [cx, cy, cz] = DIRECTIONS[m].map(|c| c as isize);
    let row = (z as isize - cz) * n as isize + (y as isize - cy);
    &old[((row * MOVING as isize + m as isize - 1) * n as isize + x as isize - cx) as usize..]
}

/// One iteration of the inner sites of a plane. Sums of (phi - before)^2 and phi^2 over its non-empty sites.
fn update_plane(
    matter: &Matter,
    gains: &[Gain; 2],
    z: usize,
    old: &[f32],
    new: &mut [f32],
    phi: &mut [f32],
) -> [f64; 2] {
    let n = matter.lattice;
    let mut sums = [0.0; 2];
    if z == 0 || z == n - 1 {
        return sums;
    }
    for y in 1..n - 1 {
        let row = &mut new[y * n * MOVING..][..n * MOVING];
        for m in 1..=MOVING {
            let arriving = &upstream(old, n, m, y, z, 1)[..n - 2];
            row[(m - 1) * n + 1..m * n - 1].copy_from_slice(arriving);
        }
        for run in 0..n / LANES {
            let at = (z * n + y) * (n / LANES) + run;
            let (leaf, wood) = (&matter.leaf[at], &matter.wood[at]);
            if leaf.0.iter().chain(&wood.0).any(|rho| *rho > 0.0) {
                let before = phi[y * n + run * LANES..].first_chunk_mut().expect("whole runs");
                let of_run = collide_run(gains, [leaf, wood], &mut row[run * LANES..], n, before);
                sums.iter_mut().zip(of_run).for_each(|(sum, part)| *sum += part);
            }
        }
    }
    sums
}

/// Replaces the arriving light of one run of a row, `[m - 1][x]` with `n` between directions, by what its sites send.
/// Empty sites among them pass their light on.
fn collide_run(
    gains: &[Gain; 2],
    rho: [&Lanes; 2],
    row: &mut [f32],
    n: usize,
    phi: &mut [f32; LANES],
) -> [f64; 2] {
    let run = |row: &[f32], m: usize| Lanes(*row[m * n..].first_chunk().expect("whole runs"));
    let arriving: [Lanes; MOVING] = std::array::from_fn(|m| run(row, m));
    let (mut sent, mut light) = ([Lanes::default(); MOVING], Lanes::default());
    for (gain, rho) in gains.iter().zip(rho) {
        if rho.0.iter().all(|rho| *rho == 0.0) {
            continue;
        }
        gain.collide(rho, &arriving, &mut sent, &mut light);
        for (m, sent) in sent.iter().enumerate() {
            for lane in (0..LANES).filter(|&lane| rho.0[lane] > 0.0) {
                row[m * n + lane] = sent.0[lane];
            }
        }
    }
    let mut sums = [0.0; 2];
    for lane in (0..LANES).filter(|&lane| rho[0].0[lane] + rho[1].0[lane] > 0.0) {
        let step = f64::from(light.0[lane] - phi[lane]);
        phi[lane] = light.0[lane];
        sums[0] += step * step;
        sums[1] += f64::from(light.0[lane]) * f64::from(light.0[lane]);
    }
    sums
}
