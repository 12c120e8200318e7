//! Buffers and dispatches of the solvers.

use flb_gpu::Gpu;

/// Bytes of a number.
pub(crate) const WORD: u64 = size_of::<f32>() as u64;

/// Bytes that a buffer takes at most, whatever the GPU would allow: the host holds a copy of what it reads.
pub(crate) const MAX_BUFFER_BYTES: u64 = 768 << 20;

/// Invocations of a workgroup; `WORKGROUP` of each types.wgsl.
pub(crate) const WORKGROUP: u32 = 64;

/// Workgroups for so many invocations, in rows as long as WebGPU allows.
pub(crate) fn workgroups(invocations: usize) -> [u32; 2] {
    const LONGEST: u32 = 65_535;
    let count = invocations.div_ceil(WORKGROUP as usize) as u32;
    let rows = count.div_ceil(LONGEST).max(1);
    [count.div_ceil(rows), rows]
}

pub(crate) fn empty(gpu: &Gpu, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}

/// A buffer for stages to read. Never of size 0, which cannot be bound.
pub(crate) fn filled(gpu: &Gpu, label: &str, words: &[u32]) -> wgpu::Buffer {
    let bytes: &[u8] = bytemuck::cast_slice(words);
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
    let buffer = empty(gpu, label, (bytes.len() as u64).max(WORD), usage);
    gpu.queue.write_buffer(&buffer, 0, bytes);
    buffer
}
