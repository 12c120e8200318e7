//! How far the light of the `physical` model is from the truth: a few suns are traced in the very same medium, each by
//! two seeds, and the fields are held against them as a renderer evaluates them. The gates (`benches/gates.rs`), `flb
//! bake --monte-carlo` and `flb trade` all ask here.

use flb_format::beam::{BEAM_RAYS, Near, NearBeam};
use flb_format::light::FieldKind;
use flb_format::progress::Progress;

use super::{
    ComparedLight, Difference, Fluence, Illumination, MonteCarloError, Settings, compare, trace_with,
};
use crate::ordinates::{OrdinatesSettings, OrdinatesSolution, SiteAlbedos};
use crate::turbid::{BandScatter, TurbidMedium};

/// Largest number of suns that [`suns`] gives.
pub const MAX_SUNS: usize = 22;

/// Photons per site that holds matter. Each scores in every site that it crosses, so that a site hears of hundreds, and
/// two seeds remove the rest of the noise.
const PHOTONS_PER_SITE: u64 = 4;

/// Fewest and most photons per sun.
const PHOTONS: [u64; 2] = [1 << 16, 1 << 20];

/// The truth under one sun.
pub struct Truth {
    towards_sun: [f64; 3],
    /// `[band]`, of two seeds each.
    estimates: Vec<[Fluence; 2]>,
    /// For fields with the light scattered once, or without, or for both.
    near: Vec<NearBeam>,
}

/// The error of fields under several suns, relative to the mean total fluence over the non-empty sites, the noise of
/// the truth removed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judgement {
    /// Root mean square over the sites, the mean over the suns.
    pub rms: f64,
    /// Standard error of `rms`.
    pub rms_error: f64,
    /// Root mean square over the sites under the worst sun.
    pub worst: f64,
    /// Mean; above 0 where the fields are too bright.
    pub bias: f64,
    /// Standard error of `bias`.
    pub bias_error: f64,
    /// Number of suns.
    pub suns: usize,
}

/// Returns the first `count` suns to judge by, unit vectors towards them: along an axis, along a diagonal, and spread
/// over the sphere by a fixed sequence (Roberts's, the plastic number's powers).
///
/// # Panics
/// If there are more than [`MAX_SUNS`].
pub fn suns(count: usize) -> Vec<[f64; 3]> {
    assert!(count <= MAX_SUNS, "{count} suns, expected up to {MAX_SUNS}");
    let diagonal = std::f64::consts::FRAC_1_SQRT_2;
    let spread = (0..MAX_SUNS - 2).map(|i| {
        let part = |step: f64| (0.5 + step * i as f64).fract();
        let y = 2.0 * part(0.754_877_666) - 1.0;
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * part(0.569_840_291));
        let across = (1.0 - y * y).sqrt();
        [across * cos, y, across * sin]
    });
    [[0.0, 1.0, 0.0], [diagonal, diagonal, 0.0]].into_iter().chain(spread).take(count).collect()
}

/// Photons per sun and seed that tell the error of a plant of so many non-empty sites.
pub fn photons(sites: usize) -> u64 {
    (sites as u64 * PHOTONS_PER_SITE).next_power_of_two().clamp(PHOTONS[0], PHOTONS[1])
}

impl Truth {
    /// Traces a sun in every band with two seeds. `near` are those of the medium's non-empty sites, of the kinds that
    /// the fields to be judged need; `albedos`, one list for each band, are those that the fields were solved with.
    ///
    /// # Errors
    /// As of [`trace_with`].
    pub fn trace(
        medium: &TurbidMedium,
        near: &[Near],
        bands: &[BandScatter],
        albedos: Option<&[SiteAlbedos]>,
        towards_sun: [f64; 3],
        photons: u64,
        progress: &Progress<'_>,
    ) -> Result<Truth, MonteCarloError> {
        let runs = 2.0 * bands.len() as f64;
        let of_seed = |band: usize, seed: u64| {
            let settings = Settings { photons, seed, rays_per_site_edge: BEAM_RAYS, ..Settings::default() };
            let part = |share: f64| progress(((2 * band) as f64 + (seed - 1) as f64 + share) / runs);
            let albedos = albedos.map(|albedos| albedos[band].as_slice());
            trace_with(medium, &bands[band], albedos, Illumination::Sun(towards_sun), &settings, &part)
        };
        let of_band = |band: usize| Ok::<_, MonteCarloError>([of_seed(band, 1)?, of_seed(band, 2)?]);
        let estimates = (0..bands.len()).map(of_band).collect::<Result<_, _>>()?;
        let near = near.iter().map(|near| near.beam(towards_sun, BEAM_RAYS)).collect();
        Ok(Truth { towards_sun, estimates, near })
    }

    /// Compares the solution's band at the non-empty `sites`, in total fluence.
    ///
    /// # Errors
    /// As of [`compare`].
    ///
    /// # Panics
    /// As [`OrdinatesSolution::light`], if the band was not traced, and if no near beam is of the kind that the fields
    /// need.
    pub fn difference(
        &self,
        solution: &OrdinatesSolution,
        settings: &OrdinatesSettings,
        band: u32,
        sites: &[u32],
    ) -> Result<Difference, MonteCarloError> {
        let wanted = settings.suns.needs_single();
        let near = self.near.iter().find(|near| near.single == wanted).expect("near beams are of this kind");
        let light = solution.light(&settings.suns, band, sites, self.towards_sun, near);
        let [a, b] = &self.estimates[band as usize];
        let beam = |site: usize| match settings.field {
            FieldKind::Scattered => a.uncollided[site],
            FieldKind::Total => 0.0,
        };
        let total: Vec<f64> =
            light.iter().enumerate().map(|(i, light)| f64::from(*light) + beam(i)).collect();
        compare(&total, [a, b], ComparedLight::Total)
    }
}

impl Judgement {
    /// Averages the differences under several suns; `None` without any.
    pub fn over(differences: &[Difference]) -> Option<Judgement> {
        let suns = differences.len();
        let mean = |of: fn(&Difference) -> f64| differences.iter().map(of).sum::<f64>() / suns as f64;
        let error_of_mean = |of: fn(&Difference) -> f64| {
            differences.iter().map(|d| of(d) * of(d)).sum::<f64>().sqrt() / suns as f64
        };
        (suns > 0).then(|| Judgement {
            rms: mean(|d| d.rms),
            rms_error: error_of_mean(|d| d.rms_error),
            worst: differences.iter().map(|d| d.rms).fold(0.0, f64::max),
            bias: mean(|d| d.bias),
            bias_error: error_of_mean(|d| d.bias_error),
            suns,
        })
    }
}
