//! The stages of the GPU on the CPU, eight lanes at a time: what the WGSL is held against. The solver in which a site
//! sees only the iteration before.

use flb_format::direction::MOVING;
use flb_format::matter::Optics;

use super::super::collision::{self, Matrix};
use super::super::dense;
use super::super::kernel::{Gain, LANES, Lanes};
use super::super::sites::Domain;
use super::super::sweep::MIN_LOSS;

/// After some iterations.
pub(super) struct Twin {
    /// Rows as `before` and `after` of types.wgsl, but settled.
    pub rows: Vec<Lanes>,
    /// Sums of (phi - before)^2 and phi^2, `[iteration][lane]`.
    pub moves: Vec<[[f64; 2]; LANES]>,
}

/// Does `count` iterations from darkness.
pub(super) fn relax(domain: &Domain, optics: &Optics, lanes: &[(u8, u32); LANES], count: usize) -> Twin {
    let bands = lanes.map(|(_, band)| &optics.bands[band as usize]);
    let leaf = bands.map(|band| collision::gain(band.leaf, false));
    let wood = bands.map(|band| collision::gain(band.wood, true));
    let gains = [Gain::new(&leaf), Gain::new(&wood)];
    let mut before = vec![Lanes::default(); domain.rows()];
    for (m, row) in before[domain.len() * MOVING..].iter_mut().enumerate() {
        row.0 = lanes.map(|(base, _)| if dense::is_lit(usize::from(base), m + 1) { 1.0 } else { 0.0 });
    }
    let mut after = before.clone();
    let mut phi = vec![Lanes::default(); domain.len()];
    let mut moves = Vec::new();
    for _ in 0..count {
        let mut of_iteration = [[0.0; 2]; LANES];
        for (site, phi) in phi.iter_mut().enumerate() {
            let light = collide(domain, &gains, &wood, site, &before, &mut after);
            for (lane, sums) in of_iteration.iter_mut().enumerate() {
                let (light, step) = (light.0[lane], light.0[lane] - phi.0[lane]);
                *sums = [sums[0] + f64::from(step * step), sums[1] + f64::from(light * light)];
            }
            *phi = light;
        }
        moves.push(of_iteration);
        std::mem::swap(&mut before, &mut after);
    }
    settle(domain, &wood, &mut before);
    Twin { rows: before, moves }
}

/// collide.wgsl: light of `before` -> light of `after`; returns phi.
fn collide(
    domain: &Domain,
    gains: &[Gain; 2],
    wood: &[Matrix; LANES],
    site: usize,
    before: &[Lanes],
    after: &mut [Lanes],
) -> Lanes {
    let rho = domain.rho[site];
    let mut arriving = [Lanes::default(); MOVING];
    let mut returned = [Lanes::default(); MOVING];
    for m in 0..MOVING {
        let link = domain.links[site][m] as usize;
        arriving[m] = before[link];
        let leaving = m ^ 1;
        if domain.echoes[site] >> leaving & 1 == 1 {
            for (lane, wood) in wood.iter().enumerate() {
                let share = wood[m + 1][leaving + 1] as f32;
                let (here, there) = (rho * share, domain.rho[link / MOVING] * share);
                let lost = 1.0 - here * there;
                if lost >= MIN_LOSS {
                    let own = before[site * MOVING + leaving].0[lane];
                    arriving[m].0[lane] = (before[link].0[lane] + there * own) / lost;
                    returned[leaving].0[lane] = here * arriving[m].0[lane];
                }
            }
        }
    }
    let (mut sent, mut phi) = ([Lanes::default(); MOVING], Lanes::default());
    gains[usize::from(domain.wood[site])].collide(&Lanes([rho; LANES]), &arriving, &mut sent, &mut phi);
    for m in 0..MOVING {
        after[site * MOVING + m] = Lanes(std::array::from_fn(|lane| sent[m].0[lane] - returned[m].0[lane]));
    }
    phi
}

/// settle.wgsl.
fn settle(domain: &Domain, wood: &[Matrix; LANES], rows: &mut [Lanes]) {
    for site in 0..domain.len() {
        for m in (0..MOVING).filter(|m| domain.echoes[site] >> m & 1 == 1) {
            let other = domain.links[site][m ^ 1] as usize;
            if other / MOVING < site {
                continue;
            }
            let own = site * MOVING + m;
            for (lane, wood) in wood.iter().enumerate() {
                let share = wood[(m ^ 1) + 1][m + 1] as f32;
                let (here, there) = (domain.rho[site] * share, domain.rho[other / MOVING] * share);
                let lost = 1.0 - here * there;
                if lost >= MIN_LOSS {
                    let (p, q) = (rows[own].0[lane], rows[other].0[lane]);
                    rows[own].0[lane] = (p + here * q) / lost;
                    rows[other].0[lane] = (q + there * p) / lost;
                }
            }
        }
    }
}
