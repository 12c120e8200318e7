//! What does not change with instances: models, materials and images in buffers, and behind the images room for grids
//! that come and go.

use flb_gpu::Gpu;

use crate::ForestError;
use crate::buffers::{empty, storage, uniform};
use crate::models::Models;
use crate::stages::{self, Stages};
use crate::stand::Stand;

/// The buffers of all models.
pub(crate) struct Statics {
    models: wgpu::Buffer,
    materials: wgpu::Buffer,
    boxes: wgpu::Buffer,
    triangles: wgpu::Buffer,
    vertices: wgpu::Buffer,
    words: wgpu::Buffer,
    /// Words that stay.
    still: usize,
    /// `[place in the order]`: number in its mesh.
    pub numbers: Vec<u32>,
    /// Depth of the deepest tree.
    pub depth: u32,
}

/// Where words came to lie.
pub(crate) struct Put {
    pub first: u32,
    /// Whether another buffer holds all words now.
    pub is_elsewhere: bool,
}

const WORDS: &str = "images, cuts, heights and grids";
const SMALLER: &str = "with smaller textures";

impl Statics {
    pub(crate) fn new(gpu: &Gpu, models: &Models) -> Result<Statics, ForestError> {
        let plants = "with fewer triangles in the models";
        let lookups = &models.lookups;
        Ok(Statics {
            models: uniform(gpu, "flb models", &models.model_words()),
            materials: uniform(gpu, "flb materials", &lookups.material_words()),
            boxes: storage(gpu, "boxes of the models", &models.boxes.0, plants)?,
            triangles: storage(gpu, "triangles", &models.triangles.0, plants)?,
            vertices: storage(gpu, "vertices", &models.vertices.0, plants)?,
            words: storage(gpu, WORDS, &lookups.words, SMALLER)?,
            still: lookups.words.len(),
            numbers: models.numbers.clone(),
            depth: models.depth,
        })
    }

    /// What the stages of rays bind.
    pub(crate) fn group(&self, gpu: &Gpu, stages: &Stages, stand: &Stand) -> wgpu::BindGroup {
        let buffers = [
            &self.models,
            &self.materials,
            &self.boxes,
            &self.triangles,
            &self.vertices,
            &self.words,
            &stand.boxes,
            &stand.instances,
        ];
        let buffers = buffers.map(wgpu::Buffer::as_entire_binding);
        stages::group(&gpu.device, "flb scene", &stages.scene, &buffers)
    }

    /// Sends words that lie so many behind those that stay. What lies behind them is lost.
    pub(crate) fn put(&mut self, gpu: &Gpu, behind: usize, words: &[u32]) -> Result<Put, ForestError> {
        let first = self.still + behind;
        let needed = 4 * (first + words.len()) as u64;
        let limit = gpu.largest_buffer_bytes();
        if needed > limit {
            return Err(ForestError::TooLarge { what: WORDS, needed, limit, remedy: SMALLER });
        }
        let is_elsewhere = needed > self.words.size();
        if is_elsewhere {
            // Another view or sun may need some more.
            let size = (needed + needed / 4).next_multiple_of(4).min(limit);
            let larger = empty(gpu, WORDS, size, self.words.usage());
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&self.words, 0, &larger, 0, 4 * first as u64);
            gpu.queue.submit([encoder.finish()]);
            self.words = larger;
        }
        gpu.queue.write_buffer(&self.words, 4 * first as u64, bytemuck::cast_slice(words));
        Ok(Put { first: first as u32, is_elsewhere })
    }

    pub(crate) fn size_bytes(&self) -> u64 {
        let buffers = [&self.boxes, &self.triangles, &self.vertices, &self.words];
        buffers.iter().map(|buffer| buffer.size()).sum()
    }
}
