//! A GPU with the stages of the solver compiled on it.

use super::stages::{self, Stages};
use crate::gpu::GpuError;
use crate::gpu::buffers::MAX_BUFFER_BYTES;

/// An open GPU.
pub(in crate::ordinates) struct Gpu {
    pub opened: flb_gpu::Gpu,
    pub stages: Stages,
    /// Bytes of the largest buffer that a stage can bind.
    pub buffer_bytes: u64,
}

/// Opens the GPU that [`flb_gpu::find`] finds.
pub(in crate::ordinates) fn open() -> Result<Gpu, GpuError> {
    let opened = flb_gpu::Gpu::open_with_buffers(wgpu::Features::empty(), MAX_BUFFER_BYTES)?;
    let stages = stages::compile(&opened.device);
    opened.check()?;
    let buffer_bytes = opened.largest_buffer_bytes();
    Ok(Gpu { opened, stages, buffer_bytes })
}
