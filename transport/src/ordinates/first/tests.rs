//! The first scattering has the same bits whatever SIMD the machine has.

use flb_format::beam::Near;
use flb_format::ordinates::Ordinates;

use super::super::march::tests::{medium, numbers};
use super::*;

#[test]
fn first_scattering_has_the_same_bits_with_any_simd() {
    let medium = medium();
    let sites = medium.sites();
    let march = March::new(&medium, &sites, Ordinates::Lebedev50, 2);
    let beam = Near::new(&medium, &sites, false).uncollided([0.6, 0.8, 0.0], 2);
    let lights: Vec<SiteLight> = numbers::<4>(sites.len())
        .iter()
        .map(|[mean, x, y, z]| [LanePair([*mean, *x]), LanePair([*y, *z])])
        .collect();
    let albedos: Vec<Albedos<2>> =
        beam.mean.iter().map(|mean| Albedos([[*mean, 0.1], [0.3, *mean]])).collect();
    let turned = [[[Lanes([0.3; 8]), Lanes([0.7; 8])]; 2], [[Lanes([1.1; 8]), Lanes([0.2; 8])]; 2]];
    let scattered = |simd: bool| {
        let mut first = vec![[[Lanes::default(); 4]; 2]; sites.len()];
        let mut crossed = Vec::new();
        for axis in &march.axes {
            let (first, crossed) = (&mut first, &mut crossed);
            let job = FirstJob { axis, albedos: &albedos, turned: &turned, lights: &lights, first, crossed };
            if simd { Arch::new().dispatch(job) } else { job.call() }
        }
        first
    };
    assert!(scattered(true) == scattered(false));
}
