//! Light of a `physical` species at points of model space: stored fields and the near beam of the sun (SPEC.md, section
//! 10.4).
//!
//! ```text
//! PhysicalSampler + sun -prepare-> PreparedSun: the near beam of every non-empty site, sampled like a field
//! PhysicalSampler -> Marcher: the near beam of one point by marches through the extinction, for suns that are too many
//! ```
//!
//! Prepare for a sun that lights many points. For a forest, where every instance turns the sun another way, there are
//! rings of suns ([`crate::light::SunRings`]), or marches: nothing is kept per instance, but a sample costs `4 x
//! offsets` marches. Of the default bake of an oak at lattice 128 a sun is prepared in 0.1 s of one thread, after 0.7 s
//! of sums that all suns share; a prepared sample takes 6 us, a marched one of 4 offsets 30 to 50
//! (`cargo bench -p flb-tests --bench rings -- oak 80000 128`; other kinds of suns by `cargo bench -p flb-runtime
//! --bench physical`).
//!
//! Marches have grain, the less the more offsets: of the default bake of an oak at lattice 64, under suns alone, a
//! point is 122 % off with one offset, 56 % with 4 and 28 % with 16 (rms, of the mean), and the mean 0.5 % at most
//! (`cargo bench -p flb-tests --bench grain`). Species of lattice directions need no march and have none.

use std::path::PathBuf;
use std::sync::Arc;

use flb_format::Grid;
use flb_format::beam::{MAX_MEANS, Near};
use flb_format::container::Species;
use flb_format::light::{FieldKind, SunBasis};
use flb_format::matter::TurbidMedium;

use crate::entry::{known_species, no_base, other_model};
use crate::near_beam::{Marcher, MediumSites, PreparedSun};
use crate::resident::ResidentSpecies;
use crate::sun_terms::{SunTerms, near_bases};
use crate::{Library, RuntimeError};

/// A `physical` species with all its fields and its extinction, ready to be sampled from any number of threads.
pub struct PhysicalSampler {
    path: PathBuf,
    species: Species,
    light: ResidentSpecies,
    field: FieldKind,
    sites: Arc<MediumSites>,
}

impl PhysicalSampler {
    /// Reads, verifies and keeps every base of a species, and its extinction.
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`]; [`RuntimeError::OtherModel`]; [`RuntimeError::Format`] for a page that fails
    /// its checks.
    pub fn load(library: &Library, species: usize) -> Result<PhysicalSampler, RuntimeError> {
        let entry = known_species(library, species)?;
        let Some((_, light)) = entry.meta.physical() else {
            return Err(other_model(library, entry, "physical"));
        };
        let field = light.field;
        let bases: Vec<u8> = entry.bases.iter().map(|base| base.base).collect();
        let light = ResidentSpecies::load(library, species, &bases)?;
        let sites = Arc::clone(light.sites().expect("a species of the model physical has its extinction"));
        let (path, species) = (library.path().to_owned(), entry.clone());
        Ok(PhysicalSampler { path, species, light, field, sites })
    }

    /// Grid of the lattice in model space.
    pub fn grid(&self) -> &Grid {
        self.light.grid()
    }

    /// Values per sample.
    pub fn bands(&self) -> usize {
        self.light.bands()
    }

    /// Whether the sun's beam is part of the sun's light.
    pub fn field(&self) -> FieldKind {
        self.field
    }

    /// Dependence of the fields on the sun.
    pub fn suns(&self) -> &SunBasis {
        self.light.suns()
    }

    /// The extinction, in m^-1.
    pub fn turbid(&self) -> &TurbidMedium {
        self.sites.turbid()
    }

    /// Memory that fields, extinction and lists take.
    pub fn size_bytes(&self) -> usize {
        self.light.size_bytes()
    }

    /// Whether the species has light of the sky; a file of lattice directions may have been made without.
    pub fn has_sky(&self) -> bool {
        self.light.item(0).is_some()
    }

    /// Factors that a sun in direction `towards_sun` (model space, any length) gives each field.
    ///
    /// # Errors
    /// [`RuntimeError::NoDirection`] for a vector that is zero or not finite; where the species holds lattice
    /// directions and has not one that the sun needs, [`RuntimeError::LeftOut`] or [`RuntimeError::MissingBase`].
    pub fn terms(&self, towards_sun: [f64; 3]) -> Result<SunTerms, RuntimeError> {
        let no_direction = RuntimeError::NoDirection { found: towards_sun };
        let terms = SunTerms::of(self.light.species_suns(), towards_sun).ok_or(no_direction)?;
        match self.light.lacks(&terms) {
            Some(missing) => Err(no_base(&self.path, &self.species, missing)),
            None => Ok(terms),
        }
    }

    /// Maker of the near beams of suns: sums of the extinction over the cubes, and rays for light scattered once where
    /// the fields need it. Build it once for many suns.
    pub fn near(&self) -> Near<'_> {
        self.sites.near(self.suns().needs_single())
    }

    /// Finds the near beam at points, for any sun, without preparing one.
    pub fn marcher(&self) -> Marcher<'static> {
        Marcher::new(self.turbid(), self.suns().needs_single())
    }

    /// The near beam of a sun in every non-empty site; `rays` per site edge (2 do) find the beam. Nothing is computed
    /// for a species of directions.
    pub fn prepare(&self, near: &Near, terms: SunTerms, rays: u32) -> PreparedSun {
        self.sites.prepare(self.suns(), near, terms, rays)
    }

    /// Fluence per band at a point of model space: `sun` times the light of the prepared sun (scattered or total,
    /// [`PhysicalSampler::field`]) plus `sky` times that of the even sky, never below 0. Points outside the lattice
    /// take the value of the nearest point of it.
    ///
    /// # Panics
    /// If `out` is shorter than the bands, or `sky` is not 0 and the species has no base 0.
    pub fn fluence(
        &self,
        prepared: &PreparedSun,
        sun: f32,
        sky: f32,
        point_model_m: [f32; 3],
        out: &mut [f32],
    ) {
        let near = match self.suns().first_near_item() {
            Some(_) if sun != 0.0 => self.near_at(prepared, point_model_m),
            _ => [0.0; MAX_MEANS],
        };
        self.fluence_of(&prepared.terms, near, sun, sky, point_model_m, out);
    }

    /// Light per band as by [`PhysicalSampler::fluence`], with means of the near beam that the caller has found, as by
    /// [`Marcher::near`].
    ///
    /// # Panics
    /// As [`PhysicalSampler::fluence`].
    pub fn fluence_of(
        &self,
        terms: &SunTerms,
        near: [f32; MAX_MEANS],
        sun: f32,
        sky: f32,
        point_model_m: [f32; 3],
        out: &mut [f32],
    ) {
        let expected = near_bases(self.suns());
        assert_eq!(terms.near_bases(), expected, "terms of a species whose suns are stored in another way");
        let out = &mut out[..self.bands()];
        let terms = self.light.terms_by(Some(*terms), sun, sky);
        self.light.light(&terms, near, point_model_m, out);
    }

    /// Light of the even sky of fluence 1 alone, per band.
    ///
    /// # Panics
    /// If the species has no base 0, or `out` is shorter than the bands.
    pub fn sky(&self, point_model_m: [f32; 3], out: &mut [f32]) {
        let terms = self.light.terms([0.0; 3], 0.0, 1.0);
        assert!(self.has_sky(), "light of the sky");
        self.light.light(&terms, Default::default(), point_model_m, &mut out[..self.bands()]);
    }

    /// Means of the near beam at a point: over the non-empty of the eight sites, by their trilinear weights; where
    /// there are none, the beam at the point itself, and no light scattered once.
    ///
    /// # Panics
    /// If the species has no near beam, or the sun was prepared for another medium.
    pub fn near_at(&self, prepared: &PreparedSun, point_model_m: [f32; 3]) -> [f32; MAX_MEANS] {
        self.sites.near_at(prepared, self.suns().needs_single(), point_model_m)
    }
}

#[cfg(test)]
mod tests;
