//! The marches on the GPU against those of the CPU. They need an adapter, and fail without one; lavapipe
//! (`scripts/setup test` installs it) will do.

mod scattered;
mod stages;
mod wgsl;

use super::super::band::{Band, Own};
use super::super::lanes::LANES;
use super::super::march::March;
use super::super::march::tests::medium;
use super::super::moments::Moments;
use super::device::{self, Gpu};
use crate::turbid::{BandScatter, LeafAngles, Phase, Scatter, TurbidMedium};

/// Largest difference from the CPU, relative to the mean.
const ALIKE: f64 = 1e-4;

/// Two orders of the same sums in f32; drivers may fuse multiplications with additions.
const ROUNDING: f64 = 2e-5;

fn gpu() -> Gpu {
    // The message says what to install.
    device::open(1).unwrap_or_else(|error| panic!("{error}")).remove(0)
}

/// Largest difference of two lists, relative to the mean of the second, and that mean.
fn difference(found: &[f32], expected: &[f32]) -> (f64, f64) {
    assert_eq!(found.len(), expected.len());
    let mean = expected.iter().map(|value| f64::from(value.abs())).sum::<f64>() / expected.len() as f64;
    let differences = found.iter().zip(expected).map(|(found, expected)| f64::from((found - expected).abs()));
    (differences.fold(0.0, f64::max) / mean, mean)
}

fn numbers_of<const M: usize>(light: &Moments<M>) -> Vec<f32> {
    light.iter().flatten().flat_map(|lanes| lanes.0).collect()
}

/// Leaves that let a third of what they scatter through, and bark.
fn leaves(albedo: f64) -> BandScatter {
    let scatter = |albedo, transmitted| Scatter { albedo, phase: Phase::BiLambert { transmitted } };
    BandScatter { leaf: scatter(albedo, 0.33), wood: scatter(0.15, 0.0) }
}

/// Bands whose light has 1, 4 and 9 moments.
fn bands() -> [BandScatter; 3] {
    let forward = |g| Scatter { albedo: 0.6, phase: Phase::HenyeyGreenstein { g } };
    let opaque = Scatter { albedo: 0.7, phase: Phase::BiLambert { transmitted: 0.0 } };
    let slanted = BandScatter { leaf: opaque, ..leaves(0.7) };
    [leaves(0.4), slanted, BandScatter { leaf: forward(0.5), wood: forward(-0.4) }]
}

fn band(medium: &TurbidMedium, scatter: &BandScatter) -> Band {
    Band::new(medium, &medium.sites(), scatter, &Own { albedos: None, transmitted: None })
}

/// Leaves that lie mostly flat: light of the first of the bands has 9 moments.
fn flat_leaves() -> TurbidMedium {
    TurbidMedium { angles: LeafAngles::planophile(), ..medium() }
}
