//! The shaders: WGSL -> pipelines, and the layouts of what they bind.

use flb_render::forest::{InstanceSearch, ModelSearch, Search};
use flb_runtime::gpu::light_wgsl;

/// Group of the light's buffers.
const LIGHT_GROUP: u32 = 3;

const TYPES: &str = include_str!("shaders/types.wgsl");
const RAYS: &str = include_str!("shaders/rays.wgsl");
const MODEL_BY_TREE: &str = include_str!("shaders/model_by_tree.wgsl");
const MODEL_BY_GRID: &str = include_str!("shaders/model_by_grid.wgsl");
const STAND_BY_TREE: &str = include_str!("shaders/stand_by_tree.wgsl");
const VIEW_BY_TREE: &str = include_str!("shaders/view_by_tree.wgsl");
const VIEW_BY_GRID: &str = include_str!("shaders/view_by_grid.wgsl");
const SUN_BY_TREE: &str = include_str!("shaders/sun_by_tree.wgsl");
const SUN_BY_GRID: &str = include_str!("shaders/sun_by_grid.wgsl");
const GROUND: &str = include_str!("shaders/ground.wgsl");
const WATER: &str = include_str!("shaders/water.wgsl");
const TRACE: &str = include_str!("shaders/trace.wgsl");
const SHADE: &str = include_str!("shaders/shade.wgsl");
const LIGHT: &str = include_str!("shaders/light.wgsl");
const ALONE: &str = include_str!("shaders/light_isolated.wgsl");
const AMONG: &str = include_str!("shaders/light_in_scene.wgsl");
const RESOLVE: &str = include_str!("shaders/resolve.wgsl");

/// Which ways rays go.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Ways {
    /// Search structures for what the rays meet.
    pub search: Search,
    /// Whether there is water, which sends rays back: a second search, that a stand without water has no code for.
    pub has_water: bool,
}

/// Name of each stage's entry point, and its source.
pub(crate) fn sources(Ways { search, has_water }: Ways) -> [(&'static str, String); 4] {
    let model = match search.model {
        ModelSearch::Tree => MODEL_BY_TREE,
        ModelSearch::Grid => MODEL_BY_GRID,
    };
    let by = |search: InstanceSearch, [tree, grid]: [&'static str; 2]| match search {
        InstanceSearch::Tree => tree,
        InstanceSearch::Grid => grid,
    };
    let view = by(search.primary, [VIEW_BY_TREE, VIEW_BY_GRID]);
    let sun = by(search.shadow, [SUN_BY_TREE, SUN_BY_GRID]);
    let has_water = format!("const HAS_WATER: bool = {has_water};\n");
    let rays = [TYPES, RAYS, model, STAND_BY_TREE, GROUND, WATER, &has_water].concat();
    [
        ("trace", [&rays, view, TRACE].concat()),
        ("shade", [&rays, sun, SHADE].concat()),
        ("light", [TYPES, &light_wgsl(LIGHT_GROUP), LIGHT, ALONE].concat()),
        ("resolve", [TYPES, RESOLVE].concat()),
    ]
}

/// The same of the stage that takes the place of `light` where plants change each other's.
pub(crate) fn among() -> (&'static str, String) {
    ("light", [TYPES, &light_wgsl(LIGHT_GROUP), LIGHT, AMONG].concat())
}

/// A stage, and the layout of its lights.
pub(crate) struct Among {
    /// Light of species, blends, volumes.
    pub lights: wgpu::BindGroupLayout,
    pub pipeline: wgpu::ComputePipeline,
}

/// The pipelines, and what they bind.
pub(crate) struct Stages {
    /// View, daylight, strip.
    pub frame: wgpu::BindGroupLayout,
    /// The forest itself.
    pub scene: wgpu::BindGroupLayout,
    pub lights: wgpu::BindGroupLayout,
    pub picture: wgpu::BindGroupLayout,
    /// Fragments, and what they are lit to.
    pub rays: wgpu::BindGroupLayout,
    /// The sky as it is drawn.
    pub dome: wgpu::BindGroupLayout,
    pub trace: wgpu::ComputePipeline,
    pub shade: wgpu::ComputePipeline,
    pub light: wgpu::ComputePipeline,
    pub resolve: wgpu::ComputePipeline,
}

#[derive(Clone, Copy)]
enum Kind {
    Uniform,
    /// At an offset that is given anew for every dispatch.
    Moving,
    Read,
    Write,
    Texture,
}

/// Compiles every stage. Errors arrive at the device's handler.
pub(crate) fn compile(device: &wgpu::Device, light: &wgpu::BindGroupLayout, ways: Ways) -> Stages {
    use Kind::{Moving, Read, Texture, Uniform, Write};
    let frame = layout(device, "flb frame", &[Uniform, Uniform, Moving]);
    let scene = layout(device, "flb scene", &[Uniform, Uniform, Read, Read, Read, Read, Read, Read]);
    let lights = layout(device, "flb lights", &[Read]);
    let picture = layout(device, "flb picture", &[Write]);
    let rays = layout(device, "flb rays", &[Write, Write]);
    let dome = layout(device, "flb dome", &[Texture]);
    let [trace, shade, lit, resolve] = sources(ways);
    Stages {
        trace: make(device, &trace, &[&frame, &scene, &rays]),
        shade: make(device, &shade, &[&frame, &scene, &rays, &dome]),
        light: make(device, &lit, &[&frame, &lights, &rays, light]),
        resolve: make(device, &resolve, &[&frame, &picture, &rays]),
        frame,
        scene,
        lights,
        picture,
        rays,
        dome,
    }
}

/// Compiles [`among`], beside layouts of [`Stages`]: those of the frame and of rays.
pub(crate) fn compile_among(
    device: &wgpu::Device,
    light: &wgpu::BindGroupLayout,
    [frame, rays]: [&wgpu::BindGroupLayout; 2],
) -> Among {
    let lights = layout(device, "flb among", &[Kind::Read; 3]);
    let pipeline = make(device, &among(), &[frame, &lights, rays, light]);
    Among { lights, pipeline }
}

fn make(
    device: &wgpu::Device,
    (name, source): &(&'static str, String),
    groups: &[&wgpu::BindGroupLayout],
) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let groups: Vec<_> = groups.iter().copied().map(Some).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(name),
        compilation_options: Default::default(),
        cache: None,
    })
}

fn layout(device: &wgpu::Device, label: &str, kinds: &[Kind]) -> wgpu::BindGroupLayout {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let buffer =
        |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
    let entry = |(binding, kind): (u32, &Kind)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: match kind {
            Kind::Uniform | Kind::Moving => buffer(Uniform, matches!(kind, Kind::Moving)),
            Kind::Read => buffer(Storage { read_only: true }, false),
            Kind::Write => buffer(Storage { read_only: false }, false),
            Kind::Texture => wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
        },
        count: None,
    };
    let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A group of buffers and textures, in order.
pub(crate) fn group(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    buffers: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
