//! Pictures of a plant alone, in the light of a file: a forest of one, before a camera that frames it.
//!
//! What is asked of one plant is asked many times, so that what a forest has no time for pays here: the near beam of a
//! sun is found at all sites at once, and an uneven sky is taken with its finest detail.

use flb_format::Transform;
use flb_format::progress::Progress;
use flb_format::sun::towards_sun;
use flb_render::portrait::cover_of_plant;
use flb_render::reference::render_reference;
use flb_render::shading::Units;
use flb_render::{LightQuery, Look, Picture, Portrait, Shading, Species, render_plant};
use flb_runtime::light::LightCursors;
use flb_runtime::{InstanceLight, SpeciesLight};
use flb_scene::scene::Sunlight;
use flb_scene::sky::Sky;
use flb_scene::{ClassedMesh, Observer, Step};

use crate::frames::subject;
use crate::light::{by_day, even_sky, load_for};
use crate::look::sun_strength;
use crate::parts::{Part, Parts, Sources};
use crate::plant::PlantLight;
use crate::show::Shows;
use crate::{SceneShow, StageError, StageSky};

/// Size, direction and light of the pictures of a plant alone.
#[derive(Debug, Clone)]
pub struct PlantLook {
    /// Size, and direction of the camera.
    pub portrait: Portrait,
    /// Parts of the light that are shown.
    pub look: Look,
    /// Light of the sky, as [`LookSettings::ambient`](crate::LookSettings::ambient); `None` is the default of the
    /// plant's light.
    pub ambient: Option<f32>,
    /// The sky.
    pub sky: StageSky,
    /// Light of the sun, and further suns.
    pub sunlight: Sunlight,
    /// Contents of the pictures, one layer each; not none. A plant alone has no [`SceneShow::Global`].
    pub shows: Vec<SceneShow>,
    /// Whether light is followed by paths on the mesh, in place of the file's: what that is judged by.
    pub is_path_traced: bool,
}

/// Takes pictures of a plant alone.
pub struct PlantRenderer<'p> {
    plant: Species<'p>,
    look: PlantLook,
    /// Of the file; `None` where pictures show none of it.
    light: Option<SpeciesLight<'static>>,
}

impl PlantLook {
    /// Strength of a sun: nothing comes through the ground.
    fn sun_strength(&self, sun_deg: Option<[f64; 2]>) -> f32 {
        sun_strength(sun_deg, self.portrait.has_ground)
    }

    /// Light of an even sky.
    fn even_ambient(&self, units: Units) -> f32 {
        self.ambient.unwrap_or(units.default_sky())
    }
}

impl<'p> PlantRenderer<'p> {
    /// Loads what pictures under these suns, azimuths and elevations in degrees, show of the light of a file, whose
    /// first three bands are shown.
    ///
    /// # Errors
    /// [`StageError::NoSkyLight`], [`StageError::Runtime`].
    ///
    /// # Panics
    /// If the species has fewer than three bands.
    pub fn new(
        mesh: &'p ClassedMesh,
        light: &PlantLight,
        mut look: PlantLook,
        suns_deg: &[[f64; 2]],
    ) -> Result<PlantRenderer<'p>, StageError> {
        let ClassedMesh { mesh, classes } = mesh;
        let plant = Species { mesh, classes, shading: Shading::of(light.meta()) };
        let shows = Shows(&look.shows);
        let Portrait { width, height, .. } = look.portrait;
        shows.check(light.library.container().species()[light.species].bases.len(), [width, height])?;
        if look.shows.contains(&SceneShow::Global) {
            return Err(StageError::NoSceneLight);
        }
        let has_light = !look.is_path_traced && shows.has_fields(&look.look);
        let has_bases = shows.has_bases();
        look.look = shows.look(look.look);
        let light = match (has_bases, has_light) {
            (true, _) => Some(SpeciesLight::load(&light.library, light.species)?),
            (false, false) => None,
            (false, true) => {
                let suns = suns_deg.iter().chain(look.sunlight.added.iter().map(|one| &one.sun_deg));
                let lit = suns.filter(|sun| look.sun_strength(Some(**sun)) > 0.0);
                let suns = lit.map(|[azimuth, elevation]| towards_sun(*azimuth, *elevation));
                let ambient = look.even_ambient(plant.shading.units());
                Some(load_for(&light.library, light.species, suns, ambient)?)
            }
        };
        Ok(PlantRenderer { plant, look, light })
    }

    /// The picture under a sun, linear; without one, in the light of the sky alone.
    ///
    /// # Errors
    /// [`StageError::UnevenSkyOverPaper`], [`StageError::Sky`], [`StageError::Render`], [`StageError::Runtime`].
    pub fn picture(&self, sun_deg: Option<[f64; 2]>, observer: &dyn Observer) -> Result<Picture, StageError> {
        self.layer(sun_deg, self.look.shows[0], observer)
    }

    /// The pictures under a sun, one of each content of its look.
    ///
    /// # Errors
    /// As [`PlantRenderer::picture`].
    pub fn layers(
        &self,
        sun_deg: Option<[f64; 2]>,
        observer: &dyn Observer,
    ) -> Result<Vec<(SceneShow, Picture)>, StageError> {
        let layer = |show: &SceneShow| Ok((*show, self.layer(sun_deg, *show, observer)?));
        self.look.shows.iter().map(layer).collect()
    }

    fn layer(
        &self,
        sun_deg: Option<[f64; 2]>,
        show: SceneShow,
        observer: &dyn Observer,
    ) -> Result<Picture, StageError> {
        let look = show.look(&self.look.look);
        let parts = self.parts(sun_deg, &look)?;
        if show.is_light() {
            return parts.sum(|part| self.part(part, observer));
        }
        let PlantRenderer { plant, look: PlantLook { portrait, .. }, light } = self;
        let lighting = &parts.first.lighting;
        let SceneShow::Base(base) = show else {
            return Ok(
                Step::Trace.run(observer, "alpha", |_| cover_of_plant(plant, portrait, lighting, &look))?
            );
        };
        let light = |LightQuery { point, .. }: LightQuery, phi: &mut [f32; 3]| {
            if let Some(light) = light {
                light.base_at(usize::from(base), point, phi);
            }
        };
        let render =
            |progress: &Progress<'_>| render_plant(plant, portrait, lighting, &look, &light, progress);
        Ok(Step::Render.run(observer, &subject(sun_deg), render)?)
    }

    /// The picture of a part of the light.
    fn part(&self, part: &Part, observer: &dyn Observer) -> Result<Picture, StageError> {
        let PlantRenderer { plant, look: PlantLook { portrait, .. }, .. } = self;
        let Part { lighting, look, sun_deg, .. } = part;
        let subject = subject(*sun_deg);
        if self.look.is_path_traced {
            let trace = |progress: &Progress<'_>| render_reference(plant, portrait, lighting, look, progress);
            return Ok(Step::Render.run(observer, &subject, trace)?.picture);
        }
        let sky = match (&lighting.dome, &self.light) {
            (Some(dome), Some(light)) => {
                let find = |dome: &Sky| light.sky(dome.patches(), &Transform::IDENTITY);
                Some(Step::Sky.run(observer, &subject, |_| find(dome))?)
            }
            _ => None,
        };
        let prepare = |light| -> Result<InstanceLight<'_>, StageError> {
            let even = even_sky(lighting.daylight.sky);
            let lit = by_day(light, sky.as_ref(), even, lighting, &Transform::IDENTITY)?;
            Ok(match plant.shading.surfaces() {
                None => lit,
                Some(_) => Step::Prepare.run(observer, "", |_| lit.prepared()),
            })
        };
        let lit = self.light.as_ref().map(prepare).transpose()?;
        let cursors = LightCursors::new(std::slice::from_ref(&lit));
        let light = |LightQuery { point, facing, .. }: LightQuery, phi: &mut [f32; 3]| {
            cursors.at_facing(0, point, facing, phi);
        };
        let render =
            |progress: &Progress<'_>| render_plant(plant, portrait, lighting, look, &light, progress);
        Ok(Step::Render.run(observer, &subject, render)?)
    }

    fn parts(&self, sun_deg: Option<[f64; 2]>, look: &Look) -> Result<Parts, StageError> {
        let PlantLook { ambient, sky, sunlight, .. } = &self.look;
        let units = self.plant.shading.units();
        let ambient = (self.look.even_ambient(units), *ambient);
        let sources = Sources { sky, ambient, sunlight, units, look };
        sources.parts(sun_deg, |sun_deg| self.look.sun_strength(Some(sun_deg)))
    }
}
