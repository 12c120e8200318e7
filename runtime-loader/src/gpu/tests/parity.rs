//! light.wgsl against `CodedBase`: texels to the bit, samples to a part in 10^5 of the field's peak.

use std::path::PathBuf;

use flb_format::blocks::{CodedBase, TEXELS};
use flb_format::matter::{BandOptics, Class, ClassOptics, Optics};
use flb_format::meta::{Bounds, TriangleCounts};
use flb_format::model::Model;
use flb_format::{Codec, Field, Grid, Medium, SpeciesFields, SpeciesMeta};
use flb_packer::{EncodeSettings, encode_species, write_library_to};

use super::super::{Gpu, GpuLight, GpuSpeciesId, LightSettings, Term, pack};
use super::made::{self, Random};
use super::probe::{self, Ask};
use crate::Library;

/// Of the field's peak: sums of 64 products in f32 in another order, and places in f32 (two parts in 10^6 of a lattice
/// of 64).
const ROUNDING: f64 = 1e-5;
/// The same of sums in f16, whose detail has 11 bits.
const ROUNDING_F16: f64 = 5e-4;
const SAMPLES: usize = 10_000;

fn light(gpu: &Gpu) -> GpuLight {
    GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default()).expect("a sound budget")
}

/// Largest magnitude of texels over all blocks, in light.
fn peak(base: &CodedBase) -> f64 {
    f64::from(base.field().values().iter().fold(0.0f32, |peak, value| peak.max(value.abs())))
}

/// Points all over a lattice and a little beyond it, in model space.
fn points(random: &mut Random, grid: &Grid) -> Vec<[f32; 3]> {
    let along = |axis: usize, unit: f64| {
        let site = unit * f64::from(grid.lattice + 2) - 1.0;
        (grid.origin_m[axis] + site * grid.spacing_m) as f32
    };
    (0..SAMPLES).map(|_| std::array::from_fn(|axis| along(axis, random.unit()))).collect()
}

/// Largest difference between the GPU's samples of a blend and the CPU's, relative to the peak of the blend.
fn worst(
    gpu: &Gpu,
    light: &mut GpuLight,
    grid: &Grid,
    species: GpuSpeciesId,
    terms: &[(&CodedBase, Term)],
    seed: u64,
) -> f64 {
    worst_by(probe::samples, gpu, light, grid, species, terms, seed)
}

type Samples = fn(&Gpu, &GpuLight, Ask, &[[f32; 3]]) -> Vec<[f32; 3]>;

fn worst_by(
    samples: Samples,
    gpu: &Gpu,
    light: &mut GpuLight,
    grid: &Grid,
    species: GpuSpeciesId,
    terms: &[(&CodedBase, Term)],
    seed: u64,
) -> f64 {
    let list: Vec<Term> = terms.iter().map(|(_, term)| *term).collect();
    light.set_terms(7, &list).unwrap();
    let points = points(&mut Random(seed), grid);
    let ask = Ask { species, first: 7, second: list.len() as u32 };
    let found = samples(gpu, light, ask, &points);
    let peak: f64 = terms.iter().map(|(base, term)| peak(base) * f64::from(term.factor.abs())).sum();
    let mut worst = 0.0f64;
    for (point, found) in points.iter().zip(&found) {
        let mut expected = [0.0f64; 3];
        for (base, term) in terms {
            let mut light = vec![0.0; base.head().bands as usize];
            base.sample(grid.lattice_from_model(point.map(f64::from)), &mut light);
            let sums = expected.iter_mut().zip(&light);
            sums.for_each(|(sum, light)| *sum += f64::from(term.factor) * f64::from(*light));
        }
        for (found, expected) in found.iter().zip(expected) {
            // Not a number is as wrong as can be.
            let difference = (f64::from(*found) - expected).abs();
            worst = if difference.is_nan() { f64::INFINITY } else { worst.max(difference) };
        }
    }
    worst / peak
}

fn assert_texels(
    gpu: &Gpu,
    light: &GpuLight,
    species: GpuSpeciesId,
    index: u32,
    base: &CodedBase,
    what: &str,
) {
    let blocks = base.shared().map.len();
    for component in 0..base.head().components() {
        let ask = Ask { species, first: index, second: component as u32 };
        let found = probe::texels(gpu, light, ask, blocks);
        assert_eq!(found.len(), TEXELS * blocks);
        for (rank, found) in found.chunks_exact(TEXELS).enumerate() {
            assert_eq!(found, base.texels(rank, component), "{what}, component {component}, block {rank}");
        }
    }
}

#[test]
fn every_golden_block_has_its_texels_and_its_samples() {
    let gpu = probe::gpu();
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../format-spec/golden"));
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "flb"));
    files.sort();
    let mut bases = Vec::new();
    for path in &files {
        let library = Library::open(path).unwrap();
        let (container, source) = (library.container(), library.source());
        for (number, entry) in container.species().iter().enumerate().filter(|(_, s)| s.blocks.is_some()) {
            let mut light = light(&gpu);
            let shared = container.read_shared(source, number).unwrap();
            let species = light.add_species(&entry.meta.grid, &shared).unwrap();
            for base in entry.bases.iter().map(|entry| entry.base) {
                let what = format!("{}, base {base}", path.display());
                let coded = container.read_coded_base(source, number, base, &shared).unwrap();
                let index = light.set_base(species, base, &coded).unwrap();
                assert_texels(&gpu, &light, species, index, &coded, &what);
                let terms = [(&coded, Term { base: index, factor: 1.0 })];
                let worst = worst(&gpu, &mut light, &entry.meta.grid, species, &terms, u64::from(base));
                assert!(worst < ROUNDING, "{what}: {worst:e}");
                bases.push(what);
            }
        }
    }
    // classed, classed-first, classed-all-blocks, directions and haar are there.
    assert!(bases.len() > 20, "{bases:?}");
}

/// Both codings, all numbers of bands, maps of some blocks and of all, all detail and a part of it.
#[test]
fn random_bases_have_their_texels_and_their_samples() {
    let gpu = probe::gpu();
    for seed in 0..12 {
        let random = &mut Random(seed);
        let (haar, full, part) = (seed & 1 == 1, seed % 5 == 4, seed & 2 == 2);
        let grid = made::grid(32);
        let shared = made::shared(random, 32, haar, full);
        let mut light = light(&gpu);
        let species = light.add_species(&grid, &shared).unwrap();
        let bands = 1 + (seed % 3) as u32;
        let all: Vec<CodedBase> = (0..4)
            .map(|_| made::made(random, &shared, bands, 5).with(|page| !part || page % 2 == 0))
            .collect();
        let mut terms = Vec::new();
        for (number, base) in (0..).zip(&all) {
            let index = light.set_base(species, number, base).unwrap();
            assert_texels(&gpu, &light, species, index, base, &format!("seed {seed}, base {number}"));
            terms.push((base, Term { base: index, factor: random.unit() as f32 - 0.3 }));
        }
        let worst = worst(&gpu, &mut light, &grid, species, &terms, !seed);
        assert!(worst < ROUNDING, "seed {seed}: {worst:e}");
    }
}

/// Light that falls off into a ball, as the packer codes it near the ball's matter.
#[test]
fn light_like_that_of_a_solve_has_its_texels_and_its_samples() {
    let gpu = Gpu::open(wgpu::Features::SHADER_F16).unwrap_or_else(|error| panic!("{error}"));
    assert!(gpu.device.features().contains(wgpu::Features::SHADER_F16), "{} has no f16", gpu.name);
    for codec in [Codec::Classed, Codec::Haar] {
        let settings = EncodeSettings { codec, page_bytes: 20_480, ..EncodeSettings::papers() };
        let coded = encode_species(&ball(), &settings, &|_| Ok(())).unwrap();
        let mut bytes = Vec::new();
        write_library_to(&mut bytes, &[&coded]).unwrap();
        let library = Library::from_source("ball.flb", Box::new(bytes)).unwrap();
        let (container, source) = (library.container(), library.source());
        let grid = container.species()[0].meta.grid;
        let shared = container.read_shared(source, 0).unwrap();
        assert!(!shared.map.is_full());
        let mut light = light(&gpu);
        let species = light.add_species(&grid, &shared).unwrap();
        let bases =
            [0, 3, 9].map(|base| (base, container.read_coded_base(source, 0, base, &shared).unwrap()));
        let mut terms = Vec::new();
        for ((number, base), factor) in bases.iter().zip([0.25, 0.5, 1.5]) {
            let index = light.set_base(species, *number, base).unwrap();
            assert_texels(&gpu, &light, species, index, base, codec.name());
            terms.push((base, Term { base: index, factor }));
        }
        let in_f32 = worst(&gpu, &mut light, &grid, species, &terms, 11);
        assert!(in_f32 < ROUNDING, "{codec:?}: {in_f32:e}");
        let in_f16 = worst_by(probe::samples_f16, &gpu, &mut light, &grid, species, &terms, 11);
        println!("{codec:?}: {in_f32:e} in f32, {in_f16:e} in f16");
        assert!(in_f16 < ROUNDING_F16, "{codec:?}: {in_f16:e}");
        assert!(in_f16 > 2.0 * in_f32, "as exact as f32: {in_f16:e}");
    }
}

fn ball() -> SpeciesFields {
    let grid = made::grid(64);
    let optics = ClassOptics { sigma_a: 0.1, g: 0.0 };
    let band = |name: &str| BandOptics { name: name.to_owned(), leaf: optics, wood: optics };
    let meta = SpeciesMeta {
        name: "ball".to_owned(),
        model: Model::Paper { optics: Optics { bands: ["R", "G", "B"].map(band).to_vec() } },
        grid,
        bounds_m: Bounds { min: [-1.0, 1.0, -2.0], max: [1.0, 2.0, 1.0] },
        triangles: TriangleCounts::default(),
        mesh_blake3: None,
        mean_light: None,
        sky_averages: None,
        sources: Vec::new(),
        settings: Default::default(),
        tool: "flb".to_owned(),
        left_out: None,
        extra: Default::default(),
    };
    let mut medium = Medium::empty(grid);
    let mut bases = [0, 3, 9].map(|base| (base, Field::zeros(64, 3)));
    for site in 0..grid.sites() {
        let at = grid.site(site).map(|c| f64::from(c) - 31.5);
        let depth = 20.0 - libm::sqrt(at.iter().map(|c| c * c).sum());
        if depth > 0.0 && (site * 7919) % 5 == 0 {
            (medium.density[site], medium.class[site]) = (0.5, Class::Leaf);
        }
        for (base, field) in &mut bases {
            let towards = at[usize::from(*base) % 2] + 8.0 * libm::sin(0.4 * at[2]);
            let light = libm::exp(-0.1 * (depth - 0.5 * towards).max(0.0));
            for b in 0..3 {
                field.values_mut()[b * grid.sites() + site] = light as f32 * (1.0 - 0.25 * b as f32);
            }
        }
    }
    SpeciesFields { meta, medium, turbid: None, bases: bases.to_vec() }
}

#[test]
fn nibbles_are_the_coefficients() {
    for seed in 0..8 {
        let random = &mut Random(seed);
        let shared = made::shared(random, 32, seed & 1 == 1, false);
        let base = made::made(random, &shared, 3, 3).with(|page| page != 1);
        let (blocks, components) = (shared.map.len(), base.head().components());
        let mut page = pack::pack_page(&base, 0, blocks);
        // As in a buffer: records, then nibbles.
        page.place(components, page.records.len() as u32);
        let words: Vec<u32> = page.records.iter().chain(&page.nibbles).copied().collect();
        for rank in 0..blocks {
            for component in 0..components {
                let found = pack::twin::coefficients(&words, rank * (1 + components), components, component);
                let mut expected = base.coefficients(rank, component);
                if !base.is_detailed(rank) {
                    expected[1..].fill(0);
                }
                assert_eq!(found, expected, "seed {seed}, block {rank}, component {component}");
            }
        }
    }
}

#[test]
fn a_planted_difference_is_found() {
    let gpu = probe::gpu();
    let random = &mut Random(3);
    let grid = made::grid(32);
    let shared = made::shared(random, 32, false, false);
    let made = made::made(random, &shared, 3, 4);
    let (whole, part) = (made.with(|_| true), made.with(|page| page != 2));
    let mut light = light(&gpu);
    let species = light.add_species(&grid, &shared).unwrap();
    let base = light.set_base(species, 0, &part).unwrap();
    let term = Term { base, factor: 1.0 };
    assert!(worst(&gpu, &mut light, &grid, species, &[(&part, term)], 1) < ROUNDING);
    assert!(worst(&gpu, &mut light, &grid, species, &[(&whole, term)], 1) > 10.0 * ROUNDING);
}
