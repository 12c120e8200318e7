//! An uneven sky as a texture, which is drawn where no plant is.

use flb_gpu::Gpu;
use flb_scene::sky::{Sky, image};

use crate::stages::{self, Stages};

/// Columns and rows of a clear sky, which is smooth.
const CLEAR: [u32; 2] = [512, 256];
/// Columns or rows of an image, at most: 128 MiB.
const MAX_EDGE: u32 = 4096;

/// The sky that was sent last.
pub(crate) struct Dome {
    /// `None` before the first.
    of: Option<Sky>,
    group: wgpu::BindGroup,
}

impl Dome {
    /// Of no sky.
    pub(crate) fn new(gpu: &Gpu, stages: &Stages) -> Dome {
        Dome { of: None, group: group(gpu, stages, [1, 1], &[[0.0; 4]]) }
    }

    /// Sends a sky, unless it is there.
    pub(crate) fn send(&mut self, gpu: &Gpu, stages: &Stages, sky: &Sky) {
        if self.of.as_ref() == Some(sky) {
            return;
        }
        let size = size(gpu, sky);
        let [width, height] = size.map(|edge| edge as usize);
        let mut texels = Vec::with_capacity(width * height);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let towards = image::towards([x as f64 + 0.5, y as f64 + 0.5], [width, height]);
            let [red, green, blue] = sky.seen(towards);
            texels.push([red, green, blue, 1.0]);
        }
        self.group = group(gpu, stages, size, &texels);
        self.of = Some(sky.clone());
    }

    pub(crate) fn group(&self) -> &wgpu::BindGroup {
        &self.group
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
