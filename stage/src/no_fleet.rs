//! In place of `fleet.rs` in a build without the feature `gpu`.

use flb_render::forest::{Forest, View};
use flb_render::{Lighting, Look, Picture};
use flb_runtime::scene_light::SceneLightAtSun;
use flb_scene::Observer;

use crate::{Backend, SceneLook, Stage, StageError};

/// There is none.
pub(crate) enum Fleet {}

impl Fleet {
    /// Refuses a GPU; tells that there is none where it is left open.
    pub(crate) fn send(
        backend: Backend,
        _: &Stage,
        _: &Forest<'_>,
        _: &SceneLook,
        observer: &dyn Observer,
    ) -> Result<Option<Fleet>, StageError> {
        match backend {
            Backend::Cpu => Ok(None),
            Backend::Gpu(_) => Err(StageError::NoGpuBuilt),
            Backend::Auto(_) => {
                observer.note(&format!("rendering on the CPU: {}", StageError::NoGpuBuilt));
                Ok(None)
            }
        }
    }

    pub(crate) fn names(&self) -> &[String] {
        match *self {}
    }

    pub(crate) fn picture(
        &mut self,
        _: &View,
        _: (&Lighting, &Look),
        _: Option<&SceneLightAtSun<'_>>,
        _: (&str, &dyn Observer),
    ) -> Result<Picture, StageError> {
        match *self {}
    }

    pub(crate) fn rays(&mut self) -> Result<[usize; 4], StageError> {
        match *self {}
    }

    pub(crate) fn light_bytes(&self) -> usize {
        match *self {}
    }
}
