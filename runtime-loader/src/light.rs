//! Light at points of plants, of either model, from a file or from what a streamer has loaded.
//!
//! ```text
//! Library, Streamer -> SpeciesLight -lit_by(daylight, transform)-> InstanceLight -at(point)-> light per band
//!                                                                      └─cursor()-> LightCursor -at(point)->
//! ```
//!
//! A renderer keeps one [`SpeciesLight`] for each species, makes one [`InstanceLight`] for each plant when the sun
//! moves, and asks it for each shaded point, from any number of threads. A point lies in the frame of the model. A
//! renderer in which the scene has many plants gives each its neighbours' shade, too
//! ([`InstanceLight::with_neighbours`]).
//!
//! # Wind, skinning and levels of detail
//!
//! Ask at the point where the surface is **at rest**: before wind, bones or morphs move it, as the mesh that was baked
//! has it. A vertex shader hands that position on beside the moved one. A leaf then keeps its own light while it sways,
//! and no lattice has to follow it. The light is a field in space and knows no triangles, so every level of detail of
//! the mesh may ask, and a billboard, too; where the same point is asked for, the light is the same to the bit.
//!
//! # How near points cost less
//!
//! [`InstanceLight::at`] reads what it needs from the coded blocks, for points in any order. [`LightCursor::at`] keeps
//! the blocks that it read, added up over all bases: where several points lie in a block, as neighbouring pixels do, a
//! point costs about what uncoded floats do. It adds up in another order, so its light differs from that of `at` by the
//! rounding of f32. [`LightCursors`] holds cursors for many plants and threads; `flb render` and `flb view` ask it.

pub(crate) mod cursor;
mod cursors;
pub(crate) mod instance;
mod rings;
mod sky;
mod volume;

use flb_format::beam::Near;
use flb_format::{Grid, Transform};

pub use cursors::LightCursors;
pub use flb_format::sky_part::SkyPart;
pub use instance::KeptLight;
pub use rings::{RING_STEP_DEG, SunRings};
#[cfg(feature = "gpu")]
pub(crate) use sky::{OTHER_ROWS, SkyRows};
pub use sky::{SkyBeams, SkyLight};
pub use volume::{FieldVolume, LightVolume, words as volume_words};

use crate::entry::known_species;
use crate::file_light::{FileLight, bases_for};
use crate::resident::{LightLevel, ResidentSpecies};
use crate::sun_terms::unit;
use crate::{Daylight, InstanceLight, Library, LightCursor, RuntimeError};

/// The light of one species, ready for any sun.
pub struct SpeciesLight<'r> {
    source: Source<'r>,
}

enum Source<'r> {
    File(Box<FileLight>),
    Streamed(&'r ResidentSpecies),
}

impl SpeciesLight<'static> {
    /// Reads, verifies and keeps all light of a species of a file.
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`]; [`RuntimeError::Format`] for a page that fails its checks.
    pub fn load(library: &Library, species: usize) -> Result<SpeciesLight<'static>, RuntimeError> {
        Ok(SpeciesLight::of_file(FileLight::load_whole(library, species)?))
    }

    /// Loads no more bases than these suns (directions in the model's frame, any length) and, if there is one, the sky
    /// need. A species of the model `paper` takes less memory then; one of `physical` is loaded whole.
    ///
    /// # Errors
    /// As [`SpeciesLight::load`]; [`RuntimeError::NoDirection`] for a sun that has none; for a basis of the model
    /// `paper` that is not in the file [`RuntimeError::LeftOut`] or [`RuntimeError::MissingBase`], before any page is
    /// read.
    pub fn load_for(
        library: &Library,
        species: usize,
        suns: impl IntoIterator<Item = [f64; 3]>,
        has_sky: bool,
    ) -> Result<SpeciesLight<'static>, RuntimeError> {
        if known_species(library, species)?.meta.optics().is_none() {
            return SpeciesLight::load(library, species);
        }
        Ok(SpeciesLight::of_file(FileLight::load(library, species, &bases_for(suns, has_sky)?)?))
    }

    fn of_file(file: FileLight) -> SpeciesLight<'static> {
        SpeciesLight { source: Source::File(Box::new(file)) }
    }
}

impl<'r> SpeciesLight<'r> {
    /// What is there of it.
    fn resident(&self) -> &ResidentSpecies {
        match &self.source {
            Source::File(file) => file.light(),
            Source::Streamed(species) => species,
        }
    }

    /// Returns the light that a streamer has loaded of a species; where a unit is missing, a coarser one answers, and
    /// the light is never black.
    pub fn streamed(species: &'r ResidentSpecies) -> SpeciesLight<'r> {
        SpeciesLight { source: Source::Streamed(species) }
    }

    /// Grid of the lattice in model space.
    pub fn grid(&self) -> &Grid {
        self.resident().grid()
    }

    /// Values per point.
    pub fn bands(&self) -> usize {
        self.resident().bands()
    }

    /// Refuses light of another number of bands than a renderer can show; once, so that no point has to be checked.
    ///
    /// # Errors
    /// [`RuntimeError::Bands`].
    pub fn check_bands(&self, expected: usize) -> Result<(), RuntimeError> {
        match self.bands() {
            found if found == expected => Ok(()),
            found => Err(RuntimeError::Bands { found, expected }),
        }
    }

    /// Whether the species has light of the sky; a file of lattice directions may have been made without. Streamed
    /// light always has some.
    pub fn has_sky(&self) -> bool {
        match &self.source {
            Source::File(file) => file.light().item(0).is_some(),
            Source::Streamed(_) => true,
        }
    }

    /// Memory that what was read from a file takes; 0 of a streamed species, whose memory is its streamer's.
    pub fn size_bytes(&self) -> usize {
        match &self.source {
            Source::File(file) => file.light().size_bytes(),
            Source::Streamed(_) => 0,
        }
    }

    /// The light of a plant that stands where `world_from_model` says. Nothing is read; what it costs is an evaluation
    /// of the sun's direction.
    ///
    /// # Errors
    /// [`RuntimeError::NoDirection`] for a sun whose direction is zero or not finite; [`RuntimeError::Daylight`] for a
    /// sun or a sky that is not finite; for a basis that the sun or the sky needs [`RuntimeError::NotLoaded`] if the
    /// file has it, else [`RuntimeError::LeftOut`] or [`RuntimeError::MissingBase`].
    pub fn lit_by(
        &self,
        daylight: &Daylight,
        world_from_model: &Transform,
    ) -> Result<InstanceLight<'_>, RuntimeError> {
        let towards_sun = world_from_model.model_from_world_direction(daylight.towards_sun);
        self.lit_by_in_model(&Daylight { towards_sun, ..*daylight })
    }

    /// Returns the light of a plant by a sun whose direction is given in the frame of the model.
    ///
    /// # Errors
    /// As [`SpeciesLight::lit_by`].
    pub fn lit_by_in_model(&self, daylight: &Daylight) -> Result<InstanceLight<'_>, RuntimeError> {
        for (what, found) in [("sun", daylight.sun), ("sky", daylight.sky)] {
            if !found.is_finite() {
                return Err(RuntimeError::Daylight { what, found });
            }
        }
        if daylight.sun != 0.0 && unit(daylight.towards_sun).is_none() {
            return Err(RuntimeError::NoDirection { found: daylight.towards_sun });
        }
        let light = InstanceLight::new(self.resident(), daylight);
        match &self.source {
            // Of a file nothing stands in for what is missing.
            Source::File(file) if light.level() < LightLevel::Averages => {
                let towards_sun = (daylight.sun != 0.0).then_some(daylight.towards_sun);
                file.check(towards_sun, daylight.sky != 0.0).map(|()| light)
            }
            Source::File(_) | Source::Streamed(_) => Ok(light),
        }
    }

    /// Light of one base by itself, by its place among those of the file, per band at a point of the model at rest,
    /// metres; 0 of one that is not loaded. A base is no light where suns are harmonics: values may be below 0.
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn base_at(&self, base: usize, point_m: [f32; 3], out: &mut [f32]) {
        let bands = self.bands();
        self.resident().base_at(base, point_m, &mut out[..bands]);
    }

    /// Returns light that was kept of a plant of this species ([`InstanceLight::keep`]), as long as
    /// [`ResidentSpecies::generation`] is what it was; `None` where the plant is to be lit anew. Neighbours and an
    /// uneven sky are to be added again. What was kept of another species is wrong light.
    pub fn lit_again(&self, kept: &KeptLight) -> Option<InstanceLight<'_>> {
        InstanceLight::of_kept(self.resident(), kept)
    }

    /// Sums that the near beams of all suns share, for [`InstanceLight::prepared_by`]: making them takes longer than a
    /// sun does. `None` where the light needs no near beam, and where streamed light has no extinction yet.
    pub fn near(&self) -> Option<Near<'_>> {
        self.resident().near_sums()
    }

    /// Sites that a sun is prepared for; 0 where the light needs no near beam.
    pub fn near_sites(&self) -> usize {
        let species = self.resident();
        if species.suns().has_near_beam() { species.matter_sites() } else { 0 }
    }

    /// The light of an uneven sky on a plant that stands where `world_from_model` says, for
    /// [`InstanceLight::with_sky`]. It is the same for all plants that are turned in the same way, and stays right
    /// while blocks come and go. It takes as long as some prepared suns ([`InstanceLight::prepared`]); for many plants
    /// there is [`SpeciesLight::sky_beams`].
    ///
    /// # Errors
    /// [`RuntimeError::UnevenSky`] for a species of the model `paper`, for streamed light of which a base or the
    /// extinction is not there, and for parts that are not the whole sphere; [`RuntimeError::Bands`] for other than
    /// three bands; where a file of lattice directions lacks one, as [`SpeciesLight::lit_by`].
    pub fn sky(
        &self,
        parts: &[SkyPart],
        world_from_model: &Transform,
    ) -> Result<SkyLight<'static>, RuntimeError> {
        let in_model = |part: &SkyPart| SkyPart {
            towards: world_from_model.model_from_world_direction(part.towards),
            ..*part
        };
        let parts: Vec<SkyPart> = parts.iter().map(in_model).collect();
        SkyLight::new(self, &parts)
    }

    /// Sums that the skies over many plants of the species share, however these are turned: a second or some, and then
    /// the sky of each plant costs next to nothing. Detail finer than harmonics of degree 3 have is lost, which
    /// [`SpeciesLight::sky`] keeps.
    ///
    /// # Errors
    /// As [`SpeciesLight::sky`].
    pub fn sky_beams(&self) -> Result<SkyBeams, RuntimeError> {
        SkyBeams::new(self)
    }

    /// Refuses a sun, and a sky where it counts, of which something is not there.
    fn check(&self, towards_sun: Option<[f64; 3]>, has_sky: bool) -> Result<(), RuntimeError> {
        match &self.source {
            Source::File(file) => file.check(towards_sun, has_sky),
            Source::Streamed(species) => {
                let [sun, sky] = [towards_sun.is_some(), has_sky].map(|counts| f32::from(u8::from(counts)));
                match species.terms(towards_sun.unwrap_or_default(), sun, sky).level {
                    LightLevel::Outside | LightLevel::Other => Err(NOT_THERE),
                    LightLevel::Averages | LightLevel::Whole => Ok(()),
                }
            }
        }
    }
}

/// Of streamed light.
const NOT_THERE: RuntimeError = RuntimeError::UnevenSky {
    found: "a species of which not all bases or not the extinction are loaded yet",
    expected: "all of them: ask again once `InstanceLight::level` is `Averages`",
};

#[cfg(test)]
mod tests;
