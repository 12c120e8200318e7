//! A species of a file, whole, on a GPU, and the terms of its instances.
//!
//! ```text
//! Library -load-> GpuSpecies -terms(sun, sky)-> Term -> GpuLight::set_terms
//! ```

use flb_format::FormatError;

use super::{GpuError, GpuLight, GpuSpeciesId, SkyOnGpu, Term};
use crate::entry::known_species;
use crate::extinction::Extinction;
use crate::sun_terms::{SpeciesSuns, SunTerms};
use crate::{Library, RuntimeError};

/// All light of a species that was sent to a [`GpuLight`].
pub struct GpuSpecies {
    number: GpuSpeciesId,
    suns: SpeciesSuns,
    is_bounded: bool,
    /// `[base]`: its index for terms.
    indices: Vec<Option<u32>>,
}

impl GpuSpecies {
    /// Reads all bases of a species, which are coded as `classed` or `haar`, and the extinction where its suns need a
    /// near beam, and sends them.
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`]; [`RuntimeError::Format`] for a page that fails its checks, and for bases of
    /// another codec; [`RuntimeError::Gpu`] where there is no room.
    pub fn load(light: &mut GpuLight, library: &Library, species: usize) -> Result<GpuSpecies, RuntimeError> {
        let (container, source) = (library.container(), library.source());
        let at_file = |source: FormatError| RuntimeError::Format {
            path: library.path().to_owned(),
            source: Box::new(source),
        };
        let entry = known_species(library, species)?;
        let shared = container.read_shared(source, species).map_err(at_file)?;
        let number = light.add_species(&entry.meta.grid, &shared)?;
        let mut indices = vec![None; 256];
        for base in entry.bases.iter().map(|base| base.base) {
            let coded = container.read_coded_base(source, species, base, &shared).map_err(at_file)?;
            indices[usize::from(base)] = Some(light.set_base(number, base, &coded)?);
        }
        let model = &entry.meta.model;
        let (suns, is_bounded) = (SpeciesSuns::of(model), model.is_bounded());
        if suns.basis().has_near_beam() {
            let turbid = container.read_turbid(source, species).map_err(at_file)?;
            light.set_extinction(number, &Extinction::of(&turbid), suns.basis().needs_single())?;
        }
        Ok(GpuSpecies { number, suns, is_bounded, indices })
    }

    /// Number of the species for `flb_sample` and `flb_near`.
    pub fn number(&self) -> GpuSpeciesId {
        self.number
    }

    /// Whether light of the species is cut off at 0 in a shader: it is never below.
    pub fn is_bounded(&self) -> bool {
        self.is_bounded
    }

    /// The terms of an uneven sky over a plant, for `flb_sky`: [`GpuLight::set_sky_beams`] sent its beams.
    ///
    /// # Errors
    /// [`GpuError::NoBase`] for one that the file does not have.
    pub fn sky_terms(&self, sky: &SkyOnGpu) -> Result<Vec<Term>, GpuError> {
        let index = |base: u8| self.indices[usize::from(base)];
        sky.terms(index).map_err(|base| GpuError::NoBase { species: self.number, base })
    }

    /// Adds the terms of an even sky, if it sends any light, and then those of a sun (model's frame, any length; one
    /// without a direction sends nothing), and tells how many of the last are of the near beam, for `flb_sample_near`.
    ///
    /// # Errors
    /// [`GpuError::NoBase`] for one that the file does not have.
    pub fn terms(
        &self,
        towards_sun: [f64; 3],
        sun: f32,
        sky: f32,
        terms: &mut Vec<Term>,
    ) -> Result<u32, GpuError> {
        let mut push = |base: u8, factor: f32| {
            let no_base = GpuError::NoBase { species: self.number, base };
            let base = self.indices[usize::from(base)].ok_or(no_base)?;
            terms.push(Term { base, factor });
            Ok::<(), GpuError>(())
        };
        if sky != 0.0 {
            push(0, sky)?;
        }
        if sun == 0.0 {
            return Ok(0);
        }
        let Some(of_sun) = SunTerms::of(&self.suns, towards_sun) else { return Ok(0) };
        of_sun.bases().try_for_each(|(base, factor)| push(base, sun * factor))?;
        of_sun.near_bases().try_for_each(|base| push(base, sun * of_sun.near_factor()))?;
        Ok(of_sun.near_bases().len() as u32)
    }
}
