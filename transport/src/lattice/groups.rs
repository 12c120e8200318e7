//! Which solves go side by side, and which start from another's light.
//!
//! Light of one band is a good start for the next: bands share the geometry and differ little in their optics. An oak
//! at lattice 128 needs 17 sweeps from darkness, and 10 from a band like its own. So a lane stays with its base and
//! takes one band after the other.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use flb_format::matter::Optics;

use super::kernel::LANES;

/// One base in one band.
pub(super) struct Target<'a> {
    pub base: u8,
    pub band: u32,
    /// The band's part of the base's field.
    pub output: &'a mut [f32],
}

/// Solves that share their passes over the sites.
pub(super) struct SolveGroup<'a> {
    /// Steps, one after the other; lane l of a step starts from lane l of the step before, which has the same base.
    /// Later steps may have fewer lanes.
    pub steps: Vec<Vec<Target<'a>>>,
}

/// Sorts solves into groups. Bases fill lanes; bands follow each other, like after like. Where bases are too few to
/// fill a group, each gets several lanes and the bands are dealt out.
pub(super) fn form<'a>(targets: Vec<Target<'a>>, optics: &Optics) -> Vec<SolveGroup<'a>> {
    let mut order: Vec<u32> = (0..optics.bands.len() as u32).collect();
    let of = |band: &u32| &optics.bands[*band as usize];
    // What absorbs most first: light that still has to grow comes nearer with a sweep than light that has to fade.
    order.sort_by(|a, b| {
        let keys = |band| [of(band).leaf.sigma_a, of(band).wood.sigma_a, of(band).leaf.g, of(band).wood.g];
        let orders = keys(b).into_iter().zip(keys(a)).map(|(b, a)| b.total_cmp(&a));
        orders.fold(Ordering::Equal, Ordering::then)
    });
    let mut left: BTreeMap<(u8, u32), Target> =
        targets.into_iter().map(|target| ((target.base, target.band), target)).collect();
    let mut bases: Vec<u8> = left.keys().map(|(base, _)| *base).collect();
    bases.dedup();

    // Lanes: a base and its bands.
    let (full, rest) = bases.split_at(bases.len() / LANES * LANES);
    let mut lanes: Vec<(u8, &[u32])> = full.iter().map(|base| (*base, &order[..])).collect();
    // Even a few bases shall keep two threads busy.
    let parts = (LANES / rest.len().max(1)).max(if full.is_empty() { 2 } else { 1 });
    for part in order.chunks(order.len().div_ceil(parts).max(1)) {
        lanes.extend(rest.iter().map(|base| (*base, part)));
    }
    let group = |lanes: &[(u8, &[u32])]| {
        let longest = lanes.iter().map(|(_, bands)| bands.len()).max().unwrap_or(0);
        // Shorter parts come last, so a step's lanes are the first ones.
        let mut of_step = |step: usize| {
            lanes.iter().filter_map(|(base, bands)| left.remove(&(*base, *bands.get(step)?))).collect()
        };
        SolveGroup { steps: (0..longest).map(&mut of_step).collect() }
    };
    lanes.chunks(LANES).map(group).collect()
}

#[cfg(test)]
mod tests {
    use flb_format::matter::{BandOptics, ClassOptics};

    use super::*;

    fn optics(bands: usize) -> Optics {
        let band = |at: usize| {
            // Neither rising nor falling.
            let sigma_a = ((at * 5) % 7) as f64 / 7.0;
            let class = ClassOptics { sigma_a, g: 0.0 };
            BandOptics { name: format!("b{at}"), leaf: class, wood: class }
        };
        Optics { bands: (0..bands).map(band).collect() }
    }

    #[test]
    fn every_solve_is_in_one_place_and_lanes_keep_their_base() {
        for (bases, bands) in [(18, 3), (18, 64), (19, 1), (8, 2), (1, 1), (1, 9), (5, 3), (16, 7), (13, 4)] {
            let mut outputs = vec![[]; bases * bands];
            let targets: Vec<Target> = outputs
                .iter_mut()
                .enumerate()
                .map(|(at, output)| Target { base: (at % bases) as u8, band: (at / bases) as u32, output })
                .collect();
            let optics = optics(bands);
            let groups = form(targets, &optics);
            let mut seen = Vec::new();
            for group in &groups {
                for step in &group.steps {
                    assert!((1..=LANES).contains(&step.len()), "{bases} {bands}");
                    seen.extend(step.iter().map(|target| (target.base, target.band)));
                }
                for steps in group.steps.windows(2) {
                    assert!(steps[1].len() <= steps[0].len());
                    for (before, after) in steps[0].iter().zip(&steps[1]) {
                        assert_eq!(before.base, after.base, "{bases} {bands}");
                        let sigma_a = |target: &Target| optics.bands[target.band as usize].leaf.sigma_a;
                        assert!(sigma_a(before) >= sigma_a(after));
                    }
                }
            }
            seen.sort_unstable();
            let all: Vec<(u8, u32)> =
                (0..bases as u8).flat_map(|base| (0..bands as u32).map(move |band| (base, band))).collect();
            assert_eq!(seen, all);
        }
    }

    #[test]
    fn three_bands_of_eighteen_bases_make_three_groups() {
        let mut outputs = [[]; 54];
        let targets = outputs.iter_mut().enumerate();
        let targets = targets
            .map(|(at, output)| Target { base: (at % 18) as u8 + 1, band: (at / 18) as u32, output })
            .collect();
        let shape: Vec<Vec<usize>> = form(targets, &optics(3))
            .iter()
            .map(|group| group.steps.iter().map(Vec::len).collect())
            .collect();
        assert_eq!(shape, [vec![8, 8, 8], vec![8, 8, 8], vec![6]]);
    }
}
