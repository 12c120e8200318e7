//! What the plants of a scene do to each other's light, as `flb bake-scene` found it.

use std::path::PathBuf;

use flb_baker::scene_light::{digest, plant_digest};
use flb_format::Placement;
use flb_runtime::scene_light::{PreparedSceneLight, SceneLightAtSun};
use flb_runtime::{Library, SceneLight};
use flb_scene::scene::Scene;

use crate::exit::{Failure, USAGE};
use crate::inputs::open;

/// The scene light that a flag or the scene names. Refuses that of another scene, or of other plants by the same names
/// (`plants`: of each species its library and number): plants would lie in the shade of trees that are gone.
pub(crate) fn load<'l>(
    scene: &Scene,
    plants: impl Iterator<Item = Option<(&'l Library, usize)>>,
    flag: Option<&PathBuf>,
) -> Result<Option<SceneLight>, Failure> {
    let Some(file) = flag.or(scene.light.as_ref()) else { return Ok(None) };
    let library = open(file)?;
    let light = SceneLight::load(&library)?;
    let expected = digest(scene);
    if light.digest() != expected {
        let message = format!(
            "is the light of other plants or another ground than the scene's (digest {}, expected {}): bake it again with flb bake-scene",
            &light.digest().get(..12).unwrap_or(light.digest()),
            &expected[..12]
        );
        return Err(Failure::new(USAGE, message).at(library.path()));
    }
    for (species, plant) in scene.species.iter().zip(plants) {
        let (Some(number), Some((of_plant, index))) = (light.find_species(&species.name), plant) else {
            continue;
        };
        if digest_in(of_plant, index)?.as_deref() != light.plant_digest(number) {
            let message = format!(
                "is the light of another plant by the name {:?} than that of {}: bake it again with flb bake-scene",
                species.name,
                of_plant.path().display()
            );
            return Err(Failure::new(USAGE, message).at(library.path()));
        }
    }
    Ok(Some(light))
}

/// [`plant_digest`] of a species of a library; `None` for the model paper, of which scenes have no light.
fn digest_in(library: &Library, index: usize) -> Result<Option<String>, Failure> {
    let container = library.container();
    let Some((surfaces, light)) = container.species()[index].meta.physical() else { return Ok(None) };
    let digest = || {
        let turbid = container.read_turbid(library.source(), index)?;
        Ok(plant_digest(surfaces, light.field, &turbid))
    };
    digest().map(Some).map_err(|failure: Failure| failure.at(library.path()))
}

/// Scene light and where plants stand.
pub(crate) struct Neighbours<'l> {
    prepared: PreparedSceneLight<'l>,
    placed: &'l [Placement],
}

impl<'l> Neighbours<'l> {
    pub(crate) fn new(light: &'l SceneLight, scene: &'l Scene) -> Neighbours<'l> {
        Neighbours { prepared: prepare(light, scene), placed: &scene.instances }
    }

    /// Under a sun of a strength, 0 for none.
    pub(crate) fn under(&'l self, sun: [f64; 3], strength: f32) -> Result<SceneLightAtSun<'l>, Failure> {
        Ok(self.prepared.under((strength > 0.0).then_some(sun), self.placed)?)
    }
}

/// Scene light for the species of a scene.
pub(crate) fn prepare<'l>(light: &'l SceneLight, scene: &Scene) -> PreparedSceneLight<'l> {
    light.prepare(scene.species.iter().map(|species| species.name.as_str()))
}
