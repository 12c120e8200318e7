//! The light of a scene's species, and of every plant under a sun.

use std::sync::Arc;

use flb_format::{Daylight, Placement, Transform};
use flb_render::Lighting;
use flb_runtime::light::{SkyBeams, SkyLight};
use flb_runtime::scene_light::SceneLightAtSun;
use flb_runtime::{InstanceLight, Library, RuntimeError, SpeciesLight};
use flb_scene::sky::Sky;
use rayon::prelude::*;

use crate::show::Shows;
use crate::{SceneFrame, SceneLook, Stage, StageError};

/// `[species]`: only the light that frames show is loaded, for the suns as plants see them.
pub(crate) fn load(
    stage: &Stage,
    frames: &[SceneFrame],
    look: &SceneLook,
) -> Result<Vec<Option<SpeciesLight<'static>>>, StageError> {
    let suns: Vec<[f64; 3]> = frames
        .iter()
        .flat_map(|frame| look.suns_of(frame.sun_deg))
        .map(|[azimuth, elevation]| flb_format::sun::towards_sun(azimuth, elevation))
        .collect();
    let load = |(number, plant): (usize, &crate::plant::ScenePlant)| {
        let Some((library, species)) = plant.library().filter(|_| look.has_fields()) else {
            return Ok(None);
        };
        if Shows(&look.shows).has_bases() {
            return Ok(Some(SpeciesLight::load(library, species)?));
        }
        let placements = || stage.scene.instances.iter().filter(|one| one.species == number);
        let in_model = |sun: &[f64; 3]| {
            let sun = *sun;
            placements().map(move |one| one.transform.model_from_world_direction(sun))
        };
        load_for(library, species, suns.iter().flat_map(in_model), look.ambient).map(Some)
    };
    stage.plants.iter().enumerate().map(load).collect()
}

/// The light of a species for suns, in its own frame, and a sky of a strength.
pub(crate) fn load_for(
    library: &Library,
    species: usize,
    suns: impl IntoIterator<Item = [f64; 3]>,
    ambient: f32,
) -> Result<SpeciesLight<'static>, StageError> {
    let light = SpeciesLight::load_for(library, species, suns, ambient > 0.0)?;
    match ambient > 0.0 && !light.has_sky() {
        true => Err(StageError::NoSkyLight { library: library.path().to_owned() }),
        false => Ok(light),
    }
}

/// The light of a plant by day, under an uneven sky or an even one.
pub(crate) fn by_day<'l>(
    light: &'l SpeciesLight<'_>,
    uneven: Option<&'l SkyLight<'l>>,
    even: f32,
    lighting: &Lighting,
    transform: &Transform,
) -> Result<InstanceLight<'l>, RuntimeError> {
    let sky = if uneven.is_some() { 0.0 } else { even };
    let lit = light.lit_by(&Daylight { sky, ..lighting.daylight }, transform)?;
    Ok(match uneven {
        Some(sky) => lit.with_sky(sky, lighting.sun_color),
        None => lit,
    })
}

/// `[species]`: what the skies over its plants share.
pub(crate) fn beams(light: &[Option<SpeciesLight<'_>>]) -> Result<Vec<Option<Arc<SkyBeams>>>, RuntimeError> {
    let of_species = |light: &Option<SpeciesLight<'_>>| {
        Ok(light.as_ref().map(SpeciesLight::sky_beams).transpose()?.map(Arc::new))
    };
    light.iter().map(of_species).collect()
}

/// What an uneven sky gives plants.
pub(crate) struct Skies<'l> {
    /// `[plant]`; `None` without light, or beams.
    over: Vec<Option<SkyLight<'l>>>,
    /// Mean fluence of its bands: of an even sky that stands in where the other is not there.
    fluence: f32,
}

/// What an uneven sky gives each plant.
pub(crate) fn skies<'l>(
    beams: &'l [Option<Arc<SkyBeams>>],
    placements: &[Placement],
    dome: &Sky,
) -> Result<Skies<'l>, RuntimeError> {
    let parts = dome.patches();
    let fluence = parts.iter().map(|part| part.fluence.iter().sum::<f32>() / 3.0).sum();
    let sky = |one: &Placement| {
        let Some(beams) = &beams[one.species] else { return Ok(None) };
        Ok(Some(beams.sky(parts, &one.transform)?))
    };
    Ok(Skies { over: placements.par_iter().map(sky).collect::<Result<_, RuntimeError>>()?, fluence })
}

/// Light of a sky of a strength that the renderer checks later: what it will refuse lights nothing.
pub(crate) fn even_sky(ambient: f32) -> f32 {
    if ambient > 0.0 && ambient.is_finite() { ambient } else { 0.0 }
}

/// Memory of the light of all species.
pub(crate) fn size_bytes(light: &[Option<SpeciesLight<'_>>], beams: &[Option<Arc<SkyBeams>>]) -> usize {
    let light: usize = light.iter().flatten().map(SpeciesLight::size_bytes).sum();
    light + beams.iter().flatten().map(|beams| beams.size_bytes()).sum::<usize>()
}

/// `[plant]`: its light by day, among neighbours where there is scene light, for pictures of so many rays a pixel.
/// There are no `skies` under an even one.
pub(crate) fn of_plants<'l>(
    light: &'l [Option<SpeciesLight<'_>>],
    skies: Option<&'l Skies<'l>>,
    placements: &[Placement],
    lighting: &Lighting,
    shade: Option<&'l SceneLightAtSun<'l>>,
    rays: u32,
) -> Result<Vec<Option<InstanceLight<'l>>>, RuntimeError> {
    let even = even_sky(skies.map_or(lighting.daylight.sky, |skies| skies.fluence));
    let lit = |(number, one): (u32, &Placement)| -> Result<Option<InstanceLight<'l>>, RuntimeError> {
        let Some(light) = &light[one.species] else { return Ok(None) };
        let uneven = skies.and_then(|skies| skies.over[number as usize].as_ref());
        let lit = by_day(light, uneven, even, lighting, &one.transform)?.for_rays(rays);
        Ok(Some(match shade {
            Some(shade) => lit.with_neighbours(shade, number)?,
            None => lit,
        }))
    };
    // A list that grows takes up to three times the memory for a while.
    let mut all = Vec::with_capacity(placements.len());
    for one in (0..).zip(placements) {
        all.push(lit(one)?);
    }
    Ok(all)
}
