//! Monte Carlo reference: the light in a turbid medium by random walks, as the truth that the solvers are held against.
//!
//! Nothing is taken on a lattice of directions and nothing is blended: photons fly straight through the sites, meet
//! leaf or wood where their free path ends, and leave in a direction drawn from the phase function. What a site's
//! fluence lacks of the truth is noise, and the noise is reported.
//!
//! * Fluence is the integral of radiance over all directions, averaged over the volume of a site; a unit beam in empty
//!   space has fluence 1 (lighting model, section 9).
//! * The beam before its first collision is no matter of chance: its mean in every site is integrated along parallel
//!   rays ([`uncollided`], [`uncollided_sky`]).
//! * First collisions are drawn from that beam alone, so that no photon passes the plant unused, on points that fill
//!   the lit sides evenly (a shifted Halton sequence). The walks then score the length of each flight in every site
//!   that it crosses.
//! * Weights carry the albedo; Russian roulette ends faint walks without bias.
//!
//! A standard error comes from the spread over [`BATCHES`] batches, each with a stream and a shift of its own. Batches
//! are summed in their order: the bytes do not depend on the number of threads.

mod beam;
mod check;
mod compare;
mod draw;
mod error;
pub mod judge;
mod scatter;
mod sites;
mod source;
mod walk;

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_format::progress::Progress;
use rayon::prelude::*;

use crate::turbid::{BandScatter, TurbidMedium};

pub use beam::{uncollided, uncollided_sky};
pub use compare::{ComparedLight, Difference, compare};
pub use error::MonteCarloError;

/// Batches of photons that a standard error is taken over.
pub const BATCHES: usize = 32;

/// Light source outside the plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Illumination {
    /// A beam of fluence 1; the unit vector TOWARDS the sun, model space.
    Sun([f64; 3]),
    /// Even sky: the same radiance from every direction, below the plant too; fluence 1 in empty space.
    Sky,
}

/// Method by which flights are drawn. Both give the same light; the second is the plainer code, and the noisier.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tracking {
    /// Exact free paths from site to site; every site crossed scores the length of the flight in it.
    #[default]
    Regular,
    /// Woodcock's: free paths in a medium as dense as the densest site, and most collisions are none. Every tentative
    /// collision scores.
    Delta,
}

/// Amount of work, and the method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Points of the lit side from which light starts; rounded up to a multiple of [`BATCHES`]. Those whose ray meets
    /// no matter count, too.
    pub photons: u64,
    /// Seed of the random numbers; each seed gives an independent estimate.
    pub seed: u64,
    /// Method by which flights are drawn.
    pub tracking: Tracking,
    /// Parallel rays per edge of a site for the uncollided beam.
    pub rays_per_site_edge: u32,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { photons: 1 << 20, seed: 0, tracking: Tracking::Regular, rays_per_site_edge: 8 }
    }
}

/// Fluence at the sites that hold matter, in the order of [`TurbidMedium::sites`]; means over the volume of each.
#[derive(Debug, Clone, PartialEq)]
pub struct Fluence {
    /// Light that has met nothing yet.
    pub uncollided: Vec<f64>,
    /// Light that was scattered, once or more often.
    pub scattered: Vec<f64>,
    /// Standard error of each `scattered`.
    pub error: Vec<f64>,
    /// Standard error of the mean of `scattered` over the sites.
    pub mean_error: f64,
    /// Energy balance of the photons.
    pub balance: Balance,
}

impl Fluence {
    /// Uncollided and scattered light together.
    pub fn total(&self) -> Vec<f64> {
        self.uncollided.iter().zip(&self.scattered).map(|(a, b)| a + b).collect()
    }
}

/// Power, in m^2: relative to the irradiance of the beam (of the sky: to its fluence).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Balance {
    /// Light that met matter at all.
    pub intercepted: f64,
    /// Intercepted light that matter absorbed.
    pub absorbed: f64,
    /// Light that escaped, by the side of the plant's bounding box: -x, +x, -y, +y, -z, +z.
    pub escaped: [f64; 6],
    /// Standard error of the whole of `escaped`.
    pub escaped_error: f64,
}

/// The fluence of one band. `progress` hears the share of the work that is done, from any thread.
pub fn trace(
    medium: &TurbidMedium,
    scatter: &BandScatter,
    light: Illumination,
    settings: &Settings,
    progress: &Progress<'_>,
) -> Result<Fluence, MonteCarloError> {
    trace_with(medium, scatter, None, light, settings, progress)
}

/// Traces the fluence of one band with albedos of the sites in place of those of the matter, `[site][leaf, wood]` in
/// the order of [`TurbidMedium::sites`].
///
/// # Errors
/// As of [`trace`]; another number of albedos than of sites, or one outside of 0..=1.
pub fn trace_with(
    medium: &TurbidMedium,
    scatter: &BandScatter,
    albedos: Option<&[[f32; 2]]>,
    light: Illumination,
    settings: &Settings,
    progress: &Progress<'_>,
) -> Result<Fluence, MonteCarloError> {
    check::medium(medium)?;
    check::scatter(scatter)?;
    check::albedos(albedos, medium)?;
    check::settings(settings)?;
    let uncollided = match light {
        Illumination::Sun(toward) => uncollided(medium, toward, settings.rays_per_site_edge)?,
        Illumination::Sky => uncollided_sky(medium, settings.rays_per_site_edge)?,
    };
    let walls = [false; 3];
    let sites = sites::Sites::new(medium, walls);
    let walked = walk::scattered(&sites, &medium.angles, scatter, albedos, light, settings, progress)?;
    let walk::Walked { scattered, error, mean_error, mut balance } = walked;
    let square_m = medium.grid.spacing_m * medium.grid.spacing_m;
    balance.scale(square_m);
    Ok(Fluence { uncollided, scattered, error, mean_error, balance })
}

impl Balance {
    fn scale(&mut self, factor: f64) {
        self.intercepted *= factor;
        self.absorbed *= factor;
        self.escaped.iter_mut().for_each(|side| *side *= factor);
        self.escaped_error *= factor;
    }
}

/// Runs the parts `0..parts` on all threads and merges what they return in their order. At most two results per thread
/// wait at a time. The first error ends all.
fn in_order<T: Send>(
    parts: usize,
    progress: &Progress<'_>,
    run: impl Fn(usize) -> Result<T, MonteCarloError> + Sync,
    mut merge: impl FnMut(T),
) -> Result<(), MonteCarloError> {
    let finished = AtomicUsize::new(0);
    let wave = 2 * rayon::current_num_threads();
    for start in (0..parts).step_by(wave) {
        let report = |part| {
            let result = run(part)?;
            progress((finished.fetch_add(1, Ordering::Relaxed) + 1) as f64 / parts as f64)?;
            Ok(result)
        };
        let results = (start..parts.min(start + wave)).into_par_iter().map(report);
        results.collect::<Result<Vec<T>, MonteCarloError>>()?.into_iter().for_each(&mut merge);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
