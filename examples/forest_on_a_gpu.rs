//! A day in a forest whose light is in one buffer of a GPU: plants come and go, the sun moves, and a shader asks for
//! the light of every plant by one function.
//!
//! `cargo run -p flb-examples --bin forest_on_a_gpu [FILE.flb]`; without a file it takes the shrub of the tests.
#![forbid(unsafe_code)]

use std::error::Error;
use std::sync::Arc;

use flb_format::sun::towards_sun;
use flb_runtime::forest::{BufferSettings, Forest, ForestBuffer, ForestSettings, PlantId, Work};
use flb_runtime::light::volume_words;
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, Library, Placement, Transform};
use wgpu::util::DeviceExt;

const SHRUB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../runtime-loader/golden/shrub.flb");

const PLANTS: u32 = 60;
const FRAMES: u32 = 200;
/// Frames from report to report.
const HOUR: u32 = 40;
const POINT_M: [f32; 3] = [0.2, 0.8, 0.1];

/// An engine's own shader, behind `volume_words::WGSL`: here it asks for one point of each plant, where a renderer asks
/// for those of vertices or pixels.
const SHADER: &str = "
@group(0) @binding(1) var<storage, read> plants: array<u32>;
@group(0) @binding(2) var<storage, read_write> light: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x < arrayLength(&plants) {
        light[at.x] = vec4<f32>(flb_light(0u, plants[at.x], POINT_M), 1.0);
    }
}
";

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| SHRUB.to_owned());
    let library = Arc::new(Library::open(&path)?);
    let sizes = BufferSettings { max_plants: PLANTS, ..BufferSettings::default() };
    // No more volumes than the buffer has room for.
    let max_volume_bytes = sizes.max_volume_bytes();
    let settings = ForestSettings { blend_frames: 20, max_volume_bytes, ..ForestSettings::default() };
    let mut forest = Forest::new(library, settings)?;
    let mut plants = (0..PLANTS).map(|number| forest.add(&stands(number))).collect::<Result<Vec<_>, _>>()?;
    let (gpu, mut buffer) = (Gpu::new(sizes.bytes)?, ForestBuffer::new(sizes));
    for frame in 0..FRAMES {
        // A plant goes, another comes.
        let oldest = (frame / 4) as usize % plants.len();
        if frame % 4 == 0 && forest.remove(plants[oldest]) {
            plants[oldest] = forest.add(&stands(PLANTS + frame))?;
        }
        // An engine lets its threads run the work; here it is done at once.
        forest.frame(&camera(frame), &morning(frame), Work::run);
        let snapshot = forest.snapshot();
        let followed = buffer.follow(&snapshot, |offset_bytes, words| {
            gpu.queue.write_buffer(&gpu.light, offset_bytes, bytemuck::cast_slice(words));
        });
        if frame % HOUR == HOUR - 1 {
            let found = gpu.ask(&plants)?;
            let mut rgb = [0.0; 3];
            let mut apart = 0.0_f32;
            for (found, plant) in found.iter().zip(&plants) {
                snapshot.at(*plant, POINT_M, &mut rgb);
                apart = found.iter().zip(rgb).fold(apart, |most, (gpu, cpu)| most.max((gpu - cpu).abs()));
            }
            let mean = |band: usize| found.iter().map(|rgb| rgb[band]).sum::<f32>() / PLANTS as f32;
            if followed.lacking_bytes > 0 {
                eprintln!("frame {frame}: the buffer lacks {} bytes", followed.lacking_bytes);
            }
            println!(
                "frame {frame}: {} bytes written, {apart:.4} from the CPU at most, light {:.3?}",
                followed.written_bytes,
                [0, 1, 2].map(mean)
            );
        }
    }
    Ok(())
}

/// A place in the forest.
fn stands(number: u32) -> Placement {
    let (angle, away_m) = (2.4 * f64::from(number), 1.5 * f64::from(number % PLANTS).sqrt());
    let (sin, cos) = libm::sincos(angle);
    let yaw_deg = 77.0 * f64::from(number) % 360.0;
    Placement { species: 0, transform: Transform::from_yaw([away_m * cos, 0.0, away_m * sin], yaw_deg, 1.0) }
}

/// The sun rises.
fn morning(frame: u32) -> Daylight {
    let part = f64::from(frame) / f64::from(FRAMES);
    let up = 0.2 + 0.8 * part as f32;
    Daylight { towards_sun: towards_sun(90.0 + 60.0 * part, 5.0 + 40.0 * part), sun: up, sky: 0.4 * up }
}

fn camera(frame: u32) -> Camera {
    let forward = towards_sun(f64::from(frame), 0.0).map(|c| c as f32);
    let (position_m, up) = ([0.0, 1.7, 0.0], [0.0, 1.0, 0.0]);
    Camera { position_m, forward, up, fov_deg: 60.0, width_px: 1280, height_px: 720 }
}

/// What an engine has of its own.
struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::ComputePipeline,
    light: wgpu::Buffer,
}

impl Gpu {
    fn new(bytes: u64) -> Result<Gpu, Box<dyn Error>> {
        let instance = wgpu::Instance::default();
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
        let [x, y, z] = POINT_M;
        let point = format!("const POINT_M = vec3<f32>({x:?}, {y:?}, {z:?});\n");
        let source = wgpu::ShaderSource::Wgsl((volume_words::WGSL.to_owned() + &point + SHADER).into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let light = wgpu::BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false };
        Ok(Gpu { light: device.create_buffer(&light), device, queue, pipeline })
    }

    /// Light of plants, read back.
    fn ask(&self, plants: &[PlantId]) -> Result<Vec<[f32; 3]>, Box<dyn Error>> {
        let numbers: Vec<u32> = plants.iter().map(|plant| plant.number()).collect();
        let made = |contents: &[u8], usage| {
            let descriptor = wgpu::util::BufferInitDescriptor { label: None, contents, usage };
            self.device.create_buffer_init(&descriptor)
        };
        let (storage, copied) = (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::COPY_SRC);
        let asked = made(bytemuck::cast_slice(&numbers), storage);
        let found = made(&vec![0; 16 * plants.len()], storage | copied);
        let read =
            made(&vec![0; 16 * plants.len()], wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let entries: Vec<_> = (0..)
            .zip([&self.light, &asked, &found])
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let layout = self.pipeline.get_bind_group_layout(0);
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries };
        let group = self.device.create_bind_group(&descriptor);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((plants.len() as u32).div_ceil(64), 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&found, 0, &read, 0, read.size());
        self.queue.submit([encoder.finish()]);
        let (sender, mapped) = std::sync::mpsc::channel();
        read.map_async(wgpu::MapMode::Read, .., move |result| drop(sender.send(result)));
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        mapped.recv()??;
        let bytes = read.slice(..).get_mapped_range()?;
        let light: &[[f32; 4]] = bytemuck::cast_slice(&bytes);
        Ok(light.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect())
    }
}
