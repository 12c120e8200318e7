//! The light of a file as a renderer samples it, at points of the plant's surface; and how far two files' lights are
//! apart.

use std::sync::Arc;

use flb_runtime::samplers::PreparedSun;
use flb_runtime::{Daylight, InstanceLight, Library, SpeciesLight};
use rayon::prelude::*;
use serde::Serialize;

use super::on_mesh::{MeshRow, OnMesh};
use crate::EvalError;

/// `[sun][point][band]`
pub(super) type Light = Vec<f32>;

/// Near beams of the suns in one medium, of fields without and with the light scattered once: files of the same medium
/// share them.
pub(super) type Prepared = [Option<Vec<Arc<PreparedSun>>>; 2];

/// Samples of the finest file.
pub(super) struct Finest {
    pub scattered: Light,
    /// The sun's beam, `[sun][point]`.
    pub beam: Vec<f32>,
    pub bands: usize,
}

/// The distance from the finest light.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Distance {
    /// Rms over suns, points and bands, in % of the mean total fluence.
    pub percent: f64,
    /// Rms over suns and points of each band, in % of its own mean.
    pub bands: Vec<f64>,
}

/// The light of a file at points, and how far it is off on the mesh, or why that is not known.
pub(super) struct Sampled {
    pub light: Light,
    pub on_mesh: Result<MeshRow, String>,
}

/// Samples the only species of a library under every sun, without the sky, where a renderer asks for it.
pub(super) fn light(
    library: &Library,
    suns: &[[f64; 3]],
    on_mesh: &OnMesh,
    prepared: &mut Prepared,
) -> Result<Sampled, EvalError> {
    let meta = &library.container().species()[0].meta;
    let points = on_mesh.asked(meta);
    let species = SpeciesLight::load_for(library, 0, suns.iter().copied(), false)?;
    let bands = species.bands();
    let mut light = vec![0.0; suns.len() * points.len() * bands];
    let of_suns = light.chunks_exact_mut(points.len() * bands);
    let suns = under(&species, library, suns, prepared)?;
    for (sun, out) in suns.iter().zip(of_suns) {
        points.iter().zip(out.chunks_exact_mut(bands)).for_each(|(point, out)| sun.at(*point, out));
    }
    let on_mesh = on_mesh.error(meta, &species, &suns)?;
    Ok(Sampled { light, on_mesh })
}

/// The sun's beam at the points, from the same file: what its near beam is over the site itself. `[sun][point]`
pub(super) fn beam(
    library: &Library,
    suns: &[[f64; 3]],
    on_mesh: &OnMesh,
    prepared: &mut Prepared,
) -> Result<Vec<f32>, EvalError> {
    let points = on_mesh.asked(&library.container().species()[0].meta);
    let species = SpeciesLight::load(library, 0)?;
    let suns = under(&species, library, suns, prepared)?;
    let each = suns.iter().flat_map(|sun| points.iter().map(move |point| sun.beam_at(*point)));
    each.map(|beam| beam.ok_or(EvalError::NoNearBeam)).collect()
}

/// The light of each sun. Near beams are of the medium alone, so another file's are taken where there are any.
fn under<'a>(
    species: &'a SpeciesLight,
    library: &Library,
    suns: &[[f64; 3]],
    prepared: &mut Prepared,
) -> Result<Vec<InstanceLight<'a>>, EvalError> {
    let meta = &library.container().species()[0].meta;
    let needs_single = meta.model.suns().needs_single();
    let prepared = &mut prepared[usize::from(needs_single)];
    let near = if prepared.is_none() { species.near() } else { None };
    let one = |(at, sun): (usize, &[f64; 3])| {
        let light = species.lit_by_in_model(&Daylight { towards_sun: *sun, sun: 1.0, sky: 0.0 })?;
        Ok(match &*prepared {
            Some(suns) => light.prepared_as(&suns[at]),
            None => light.prepared_by(near.as_ref()),
        })
    };
    let lights = suns.par_iter().enumerate().map(one).collect::<Result<Vec<_>, EvalError>>()?;
    if prepared.is_none() {
        *prepared = lights.iter().map(|light| light.prepared_sun().cloned()).collect();
    }
    Ok(lights)
}

/// Mean fluence over points, suns and bands; that of the sun is 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct MeanFluence {
    /// Mean fluence without the sun's beam.
    pub scattered: f64,
    /// Mean fluence with the sun's beam.
    pub total: f64,
}

impl Finest {
    /// Of the light itself.
    pub(super) fn mean_fluence(&self) -> MeanFluence {
        let mean = |values: &[f32]| {
            values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len().max(1) as f64
        };
        let scattered = mean(&self.scattered);
        MeanFluence { scattered, total: scattered + mean(&self.beam) }
    }

    /// How far `light` is off; the beam counts where it holds the beam.
    pub(super) fn distance(&self, light: &Light, holds_beam: bool) -> Distance {
        let mut square = vec![0.0; self.bands];
        let mut total = vec![0.0; self.bands];
        let places = light.chunks_exact(self.bands).zip(self.scattered.chunks_exact(self.bands));
        for ((found, scattered), beam) in places.zip(&self.beam) {
            let beam = f64::from(*beam);
            for band in 0..self.bands {
                let scattered = f64::from(scattered[band]);
                let expected = if holds_beam { scattered + beam } else { scattered };
                let off = f64::from(found[band]) - expected;
                square[band] += off * off;
                total[band] += scattered + beam;
            }
        }
        let count = self.beam.len() as f64;
        let percent = |square: f64, total: f64, count: f64| match total > 0.0 {
            true => 100.0 * libm::sqrt(square / count) / (total / count),
            false => 0.0,
        };
        Distance {
            percent: percent(square.iter().sum(), total.iter().sum(), count * self.bands as f64),
            bands: square.iter().zip(&total).map(|(square, total)| percent(*square, *total, count)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finest() -> Finest {
        Finest { scattered: vec![0.1, 0.3, 0.1, 0.3], beam: vec![1.0, 0.6], bands: 2 }
    }

    #[test]
    fn the_finest_is_no_distance_from_itself() {
        let finest = finest();
        assert_eq!(finest.distance(&finest.scattered, false), Distance { percent: 0.0, bands: vec![0.0; 2] });
        let MeanFluence { scattered, total } = finest.mean_fluence();
        assert!((scattered - 0.2).abs() < 1e-6 && (total - 1.0).abs() < 1e-6);
    }

    #[test]
    fn light_that_holds_the_beam_is_compared_with_the_beam() {
        let finest = finest();
        let total = vec![1.1, 1.3, 0.7, 0.9];
        assert!(finest.distance(&total, true).percent < 1e-5);
        assert!(finest.distance(&total, false).percent > 50.0);
    }

    #[test]
    fn a_planted_error_is_found_in_its_band() {
        let finest = finest();
        // 0.1 off at both points in the second band, whose mean is 1.1; the mean of both bands is 1.
        let light = vec![0.1, 0.4, 0.1, 0.2];
        let Distance { percent, bands } = finest.distance(&light, false);
        assert_eq!(bands[0], 0.0);
        assert!((bands[1] - 10.0 / 1.1).abs() < 1e-4, "{bands:?}");
        assert!((percent - 10.0 * std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-4, "{percent}");
    }
}
