//! A scene with its meshes and its light.

use flb_render::RenderError;
use flb_render::forest::{Forest, Ground, Land, Search, Water};
use flb_render::shading::Units;
use flb_runtime::scene_light::SceneLight;
use flb_scene::scene::{Ground as SceneGround, Scene, Terrain, Water as SceneWater};

use crate::plant::{PlantLight, ScenePlant};
use crate::{StageError, neighbours, plant};

/// A scene with its meshes and its light.
pub struct Stage {
    /// Scene as its file has it.
    pub scene: Scene,
    /// Plants of the species, `[species]`.
    pub plants: Vec<ScenePlant>,
    /// What its plants do to each other's light.
    pub(crate) scene_light: Option<SceneLight>,
}

impl Stage {
    /// Memory for each plant while frames are made, bytes: where it stands, its place in the trees that rays find it by
    /// while they are made, and in the grids of a picture and a sun.
    pub const PLANT_BYTES: usize = 500;
    /// Memory of a plant that an uneven sky takes beside [`Stage::PLANT_BYTES`], bytes.
    pub const SKY_BYTES: usize = 1500;

    /// Puts a scene together. Plants whose libraries are of one file share one from here on.
    ///
    /// # Errors
    /// [`StageError::PlantCount`] unless there is a plant for each species; [`StageError::Models`].
    pub fn new(scene: Scene, mut plants: Vec<ScenePlant>) -> Result<Stage, StageError> {
        if plants.len() != scene.species.len() {
            return Err(StageError::PlantCount { found: plants.len(), expected: scene.species.len() });
        }
        plant::share(&mut plants);
        let lit = || {
            scene
                .species
                .iter()
                .zip(&plants)
                .filter_map(|(species, plant)| Some((species, plant.light.as_ref()?)))
        };
        let model = |light: &PlantLight| light.meta().model.name();
        if let Some(first) = lit().next()
            && let Some(other) = lit().find(|(_, light)| model(light) != model(first.1))
        {
            let found = [first, other];
            let species =
                found.map(|(species, light)| (species.name.clone(), light.library.path().to_owned()));
            let models = found.map(|(_, light)| model(light));
            return Err(StageError::Models { species: Box::new(species), models });
        }
        Ok(Stage { scene, plants, scene_light: None })
    }

    /// Adds scene light: what the scene's plants do to each other's light.
    ///
    /// # Errors
    /// [`StageError::OtherScene`], [`StageError::OtherPlant`] for light of another scene, or of other plants by the
    /// same names: plants would lie in the shade of trees that are gone. [`StageError::Format`] for a plant's library.
    pub fn with_scene_light(self, light: SceneLight) -> Result<Stage, StageError> {
        neighbours::check(&self.scene, &self.plants, &light)?;
        Ok(Stage { scene_light: Some(light), ..self })
    }

    /// Units of its pictures.
    pub fn units(&self) -> Units {
        ScenePlant::units(&self.plants)
    }

    /// Names of species that a [`Painter`](crate::stream::Painter) shows under an even sky whatever the sky is: their
    /// light is of single directions of the sun, of which a stream brings those of the sun alone.
    pub fn under_even_sky(&self) -> impl Iterator<Item = &str> {
        let named = self.scene.species.iter().zip(&self.plants);
        let even = named.filter(|(_, plant)| plant.light.is_some() && !plant.is_of_harmonics());
        even.map(|(species, _)| species.name.as_str())
    }

    /// Whether the scene has a ground, or water.
    pub fn has_ground(&self) -> bool {
        self.scene.ground.is_some() || self.scene.water.is_some()
    }

    /// The scene made ready for rays.
    ///
    /// # Errors
    /// [`StageError::Import`] for a height map that cannot be read; [`StageError::Render`].
    pub fn forest(&self, search: Search) -> Result<Forest<'_>, StageError> {
        let ground = self.scene.ground.as_ref().map(ground).transpose()?;
        let species: Vec<_> = self.plants.iter().map(ScenePlant::as_species).collect();
        let prepare = || -> Result<Forest<'_>, RenderError> {
            let forest = Forest::prepare(&species, &self.scene.instances, ground, search)?;
            match &self.scene.water {
                None => Ok(forest),
                Some(found) => forest.with_water(water(found)),
            }
        };
        Ok(prepare()?)
    }
}

fn ground(ground: &SceneGround) -> Result<Ground, StageError> {
    let land = match &ground.terrain {
        Terrain::Plane { height_m } => Land::Plane { height_m: *height_m },
        Terrain::Map(map) => Land::Heights(map.read()?),
    };
    Ok(Ground { land, color: ground.color.map(|share| share as f32), fades_at_m: None })
}

fn water(water: &SceneWater) -> Water {
    let waves = water.waves.map(|moving| moving.waves);
    Water { height_m: water.height_m, color: water.color.map(|share| share as f32), waves }
}
