//! The bases of one species of the model `paper`, sampled at points of model space.

use flb_format::Grid;
use flb_format::sun::SunBlend;

use crate::entry::{known_species, other_model};
use crate::resident::ResidentSpecies;
use crate::{Library, RuntimeError};

/// One species, ready to be sampled from any number of threads. Everything is read and verified at loading; sampling
/// does no input, takes no lock and cannot fail.
pub struct SpeciesSampler {
    light: ResidentSpecies,
}

/// The bases that [`SpeciesSampler::indirect`] will ask for, each once, ascending: those of the blend that
/// have weight, and base 0 if there is ambient light.
pub fn bases_needed(blend: &SunBlend, ambient: bool) -> Vec<u8> {
    let sun =
        blend.bases.iter().zip(blend.weights).filter(|(_, weight)| *weight != 0.0).map(|(base, _)| *base);
    let mut bases: Vec<u8> = ambient.then_some(0).into_iter().chain(sun).collect();
    bases.sort_unstable();
    bases.dedup();
    bases
}

impl SpeciesSampler {
    /// Reads, verifies and keeps the given bases of a species of the model `paper` (repeats are ignored).
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`]; [`RuntimeError::OtherModel`]; for the first base that the file does not hold
    /// (before any page is read) [`RuntimeError::LeftOut`] if the file says so, else [`RuntimeError::MissingBase`];
    /// [`RuntimeError::Format`] for a page that fails its checks.
    pub fn load(library: &Library, species: usize, bases: &[u8]) -> Result<SpeciesSampler, RuntimeError> {
        let entry = known_species(library, species)?;
        if entry.meta.optics().is_none() {
            return Err(other_model(library, entry, "paper"));
        }
        Ok(SpeciesSampler { light: ResidentSpecies::load(library, species, bases)? })
    }

    /// Grid of the lattice in model space.
    pub fn grid(&self) -> &Grid {
        self.light.grid()
    }

    /// Values per sample.
    pub fn bands(&self) -> usize {
        self.light.bands()
    }

    /// Whether a base was loaded.
    pub fn has_base(&self, base: u8) -> bool {
        self.light.item(base).is_some()
    }

    /// Memory that the loaded bases take.
    pub fn size_bytes(&self) -> usize {
        self.light.size_bytes()
    }

    /// phi of one base at a point of model space, trilinear, one value per band. Points outside the lattice
    /// take the value of the nearest point of it; a coordinate that is NaN counts as the lower end.
    ///
    /// # Panics
    /// If the base was not loaded or `out` is shorter than the bands.
    pub fn sample(&self, base: u8, point_model_m: [f32; 3], out: &mut [f32]) {
        self.sum(&[(base, 1.0)], point_model_m, out);
    }

    /// `sun * sum_k w_k B_k + ambient * B_0` at a point of model space (lighting model, section 6), one value
    /// per band. Bases whose factor is 0 are neither needed nor touched: [`bases_needed`].
    ///
    /// # Panics
    /// If a base with a factor other than 0 was not loaded, or `out` is shorter than the bands.
    pub fn indirect(
        &self,
        blend: &SunBlend,
        sun: f32,
        ambient: f32,
        point_model_m: [f32; 3],
        out: &mut [f32],
    ) {
        let [a, b, c] = blend.bases;
        let [of_a, of_b, of_c] = blend.weights.map(|weight| sun * weight);
        self.sum(&[(a, of_a), (b, of_b), (c, of_c), (0, ambient)], point_model_m, out);
    }

    fn sum(&self, terms: &[(u8, f32)], point_model_m: [f32; 3], out: &mut [f32]) {
        let out = &mut out[..self.bands()];
        out.fill(0.0);
        let mut at = self.light.point(point_model_m);
        for &(base, factor) in terms.iter().filter(|(_, factor)| *factor != 0.0) {
            let Some(light) = self.light.item(base) else { panic!("base {base} was not loaded") };
            at.add(light, factor, out);
        }
    }
}

#[cfg(test)]
mod tests;
