//! What is the same in all frames of a scene, and the light of each.

use flb_render::forest::{Search, View};
use flb_render::shading::Units;
use flb_render::{Lighting, Look};
use flb_scene::scene::{AddedSun, HighlightChoice, Sunlight};

use crate::parts::{Parts, Sources};
use crate::plant::ScenePlant;
use crate::show::Shows;
use crate::{SceneFrame, SceneShow, Stage, StageError, StageSky};

/// Rays that look for the sky from each point of the ground that the camera sees.
pub(crate) const SKY_RAYS: u32 = 4;

/// Size, rays and light that a caller chooses for all frames; `None` is the default of the scene, or of its plants'
/// model.
#[derive(Debug, Clone, PartialEq)]
pub struct LookSettings {
    /// Width and height, pixels; by default 16:9 by the height of the scene's camera, or 512.
    pub size: Option<[u32; 2]>,
    /// Rays per pixel.
    pub samples: u32,
    /// Light of the sky: fluence, a factor on base 0 in the `paper` shading, a factor on a clear sky.
    pub ambient: Option<f32>,
    /// Irradiance of the sun, R, G, B, as [`Sunlight::irradiance`].
    pub irradiance: Option<[f32; 3]>,
    /// Further suns.
    pub added_suns: Option<Vec<AddedSun>>,
    /// Parts of the light that are shown.
    pub look: Look,
    /// Highlights in place of those of the scene, and of the look.
    pub highlight: HighlightChoice,
    /// Contents of the frames, one layer each; not none.
    pub shows: Vec<SceneShow>,
    /// Search structures for what rays meet; they change no bit of a picture.
    pub search: Search,
}

impl Default for LookSettings {
    /// Light, of 4 rays a pixel, all else as the scene has it.
    fn default() -> LookSettings {
        LookSettings {
            size: None,
            samples: 4,
            ambient: None,
            irradiance: None,
            added_suns: None,
            look: Look::default(),
            highlight: HighlightChoice::default(),
            shows: vec![SceneShow::Light],
            search: Search::default(),
        }
    }
}

/// Size, rays, light and sky that all frames share.
#[derive(Debug, Clone)]
pub struct SceneLook {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Rays per pixel.
    pub samples: u32,
    /// Light of an even sky.
    pub ambient: f32,
    /// Parts of the light that are shown.
    pub look: Look,
    /// Contents of the frames, one layer each.
    pub shows: Vec<SceneShow>,
    /// Search structures for what rays meet.
    pub search: Search,
    /// The sky.
    pub sky: StageSky,
    /// Light of the sun of a frame, and further suns.
    pub sunlight: Sunlight,
    /// Whether the sun goes down behind a ground, or water.
    has_ground: bool,
    units: Units,
    /// The caller's, else the scene's.
    asked_ambient: Option<f32>,
}

impl SceneLook {
    /// Makes the look of a stage under a sky.
    ///
    /// # Errors
    /// [`StageError::UnevenSkyOverPaper`], [`StageError::Sky`], [`StageError::HighlightOfPhysical`];
    /// [`StageError::Shows`], [`StageError::NoBase`], [`StageError::LayerPixels`]; [`StageError::NoSceneLight`] where
    /// that is to be shown and there is none.
    pub fn new(stage: &Stage, settings: &LookSettings, sky: StageSky) -> Result<SceneLook, StageError> {
        let scene = &stage.scene;
        let height = scene.camera.as_ref().map_or(512, |camera| camera.height_px);
        let wide = [(u64::from(height) * 16 / 9).clamp(1, u64::from(u32::MAX)) as u32, height];
        let size = settings.size.unwrap_or(wide);
        let shows = Shows(&settings.shows);
        shows.check(stage.plants.iter().map(ScenePlant::bases).max().unwrap_or(0), size)?;
        if settings.shows.contains(&SceneShow::Global) && stage.scene_light.is_none() {
            return Err(StageError::NoSceneLight);
        }
        let asked_ambient = settings.ambient.or(scene.ambient.map(|ambient| ambient as f32));
        let units = stage.units();
        sky.over([0.0, 1.0, 0.0], None, units)?;
        let highlight = settings.highlight.or(scene.highlight);
        if highlight.is_any() && !units.has_highlights() {
            return Err(StageError::HighlightOfPhysical);
        }
        let highlights = settings.look.highlights.with(&highlight);
        Ok(SceneLook {
            size,
            samples: settings.samples,
            ambient: asked_ambient.unwrap_or(stage.default_ambient()),
            look: shows.look(Look { highlights, ..settings.look }),
            shows: settings.shows.clone(),
            search: settings.search,
            sky,
            sunlight: Sunlight {
                irradiance: settings.irradiance.unwrap_or(scene.sunlight.irradiance),
                added: settings.added_suns.clone().unwrap_or_else(|| scene.sunlight.added.clone()),
            },
            has_ground: stage.has_ground(),
            units,
            asked_ambient,
        })
    }

    pub(crate) fn view(&self, frame: &SceneFrame) -> View {
        let [width, height] = self.size;
        View {
            eye: frame.eye,
            width,
            height,
            samples: self.samples,
            sky_rays: SKY_RAYS,
            time_s: frame.time_s,
        }
    }

    /// Of the sun: nothing comes through ground or water.
    pub(crate) fn strength(&self, sun_deg: Option<[f64; 2]>) -> f32 {
        // An image shows the sky of an hour of its own, so a sun below the horizon is none.
        let has_horizon = self.has_ground || !self.sky.needs_sun();
        sun_strength(sun_deg, has_horizon)
    }

    /// The light of a frame, in parts that add up; of its look `shown` is shown.
    pub(crate) fn parts(&self, sun_deg: Option<[f64; 2]>, shown: &Look) -> Result<Parts, StageError> {
        let sources = Sources {
            sky: &self.sky,
            ambient: (self.ambient, self.asked_ambient),
            sunlight: &self.sunlight,
            units: self.units,
            look: shown,
        };
        sources.parts(sun_deg, |sun_deg| self.strength(Some(sun_deg)))
    }

    /// Whether any content is what files hold.
    pub(crate) fn has_fields(&self) -> bool {
        Shows(&self.shows).has_fields(&self.look)
    }

    /// Suns of a frame that light the scene.
    pub(crate) fn suns_of(&self, sun_deg: Option<[f64; 2]>) -> impl Iterator<Item = [f64; 2]> {
        let suns = sun_deg.into_iter().chain(self.sunlight.added.iter().map(|one| one.sun_deg));
        suns.filter(|sun_deg| self.strength(Some(*sun_deg)) > 0.0)
    }

    /// The light of a frame as if its sun were white and alone, of irradiance 1.
    ///
    /// # Errors
    /// [`StageError::Sky`].
    pub fn lighting(&self, sun_deg: Option<[f64; 2]>) -> Result<Lighting, StageError> {
        let (sun, sky) = ((sun_deg, self.strength(sun_deg)), (self.ambient, self.asked_ambient));
        self.sky.lighting(sun, sky, self.units)
    }
}

/// 1 for a sun that lights a scene; 0 for none, and for one at or below the horizon of a ground.
pub(crate) fn sun_strength(sun_deg: Option<[f64; 2]>, has_ground: bool) -> f32 {
    match sun_deg {
        Some([_, elevation]) if elevation > 0.0 || !has_ground => 1.0,
        _ => 0.0,
    }
}

impl Stage {
    /// Light of the sky by default.
    pub fn default_ambient(&self) -> f32 {
        self.units().default_sky()
    }

    /// Stops of exposure by default.
    pub fn default_exposure(&self) -> f32 {
        self.units().default_exposure()
    }
}
