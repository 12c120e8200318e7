//! Seconds per solve of the `physical` model on the built-in oak, with the default settings and three bands: the cores
//! and the GPU side by side, how far apart their fields are, and several GPUs of a kind
//! beside one.
//!
//! `cargo bench -p flb-baker --features gpu --bench gpu_physical [-- once LATTICE ...]`; without any, lattices 32 and
//! 64. The fastest of three solves counts, or the only one with `once`: software that stands in for a GPU takes long.

use std::time::Instant;

use flb_baker::crown::{CrownSettings, LeafAngleChoice, measure_crown};
use flb_baker::{VoxelSettings, downsample, voxelise};
use flb_fixtures::{PlantKind, grow};
use flb_format::matter::TurbidMedium;
use flb_scene::classify::classify;
use flb_scene::import::import;
use flb_scene::{ClassRules, ImportSettings, Mesh};
use flb_transport::gpu::{find_gpu, find_gpus};
use flb_transport::ordinates::{Backend, OrdinatesSettings, OrdinatesSolution, rays_for, solve};
use flb_transport::turbid::{BandScatter, Phase, Scatter};

/// Of leaves in red, green and blue.
const ALBEDOS: [f64; 3] = [0.1, 0.2, 0.07];

fn main() {
    println!("GPU: {}", find_gpu().unwrap_or_else(|error| panic!("{error}")));
    let tries = if std::env::args().any(|word| word == "once") { 1 } else { 3 };
    let lattices: Vec<u32> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let lattices = if lattices.is_empty() { vec![32, 64] } else { lattices };
    let mesh = oak();
    for lattice in lattices {
        let medium = crown(&mesh, lattice);
        let [(cpu, on_cpu), (gpu, on_gpu)] =
            [Backend::Cpu, Backend::GPU].map(|backend| best(&medium, backend, tries));
        println!(
            "lattice {lattice}, {} sites: {cpu:.2} s on the cores, {gpu:.2} s on the GPU; fields {:.1e} of the mean apart",
            medium.sites().len(),
            apart(&medium, &on_cpu, &on_gpu)
        );
        for most in 2..=find_gpus(ALBEDOS.len()).map_or(1, |gpus| gpus.len()) {
            let (shared, by_all) = best(&medium, Backend::Gpu { most }, tries);
            assert!(by_all == on_gpu, "GPUs of a kind compute the same bytes");
            println!("  {most} GPUs: {shared:.2} s, {:.2} times one", gpu / shared);
        }
    }
}

/// The fastest of so many solves, in seconds, and what it found.
fn best(medium: &TurbidMedium, backend: Backend, tries: usize) -> (f64, OrdinatesSolution) {
    let scatter = |albedo| Scatter { albedo, phase: Phase::BiLambert { transmitted: 0.4 } };
    let bands = ALBEDOS.map(|albedo| BandScatter { leaf: scatter(albedo), wood: scatter(0.2) });
    let rays = rays_for(medium.grid.lattice, 1);
    let settings = OrdinatesSettings { rays, backend, ..OrdinatesSettings::default() };
    let solves = (0..tries).map(|_| {
        let start = Instant::now();
        let solution =
            solve(medium, &bands, &settings, &|_| Ok(())).unwrap_or_else(|error| panic!("{error}"));
        (start.elapsed().as_secs_f64(), solution)
    });
    solves.min_by(|a, b| a.0.total_cmp(&b.0)).expect("one at least")
}

/// Largest difference of the light of all suns and of the sky, relative to the mean of each field.
fn apart(medium: &TurbidMedium, a: &OrdinatesSolution, b: &OrdinatesSolution) -> f64 {
    let sites = medium.sites().len() as f64;
    let of_field = |(a, b): (&Vec<f32>, &Vec<f32>)| {
        let mean = a.iter().map(|light| f64::from(light.abs())).sum::<f64>() / sites;
        let differences = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs()));
        differences.fold(0.0, f64::max) / mean
    };
    let fields = a.total.values.iter().flatten().zip(b.total.values.iter().flatten());
    fields.map(of_field).fold(0.0, f64::max)
}

fn crown(mesh: &Mesh, lattice: u32) -> TurbidMedium {
    let classified = classify(mesh, &ClassRules::default()).expect("the materials' names tell");
    let classes: Vec<_> = classified.iter().map(|found| found.class).collect();
    let voxels = VoxelSettings { voxels: 1024, lattice, ignore_alpha: false };
    let occupancy = voxelise(mesh, &classes, &voxels, &|_| Ok(())).expect("the mesh has triangles");
    let medium = downsample(&occupancy).expect("an occupancy downsamples");
    let settings = CrownSettings { ignore_alpha: false, angles: LeafAngleChoice::Measured };
    let crown = measure_crown(mesh, &classes, &medium, &settings, &|_| Ok(()));
    crown.expect("the mesh has leaves").turbid
}

fn oak() -> Mesh {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("oak.glb");
    let oak = grow(PlantKind::Oak, 1, 80_000).expect("the count is within the limits");
    std::fs::write(&path, oak.to_glb()).expect("a temporary file");
    import(&path, &ImportSettings::default()).unwrap_or_else(|error| panic!("{error}"))
}
