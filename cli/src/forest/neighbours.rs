//! What the plants of a scene do to each other's light, as `flb bake-scene` found it.

use std::path::PathBuf;

use flb_baker::scene::{Instance, Scene};
use flb_baker::scene_light::digest;
use flb_runtime::SceneLight;
use flb_runtime::scene_light::{Shade, Shades, Stood};

use crate::exit::{Failure, USAGE};
use crate::inputs::open;

/// The scene light that a flag or the scene names. Refuses that of another scene: plants would lie in the shade of trees that are gone.
pub fn load(scene: &Scene, flag: Option<&PathBuf>) -> Result<Option<SceneLight>, Failure> {
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
    Ok(Some(light))
}

/// Scene light and where plants stand.
pub struct Neighbours<'l> {
    shades: Shades<'l>,
    stood: Vec<Stood>,
}

impl<'l> Neighbours<'l> {
    pub fn new(light: &'l SceneLight, scene: &Scene) -> Neighbours<'l> {
        Neighbours { shades: light.prepare(), stood: stood(light, scene) }
    }

    /// Under a sun of a strength, 0 for none.
    pub fn under(&'l self, sun: [f64; 3], strength: f32) -> Result<Shade<'l>, Failure> {
        Ok(self.shades.under((strength > 0.0).then_some(sun), &self.stood)?)
    }
}

/// Where a scene's plants stand in its light.
pub fn stood(light: &SceneLight, scene: &Scene) -> Vec<Stood> {
    let numbers: Vec<Option<usize>> =
        scene.species.iter().map(|species| light.find_species(&species.name)).collect();
    let one = |instance: &Instance| Stood {
        species: numbers[instance.species],
        position_m: instance.position_m,
        rotation: instance.rotation,
        scale: instance.scale,
    };
    scene.instances.iter().map(one).collect()
}
