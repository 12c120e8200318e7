//! A GPU with the stages of the solver compiled on it.

use super::stages::{self, Stages};
use crate::gpu::GpuError;
use crate::gpu::buffers::MAX_BUFFER_BYTES;

/// An open GPU.
pub(super) struct Gpu {
    pub opened: flb_gpu::Gpu,
    pub stages: Stages,
}

/// Opens the GPU that [`flb_gpu::find`] finds and others of its kind, up to so many.
pub(super) fn open(most: usize) -> Result<Vec<Gpu>, GpuError> {
    let all = flb_gpu::Gpu::open_alike(wgpu::Features::empty(), MAX_BUFFER_BYTES, most)?;
    all.into_iter().map(with_stages).collect()
}

fn with_stages(opened: flb_gpu::Gpu) -> Result<Gpu, GpuError> {
    let stages = stages::compile(&opened.device);
    opened.check()?;
    Ok(Gpu { opened, stages })
}
