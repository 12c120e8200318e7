//! The part of a painter that a GPU does: it follows the streamer, traces, and relights.

use std::sync::Arc;

use flb_format::light::SunBasis;
use flb_gpu::Gpu;
use flb_render::forest::{Forest, View};
use flb_render::{Lighting, Look, Picture};
use flb_render_gpu::{ForestSettings, GpuForest, StreamedLights};
use flb_runtime::light::SkyBeams;
use flb_runtime::residency::Units;
use flb_runtime::resident::Resident;
use flb_runtime::scene_light::SceneLightAtSun;
use flb_runtime::stream::Frame;

use crate::{StageError, neighbours};

/// Most bytes of light that a picture waits for to be sent.
const UPLOAD_BYTES: u64 = 16 << 20;

/// A scene on a GPU.
pub(crate) struct OnGpu {
    forest: GpuForest,
    lights: StreamedLights,
    view: Option<View>,
    /// Of which sun the shade was sent, which may be none.
    shaded: Option<Option<[f64; 3]>>,
    name: String,
}

impl OnGpu {
    /// Of a streamer's units. `species` has the number in the library of each of the forest's; `suns` are those of an
    /// uneven sky, and none of an even one.
    pub(crate) fn new(
        gpu: &Gpu,
        forest: &Forest<'_>,
        units: &Units,
        (species, suns): (Vec<Option<usize>>, &[&SunBasis]),
        budget_bytes: u64,
    ) -> Result<OnGpu, StageError> {
        let instances = forest.placements().len();
        let lights = match suns {
            [] => StreamedLights::new(gpu, units, species, instances, budget_bytes)?,
            suns => StreamedLights::for_skies(gpu, units, species, suns, instances, budget_bytes)?,
        };
        let forest = GpuForest::with_light(gpu, forest, lights.light(), ForestSettings::default())?;
        Ok(OnGpu { forest, lights, view: None, shaded: None, name: gpu.name.clone() })
    }

    /// Name of the GPU.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Sets what uneven skies over the plants of a species share.
    pub(crate) fn set_sky_beams(&mut self, species: usize, beams: Arc<SkyBeams>) {
        self.lights.set_sky_beams(species, beams);
    }

    /// Takes over what a frame loaded and dropped; tells whether all of it has been sent.
    pub(crate) fn follow(
        &mut self,
        frame: &Frame,
        units: &Units,
        resident: &Resident,
    ) -> Result<bool, StageError> {
        let followed = self.lights.follow(frame, units, resident, UPLOAD_BYTES)?;
        Ok((followed.waiting == 0 || followed.is_full) && !followed.is_blending)
    }

    /// Finds what the camera sees, if it has moved.
    pub(crate) fn trace(&mut self, view: &View) -> Result<(), StageError> {
        if self.view != Some(*view) {
            self.view = None;
            self.forest.trace(view)?;
            self.forest.wait()?;
            self.view = Some(*view);
        }
        Ok(())
    }

    /// A picture of what was traced. The shade is that of a sun, and sent once.
    pub(crate) fn lit(
        &mut self,
        resident: &Resident,
        (lighting, look): (&Lighting, &Look),
        shade: Option<&SceneLightAtSun<'_>>,
    ) -> Result<Picture, StageError> {
        let sun = neighbours::sun(&lighting.daylight);
        if shade.is_some() && self.shaded != Some(sun) {
            self.shaded = None;
            self.forest.set_scene_light(shade)?;
            self.shaded = Some(sun);
        }
        self.forest.relight_streamed(&mut self.lights, resident, lighting, look)?;
        Ok(self.forest.picture()?)
    }
}

/// Whether an error is a GPU's, and another way may do.
pub(crate) fn is_of_gpu(error: &StageError) -> bool {
    matches!(error, StageError::Forest(_) | StageError::Device(_))
}
