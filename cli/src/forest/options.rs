//! What is the same in all pictures of a scene, and the daylight of each.

use flb_render::forest::View;
use flb_render::{Daylight, Lighting, Look, PHYSICAL_EXPOSURE};
use flb_scene::scene::Scene;

use super::light::SKY_BYTES;
use super::suns::Shot;
use super::{Loaded, PLANT_BYTES, SKY_RAYS, towards};
use crate::args::RenderArgs;
use crate::exit::Failure;
use crate::picture::{PHYSICAL_SKY, indirect};
use crate::sky::SkyChoice;

/// What is the same in all pictures.
pub(super) struct PictureOptions {
    pub size: [u32; 2],
    pub samples: u32,
    pub ambient: f32,
    pub look: Look,
    pub exposure: f32,
    /// Or water.
    has_ground: bool,
    pub sky: SkyChoice,
    is_physical: bool,
    /// The flag, else the scene's.
    asked_ambient: Option<f32>,
}

/// Light of the sky and exposure by default.
pub(crate) fn sky_and_exposure(loaded: &[Loaded]) -> [f32; 2] {
    match loaded.iter().any(Loaded::is_physical) {
        true => [PHYSICAL_SKY, PHYSICAL_EXPOSURE],
        false => [Lighting::default().daylight.sky, 0.0],
    }
}

impl PictureOptions {
    pub(super) fn of(
        scene: &Scene,
        loaded: &[Loaded],
        args: &RenderArgs,
        sky: SkyChoice,
    ) -> Result<PictureOptions, Failure> {
        let look = Look::default();
        let [ambient, exposure] = sky_and_exposure(loaded);
        let height = scene.camera.as_ref().map_or(512, |camera| camera.height_px);
        let wide = [(u64::from(height) * 16 / 9).clamp(1, u64::from(u32::MAX)) as u32, height];
        let asked_ambient = args.ambient.or(scene.ambient.map(|ambient| ambient as f32));
        let is_physical = loaded.iter().any(Loaded::is_physical);
        sky.over([0.0, 1.0, 0.0], None, is_physical).map_err(|failure| failure.at(&args.file))?;
        Ok(PictureOptions {
            size: args.size.unwrap_or(wide),
            samples: args.samples.unwrap_or(4),
            ambient: asked_ambient.unwrap_or(ambient),
            look: Look {
                indirect: indirect(args.indirect),
                indirect_scale: args.indirect_scale.unwrap_or(look.indirect_scale),
                ..look
            },
            exposure: args.exposure.unwrap_or(exposure),
            has_ground: scene.ground.is_some() || scene.water.is_some(),
            sky,
            is_physical,
            asked_ambient,
        })
    }

    /// Memory for each plant.
    pub(super) fn plant_bytes(&self) -> usize {
        PLANT_BYTES + if self.sky.is_even() { 0 } else { SKY_BYTES }
    }

    pub(super) fn view(&self, shot: &Shot) -> View {
        let [width, height] = self.size;
        View { eye: shot.eye, width, height, samples: self.samples, sky_rays: SKY_RAYS }
    }

    /// Of the sun: nothing comes through ground or water.
    pub(super) fn strength(&self, sun: Option<[f64; 2]>) -> f32 {
        match sun {
            Some([_, elevation]) if elevation > 0.0 || !self.has_ground => 1.0,
            _ => 0.0,
        }
    }

    pub(super) fn lighting(&self, sun: Option<[f64; 2]>) -> Result<Lighting, Failure> {
        let towards_sun = sun.map_or(Lighting::default().daylight.towards_sun, towards);
        let light = Lighting::of(Daylight { towards_sun, sun: self.strength(sun), sky: self.ambient });
        Ok(match self.sky.over(towards_sun, self.asked_ambient, self.is_physical)? {
            Some((dome, sun_color)) => Lighting { dome: Some(dome), sun_color, ..light },
            None => light,
        })
    }
}
