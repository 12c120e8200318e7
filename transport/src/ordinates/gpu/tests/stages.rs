//! First scattering, a pass and an iteration, each by itself.

use flb_format::beam::{Beam, Near};
use flb_format::ordinates::Ordinates;

use super::super::super::march::tests::numbers;
use super::super::super::source_iteration::{arrives, source_iteration};
use super::super::rays::Rays;
use super::super::relax::{End, relax};
use super::super::work::Work;
use super::*;
use crate::gpu::GpuError;

/// Toward the suns of two groups, of which the second is not full.
fn suns() -> Vec<[f64; 3]> {
    let around = |at: usize| {
        let angle = at as f64 * 0.7;
        [0.8 * libm::cos(angle), 0.6, 0.8 * libm::sin(angle)]
    };
    (0..11).map(around).collect()
}

fn march(medium: &TurbidMedium) -> March {
    March::new(medium, &medium.sites(), Ordinates::Lebedev50, 2)
}

fn beams(medium: &TurbidMedium) -> Vec<Beam> {
    let sites = medium.sites();
    let near = Near::new(medium, &sites, false);
    suns().iter().map(|sun| near.uncollided(*sun, 2)).collect()
}

/// Does `of` with the lanes of two groups.
fn with_work<const M: usize, T>(march: &March, band: &Band, of: impl FnOnce(&Work) -> T) -> T {
    assert_eq!(band.moments, M);
    let gpu = gpu();
    let rays = Rays::upload(&gpu.opened, march, u64::MAX).unwrap();
    let work = Work::new(&gpu, &rays, &march.escape, &band.gains, M, 2 * LANES).unwrap();
    of(&work)
}

fn first_scatterings_are_alike<const M: usize>(medium: &TurbidMedium, scatter: &BandScatter) {
    let (march, beams, band) = (march(medium), beams(medium), band(medium, scatter));
    let beams: Vec<&Beam> = beams.iter().collect();
    let groups: Vec<&[&Beam]> = beams.chunks(LANES).collect();
    let found = with_work::<M, _>(&march, &band, |work| {
        work.first_scattering::<M>(&march, &band.matter, &groups).unwrap()
    });
    assert_eq!(found.len(), groups.len());
    for (found, beams) in found.iter().zip(groups) {
        let [expected] = march.first_scattering::<M, 1>([&band.matter], beams);
        let (worst, mean) = difference(&numbers_of(found), &numbers_of(&expected));
        assert!(worst < ALIKE && mean > 0.0, "{M} moments: {worst:e} of {mean}");
        for lane in beams.len()..LANES {
            assert!(found.iter().flatten().all(|lanes| lanes.0[lane] == 0.0), "lane {lane} is idle");
        }
    }
}

#[test]
fn the_first_scattering_is_that_of_the_cpu() {
    let [even, slanted, curved] = bands();
    first_scatterings_are_alike::<1>(&medium(), &even);
    first_scatterings_are_alike::<4>(&medium(), &slanted);
    first_scatterings_are_alike::<9>(&medium(), &curved);
    first_scatterings_are_alike::<9>(&flat_leaves(), &even);
}

/// Different light in each group.
fn lights<const M: usize>(sites: usize) -> [Moments<M>; 2] {
    let light = numbers::<M>(sites);
    let mut other = light.clone();
    other.reverse();
    [light, other]
}

fn passes_are_alike<const M: usize>(medium: &TurbidMedium, scatter: &BandScatter) {
    let (march, band) = (march(medium), band(medium, scatter));
    let lights = lights::<M>(march.escape.len());
    let [a, b] = &lights;
    let found = with_work::<M, _>(&march, &band, |work| work.arrives(&[a, b]).unwrap());
    assert_eq!(found.len(), 2);
    for (found, light) in found.iter().zip(&lights) {
        let expected = arrives(&march, &band.gains, light);
        let (worst, mean) = difference(&numbers_of(found), &numbers_of(&expected));
        assert!(worst < ROUNDING && mean > 0.0, "{M} moments: {worst:e} of {mean}");
    }
}

#[test]
fn a_pass_is_that_of_the_cpu() {
    let [even, slanted, curved] = bands();
    passes_are_alike::<1>(&medium(), &even);
    passes_are_alike::<4>(&medium(), &slanted);
    passes_are_alike::<9>(&medium(), &curved);
    passes_are_alike::<9>(&flat_leaves(), &even);
}

fn iterations_are_alike<const M: usize>(medium: &TurbidMedium, scatter: &BandScatter, end: End) -> Vec<u32> {
    let (march, band) = (march(medium), band(medium, scatter));
    let lights = lights::<M>(march.escape.len());
    let [a, b] = &lights;
    // Errors of the second group count less, so that it ends sooner.
    let sizes = [[0.0; LANES], [1e6; LANES]];
    let found = with_work::<M, _>(&march, &band, |work| {
        relax(work, &band.gains, &[a, b], &[a, b], &sizes, end).unwrap()
    });
    let mut passes = Vec::new();
    for ((found, light), sizes) in found.iter().zip(&lights).zip(sizes) {
        let expected = source_iteration(&march, &band.gains, light, None, sizes, end.tolerance, end.most);
        assert_eq!(found.passes, expected.passes);
        let ratio = found.error_estimate / expected.error_estimate;
        assert!((ratio - 1.0).abs() < 1e-2, "{M} moments: error estimates differ by {ratio}");
        let (worst, mean) = difference(&numbers_of(&found.light), &numbers_of(&expected.light));
        assert!(worst < ALIKE && mean > 0.0, "{M} moments: {worst:e} of {mean}");
        passes.push(found.passes);
    }
    passes
}

#[test]
fn an_iteration_is_that_of_the_cpu_and_each_group_ends_by_itself() {
    let [even, slanted, curved] = bands();
    let end = End { tolerance: 1e-4, most: 100 };
    let passes = iterations_are_alike::<1>(&medium(), &even, end);
    assert!(passes[1] < passes[0], "{passes:?}");
    iterations_are_alike::<4>(&medium(), &slanted, end);
    iterations_are_alike::<9>(&medium(), &curved, end);
    iterations_are_alike::<9>(&flat_leaves(), &even, end);
}

#[test]
fn an_iteration_is_given_up_after_the_passes_of_the_cpu() {
    let [_, slanted, _] = bands();
    for most in 1..=4 {
        assert_eq!(iterations_are_alike::<4>(&medium(), &slanted, End { tolerance: 1e-6, most }), [most; 2]);
    }
}

#[test]
fn what_does_not_fit_is_refused_with_both_numbers() {
    let (gpu, march) = (gpu(), march(&medium()));
    let rays = Rays::upload(&gpu.opened, &march, u64::MAX).unwrap();
    let lane_bytes = rays.most_of_lane(1) * 4;
    let fit = |groups: u64| rays.lanes_that_fit(&gpu.opened, 1, groups * LANES as u64 * lane_bytes);
    assert_eq!([fit(1), fit(3), fit(9)], [Ok(LANES), Ok(3 * LANES), Ok(4 * LANES)]);
    let needed = LANES as u64 * lane_bytes;
    let too_large = |sites: usize, needed: u64, limit: u64| GpuError::TooLarge {
        adapter: gpu.opened.name.clone(),
        sites,
        needed,
        limit,
    };
    let sites = march.escape.len();
    let refused = rays.lanes_that_fit(&gpu.opened, 1, needed - 1).unwrap_err();
    assert_eq!(refused, too_large(sites, needed, needed - 1));
    let refused = Rays::upload(&gpu.opened, &march, 1000).err().unwrap();
    assert!(matches!(refused, GpuError::TooLarge { limit: 1000, .. }), "{refused}");
    for part in [&gpu.opened.name, "non-empty sites", "at most the 1000"] {
        assert!(refused.to_string().contains(part), "{refused}");
    }
}
