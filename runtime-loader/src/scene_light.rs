//! A library of scene light: what the plants of a scene leave of each other's light, and what they add to it.
//!
//! ```text
//! Library -load-> SceneLight -prepare-> PreparedSceneLight -at_sun(sun, where plants stand)-> SceneLightAtSun
//!     -at(instance, point)-> Modulations
//! ```
//!
//! The library holds light twice, on sites as coarse: that of the whole scene, S, and that of each species alone, A
//! ([`flb_format::scene_light`]). At a point of an instance both are sampled. Where S is below A, neighbours take light
//! away, and what they leave is the share S / A of what the species' own fine fields say. Where S is above A, they or
//! the ground bring light, and S - A is added to it: a quotient would multiply leaves that are dark, and that light
//! does not come through them. The sun's light and the sky's are compared apart. Both rules say the same where S is A,
//! so the result is continuous.
//!
//! A sun costs an evaluation of the fields at every site; a point then costs four samples of plain volumes, whatever
//! the fields are. The species alone is lit from another side for every turn of an instance: up to [`TURNS`] instances
//! of a species have volumes of their own; more, if they stand upright, share those of [`TURNS`] turns, and lie between
//! two; more than [`TILTS`] that are tilted share those of directions, and lie between three. So the number of volumes
//! does not grow with the forest.

mod at_sun;
pub mod export;
mod octahedron;
#[cfg(test)]
pub(crate) mod tests;
mod volume;

use std::sync::Arc;

use flb_format::FormatError;
use flb_format::beam::{BEAM_RAYS, MAX_MEANS, Near};
use flb_format::light::FieldKind;
pub use flb_format::scene_light::SceneFactor;
use flb_format::scene_light::{GROUND_DENSITY, PLANT, Role};

use crate::file_light::FileLight;
use crate::sun_terms::SunTerms;
use crate::{Library, RuntimeError};
pub use at_sun::{Modulation, Modulations, SceneLightAtSun, TILTS, TURNS};
use volume::Volume;

/// Light of a whole scene and of its species alone, in luminance.
pub struct SceneLight {
    digest: String,
    factor: SceneFactor,
    scene: Coarse,
    alone: Vec<(String, Coarse)>,
}

/// An entry of the library.
struct Coarse {
    light: FileLight,
    /// Whether the fields lack the sun's beam, which is added where the light is compared with an empty scene's.
    is_scattered: bool,
    /// Light of a sky of strength 1 where nothing stands.
    open_sky: f32,
    /// Sites with matter, the ground's left out.
    sites: Vec<u32>,
    sky: Volume,
    /// [`PLANT`]
    plant: Option<String>,
}

/// Scene light with what all suns share.
pub struct PreparedSceneLight<'l> {
    light: &'l SceneLight,
    /// `[species of the scene]`: its number here; `None`: others change nothing of its light.
    species: Arc<[Option<usize>]>,
    scene: Option<Near<'l>>,
    /// Per species alone.
    alone: Vec<Option<Near<'l>>>,
}

impl SceneLight {
    /// Reads, verifies and keeps all of a library of scene light.
    ///
    /// # Errors
    /// [`RuntimeError::NoSceneLight`] for an ordinary library; [`RuntimeError::Format`] for a page that fails its
    /// checks.
    pub fn load(library: &Library) -> Result<SceneLight, RuntimeError> {
        let (mut scene, mut alone) = (None, Vec::new());
        for (index, entry) in library.container().species().iter().enumerate() {
            match Role::of(&entry.meta) {
                Some(Role::Scene { digest }) => scene = Some((digest, Coarse::load(library, index)?)),
                Some(Role::Alone { species }) => alone.push((species, Coarse::load(library, index)?)),
                None => {
                    let found = format!("species {:?}, which is an ordinary one", entry.meta.name);
                    return Err(no_scene_light(library, found));
                }
            }
        }
        match scene {
            Some((digest, scene)) => Ok(SceneLight { digest, factor: SceneFactor::Alone, scene, alone }),
            None => Err(no_scene_light(library, "no entry of a scene".to_owned())),
        }
    }

    /// Returns the light, compared with something else than each plant alone.
    ///
    /// # Errors
    /// [`RuntimeError::SceneFactor`] for an empty scene where the fields lack the sun's beam and cannot add it: those
    /// of lists of suns.
    pub fn compared_with(self, factor: SceneFactor) -> Result<SceneLight, RuntimeError> {
        let lacks_beam = self.scene.is_scattered && !self.scene.light.light().suns().has_near_beam();
        match factor == SceneFactor::Empty && lacks_beam {
            true => Err(RuntimeError::SceneFactor),
            false => Ok(SceneLight { factor, ..self }),
        }
    }

    /// The digest of the plants and the ground that it was baked for.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// The number of a species by its name in the scene.
    pub fn find_species(&self, name: &str) -> Option<usize> {
        self.alone.iter().position(|(species, _)| species == name)
    }

    /// The digest of the plant that a species' light was solved for, where the file tells it.
    ///
    /// # Panics
    /// If there is no such species.
    pub fn plant_digest(&self, species: usize) -> Option<&str> {
        self.alone[species].1.plant.as_deref()
    }

    /// Memory that it takes.
    pub fn size_bytes(&self) -> usize {
        let of = |coarse: &Coarse| {
            coarse.light.light().size_bytes() + coarse.sky.size_bytes() + size_of_val(&coarse.sites[..])
        };
        of(&self.scene) + self.alone.iter().map(|(_, coarse)| of(coarse)).sum::<usize>()
    }

    /// Prepares what all suns share, for plants of species by their names in the scene, whose numbers are their places
    /// in the list. Others change nothing of the light of a species that the library does not know. Keep it while the
    /// sun moves.
    pub fn prepare<'n>(&self, species: impl IntoIterator<Item = &'n str>) -> PreparedSceneLight<'_> {
        PreparedSceneLight {
            light: self,
            species: species.into_iter().map(|name| self.find_species(name)).collect(),
            scene: self.scene.light.light().near_sums(),
            // An empty scene's light needs none of them.
            alone: match self.factor {
                SceneFactor::Alone => {
                    self.alone.iter().map(|(_, coarse)| coarse.light.light().near_sums()).collect()
                }
                SceneFactor::Empty => Vec::new(),
            },
        }
    }
}

impl Coarse {
    fn load(library: &Library, index: usize) -> Result<Coarse, RuntimeError> {
        let light = FileLight::load_whole(library, index)?;
        let (meta, species) = (&library.container().species()[index].meta, light.light());
        let name = &meta.name;
        let plant = meta.settings.get(PLANT).and_then(|digest| digest.as_str()).map(str::to_owned);
        let is_scattered = meta.physical().is_some_and(|(_, light)| light.field == FieldKind::Scattered);
        if species.bands() != 1 {
            let found = format!("species {name:?} of {} bands, which has to have one", species.bands());
            return Err(no_scene_light(library, found));
        }
        if species.item(0).is_none() {
            let found = format!("species {name:?} without base 0, the sky's");
            return Err(no_scene_light(library, found));
        }
        let medium =
            library.container().read_medium(library.source(), index).map_err(|source: FormatError| {
                RuntimeError::Format { path: library.path().to_owned(), source: Box::new(source) }
            })?;
        let is_plants = |density: &f32| *density > 0.0 && *density != GROUND_DENSITY;
        let matter = (0..).zip(&medium.density).filter(|(_, density)| is_plants(density));
        let sites: Vec<u32> = matter.map(|(site, _)| site).collect();
        let terms = species.terms([0.0; 3], 0.0, 1.0);
        let sky = Volume::of(species.grid(), &sites, |point| {
            let mut sky = [0.0];
            species.light(&terms, Default::default(), point, &mut sky);
            sky[0]
        });
        Ok(Coarse { light, is_scattered, open_sky: meta.model.open_sky(), sites, sky, plant })
    }

    /// Light of a sun in the entry's own frame, `with_beam` the sun's own beam where the fields lack it.
    fn under(
        &self,
        near: Option<&Near>,
        towards_sun: [f64; 3],
        with_beam: bool,
    ) -> Result<Volume, RuntimeError> {
        self.light.check(Some(towards_sun), false)?;
        let species = self.light.light();
        let of_sun = SunTerms::of(species.species_suns(), towards_sun);
        let prepared = near
            .zip(species.sites())
            .zip(of_sun)
            .map(|((near, sites), of_sun)| (sites, sites.prepare(species.suns(), near, of_sun, BEAM_RAYS)));
        let terms = species.terms_by(of_sun, 1.0, 0.0);
        Ok(Volume::of(species.grid(), &self.sites, |point| {
            let means = match &prepared {
                Some((sites, sun)) => sites.near_at(sun, species.needs_single(), point),
                None => [0.0; MAX_MEANS],
            };
            let mut light = [0.0];
            species.light(&terms, means, point, &mut light);
            if with_beam && self.is_scattered { light[0] + means[0] } else { light[0] }
        }))
    }
}

fn no_scene_light(library: &Library, found: String) -> RuntimeError {
    RuntimeError::NoSceneLight { path: library.path().to_owned(), found }
}
