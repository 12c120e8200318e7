//! The bind group of light.wgsl, and its text for any group number.

use super::layout::{BASE_BYTES, MAX_SPECIES, SPECIES_BYTES, TERM_BYTES};

const LIGHT: &str = include_str!("light.wgsl");
const NEAR: &str = include_str!("near.wgsl");
const SKY: &str = include_str!("sky.wgsl");
/// As light.wgsl has it.
const GROUP: &str = "@group(3)";
/// As light.wgsl has it.
const SUMS: &str = "alias FlbReals = vec4<f32>;";
const ENABLE_F16: &str = "enable f16;\n";
const SUMS_F16: &str = "alias FlbReals = vec4<f16>;";

/// The functions that sample light, to be put before a shader of one's own: `flb_sample`, `flb_near`,
/// `flb_sample_near` and `flb_sky`, and what they need, bound to a group.
pub fn light_wgsl(group: u32) -> String {
    LIGHT.replace(GROUP, &format!("@group({group})")) + NEAR + SKY
}

/// [`light_wgsl`] with sums over coefficients in f16, for devices with `wgpu::Features::SHADER_F16`: half the
/// registers, and light that is off by some ten-thousandths of a base's peak (`cargo test -p flb-runtime gpu`). It
/// begins with `enable f16;`, so it has to come first.
pub fn light_wgsl_f16(group: u32) -> String {
    ENABLE_F16.to_owned() + &light_wgsl(group).replace(SUMS, SUMS_F16)
}

/// Species, bases, words and terms, for compute and fragment shaders.
pub(super) fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    use wgpu::BufferBindingType::{Storage, Uniform};
    let storage = Storage { read_only: true };
    let sizes = [u64::from(MAX_SPECIES) * SPECIES_BYTES, BASE_BYTES, 4, TERM_BYTES];
    let entries: Vec<wgpu::BindGroupLayoutEntry> = [Uniform, storage, storage, storage]
        .into_iter()
        .zip(0..)
        .zip(sizes)
        .map(|((ty, binding), size)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: std::num::NonZero::new(size),
            },
            count: None,
        })
        .collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some("flb light"), entries: &entries };
    device.create_bind_group_layout(&descriptor)
}

/// The buffers, in the order of [`layout`].
pub(super) fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: [&wgpu::Buffer; 4],
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry> = buffers
        .iter()
        .zip(0..)
        .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("flb light"),
        layout,
        entries: &entries,
    })
}
