//! What plants of a scene do to each other's light.

use flb_format::scene_light::digest_of_species;
use flb_format::{Daylight, Placement};
use flb_runtime::RuntimeError;
use flb_runtime::scene_light::{PreparedSceneLight, SceneLight, SceneLightAtSun};
use flb_scene::scene::{Scene, light_digest};

use crate::mesh_of_light::short;
use crate::plant::ScenePlant;
use crate::{Stage, StageError};

/// Refuses the light of another scene, or of other plants by the same names.
pub(crate) fn check(scene: &Scene, plants: &[ScenePlant], light: &SceneLight) -> Result<(), StageError> {
    let expected = light_digest(scene);
    if light.digest() != expected {
        let [found, expected] = [light.digest(), &expected].map(|digest| short(digest).to_owned());
        return Err(StageError::OtherScene { found, expected });
    }
    for (species, plant) in scene.species.iter().zip(plants) {
        let (Some(number), Some((library, index))) = (light.find_species(&species.name), plant.library())
        else {
            continue;
        };
        let at_library = |error| StageError::Format(Box::new(error)).at(library.path());
        let of_plant = digest_of_species(library.container(), library.source(), index).map_err(at_library)?;
        if Some(of_plant.as_str()) != light.plant_digest(number) {
            let (species, library) = (species.name.clone(), library.path().to_owned());
            return Err(StageError::OtherPlant { species, library });
        }
    }
    Ok(())
}

/// Scene light, where plants stand, and what it is under the sun of the last frame.
pub(crate) struct Neighbours<'s> {
    prepared: PreparedSceneLight<'s>,
    placements: &'s [Placement],
    /// Where the sun is, none at night.
    shade: Option<(Option<[f64; 3]>, SceneLightAtSun<'s>)>,
}

impl<'s> Neighbours<'s> {
    /// Of a stage that has scene light.
    pub(crate) fn of(stage: &'s Stage) -> Option<Neighbours<'s>> {
        let names = stage.scene.species.iter().map(|species| species.name.as_str());
        let prepared = stage.scene_light.as_ref()?.prepare(names);
        Some(Neighbours { prepared, placements: &stage.scene.instances, shade: None })
    }

    /// Whether [`Neighbours::turn`] has nothing to find for a daylight.
    pub(crate) fn is_at(&self, daylight: &Daylight) -> bool {
        self.shade.as_ref().is_some_and(|(known, _)| *known == sun(daylight))
    }

    /// Finds what plants do to each other's light, if the sun has moved.
    pub(crate) fn turn(&mut self, daylight: &Daylight) -> Result<(), RuntimeError> {
        if !self.is_at(daylight) {
            self.shade = None;
            let sun = sun(daylight);
            self.shade = Some((sun, self.prepared.at_sun(sun, self.placements)?));
        }
        Ok(())
    }

    /// What was found last.
    pub(crate) fn shade(&self) -> Option<&SceneLightAtSun<'s>> {
        self.shade.as_ref().map(|(_, shade)| shade)
    }
}

/// Where the sun of a daylight is; none at night.
pub(crate) fn sun(daylight: &Daylight) -> Option<[f64; 3]> {
    (daylight.sun > 0.0).then_some(daylight.towards_sun)
}
