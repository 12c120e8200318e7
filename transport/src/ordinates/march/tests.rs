//! Marches have the same bits whatever SIMD the machine has.

use flb_format::Grid;
use flb_format::beam::{Near, single};
use flb_format::matter::LeafAngles;

use super::*;

pub(in super::super) fn medium() -> TurbidMedium {
    let grid = Grid { lattice: 16, origin_m: [0.0; 3], spacing_m: 0.5 };
    let density = |site: usize| if site % 7 < 2 { (site % 13) as f32 * 0.3 } else { 0.0 };
    let leaf_per_m: Vec<f32> = (0..grid.sites()).map(density).collect();
    let wood_per_m = leaf_per_m.iter().map(|leaf| if *leaf > 2.0 { 1.0 } else { 0.0 }).collect();
    TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::spherical() }
}

/// A different number for each site, moment and lane.
pub(in super::super) fn numbers<const M: usize>(sites: usize) -> Vec<[Lanes; M]> {
    let number = |site: usize, a: usize, lane: usize| ((site * 31 + a * 7 + lane * 3) % 101) as f32 / 101.0;
    (0..sites)
        .map(|site| std::array::from_fn(|a| Lanes(std::array::from_fn(|lane| number(site, a, lane)))))
        .collect()
}

fn passes_alike<const M: usize>(march: &March) {
    let source = numbers::<M>(march.escape.len());
    let sites = source.iter().map(|&source| Exchange { source, excess: [Lanes::default(); M] });
    let (mut plain, mut wide): (Vec<_>, Vec<_>) = sites.map(|site| (site, site)).unzip();
    march.axes.iter().for_each(|axis| PassJob { axis, sites: &mut plain }.call());
    march.pass(&mut wide);
    assert!(plain.iter().zip(&wide).all(|(plain, wide)| plain.excess == wide.excess));
    assert!(wide.iter().any(|site| site.excess[0] != Lanes::default()));
}

#[test]
fn a_pass_has_the_same_bits_with_any_simd() {
    let medium = medium();
    let march = March::new(&medium, &medium.sites(), Ordinates::Lebedev50, 2);
    passes_alike::<1>(&march);
    passes_alike::<4>(&march);
    passes_alike::<9>(&march);
}

#[test]
fn the_near_beam_along_the_rays_of_a_march_has_the_bits_that_readers_find() {
    let medium = medium();
    let sites = medium.sites();
    let march = March::new(&medium, &sites, single::ORDINATES, single::rays(medium.grid.lattice));
    let along = Near::along(&medium, &sites, march.tracks()).beam([0.6, 0.8, 0.0], 2);
    assert!(along == Near::new(&medium, &sites, true).beam([0.6, 0.8, 0.0], 2));
    assert!(along.around[1].iter().any(|once| *once > 0.0));
}
