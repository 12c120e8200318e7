//! A blend of a species' bases, decoded once into a 3D texture that hardware filters: where many fragments share one
//! sun.
//!
//! ```text
//! GpuLight + terms -fill.wgsl-> bricks of 5^3 texels (rgba16float) -atlas.wgsl: flb_sample_atlas-> light at a point
//! ```
//!
//! Only stored blocks have bricks, so an atlas takes 1,000 bytes for each, whatever the number of terms; the block map
//! that is on the GPU anyway finds them. A brick repeats the first texels of the blocks above it, so that a sample is
//! one fetch. Coarse averages are bricks too. Light is rounded to binary16: 11 bits, nothing above 65,504.

use flb_format::blocks::{coarse, map};

use super::{GpuError, GpuLight, GpuSpeciesId, light_wgsl};

/// Texels of a brick along an axis; `FLB_BRICK` of atlas.wgsl and `BRICK` of fill.wgsl.
pub(super) const BRICK: u32 = 5;
/// Bytes of a texel.
const TEXEL_BYTES: u64 = 8;
/// Workgroups along x; `WORKGROUPS` of fill.wgsl.
pub(super) const WORKGROUPS: u32 = 32_768;
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

const ATLAS: &str = include_str!("atlas.wgsl");
/// fill.wgsl, with light.wgsl in group 1.
pub(super) const FILL: &str = include_str!("fill.wgsl");

/// The functions that sample light and atlases, to be put before a shader of one's own, bound to two groups.
pub fn atlas_wgsl(light_group: u32, atlas_group: u32) -> String {
    light_wgsl(light_group) + &ATLAS.replace("@group(2)", &format!("@group({atlas_group})"))
}

/// Pipeline that fills atlases, and the layouts by which shaders read them.
pub struct AtlasDecoder {
    device: wgpu::Device,
    pipeline: wgpu::ComputePipeline,
    filled: wgpu::BindGroupLayout,
    sampled: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
}

/// Bricks of a species under one sun.
pub struct Atlas {
    species: GpuSpeciesId,
    texture: wgpu::Texture,
    /// Of `fill`, its parameters.
    fill: wgpu::Buffer,
    filled: wgpu::BindGroup,
    sampled: wgpu::BindGroup,
    layout: Layout,
}

/// How bricks lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Layout {
    bricks: u32,
    across: u32,
    coarse: u32,
    coarse_bricks: u32,
}

impl Layout {
    fn of(map: &map::BlockMap) -> Layout {
        let (coarse, coarse_bricks) = (map.len() as u32, coarse::edge(map).div_ceil(4));
        let bricks = coarse + coarse_bricks.pow(3);
        let across = (1..=bricks).find(|edge| edge.pow(3) >= bricks).unwrap_or(1);
        Layout { bricks, across, coarse, coarse_bricks }
    }

    /// Texels along each axis; layers without a brick are left out.
    fn texels(&self) -> [u32; 3] {
        let layers = self.bricks.div_ceil(self.across * self.across);
        [self.across, self.across, layers].map(|bricks| BRICK * bricks)
    }

    fn bytes(&self) -> u64 {
        TEXEL_BYTES * self.texels().map(u64::from).iter().product::<u64>()
    }
}

/// `Fill` of fill.wgsl.
fn fill_fields(species: u32, first_term: u32, term_count: u32, layout: Layout) -> [(&'static str, u32); 8] {
    let Layout { bricks, across, coarse, coarse_bricks } = layout;
    [
        ("species", species),
        ("first_term", first_term),
        ("term_count", term_count),
        ("across", across),
        ("bricks", bricks),
        ("coarse", coarse),
        ("coarse_bricks", coarse_bricks),
        ("unused", 0),
    ]
}

/// `FlbAtlas` of atlas.wgsl.
fn atlas_fields(species: u32, layout: Layout) -> [(&'static str, u32); 4] {
    let Layout { across, coarse, coarse_bricks, .. } = layout;
    [("species", species), ("across", across), ("coarse", coarse), ("coarse_bricks", coarse_bricks)]
}

#[cfg(test)]
pub(super) fn field_names() -> (Vec<&'static str>, Vec<&'static str>) {
    let layout = Layout { bricks: 1, across: 1, coarse: 1, coarse_bricks: 0 };
    let fill = fill_fields(0, 0, 0, layout).map(|(name, _)| name);
    (fill.to_vec(), atlas_fields(0, layout).map(|(name, _)| name).to_vec())
}

impl AtlasDecoder {
    /// Compiles what fills atlases from the light of this device.
    pub fn new(device: &wgpu::Device, light: &GpuLight) -> AtlasDecoder {
        use wgpu::BindingType::{Buffer, Sampler, StorageTexture, Texture};
        let buffer = |ty| Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let uniform = buffer(wgpu::BufferBindingType::Uniform);
        let codes = buffer(wgpu::BufferBindingType::Storage { read_only: true });
        let view_dimension = wgpu::TextureViewDimension::D3;
        let access = wgpu::StorageTextureAccess::WriteOnly;
        let written = StorageTexture { access, format: FORMAT, view_dimension };
        let sample_type = wgpu::TextureSampleType::Float { filterable: true };
        let read = Texture { sample_type, view_dimension, multisampled: false };
        let filtering = Sampler(wgpu::SamplerBindingType::Filtering);
        let filled = layout(device, wgpu::ShaderStages::COMPUTE, [uniform, codes, written]);
        let stages = wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::FRAGMENT;
        let sampled = layout(device, stages, [read, filtering, uniform]);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("flb atlas"),
            source: wgpu::ShaderSource::Wgsl((light_wgsl(1) + FILL).into()),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("flb atlas"),
            bind_group_layouts: &[Some(&filled), Some(light.bind_group_layout())],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("flb atlas"),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("decode"),
            compilation_options: Default::default(),
            cache: None,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("flb atlas"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        AtlasDecoder { device: device.clone(), pipeline, filled, sampled, sampler }
    }

    /// Layout of [`Atlas::bind_group`], for the pipelines that include [`atlas_wgsl`].
    pub fn bind_group_layout(&self) -> &wgpu::BindGroupLayout {
        &self.sampled
    }

    /// An atlas for a species, empty until [`AtlasDecoder::fill`].
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`]; [`GpuError::AtlasBudget`] if it takes more than `budget_bytes`.
    pub fn atlas(
        &self,
        light: &GpuLight,
        species: GpuSpeciesId,
        budget_bytes: u64,
    ) -> Result<Atlas, GpuError> {
        let map = &light.shared(species)?.map;
        let layout = Layout::of(map);
        let [width, height, depth_or_array_layers] = layout.texels();
        if layout.bytes() > budget_bytes {
            let (blocks, needed) = (map.len(), layout.bytes());
            return Err(GpuError::AtlasBudget { species, blocks, needed, budget: budget_bytes });
        }
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("flb atlas"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format: FORMAT,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        let codes: Vec<u32> = (0..map.len()).map(|rank| map::encode(map.block(rank))).collect();
        let codes = self.buffer(&codes, wgpu::BufferUsages::STORAGE);
        let fill =
            self.buffer(&fill_fields(species.word(), 0, 0, layout).map(word), wgpu::BufferUsages::UNIFORM);
        let about = self.buffer(&atlas_fields(species.word(), layout).map(word), wgpu::BufferUsages::UNIFORM);
        let texels = wgpu::BindingResource::TextureView(&view);
        let filled = [fill.as_entire_binding(), codes.as_entire_binding(), texels.clone()];
        let sampled = [texels, wgpu::BindingResource::Sampler(&self.sampler), about.as_entire_binding()];
        let [filled, sampled] =
            [(&self.filled, filled), (&self.sampled, sampled)].map(|(layout, resources)| {
                let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
                let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
                let label = Some("flb atlas");
                self.device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout, entries: &entries })
            });
        Ok(Atlas { species, texture, fill, filled, sampled, layout })
    }

    /// Decodes a blend into an atlas as part of the commands of `encoder`: of the terms as they are when it is
    /// submitted.
    pub fn fill(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        queue: &wgpu::Queue,
        light: &GpuLight,
        atlas: &Atlas,
        first_term: u32,
        term_count: u32,
    ) {
        let words = fill_fields(atlas.species.word(), first_term, term_count, atlas.layout).map(word);
        queue.write_buffer(&atlas.fill, 0, bytemuck::cast_slice(&words));
        let bricks = atlas.layout.bricks;
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &atlas.filled, &[]);
        pass.set_bind_group(1, light.bind_group(), &[]);
        pass.dispatch_workgroups(bricks.min(WORKGROUPS), bricks.div_ceil(WORKGROUPS), 1);
    }

    fn buffer(&self, words: &[u32], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        use wgpu::util::DeviceExt;
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("flb atlas"),
            contents: bytemuck::cast_slice(words),
            usage: usage | wgpu::BufferUsages::COPY_DST,
        })
    }
}

impl Atlas {
    /// Bind group of a shader with [`atlas_wgsl`].
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        &self.sampled
    }

    /// Bytes of the atlas's texture.
    pub fn size_bytes(&self) -> u64 {
        self.layout.bytes()
    }

    /// The bricks.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }
}

fn word(field: (&'static str, u32)) -> u32 {
    field.1
}

fn layout(
    device: &wgpu::Device,
    visibility: wgpu::ShaderStages,
    kinds: [wgpu::BindingType; 3],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("flb atlas"),
        entries: &entries,
    })
}
