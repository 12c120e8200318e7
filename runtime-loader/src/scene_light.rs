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
use flb_format::beam::Near;
use flb_format::scene_light::{GROUND_DENSITY, PLANT, Role};

use crate::physical::PhysicalSampler;
use crate::{Library, RuntimeError};
pub use at_sun::{Modulation, Modulations, SceneLightAtSun, TILTS, TURNS};
use volume::Volume;

/// Light of a whole scene and of its species alone, in luminance.
pub struct SceneLight {
    digest: String,
    scene: Coarse,
    alone: Vec<(String, Coarse)>,
}

/// An entry of the library.
struct Coarse {
    sampler: PhysicalSampler,
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
            Some((digest, scene)) => Ok(SceneLight { digest, scene, alone }),
            None => Err(no_scene_light(library, "no entry of a scene".to_owned())),
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
            coarse.sampler.size_bytes() + coarse.sky.size_bytes() + size_of_val(&coarse.sites[..])
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
            scene: self.scene.near(),
            alone: self.alone.iter().map(|(_, coarse)| coarse.near()).collect(),
        }
    }
}

impl Coarse {
    fn load(library: &Library, index: usize) -> Result<Coarse, RuntimeError> {
        let sampler = PhysicalSampler::load(library, index)?;
        let meta = &library.container().species()[index].meta;
        let name = &meta.name;
        let plant = meta.settings.get(PLANT).and_then(|digest| digest.as_str()).map(str::to_owned);
        if sampler.bands() != 1 {
            let found = format!("species {name:?} of {} bands, which has to have one", sampler.bands());
            return Err(no_scene_light(library, found));
        }
        if !sampler.has_sky() {
            let found = format!("species {name:?} without base 0, the sky's");
            return Err(no_scene_light(library, found));
        }
        let medium =
            library.container().read_medium(library.source(), index).map_err(|source: FormatError| {
                RuntimeError::Format { path: library.path().to_owned(), source: Box::new(source) }
            })?;
        let is_ground = |site: &u32| medium.density[*site as usize] == GROUND_DENSITY;
        let sites: Vec<u32> = sampler.turbid().sites().into_iter().filter(|site| !is_ground(site)).collect();
        let sky = Volume::of(sampler.grid(), &sites, |point| {
            let mut light = [0.0];
            sampler.sky(point, &mut light);
            light[0]
        });
        Ok(Coarse { sampler, sites, sky, plant })
    }

    fn near(&self) -> Option<Near<'_>> {
        self.sampler.suns().has_near_beam().then(|| self.sampler.near())
    }

    /// Light of a sun in the entry's own frame.
    fn under(&self, near: Option<&Near>, towards_sun: [f64; 3]) -> Result<Volume, RuntimeError> {
        let terms = self.sampler.terms(towards_sun)?;
        let prepared = match near {
            Some(near) => self.sampler.prepare(near, terms, flb_format::beam::BEAM_RAYS),
            None => self.sampler.prepared_blend(terms),
        };
        Ok(Volume::of(self.sampler.grid(), &self.sites, |point| {
            let mut light = [0.0];
            self.sampler.fluence(&prepared, 1.0, 0.0, point, &mut light);
            light[0]
        }))
    }
}

fn no_scene_light(library: &Library, found: String) -> RuntimeError {
    RuntimeError::NoSceneLight { path: library.path().to_owned(), found }
}
