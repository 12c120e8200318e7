//! Lists of words to buffers, or to an error with their size.

use flb_gpu::Gpu;

use crate::ForestError;

/// A buffer for stages to read, never of size 0, which cannot be bound.
pub(crate) fn storage(
    gpu: &Gpu,
    what: &'static str,
    words: &[u32],
    remedy: &'static str,
) -> Result<wgpu::Buffer, ForestError> {
    let bytes: &[u8] = bytemuck::cast_slice(words);
    let needed = bytes.len() as u64;
    let limit = gpu.largest_buffer_bytes();
    if needed > limit {
        return Err(ForestError::TooLarge { what, needed, limit, remedy });
    }
    use wgpu::BufferUsages as Usage;
    let usage = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
    let buffer = empty(gpu, what, needed.max(MIN_BYTES), usage);
    gpu.queue.write_buffer(&buffer, 0, bytes);
    Ok(buffer)
}

/// A uniform buffer of these words.
pub(crate) fn uniform(gpu: &Gpu, label: &str, words: &[u32]) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    let buffer = empty(gpu, label, 4 * words.len() as u64, usage);
    gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(words));
    buffer
}

/// A buffer of zeros.
pub(crate) fn empty(gpu: &Gpu, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}

/// Bytes of the largest element of any list.
const MIN_BYTES: u64 = 128;
