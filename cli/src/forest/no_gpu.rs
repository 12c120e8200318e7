//! In place of `on_gpu.rs` in a build without the feature `gpu`.

use flb_render::Picture;
use flb_render::forest::Forest;
use flb_runtime::scene_light::SceneLightAtSun;

use super::suns::Shot;
use super::{Loaded, PictureOptions};
use crate::args::{GpuCount, RenderBackendArg};
use crate::exit::{Failure, UNSUPPORTED};
use crate::print::say;
use crate::stages::Stages;

const NOT_BUILT: &str =
    "this build has no renderer on a GPU; build it with the feature `gpu`, or render on the CPU";

/// There is none.
pub enum OnGpu {}

/// Refuses a GPU; says that there is none where it is left open.
pub fn send(
    backend: RenderBackendArg,
    _: Option<GpuCount>,
    _: &Forest,
    _: &[Loaded],
    _: &PictureOptions,
    _: &Stages,
) -> Result<Option<OnGpu>, Failure> {
    match backend {
        RenderBackendArg::Cpu => Ok(None),
        RenderBackendArg::Gpu => Err(Failure::new(UNSUPPORTED, NOT_BUILT)),
        RenderBackendArg::Auto => {
            say!("rendering on the CPU: {NOT_BUILT}");
            Ok(None)
        }
    }
}

impl OnGpu {
    pub fn names(&self) -> &[String] {
        match *self {}
    }

    pub fn picture(
        &mut self,
        _: &Shot,
        _: Option<&SceneLightAtSun>,
        _: &PictureOptions,
        _: &Stages,
    ) -> Result<Picture, Failure> {
        match *self {}
    }

    pub fn rays(&mut self) -> Result<[usize; 4], Failure> {
        match *self {}
    }

    pub fn light_bytes(&self) -> usize {
        match *self {}
    }
}
