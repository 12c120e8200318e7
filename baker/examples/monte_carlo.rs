//! Monte Carlo light in a medium from a JSON file, for other codes to be held against (`tests/mitsuba/compare.py`).
//!
//! `cargo run --release -p flb-baker --example monte_carlo -- MEDIUM.json > LIGHT.json`
//!
//! ```text
//! { "lattice": 16, "spacing_m": 0.1,          sites of [0, 1.6] m
//!   "extinction_per_m": [...],                [z][y][x], x fastest; leaves that favour no direction
//!   "albedo": 0.9,
//!   "g": 0.5,                                 or "transmitted": 0.3, two-sided Lambertian leaves
//!   "toward_sun": [0, 1, 0],                  a unit vector; without it, light from everywhere
//!   "photons": 1000000, "seed": 1, "delta": false }
//! ```
//!
//! The output holds `site` (indices of the sites that hold matter), `uncollided`, `scattered`, `error` (per such site),
//! `mean_error` and `seconds`.

use std::error::Error;
use std::time::Instant;

use flb_format::Grid;
use flb_transport::monte_carlo::{Illumination, Settings, Tracking, trace};
use flb_transport::turbid::{BandScatter, LeafAngles, Phase, Scatter, TurbidMedium};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Task {
    lattice: u32,
    spacing_m: f64,
    extinction_per_m: Vec<f32>,
    albedo: f64,
    g: Option<f64>,
    transmitted: Option<f64>,
    toward_sun: Option<[f64; 3]>,
    photons: u64,
    seed: u64,
    #[serde(default)]
    delta: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("expected the path of a JSON file")?;
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?;
    let task: Task = serde_json::from_str(&text).map_err(|error| format!("{path}: {error}"))?;
    let phase = match (task.g, task.transmitted) {
        (Some(g), None) => Phase::HenyeyGreenstein { g },
        (None, Some(transmitted)) => Phase::BiLambert { transmitted },
        _ => return Err(format!("{path}: expected either g or transmitted").into()),
    };
    let scatter = Scatter { albedo: task.albedo, phase };
    let grid = Grid { lattice: task.lattice, origin_m: [0.0; 3], spacing_m: task.spacing_m };
    let medium = TurbidMedium {
        grid,
        wood_per_m: vec![0.0; task.extinction_per_m.len()],
        leaf_per_m: task.extinction_per_m,
        angles: LeafAngles::spherical(),
    };
    let settings = Settings {
        photons: task.photons,
        seed: task.seed,
        tracking: if task.delta { Tracking::Delta } else { Tracking::Regular },
        ..Settings::default()
    };
    let light = task.toward_sun.map_or(Illumination::Sky, Illumination::Sun);
    let start = Instant::now();
    let fluence =
        trace(&medium, &BandScatter { leaf: scatter, wood: scatter }, light, &settings, &|_| Ok(()))
            .map_err(|error| format!("{path}: {error}"))?;
    let answer = serde_json::json!({
        "site": medium.sites(),
        "uncollided": fluence.uncollided,
        "scattered": fluence.scattered,
        "error": fluence.error,
        "mean_error": fluence.mean_error,
        "seconds": start.elapsed().as_secs_f64(),
    });
    println!("{answer}");
    Ok(())
}
