//! What Monte Carlo light costs and how noisy it is, on the built-in oak under an oblique sun: a million photons.
//!
//! `cargo bench -p flb-baker --bench monte_carlo`

#[path = "solve/oak.rs"]
mod oak;

use std::time::Instant;

use flb_baker::crown::unclumped;
use flb_transport::monte_carlo::{Fluence, Illumination, Settings, Tracking, trace};
use flb_transport::turbid::{BandScatter, LeafAngles, Phase, Scatter};

fn main() {
    println!("| lattice | sites | albedo | tracking | seconds | noise of a site, % of mean |");
    println!("|---|---|---|---|---|---|");
    let sun = Illumination::Sun([0.48, 0.8, 0.36]);
    for lattice in [32, 64, 128] {
        let medium = oak::medium(lattice);
        let sites = oak::sites_of(&medium);
        let turbid = unclumped(&medium, LeafAngles::spherical()).expect("a good medium");
        for albedo in [0.9, 0.3] {
            let matter = Scatter { albedo, phase: Phase::BiLambert { transmitted: 0.45 } };
            let scatter = BandScatter { leaf: matter, wood: matter };
            for tracking in [Tracking::Regular, Tracking::Delta] {
                let settings = Settings { photons: 1_000_000, tracking, ..Settings::default() };
                let start = Instant::now();
                let light = trace(&turbid, &scatter, sun, &settings, &|_| Ok(())).expect("a good medium");
                let (seconds, noise) = (start.elapsed().as_secs_f64(), noise(&light));
                println!("| {lattice} | {sites} | {albedo} | {tracking:?} | {seconds:.2} | {noise:.2} |");
            }
        }
    }
}

/// Standard error of a site's fluence, rms over the sites, in % of the mean total fluence.
fn noise(fluence: &Fluence) -> f64 {
    let total = fluence.total();
    let square: f64 = fluence.error.iter().map(|error| error * error).sum();
    100.0 * (square / total.len() as f64).sqrt() / (total.iter().sum::<f64>() / total.len() as f64)
}
