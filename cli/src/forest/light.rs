//! The light of a scene's species, and of every instance under a sun.

use flb_format::Placement;
use flb_render::{Indirect, Lighting};
use flb_runtime::scene_light::SceneLightAtSun;
use flb_runtime::{Daylight, InstanceLight, SkyBeams, SkyLight, SpeciesLight};
use flb_scene::scene::Scene;
use flb_scene::sky::Sky;
use rayon::prelude::*;

use super::suns::Shot;
use super::{Loaded, PictureOptions, towards};
use crate::exit::Failure;
use crate::picture::{check_sky, sky};

/// `[species]`: only the light that a picture shows is loaded, for the suns as instances see them.
pub(super) fn load(
    scene: &Scene,
    loaded: &[Loaded],
    shots: &[Shot],
    look: &PictureOptions,
) -> Result<Vec<Option<SpeciesLight<'static>>>, Failure> {
    let suns: Vec<[f64; 3]> = shots
        .iter()
        .filter(|shot| look.strength(shot.sun) > 0.0)
        .filter_map(|shot| shot.sun)
        .map(towards)
        .collect();
    let load = |(index, loaded): (usize, &Loaded)| {
        let Some((library, species)) = loaded.light.as_ref().filter(|_| look.look.indirect != Indirect::Off)
        else {
            return Ok(None);
        };
        let instances = || scene.instances.iter().filter(|instance| instance.species == index);
        let in_model = |sun: &[f64; 3]| {
            let sun = *sun;
            instances().map(move |instance| instance.transform.model_from_world_direction(sun))
        };
        let suns = suns.iter().flat_map(in_model);
        let light = SpeciesLight::load_for(library, *species, suns, look.ambient > 0.0)?;
        check_sky(&light, look.ambient).map_err(|failure| failure.at(library.path()))?;
        Ok(Some(light))
    };
    loaded.iter().enumerate().map(load).collect()
}

/// Memory that an uneven sky takes for each plant.
pub(super) const SKY_BYTES: usize = 1500;

/// `[species]`: what the skies over its plants share.
pub(super) fn beams(light: &[Option<SpeciesLight<'_>>]) -> Result<Vec<Option<SkyBeams>>, Failure> {
    light.iter().map(|light| Ok(light.as_ref().map(SpeciesLight::sky_beams).transpose()?)).collect()
}

/// `[instance]`: what an uneven sky gives it; `None` without light.
pub(super) fn skies<'l>(
    beams: &'l [Option<SkyBeams>],
    instances: &[Placement],
    dome: &Sky,
) -> Result<Vec<Option<SkyLight<'l>>>, Failure> {
    let parts = dome.patches();
    let sky = |instance: &Placement| {
        let Some(beams) = &beams[instance.species] else { return Ok(None) };
        Ok(Some(beams.sky(&parts, &instance.transform)?))
    };
    instances.par_iter().map(sky).collect()
}

/// Memory of the light of all species.
pub(super) fn size_bytes(light: &[Option<SpeciesLight<'_>>], beams: &[Option<SkyBeams>]) -> usize {
    let light: usize = light.iter().flatten().map(SpeciesLight::size_bytes).sum();
    light + beams.iter().flatten().map(SkyBeams::size_bytes).sum::<usize>()
}

/// `[instance]`: its light by day, among neighbours where there is scene light, for pictures of so many rays a pixel.
/// Under an even sky `skies` are empty.
pub(super) fn under<'l>(
    light: &'l [Option<SpeciesLight<'_>>],
    skies: &'l [Option<SkyLight<'l>>],
    instances: &[Placement],
    lighting: &Lighting,
    shade: Option<&'l SceneLightAtSun<'l>>,
    rays: u32,
) -> Result<Vec<Option<InstanceLight<'l>>>, Failure> {
    let sky = if lighting.dome.is_some() { 0.0 } else { sky(lighting.daylight.sky) };
    let daylight = Daylight { sky, ..lighting.daylight };
    let lit = |(number, instance): (u32, &Placement)| -> Result<Option<InstanceLight<'l>>, Failure> {
        let Some(light) = &light[instance.species] else { return Ok(None) };
        let lit = light.under(&daylight, &instance.transform)?.for_rays(rays);
        let lit = match skies.get(number as usize) {
            Some(Some(sky)) => lit.with_sky(sky, lighting.sun_color),
            _ => lit,
        };
        Ok(Some(match shade {
            Some(shade) => lit.among(shade, number)?,
            None => lit,
        }))
    };
    // A list that grows takes up to three times the memory for a while.
    let mut all = Vec::with_capacity(instances.len());
    for instance in (0..).zip(instances) {
        all.push(lit(instance)?);
    }
    Ok(all)
}
