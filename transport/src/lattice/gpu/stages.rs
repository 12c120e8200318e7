//! The shaders: WGSL -> pipelines that share one bind group layout.

use crate::gpu::pipelines;

/// Runs of sites whose sums `measure` forms; `PARTS` of types.wgsl.
pub(super) const PARTS: u32 = 1024;

/// The WGSL of a stage: the shared types before its own file.
macro_rules! wgsl {
    ($file:literal) => {
        concat!(include_str!("types.wgsl"), "\n", include_str!($file))
    };
}

/// Name of the entry point, and source.
pub(super) const SOURCES: [(&str, &str); 3] = [
    ("collide", wgsl!("collide.wgsl")),
    ("measure", wgsl!("measure.wgsl")),
    ("settle", wgsl!("settle.wgsl")),
];

/// The pipelines, and what they bind.
pub(super) struct Stages {
    pub layout: wgpu::BindGroupLayout,
    pub collide: wgpu::ComputePipeline,
    pub measure: wgpu::ComputePipeline,
    pub settle: wgpu::ComputePipeline,
}

/// Compiles every stage. Errors arrive at the device's handler.
pub(super) fn compile(device: &wgpu::Device) -> Stages {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let (read, write) = (Storage { read_only: true }, Storage { read_only: false });
    let kinds = [Uniform, read, read, read, read, read, write, write, write];
    let entries: Vec<wgpu::BindGroupLayoutEntry> = kinds
        .iter()
        .zip(0..)
        .map(|(kind, binding)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: *kind,
                has_dynamic_offset: *kind == Uniform,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    let layout = device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("flb"), entries: &entries });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("flb"),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let [collide, measure, settle] = pipelines::compile(device, SOURCES, Some(&pipeline_layout));
    Stages { layout, collide, measure, settle }
}
