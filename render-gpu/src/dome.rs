//! An uneven sky: a texture that is drawn where no plant is, and the parts that light plants.

use std::f64::consts::PI;

use flb_format::SkyPart;
use flb_gpu::Gpu;
use flb_scene::sky::Sky;

use crate::stages::{self, Stages};

/// Columns and rows of a clear sky, which is smooth.
const CLEAR: [u32; 2] = [512, 256];
/// Columns or rows of an image, at most: 128 MiB.
const MAX_EDGE: u32 = 4096;

/// The sky that was sent last.
pub(crate) struct Dome {
    /// `None` before the first.
    of: Option<Sky>,
    parts: Vec<SkyPart>,
    fluence: [f32; 3],
    /// Another number for every other sky.
    generation: u64,
    group: wgpu::BindGroup,
}

impl Dome {
    /// Of no sky.
    pub(crate) fn new(gpu: &Gpu, stages: &Stages) -> Dome {
        let group = group(gpu, stages, [1, 1], &[[0.0; 4]]);
        Dome { of: None, parts: Vec::new(), fluence: [0.0; 3], generation: 0, group }
    }

    /// Sends a sky, unless it is there.
    pub(crate) fn send(&mut self, gpu: &Gpu, stages: &Stages, sky: &Sky) {
        if self.of.as_ref() == Some(sky) {
            return;
        }
        let [width, height] = size(gpu, sky);
        let mut texels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            let (level, up) = libm::sincos(PI * (f64::from(y) + 0.5) / f64::from(height));
            for x in 0..width {
                let (sin, cos) = libm::sincos(2.0 * PI * (f64::from(x) + 0.5) / f64::from(width));
                let [red, green, blue] = sky.seen([-level * sin, up, level * cos].map(|c| c as f32));
                texels.push([red, green, blue, 1.0]);
            }
        }
        self.group = group(gpu, stages, [width, height], &texels);
        self.parts = sky.patches();
        self.fluence = std::array::from_fn(|band| {
            self.parts.iter().map(|part| f64::from(part.fluence[band])).sum::<f64>() as f32
        });
        self.generation += 1;
        self.of = Some(sky.clone());
    }

    pub(crate) fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    pub(crate) fn parts(&self) -> &[SkyPart] {
        &self.parts
    }

    /// Fluence, R, G, B.
    pub(crate) fn fluence(&self) -> [f32; 3] {
        self.fluence
    }

    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }
}

/// Columns and rows of the texture.
fn size(gpu: &Gpu, sky: &Sky) -> [u32; 2] {
    let most = gpu.device.limits().max_texture_dimension_2d.min(MAX_EDGE);
    let edge = |edge: usize| u32::try_from(edge).map_or(most, |edge| edge.min(most));
    sky.image().map_or(CLEAR, |(image, _)| image.size().map(edge))
}

fn group(gpu: &Gpu, stages: &Stages, [width, height]: [u32; 2], texels: &[[f32; 4]]) -> wgpu::BindGroup {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("flb dome"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * width), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), layout, size);
    let view = texture.create_view(&Default::default());
    let texture = wgpu::BindingResource::TextureView(&view);
    stages::group(&gpu.device, "flb dome", &stages.dome, &[texture])
}
