//! In place of `on_gpu.rs` in a build without the feature `gpu`.

use std::sync::Arc;

use flb_render::forest::View;
use flb_render::{Lighting, Look, Picture};
use flb_runtime::light::SkyBeams;
use flb_runtime::residency::Units;
use flb_runtime::resident::Resident;
use flb_runtime::scene_light::SceneLightAtSun;
use flb_runtime::stream::Frame;

use crate::StageError;

/// There is none.
pub(crate) enum OnGpu {}

impl OnGpu {
    pub(crate) fn name(&self) -> &str {
        match *self {}
    }

    pub(crate) fn follow(&mut self, _: &Frame, _: &Units, _: &Resident) -> Result<bool, StageError> {
        match *self {}
    }

    pub(crate) fn set_sky_beams(&mut self, _: usize, _: Arc<SkyBeams>) {
        match *self {}
    }

    pub(crate) fn trace(&mut self, _: &View) -> Result<(), StageError> {
        match *self {}
    }

    pub(crate) fn lit(
        &mut self,
        _: &Resident,
        _: (&Lighting, &Look),
        _: Option<&SceneLightAtSun<'_>>,
    ) -> Result<Picture, StageError> {
        match *self {}
    }
}

pub(crate) fn is_of_gpu(_: &StageError) -> bool {
    false
}
