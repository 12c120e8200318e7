mod closed_forms;
mod comparisons;
mod directions;
mod judged;
mod laws;
mod refusals;

use flb_format::Grid;
use flb_format::progress::Cancelled;

use super::*;
use crate::turbid::{BandScatter, LeafAngles, Phase, Scatter, TurbidMedium};

/// Standard errors that two estimates may be apart: a fixed seed that passes once passes for ever, and a true fault of
/// a few percent is tens of errors away.
const ERRORS: f64 = 4.0;

/// A medium of leaves with the given extinction per site, and sites of half a metre.
fn medium(lattice: u32, extinction: impl Fn([f64; 3]) -> f64) -> TurbidMedium {
    let grid = Grid { lattice, origin_m: [-1.0, 2.0, 3.0], spacing_m: 0.5 };
    let mut leaf_per_m = vec![0.0; grid.sites()];
    for z in 0..lattice {
        for y in 0..lattice {
            for x in 0..lattice {
                let center = [x, y, z].map(|c| f64::from(c) + 0.5);
                leaf_per_m[grid.index(x, y, z)] = (extinction(center) / grid.spacing_m) as f32;
            }
        }
    }
    let wood_per_m = vec![0.0; grid.sites()];
    TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::spherical() }
}

/// A ball of radius 5 in 16^3, of optical depth `depth` across.
fn ball(depth: f64) -> TurbidMedium {
    medium(16, |center| {
        let square: f64 = center.iter().map(|c| (c - 8.0) * (c - 8.0)).sum();
        if square < 25.0 { depth / 10.0 } else { 0.0 }
    })
}

/// Clumps of very unlike extinction, leaf and wood, and holes: the same for everybody.
fn clumps() -> TurbidMedium {
    let mut clumps = medium(16, |center| {
        let mix = libm::sin(center[0] * 12.9 + center[1] * 78.2 + center[2] * 37.7) * 43758.5;
        let draw = mix - mix.floor();
        let inside = center.iter().all(|c| (3.0..13.0).contains(c));
        if inside && draw < 0.5 { 4.0 * draw * draw * draw } else { 0.0 }
    });
    for (site, wood) in clumps.wood_per_m.iter_mut().enumerate().filter(|(site, _)| site % 16 == 8) {
        *wood = clumps.leaf_per_m[site] * 0.7;
    }
    clumps
}

fn alike(albedo: f64, phase: Phase) -> BandScatter {
    BandScatter { leaf: Scatter { albedo, phase }, wood: Scatter { albedo, phase } }
}

fn photons(photons: u64) -> Settings {
    Settings { photons, ..Settings::default() }
}

fn quiet(_: f64) -> Result<(), Cancelled> {
    Ok(())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Asserts that a value is within [`ERRORS`] standard errors of what is expected, and that the error is no larger than
/// the share `most` of it, so that the test says something.
fn assert_within(found: f64, error: f64, expected: f64, most: f64, what: &str) {
    assert!(error <= most * expected.abs(), "{what}: standard error {error} of {expected}");
    assert!(
        (found - expected).abs() <= ERRORS * error.max(1e-9 * expected.abs()),
        "{what}: {found} +- {error}, expected {expected}"
    );
}
