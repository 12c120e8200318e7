//! Shaders -> pipelines.

/// Compiles stages, given by the names of their entry points and their WGSL. Without a layout each has its own, of what
/// it binds. Errors arrive at the device's handler.
pub(crate) fn compile<const N: usize>(
    device: &wgpu::Device,
    sources: [(&str, &str); N],
    layout: Option<&wgpu::PipelineLayout>,
) -> [wgpu::ComputePipeline; N] {
    sources.map(|(name, source)| {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout,
            module: &module,
            entry_point: Some(name),
            compilation_options: Default::default(),
            cache: None,
        })
    })
}
