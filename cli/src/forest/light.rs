//! The light of a scene's species, and of every instance under a sun.

use flb_render::Indirect;
use flb_runtime::scene_light::SceneLightAtSun;
use flb_runtime::{Daylight, InstanceLight, SpeciesLight};
use flb_scene::scene::{Instance, Scene};

use super::suns::Shot;
use super::{Loaded, PictureOptions, towards};
use crate::exit::Failure;
use crate::picture::{check_sky, sky};

/// `[species]`: only the light that a picture shows is loaded, for the suns as instances see them.
pub fn load(
    scene: &Scene,
    loaded: &[Loaded],
    shots: &[Shot],
    look: &PictureOptions,
) -> Result<Vec<Option<SpeciesLight<'static>>>, Failure> {
    let suns: Vec<[f64; 3]> =
        shots.iter().filter(|shot| look.strength(shot.sun) > 0.0).map(|shot| towards(shot.sun)).collect();
    let load = |(index, loaded): (usize, &Loaded)| {
        let Some((library, species)) = loaded.light.as_ref().filter(|_| look.indirect != Indirect::Off)
        else {
            return Ok(None);
        };
        let instances = || scene.instances.iter().filter(|instance| instance.species == index);
        let in_model = |sun: &[f64; 3]| {
            let sun = *sun;
            instances().map(move |instance| instance.transform().model_from_world_direction(sun))
        };
        let suns = suns.iter().flat_map(in_model);
        let light = SpeciesLight::load_for(library, *species, suns, look.ambient > 0.0)?;
        check_sky(&light, look.ambient).map_err(|failure| failure.at(library.path()))?;
        Ok(Some(light))
    };
    loaded.iter().enumerate().map(load).collect()
}

/// `[instance]`: its light by day, among neighbours where there is scene light, for pictures of so many rays a pixel.
pub fn under<'l>(
    light: &'l [Option<SpeciesLight<'_>>],
    instances: &[Instance],
    daylight: &flb_render::forest::Daylight,
    shade: Option<&'l SceneLightAtSun<'l>>,
    rays: u32,
) -> Result<Vec<Option<InstanceLight<'l>>>, Failure> {
    let daylight =
        Daylight { towards_sun: daylight.sun, sun: daylight.sun_strength, sky: sky(daylight.ambient) };
    let lit = |(number, instance): (u32, &Instance)| {
        let Some(light) = &light[instance.species] else { return Ok(None) };
        let lit = light.under(&daylight, &instance.transform())?.for_rays(rays);
        Ok(Some(match shade {
            Some(shade) => lit.among(shade, number)?,
            None => lit,
        }))
    };
    (0..).zip(instances).map(lit).collect()
}
