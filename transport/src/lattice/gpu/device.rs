//! A GPU with the stages of the solver compiled on it.

use super::stages::{self, Stages};
use crate::gpu::GpuError;
use crate::gpu::buffers::MAX_BUFFER_BYTES;

/// An open GPU.
pub(super) struct Gpu {
    pub opened: flb_gpu::Gpu,
    pub stages: Stages,
}

/// Opens the GPU that [`flb_gpu::find`] finds.
pub(super) fn open() -> Result<Gpu, GpuError> {
    let opened = flb_gpu::Gpu::open_with_buffers(wgpu::Features::empty(), MAX_BUFFER_BYTES)?;
    let stages = stages::compile(&opened.device);
    opened.check()?;
    Ok(Gpu { opened, stages })
}
