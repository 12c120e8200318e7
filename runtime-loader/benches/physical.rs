//! Price of a sample of `physical` light: `cargo bench -p flb-runtime --bench physical`.
//!
//! An oak grown by code, leaves taken as half of their area per volume, at lattices of 64 and 128 sites; three bands,
//! harmonics of degree 2 with and without the light scattered once, fields coded with a threshold of 0.001. Prints ns
//! per sample, with the near beam prepared and with 1, 4 and 16 offsets marched, ms to prepare a sun, and bytes in
//! memory. Its fields are made up, so how far marches are off is for `cargo bench -p flb-tests --bench grain` to say.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use flb_fixtures::{Plant, PlantKind};
use flb_format::beam::BEAM_RAYS;
use flb_format::light::{Light, SunBasis};
use flb_format::matter::{BandSurfaces, Class, LeafAngles, LeafSurface, Surfaces, TurbidMedium, WoodSurface};
use flb_format::meta::{Bounds, TriangleCounts};
use flb_format::model::Model;
use flb_format::{Field, Grid, Medium, SpeciesFields, SpeciesMeta};
use flb_packer::{EncodeSettings, encode_species, write_library_to};
use flb_runtime::Library;
use flb_runtime::samplers::PhysicalSampler;
use flb_testkit::model::scattered;

const POINTS: usize = 2048;
const TOWARDS_SUN: [f64; 3] = [0.48, 0.6, -0.64];

/// Leaf and wood area of the plant's triangles, spread over the sites that points of each triangle lie in.
fn grown(lattice: u32) -> (Medium, TurbidMedium) {
    let plant = flb_fixtures::grow(PlantKind::Oak, 1, 80_000).expect("an oak of 80,000 triangles");
    let grid = grid_around(&plant, lattice);
    let mut area = [vec![0.0_f32; grid.sites()], vec![0.0_f32; grid.sites()]];
    for part in &plant.parts {
        let area = &mut area[usize::from(part.material.name == "bark")];
        for triangle in &part.triangles {
            let [a, b, c] = triangle.map(|i| part.positions[i as usize]);
            let (u, v): ([f32; 3], [f32; 3]) =
                (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
            let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let whole = cross.iter().map(|c| c * c).sum::<f32>().sqrt() / 2.0;
            const STEPS: usize = 16;
            for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS - i).map(move |j| (i, j))) {
                let (s, t) = ((i as f32 + 0.33) / STEPS as f32, (j as f32 + 0.33) / STEPS as f32);
                let point = std::array::from_fn(|axis| f64::from(a[axis] + s * u[axis] + t * v[axis]));
                let [x, y, z] = grid.lattice_from_model(point).map(|c| c as u32);
                area[grid.index(x, y, z)] += whole / (STEPS * (STEPS + 1) / 2) as f32;
            }
        }
    }
    let volume = (grid.spacing_m * grid.spacing_m * grid.spacing_m) as f32;
    let per_volume = area.map(|area| area.iter().map(|a| a / volume).collect::<Vec<f32>>());
    let [leaf_area_density, wood_area_density] = per_volume;
    let density: Vec<f32> = leaf_area_density
        .iter()
        .zip(&wood_area_density)
        .map(|(l, w)| if l + w > 0.0 { 0.5 } else { 0.0 })
        .collect();
    let class = density.iter().map(|d| if *d > 0.0 { Class::Leaf } else { Class::Empty }).collect();
    let turbid = TurbidMedium {
        grid,
        leaf_per_m: leaf_area_density.iter().map(|area| area / 2.0).collect(),
        wood_per_m: wood_area_density.iter().map(|area| area / 4.0).collect(),
        angles: LeafAngles::planophile(),
    };
    (Medium { grid, density, class, leaf_area_density, wood_area_density }, turbid)
}

/// Two empty layers all around.
fn grid_around(plant: &Plant, lattice: u32) -> Grid {
    let (low, high) = plant.bounds();
    let extent = (0..3).map(|axis| f64::from(high[axis] - low[axis])).fold(0.0, f64::max);
    let spacing_m = extent / f64::from(lattice - 5);
    let origin_m = std::array::from_fn(|axis| f64::from(low[axis]) - 2.5 * spacing_m);
    Grid { lattice, origin_m, spacing_m }
}

/// Fields that fall off from above, a little rough.
fn library(lattice: u32, single: bool) -> Library {
    let (medium, turbid) = grown(lattice);
    let suns = SunBasis::Harmonics { degree: 2, single, leaning: true };
    let n = lattice as usize;
    let field = |base: u8| {
        let mut field = Field::zeros(lattice, 3);
        for (i, value) in field.values_mut().iter_mut().enumerate() {
            let noise = (i.wrapping_mul(2_654_435_761) >> 7 & 255) as f32 / 255.0;
            let height = (i / n % n) as f32 / n as f32;
            *value = if medium.density[i % (n * n * n)] > 0.0 { height * (0.5 + 0.1 * noise) } else { 0.3 }
                / f32::from(1 + base);
        }
        (base, field)
    };
    let light = Light { ordinates: 50, ..scattered(&suns, &turbid) };
    let band = |name: &str| BandSurfaces {
        name: name.to_owned(),
        leaf: LeafSurface { reflectance: 0.1, transmittance: 0.1 },
        wood: WoodSurface { reflectance: 0.2 },
    };
    let meta = SpeciesMeta {
        name: "oak".to_owned(),
        model: Model::Physical { surfaces: Surfaces { bands: ["R", "G", "B"].map(band).to_vec() }, light },
        grid: medium.grid,
        bounds_m: Bounds { min: [0.0; 3], max: [0.0; 3] },
        triangles: TriangleCounts::default(),
        mesh_blake3: None,
        mean_light: None,
        sky_averages: None,
        sources: Vec::new(),
        settings: Default::default(),
        tool: "bench".to_owned(),
        left_out: None,
        extra: Default::default(),
    };
    let bases = suns.item_numbers().map(field).collect();
    let fields = SpeciesFields { meta, medium, turbid: Some(turbid), bases };
    let settings = EncodeSettings { threshold: 0.001, ..EncodeSettings::papers() };
    let encoded = encode_species(&fields, &settings, &|_| Ok(())).expect("the fields fit");
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[&encoded]).expect("it fits");
    Library::from_source("oak.flb", Box::new(bytes)).expect("it opens")
}

/// Middles of non-empty sites, from all over the crown, in no order.
fn points(sampler: &PhysicalSampler) -> Vec<[f32; 3]> {
    let (grid, sites) = (*sampler.grid(), sampler.turbid().sites());
    let point = |i: usize| {
        let site = sites[i.wrapping_mul(2_654_435_761) % sites.len()];
        grid.model_from_lattice(grid.site(site as usize).map(|c| f64::from(c) + 0.4)).map(|c| c as f32)
    };
    (0..POINTS).map(point).collect()
}

fn physical(criterion: &mut Criterion) {
    for (lattice, suns) in [(64, "sh2"), (64, "sh2s"), (128, "sh2"), (128, "sh2s")] {
        let library = library(lattice, suns == "sh2s");
        let sampler = PhysicalSampler::load(&library, 0).expect("it loads");
        let terms = sampler.terms(TOWARDS_SUN).expect("a direction");
        let near = sampler.near();
        let (prepared, marcher, points) =
            (sampler.prepare(&near, terms, BEAM_RAYS), sampler.marcher(), points(&sampler));
        println!(
            "lattice {lattice}, {suns}: {} non-empty sites; {:.1} MB of fields and extinction, {:.2} MB per prepared sun, {:.2} MB to march through",
            sampler.turbid().sites().len(),
            sampler.size_bytes() as f64 / 1e6,
            prepared.size_bytes() as f64 / 1e6,
            marcher.size_bytes() as f64 / 1e6
        );
        let mut group = criterion.benchmark_group(format!("physical {lattice} {suns}"));
        group.sample_size(10);
        group.bench_function("lay rays for all suns", |b| b.iter(|| black_box(sampler.near())));
        group.bench_function("prepare a sun", |b| b.iter(|| sampler.prepare(&near, terms, BEAM_RAYS)));
        group.throughput(Throughput::Elements(POINTS as u64));
        let mut out = [0.0; 3];
        group.bench_function("sample, prepared", |b| {
            b.iter(|| {
                for point in &points {
                    sampler.fluence(&prepared, 1.0, 0.2, *point, &mut out);
                    black_box(&out);
                }
            })
        });
        for count in [1_u32, 4, 16] {
            let turn = [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9];
            let offset = |i: u32| turn.map(|t: f64| ((0.5 + f64::from(i) * t) % 1.0) as f32);
            let offsets: Vec<[f32; 3]> = (0..count).map(offset).collect();
            group.bench_function(format!("sample, marched with {count} offsets"), |b| {
                b.iter(|| {
                    for point in &points {
                        let near = marcher.near(*point, TOWARDS_SUN, &offsets);
                        sampler.fluence_of(&terms, near, 1.0, 0.2, *point, &mut out);
                        black_box(&out);
                    }
                })
            });
        }
        group.finish();
    }
}

criterion_group!(benches, physical);
criterion_main!(benches);
