//! Price of a sample of light on a GPU, coded and uncoded side by side:
//! `cargo bench -p flb-runtime --bench gpu [-- FILE.flb]`.
//!
//! A blend of four bases at 262,144 points, as a picture meets them (squares of neighbours at the first matter along z)
//! and anywhere in the plant. 16 instances, neighbours in blocks of 4,096 points or anyhow, have their own terms of the
//! same bases. Ways take turns; the best of several rounds counts, waiting for the GPU included. An atlas holds one
//! blend for all of them. Without a file a crown by formula is packed.

#[path = "../plant/mod.rs"]
mod plant;

use std::sync::Arc;
use std::time::Instant;

use flb_runtime::gpu::{
    AtlasDecoder, Gpu, GpuLight, GpuSpeciesId, LightSettings, Term, atlas_wgsl, light_wgsl, light_wgsl_f16,
};
use plant::{BASES, POINTS, Plant, interleaved};
use wgpu::util::DeviceExt;

const INSTANCES: usize = 16;
const ROUNDS: usize = 7;
/// Between a way's light and the coded one, relative to the brightest.
const ALIKE: f32 = 0.01;

const CODED: &str = "fn light_at(first_term: u32, point: vec3<f32>) -> vec3<f32> {
    return flb_sample(ask.species, first_term, 4u, point);
}";

/// A way to take the light at points.
struct Way {
    name: &'static str,
    bytes: u64,
    pipeline: wgpu::ComputePipeline,
    group: Option<wgpu::BindGroup>,
    /// Whether it takes the instances' own blends, so that its light can be held against the coded one.
    has_blends: bool,
}

struct Bench {
    gpu: Gpu,
    light: GpuLight,
    species: GpuSpeciesId,
    plant: Plant,
    layout: wgpu::BindGroupLayout,
    found: wgpu::Buffer,
}

fn main() {
    let file = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let plant = file.map_or_else(Plant::made, |path| Plant::read(&path));
    let mut bench = Bench::new(plant);
    let mut ways = vec![bench.coded(), bench.volumes()];
    ways.extend(bench.textures());
    ways.extend(bench.coded_f16());
    ways.push(bench.atlas());
    println!("adapter: {}", bench.gpu.name);
    let plant = &bench.plant;
    let blocks = plant.bases[0].shared().map.len();
    println!("plant: {}, lattice {}, {blocks} blocks, {BASES} bases", plant.name, plant.grid.lattice);
    println!(
        "{:34} {:>9} {:>12} {:>7} {:>12} {:>7}",
        "way", "MB", "picture M/s", "ratio", "random M/s", "ratio"
    );
    let [picture, random] =
        [(plant.sweep(), 4096), (plant.scattered(), 1)].map(|(p, run)| bench.time(&ways, &p, run));
    for (i, way) in ways.iter().enumerate() {
        let rate = |seconds: &[f64]| POINTS as f64 / seconds[i] / 1e6;
        let ratio = |seconds: &[f64]| seconds[i] / seconds[1];
        let megabytes = way.bytes as f64 / 1e6;
        println!(
            "{:34} {megabytes:9.2} {:12.2} {:7.2} {:12.2} {:7.2}",
            way.name,
            rate(&picture),
            ratio(&picture),
            rate(&random),
            ratio(&random)
        );
    }
    let (bases, bytes) = bench.add_rest();
    println!("all {bases} bases of the species take {:.2} MB on the GPU", bytes as f64 / 1e6);
    println!("ratio: time over that of uncoded f32 in a storage buffer");
}

impl Bench {
    fn new(plant: Plant) -> Bench {
        let wanted = wgpu::Features::FLOAT32_FILTERABLE | wgpu::Features::SHADER_F16;
        let gpu = Gpu::open(wanted).unwrap_or_else(|error| panic!("{error}"));
        let settings = LightSettings { budget_bytes: 64 << 20, ..LightSettings::default() };
        let mut light = GpuLight::new(&gpu.device, &gpu.queue, settings).expect("a sound budget");
        let shared = Arc::new(plant.bases[0].shared().clone());
        let species = light.add_species(&plant.grid, &shared).expect("it fits");
        for (number, base) in (0..).zip(&plant.bases) {
            assert_eq!(light.set_base(species, number, base), Ok(u32::from(number)));
        }
        let factor = |i: usize| 0.1 + (i * 7 % 11) as f32 / 20.0;
        let term = |i| Term { base: (i % BASES) as u32, factor: factor(i) };
        let terms: Vec<Term> = (0..INSTANCES * BASES).map(term).collect();
        light.set_terms(0, &terms).expect("it fits");
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let found = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("found"),
            size: 16 * POINTS as u64,
            usage,
            mapped_at_creation: false,
        });
        let layout = layout(&gpu.device, &[buffer(true), buffer(false), writable()]);
        Bench { gpu, light, species, plant, layout, found }
    }

    fn way(
        &self,
        name: &'static str,
        bytes: u64,
        source: &str,
        bound: Option<(&wgpu::BindGroupLayout, wgpu::BindGroup)>,
    ) -> Way {
        self.way_of(name, bytes, light_wgsl(2) + source, bound)
    }

    fn way_of(
        &self,
        name: &'static str,
        bytes: u64,
        source: String,
        bound: Option<(&wgpu::BindGroupLayout, wgpu::BindGroup)>,
    ) -> Way {
        let source = source + include_str!("sweep.wgsl");
        let device = &self.gpu.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layouts =
            [Some(&self.layout), bound.as_ref().map(|(l, _)| *l), Some(self.light.bind_group_layout())];
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("sweep"),
            compilation_options: Default::default(),
            cache: None,
        });
        Way { name, bytes, pipeline, group: bound.map(|(_, group)| group), has_blends: true }
    }

    fn coded(&self) -> Way {
        let bytes = self.light.species_bytes(self.species).expect("it is there");
        self.way("coded, storage buffers", bytes, CODED, None)
    }

    /// Where the device has it.
    fn coded_f16(&self) -> Option<Way> {
        let has_f16 = self.gpu.device.features().contains(wgpu::Features::SHADER_F16);
        let bytes = self.light.species_bytes(self.species).expect("it is there");
        has_f16.then(|| self.way_of("coded, sums in f16", bytes, light_wgsl_f16(2) + CODED, None))
    }

    /// Bases of the species, and what they take together.
    fn add_rest(&mut self) -> (usize, u64) {
        for (number, base) in (BASES as u8..).zip(&self.plant.rest) {
            self.light.set_base(self.species, number, &base.1).expect("it fits");
        }
        let bytes = self.light.species_bytes(self.species).expect("it is there");
        (BASES + self.plant.rest.len(), bytes)
    }

    /// Prints how long it takes to fill.
    fn atlas(&self) -> Way {
        let decoder = AtlasDecoder::new(&self.gpu.device, &self.light);
        let atlas = decoder.atlas(&self.light, self.species, 512 << 20).expect("it fits");
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let start = Instant::now();
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            decoder.fill(&mut encoder, &self.gpu.queue, &self.light, &atlas, 0, BASES as u32);
            self.gpu.queue.submit([encoder.finish()]);
            self.gpu.wait().unwrap_or_else(|error| panic!("{error}"));
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!("an atlas is filled in {:.1} ms", 1000.0 * best);
        let source = atlas_wgsl(2, 1).replace(&light_wgsl(2), "")
            + "fn light_at(first_term: u32, point: vec3<f32>) -> vec3<f32> {
                return flb_sample_atlas(point);
            }";
        let bound = (decoder.bind_group_layout(), atlas.bind_group().clone());
        let way = self.way("atlas, 3D texture of bricks", atlas.size_bytes(), &source, Some(bound));
        Way { has_blends: false, ..way }
    }

    fn volumes(&self) -> Way {
        let texels: Vec<f32> = self.plant.bases.iter().flat_map(|base| interleaved(base, 3)).collect();
        let contents: &[u8] = bytemuck::cast_slice(&texels);
        let usage = wgpu::BufferUsages::STORAGE;
        let device = &self.gpu.device;
        let volumes =
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage });
        let layout = layout(device, &[buffer(false)]);
        let group = group(device, &layout, &[volumes.as_entire_binding()]);
        let bytes = contents.len() as u64;
        self.way("uncoded f32, storage buffer", bytes, include_str!("volumes.wgsl"), Some((&layout, group)))
    }

    fn textures(&self) -> Vec<Way> {
        let device = &self.gpu.device;
        let mut formats = vec![("uncoded rgba16float, 3D textures", wgpu::TextureFormat::Rgba16Float)];
        if device.features().contains(wgpu::Features::FLOAT32_FILTERABLE) {
            formats.push(("uncoded rgba32float, 3D textures", wgpu::TextureFormat::Rgba32Float));
        }
        formats.into_iter().map(|(name, format)| self.texture(name, format)).collect()
    }

    fn texture(&self, name: &'static str, format: wgpu::TextureFormat) -> Way {
        let (device, n) = (&self.gpu.device, self.plant.grid.lattice);
        let mut total = 0;
        let views: Vec<wgpu::TextureView> = self
            .plant
            .bases
            .iter()
            .map(|base| {
                let texels = interleaved(base, 4);
                let halves: Vec<u16> = texels.iter().map(|value| half(*value)).collect();
                let data: &[u8] = match format {
                    wgpu::TextureFormat::Rgba16Float => bytemuck::cast_slice(&halves),
                    _ => bytemuck::cast_slice(&texels),
                };
                total += data.len() as u64;
                let size = wgpu::Extent3d { width: n, height: n, depth_or_array_layers: n };
                let descriptor = wgpu::TextureDescriptor {
                    label: None,
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D3,
                    format,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING,
                    view_formats: &[],
                };
                let order = wgpu::util::TextureDataOrder::LayerMajor;
                let texture = device.create_texture_with_data(&self.gpu.queue, &descriptor, order, data);
                texture.create_view(&Default::default())
            })
            .collect();
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D3,
            multisampled: false,
        };
        let filtering = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let layout = layout(device, &[texture, texture, texture, texture, filtering]);
        let mut resources: Vec<_> = views.iter().map(wgpu::BindingResource::TextureView).collect();
        resources.push(wgpu::BindingResource::Sampler(&sampler));
        let group = group(device, &layout, &resources);
        self.way(name, total, include_str!("textures.wgsl"), Some((&layout, group)))
    }

    /// Seconds of each way, the best of several rounds in turns. `run` points that follow one another are of one
    /// instance.
    fn time(&self, ways: &[Way], points: &[[f32; 3]], run: usize) -> Vec<f64> {
        let device = &self.gpu.device;
        let first_term = |i: usize| (i / run * 5 % INSTANCES * BASES) as u32;
        let padded: Vec<f32> = points
            .iter()
            .enumerate()
            .flat_map(|(i, [x, y, z])| [*x, *y, *z, f32::from_bits(first_term(i))])
            .collect();
        let ask = [self.species.word(), self.plant.grid.lattice, points.len() as u32, 0];
        let make = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let ask = make(bytemuck::cast_slice(&ask), wgpu::BufferUsages::UNIFORM);
        let points = make(bytemuck::cast_slice(&padded), wgpu::BufferUsages::STORAGE);
        let resources = [&ask, &points, &self.found].map(wgpu::Buffer::as_entire_binding);
        let group = group(device, &self.layout, &resources);
        let mut best = vec![f64::INFINITY; ways.len()];
        let mut coded = Vec::new();
        for round in 0..ROUNDS {
            for (way, best) in ways.iter().zip(&mut best) {
                let start = Instant::now();
                let mut encoder = device.create_command_encoder(&Default::default());
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&way.pipeline);
                pass.set_bind_group(0, &group, &[]);
                if let Some(group) = &way.group {
                    pass.set_bind_group(1, group, &[]);
                }
                pass.set_bind_group(2, self.light.bind_group(), &[]);
                pass.dispatch_workgroups((POINTS / 64) as u32, 1, 1);
                drop(pass);
                self.gpu.queue.submit([encoder.finish()]);
                self.gpu.wait().unwrap_or_else(|error| panic!("{error}"));
                *best = best.min(start.elapsed().as_secs_f64());
                if round == 0 && way.has_blends {
                    self.check(way, &mut coded);
                }
            }
        }
        best
    }

    /// All ways give the light that the first gave.
    fn check(&self, way: &Way, coded: &mut Vec<f32>) {
        let bytes = self.gpu.read(&self.found).unwrap_or_else(|error| panic!("{error}"));
        let found: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
        if coded.is_empty() {
            coded.clone_from(&found);
        }
        let peak = coded.iter().fold(0.0f32, |peak, value| peak.max(value.abs()));
        let worst = found.iter().zip(coded).fold(0.0f32, |worst, (a, b)| worst.max((a - *b).abs()));
        assert!(worst <= ALIKE * peak, "{}: differs by {worst} of {peak}", way.name);
    }
}

/// The binary16 nearest to a value that is within its range; what is below its normal numbers is 0.
fn half(value: f32) -> u16 {
    let bits = value.to_bits() + 0x1000;
    let (sign, exponent) = ((bits >> 16 & 0x8000) as u16, (bits >> 23 & 255) as i32 - 112);
    if exponent <= 0 { sign } else { sign | (exponent as u16) << 10 | (bits >> 13 & 0x3FF) as u16 }
}

fn buffer(uniform: bool) -> wgpu::BindingType {
    let storage = wgpu::BufferBindingType::Storage { read_only: true };
    let ty = if uniform { wgpu::BufferBindingType::Uniform } else { storage };
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

fn writable() -> wgpu::BindingType {
    let ty = wgpu::BufferBindingType::Storage { read_only: false };
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

fn layout(device: &wgpu::Device, kinds: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty): (u32, &wgpu::BindingType)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: *ty,
        count: None,
    };
    let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}
