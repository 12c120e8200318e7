//! Runs the functions of light.wgsl over lists, as a renderer's shader would.

use wgpu::util::DeviceExt;

use super::super::{
    Atlas, AtlasDecoder, Gpu, GpuLight, GpuSpeciesId, atlas_wgsl, light_wgsl, light_wgsl_f16,
};

/// Invocations of a workgroup.
const WORKGROUP: u32 = 64;

/// What is asked of a species: the arguments of `flb_sample`, or a base and a component.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ask {
    pub species: GpuSpeciesId,
    pub first: u32,
    pub second: u32,
}

pub(super) const SAMPLES: &str = "
struct Ask { species: u32, first: u32, second: u32, count: u32 }
@group(0) @binding(0) var<uniform> ask: Ask;
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> found: array<vec4<f32>>;
@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x < ask.count {
        found[at.x] = vec4<f32>(flb_sample(ask.species, ask.first, ask.second, points[at.x].xyz), 1.0);
    }
}
";

pub(super) const TEXELS: &str = "
struct Ask { species: u32, first: u32, second: u32, count: u32 }
@group(0) @binding(0) var<uniform> ask: Ask;
@group(0) @binding(1) var<storage, read> unused: array<u32>;
@group(0) @binding(2) var<storage, read_write> found: array<i32>;
@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x < ask.count {
        let local = (vec3<u32>(at.x) >> vec3<u32>(0u, 2u, 4u)) & vec3<u32>(3u);
        found[at.x] = flb_texel(ask.species, ask.first, at.x / 64u, ask.second, local);
    }
}
";

pub(super) fn gpu() -> Gpu {
    // The message says what to install.
    Gpu::open(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}"))
}

/// [`SAMPLES`] with another expression for what is found.
pub(super) fn finding(expression: &str) -> String {
    let sampled = "vec4<f32>(flb_sample(ask.species, ask.first, ask.second, points[at.x].xyz), 1.0)";
    SAMPLES.replace(sampled, expression)
}

/// Light at points of model space.
pub(super) fn samples(gpu: &Gpu, light: &GpuLight, ask: Ask, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let bytes = run(gpu, light, SAMPLES, ask, points.len(), &padded(points), 16);
    colors(&bytes)
}

/// The same by sums in f16, on a device that has it.
pub(super) fn samples_f16(gpu: &Gpu, light: &GpuLight, ask: Ask, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let source = light_wgsl_f16(1) + SAMPLES;
    colors(&run_with(gpu, light, None, &source, ask, points.len(), &padded(points), 16))
}

/// What a shader of the tests' own, with the bindings of [`SAMPLES`], finds for words of four.
pub(super) fn asked(
    gpu: &Gpu,
    light: &GpuLight,
    source: &str,
    ask: Ask,
    input: &[[f32; 4]],
) -> Vec<[f32; 4]> {
    let bytes = run(gpu, light, source, ask, input.len(), bytemuck::cast_slice(input), 16);
    let floats: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|word| f32::from_le_bytes(*word)).collect();
    floats.as_chunks::<4>().0.to_vec()
}

/// Integers of the texels of `blocks` blocks; of `ask`, the index of the base and the component.
pub(super) fn texels(gpu: &Gpu, light: &GpuLight, ask: Ask, blocks: usize) -> Vec<i32> {
    let bytes = run(gpu, light, TEXELS, ask, 64 * blocks, &[0; 4], 4);
    bytes.as_chunks::<4>().0.iter().map(|word| i32::from_le_bytes(*word)).collect()
}

/// Light at points by an atlas.
pub(super) fn atlas_samples(
    gpu: &Gpu,
    light: &GpuLight,
    decoder: &AtlasDecoder,
    atlas: &Atlas,
    points: &[[f32; 3]],
) -> Vec<[f32; 3]> {
    let source = finding("vec4<f32>(flb_sample_atlas(points[at.x].xyz), 1.0)");
    let ask = Ask { species: GpuSpeciesId(0), first: 0, second: 0 };
    let bound = Some((decoder.bind_group_layout(), atlas.bind_group()));
    let bytes =
        run_with(gpu, light, bound, &(atlas_wgsl(1, 2) + &source), ask, points.len(), &padded(points), 16);
    colors(&bytes)
}

fn padded(points: &[[f32; 3]]) -> Vec<u8> {
    let floats: Vec<f32> = points.iter().flat_map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
    bytemuck::cast_slice(&floats).to_vec()
}

fn colors(bytes: &[u8]) -> Vec<[f32; 3]> {
    let floats: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|word| f32::from_le_bytes(*word)).collect();
    floats.as_chunks::<4>().0.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect()
}

fn run(
    gpu: &Gpu,
    light: &GpuLight,
    source: &str,
    ask: Ask,
    count: usize,
    input: &[u8],
    output_bytes: usize,
) -> Vec<u8> {
    run_with(gpu, light, None, &(light_wgsl(1) + source), ask, count, input, output_bytes)
}

#[allow(clippy::too_many_arguments, reason = "one call of each of two kinds")]
fn run_with(
    gpu: &Gpu,
    light: &GpuLight,
    atlas: Option<(&wgpu::BindGroupLayout, &wgpu::BindGroup)>,
    source: &str,
    ask: Ask,
    count: usize,
    input: &[u8],
    output_bytes: usize,
) -> Vec<u8> {
    let device = &gpu.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("probe"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let kinds = [
        wgpu::BufferBindingType::Uniform,
        wgpu::BufferBindingType::Storage { read_only: true },
        wgpu::BufferBindingType::Storage { read_only: false },
    ];
    let entries: Vec<_> = (0..)
        .zip(kinds)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    let layout =
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[
            Some(&layout),
            Some(light.bind_group_layout()),
            atlas.map(|(layout, _)| layout),
        ],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("probe"),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("probe"),
        compilation_options: Default::default(),
        cache: None,
    });
    let made = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let words = [ask.species.word(), ask.first, ask.second, count as u32];
    let found =
        made(&vec![0xA5; count * output_bytes], wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let buffers = [
        made(bytemuck::cast_slice(&words), wgpu::BufferUsages::UNIFORM),
        made(input, wgpu::BufferUsages::STORAGE),
        found.clone(),
    ];
    let entries: Vec<_> = (0..)
        .zip(&buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &entries,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.set_bind_group(1, light.bind_group(), &[]);
    if let Some((_, group)) = atlas {
        pass.set_bind_group(2, group, &[]);
    }
    pass.dispatch_workgroups((count as u32).div_ceil(WORKGROUP), 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    gpu.read(&found).unwrap_or_else(|error| panic!("{error}"))
}
