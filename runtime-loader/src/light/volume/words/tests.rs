//! The shaders in every language are made from the one in WGSL, and that one has the light of the volume.

use std::path::Path;

use flb_format::light::SunBasis;
use flb_format::{Codec, Transform};
use naga::back::{glsl, hlsl, msl};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use wgpu::util::DeviceExt;

use super::super::channels::Channels;
use super::*;
use crate::gpu::Gpu;
use crate::plants::{noise, plant};
use crate::{Daylight, SpeciesLight};

/// Set to write the shaders anew.
const WRITE: &str = "FLB_WRITE_SHADERS";

fn module(source: &str) -> (naga::Module, ModuleInfo) {
    let module =
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    // What every device of WebGPU can do.
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    let info = validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    (module, info)
}

fn in_hlsl() -> String {
    let (module, info) = module(WGSL);
    let (mut text, options) = (String::new(), hlsl::Options::default());
    let pipeline = hlsl::PipelineOptions::default();
    let mut writer = hlsl::Writer::new(&mut text, &options, &pipeline);
    writer.write(&module, &info, None).expect("HLSL has all of it");
    text
}

fn in_msl() -> String {
    let (module, info) = module(WGSL);
    let options = msl::Options { lang_version: (2, 0), ..Default::default() };
    msl::write_string(&module, &info, &options, &msl::PipelineOptions::default())
        .expect("Metal has all of it")
        .0
}

fn in_glsl() -> String {
    let asks = "@fragment fn main(@location(0) point_m: vec3<f32>) -> @location(0) vec4<f32> {
        return vec4<f32>(flb_light(0u, 0u, point_m), 1.0);
    }";
    let (module, info) = module(&format!("{WGSL}{asks}"));
    // Vulkan's GLSL wants a binding.
    let binding_map = [(naga::ResourceBinding { group: 0, binding: 0 }, 0)].into();
    let options = glsl::Options { version: glsl::Version::Desktop(450), binding_map, ..Default::default() };
    let pipeline = glsl::PipelineOptions {
        shader_stage: naga::ShaderStage::Fragment,
        entry_point: "main".to_owned(),
        multiview: None,
    };
    let mut text = String::new();
    let policies = naga::proc::BoundsCheckPolicies::default();
    let writer = glsl::Writer::new(&mut text, &module, &info, &options, &pipeline, policies);
    writer.expect("GLSL has all of it").write().expect("GLSL has all of it");
    text
}

#[test]
fn shaders_in_other_languages_are_those_in_wgsl() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let made =
        [("volume.hlsl", in_hlsl(), HLSL), ("volume.metal", in_msl(), MSL), ("volume.glsl", in_glsl(), GLSL)];
    for (name, text, kept) in made {
        let head = "// Made from src/light/volume/volume.wgsl by naga; FLB_WRITE_SHADERS=1 cargo test -p flb-runtime\n";
        // GLSL wants its version first.
        let text = match text.split_once('\n') {
            Some((first, rest)) if first.starts_with("#version") => format!("{first}\n{head}{rest}"),
            _ => format!("{head}{text}"),
        };
        if std::env::var_os(WRITE).is_some() {
            std::fs::write(folder.join(name), &text).expect("a file");
        } else {
            assert!(text == kept, "{name} is out of date: {WRITE}=1 writes it anew");
        }
        assert!(text.contains("flb_volume(") && text.contains("flb_light("), "{name}");
    }
}

const PROBE: &str = "
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> found: array<vec4<f32>>;
@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x < arrayLength(&points) {
        let point = points[at.x].xyz;
        let number = bitcast<u32>(points[at.x].w);
        found[at.x] = vec4<f32>(LIGHT, 1.0);
    }
}
";

/// Light at points, each with a number, as a renderer's shader has it by an expression of `point` and `number`.
pub(crate) fn on_gpu(words: &[u32], points: &[[f32; 4]], light: &str) -> Vec<[f32; 3]> {
    let gpu = Gpu::open(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}"));
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl((WGSL.to_owned() + &PROBE.replace("LIGHT", light)).into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("probe"),
        compilation_options: Default::default(),
        cache: None,
    });
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    let made = |contents: &[u8]| {
        gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let found = made(&vec![0xA5; 16 * points.len()]);
    let buffers = [made(bytemuck::cast_slice(words)), made(bytemuck::cast_slice(points)), found.clone()];
    let entries: Vec<_> = (0..)
        .zip(&buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    let layout = pipeline.get_bind_group_layout(0);
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &entries,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups((points.len() as u32).div_ceil(64), 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read(&found).unwrap_or_else(|error| panic!("{error}"));
    let floats: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|word| f32::from_le_bytes(*word)).collect();
    floats.as_chunks::<4>().0.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect()
}

#[test]
fn a_gpu_finds_the_light_of_volumes_wherever_they_lie_in_a_buffer() {
    let harmonics = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
    let kinds = [(Some(&harmonics), 32), (None, 16), (Some(&SunBasis::Lattice18), 64)];
    let day = Daylight { towards_sun: [0.6, 0.5, -0.62], sun: 1.3, sky: 0.2 };
    // Something lies before them.
    let (mut words, mut volumes) = (vec![7; 5], Vec::new());
    for (suns, lattice) in kinds {
        let library = crate::plants::library(&[plant("oak", suns, lattice, 7)], Codec::Classed);
        let species = SpeciesLight::load(&library, 0).expect("a sound file");
        let lit = species.lit_by(&day, &Transform::IDENTITY).expect("a sun").prepared();
        let volume = lit.volume().expect("blocks near geometry");
        let own = volume.words().expect("three bands");
        assert_eq!((own[0], own[1]), (VERSION, lattice));
        volumes.push((words.len() as u32, volume));
        words.extend(own);
    }
    let (mut points, mut expected) = (Vec::new(), Vec::new());
    for (number, (first, volume)) in (0_u32..).zip(&volumes) {
        for seed in 0..3000 {
            // All over the lattice, and outside of it.
            let along = |axis: u32| 5.0 * noise(seed * 3 + axis, 5 + number) - 2.5;
            let [x, y, z] = [along(0), along(1) + 2.0, along(2)];
            points.push([x, y, z, f32::from_bits(*first)]);
            let mut rgb = [0.0; 3];
            volume.at([x, y, z], &mut rgb);
            expected.push(rgb);
        }
    }
    for ((found, expected), point) in
        on_gpu(&words, &points, "flb_volume(number, point)").iter().zip(&expected).zip(&points)
    {
        for (found, expected) in found.iter().zip(expected) {
            // Places are rounded to f32 from the lattice's middle on.
            assert!(
                (found - expected).abs() < 2e-3 * (1.0 + expected.abs()),
                "{point:?}: {found} {expected}"
            );
        }
    }
}

#[test]
fn missing_bands_are_dark_and_more_than_three_have_no_words() {
    let library = crate::plants::library(&[plant("oak", None, 16, 7)], Codec::Classed);
    let species = SpeciesLight::load(&library, 0).expect("a sound file");
    let shared = species.resident().shared().expect("a map");
    let volume = |bands: usize| {
        let value = |at: usize| 1.0 + at as f32;
        let fill = |_, out: &mut [f32]| out.iter_mut().enumerate().for_each(|(at, out)| *out = value(at));
        let channels = Channels::fill(std::sync::Arc::clone(shared), bands, fill);
        let channels = channels.with_coarse(|_, out| out.fill(0.5));
        LightVolume { grid: *species.grid(), is_bounded: true, channels }
    };
    assert!(volume(4).words().is_none());
    let words = volume(1).words().expect("one band");
    let [ranges, codes] = [7, 8].map(|at| words[at] as usize);
    let (least, step) = (words[ranges], words[ranges + 3]);
    assert_eq!((f32::from_bits(least), f32::from_bits(step)), (1.0, 63.0 / 255.0));
    assert_eq!([1, 2, 4, 5].map(|at| words[ranges + at]), [0; 4]);
    assert_eq!((words[codes], words[codes + 63]), (0, 255));
}
