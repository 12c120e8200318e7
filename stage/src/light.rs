//! The light of a scene's species, and of every plant under a sun.

use flb_format::Placement;
use flb_render::{Daylight, Lighting};
use flb_runtime::scene_light::SceneLightAtSun;
use flb_runtime::{InstanceLight, RuntimeError, SkyBeams, SkyLight, SpeciesLight};
use flb_scene::sky::Sky;
use rayon::prelude::*;

use crate::{SceneFrame, SceneLook, Stage, StageError};

/// `[species]`: only the light that frames show is loaded, for the suns as plants see them.
pub(crate) fn load(
    stage: &Stage,
    frames: &[SceneFrame],
    look: &SceneLook,
) -> Result<Vec<Option<SpeciesLight<'static>>>, StageError> {
    let lit = frames.iter().filter(|frame| look.strength(frame.sun_deg) > 0.0);
    let suns: Vec<[f64; 3]> = lit
        .filter_map(|frame| frame.sun_deg)
        .map(|[azimuth, elevation]| flb_format::sun::towards_sun(azimuth, elevation))
        .collect();
    let load = |(number, plant): (usize, &crate::ScenePlant)| {
        let Some((library, species)) = plant.library().filter(|_| shows_fields(look)) else {
            return Ok(None);
        };
        let placements = || stage.scene.instances.iter().filter(|one| one.species == number);
        let in_model = |sun: &[f64; 3]| {
            let sun = *sun;
            placements().map(move |one| one.transform.model_from_world_direction(sun))
        };
        let light =
            SpeciesLight::load_for(library, species, suns.iter().flat_map(in_model), look.ambient > 0.0)?;
        match look.ambient > 0.0 && !light.has_sky() {
            true => Err(StageError::NoSkyLight { library: library.path().to_owned() }),
            false => Ok(Some(light)),
        }
    };
    stage.plants.iter().enumerate().map(load).collect()
}

/// Whether what files hold is shown.
pub(crate) fn shows_fields(look: &SceneLook) -> bool {
    look.look.indirect != flb_render::Indirect::Off
}

/// `[species]`: what the skies over its plants share.
pub(crate) fn beams(light: &[Option<SpeciesLight<'_>>]) -> Result<Vec<Option<SkyBeams>>, RuntimeError> {
    light.iter().map(|light| light.as_ref().map(SpeciesLight::sky_beams).transpose()).collect()
}

/// `[plant]`: what an uneven sky gives it; `None` without light.
pub(crate) fn skies<'l>(
    beams: &'l [Option<SkyBeams>],
    placements: &[Placement],
    dome: &Sky,
) -> Result<Vec<Option<SkyLight<'l>>>, RuntimeError> {
    let parts = dome.patches();
    let sky = |one: &Placement| {
        let Some(beams) = &beams[one.species] else { return Ok(None) };
        Ok(Some(beams.sky(&parts, &one.transform)?))
    };
    placements.par_iter().map(sky).collect()
}

/// Memory of the light of all species.
pub(crate) fn size_bytes(light: &[Option<SpeciesLight<'_>>], beams: &[Option<SkyBeams>]) -> usize {
    let light: usize = light.iter().flatten().map(SpeciesLight::size_bytes).sum();
    light + beams.iter().flatten().map(SkyBeams::size_bytes).sum::<usize>()
}

/// `[plant]`: its light by day, among neighbours where there is scene light, for pictures of so many rays a pixel.
/// Under an even sky `skies` are empty; one of the same fluence stands in for those that are not there.
pub(crate) fn of_plants<'l>(
    light: &'l [Option<SpeciesLight<'_>>],
    skies: &'l [Option<SkyLight<'l>>],
    placements: &[Placement],
    lighting: &Lighting,
    shade: Option<&'l SceneLightAtSun<'l>>,
    rays: u32,
) -> Result<Vec<Option<InstanceLight<'l>>>, RuntimeError> {
    // What the renderer refuses later lights nothing.
    let even = match &lighting.dome {
        None => lighting.daylight.sky,
        Some(dome) => dome.patches().iter().map(|part| part.fluence.iter().sum::<f32>() / 3.0).sum(),
    };
    let even = if even > 0.0 && even.is_finite() { even } else { 0.0 };
    let lit = |(number, one): (u32, &Placement)| -> Result<Option<InstanceLight<'l>>, RuntimeError> {
        let Some(light) = &light[one.species] else { return Ok(None) };
        let uneven = skies.get(number as usize).and_then(Option::as_ref);
        let sky = if uneven.is_some() { 0.0 } else { even };
        let lit = light.lit_by(&Daylight { sky, ..lighting.daylight }, &one.transform)?.for_rays(rays);
        let lit = match uneven {
            Some(sky) => lit.with_sky(sky, lighting.sun_color),
            None => lit,
        };
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
