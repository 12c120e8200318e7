//! The shaders: WGSL -> pipelines. Each binds what its file names.

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
pub(super) const SOURCES: [(&str, &str); 9] = [
    ("first", wgsl!("first.wgsl")),
    ("march", wgsl!("march.wgsl")),
    ("gather", wgsl!("gather.wgsl")),
    ("send", wgsl!("send.wgsl")),
    ("arrive", wgsl!("arrive.wgsl")),
    ("step_to", wgsl!("step.wgsl")),
    ("remember", wgsl!("remember.wgsl")),
    ("measure", wgsl!("measure.wgsl")),
    ("mix_light", wgsl!("mix.wgsl")),
];

/// The pipelines.
pub(in crate::ordinates) struct Stages {
    pub first: wgpu::ComputePipeline,
    pub march: wgpu::ComputePipeline,
    pub gather: wgpu::ComputePipeline,
    pub send: wgpu::ComputePipeline,
    pub arrive: wgpu::ComputePipeline,
    pub step: wgpu::ComputePipeline,
    pub remember: wgpu::ComputePipeline,
    pub measure: wgpu::ComputePipeline,
    pub mix: wgpu::ComputePipeline,
}

/// Compiles every stage. Errors arrive at the device's handler.
pub(super) fn compile(device: &wgpu::Device) -> Stages {
    let [first, march, gather, send, arrive, step, remember, measure, mix] =
        pipelines::compile(device, SOURCES, None);
    Stages { first, march, gather, send, arrive, step, remember, measure, mix }
}

/// Binds the parameters, those of an axis where a stage reads them, and the buffers that its file names, in order.
pub(super) fn bind(
    device: &wgpu::Device,
    stage: &wgpu::ComputePipeline,
    params: &wgpu::Buffer,
    axis: Option<wgpu::BufferBinding>,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let params = [(0, params.as_entire_binding())];
    let axis = axis.map(|axis| (1, wgpu::BindingResource::Buffer(axis)));
    let buffers = (2..).zip(buffers.iter().map(|buffer| buffer.as_entire_binding()));
    let entries: Vec<wgpu::BindGroupEntry> = params
        .into_iter()
        .chain(axis)
        .chain(buffers)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("flb"),
        layout: &stage.get_bind_group_layout(0),
        entries: &entries,
    })
}
