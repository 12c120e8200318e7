//! Times of the codings of blocks near geometry: `cargo bench -p flb-packer`.
//!
//! Samples of three bands at surfaces, of a base coded at 45 dB, beside samples of the plain floats; and the coding itself.
//! The field is light that falls off in a crown of leaves in clumps, 64^3. `FLB_FIELDS=FILE` takes the first species of a file of
//! fields in its place (`flb bake --keep-fields FILE`), and its base 7 for the samples.

use std::hint::black_box;

use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use flb_format::blocks::{BlockMap, Classes, CodedBase, Coding, Cursor, Shared};
use flb_format::sample::trilinear;
use flb_format::{Class, Container, Field};
use flb_packer::rate::{DetailCoding, RateSettings, SpeciesPayloads, Target, code_species};

/// Points per timed pass, and of them those of a run.
const POINTS: usize = 16_384;
const RUN: usize = 32;
/// Between points of a run, in sites.
const STRIDE: f64 = 0.15;
/// Base that is sampled, if there is such.
const BASE: usize = 7;

struct Plant {
    lattice: u32,
    non_empty: Vec<bool>,
    bases: Vec<(u8, Field)>,
}

impl Plant {
    /// Site `[x, y, z]` of an index.
    fn site(&self, site: usize) -> [f64; 3] {
        let n = self.lattice as usize;
        [site % n, site / n % n, site / n / n].map(|c| c as f64)
    }

    fn is_inside(&self, point: [f64; 3]) -> bool {
        let n = self.lattice as usize;
        let at = point.map(|c| c as usize);
        point.iter().all(|c| *c >= 0.0 && *c < n as f64) && self.non_empty[(at[2] * n + at[1]) * n + at[0]]
    }

    fn code(&self, coding: DetailCoding) -> SpeciesPayloads {
        let bases: Vec<(u8, &Field)> = self.bases.iter().map(|(base, field)| (*base, field)).collect();
        let settings =
            RateSettings { coding, target: Target::Psnr(45.0), all_blocks: false, page_bytes: 20_480 };
        code_species(self.lattice, &self.non_empty, &bases, &settings).expect("45 dB are in reach")
    }
}

/// Numbers in 0..1 by a linear congruence (Knuth's MMIX).
fn random() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1u32 << 31)
    }
}

fn crown() -> Plant {
    let lattice = 64;
    let mut plant = Plant { lattice, non_empty: Vec::new(), bases: vec![(0, Field::zeros(lattice, 3))] };
    let mut unit = random();
    let clumps: Vec<[f64; 3]> = (0..150).map(|_| [(); 3].map(|()| 12.0 + 40.0 * unit())).collect();
    for site in 0..(lattice as usize).pow(3) {
        let at = plant.site(site);
        let square = |c: &[f64; 3]| (0..3).map(|a| (at[a] - c[a]) * (at[a] - c[a])).sum::<f64>();
        let nearest = clumps.iter().map(square).fold(f64::INFINITY, f64::min);
        plant.non_empty.push(nearest < 10.0);
        let light =
            libm::exp(-(64.0 - at[1]) / 25.0 - 0.5 * libm::exp(-nearest / 12.0)) * (0.9 + 0.2 * unit());
        for band in 0..3 {
            plant.bases[0].1.values[band * plant.lattice.pow(3) as usize + site] =
                (light * (1.0 - 0.2 * band as f64)) as f32;
        }
    }
    plant
}

fn read(path: &std::ffi::OsStr) -> Plant {
    let bytes = std::fs::read(path).expect("FLB_FIELDS names a file");
    let container = Container::open(&bytes).expect("FLB_FIELDS names a file of fields");
    let species = flb_packer::load_species(&container, &bytes, 0).expect("fields");
    Plant {
        lattice: species.medium.grid.lattice,
        non_empty: species.medium.class.iter().map(|class| *class != Class::Empty).collect(),
        bases: species.bases,
    }
}

/// Points in non-empty sites: anywhere, or in runs of short steps.
fn points(plant: &Plant, coherent: bool) -> Vec<[f64; 3]> {
    let mut unit = random();
    let sites: Vec<usize> = (0..plant.non_empty.len()).filter(|site| plant.non_empty[*site]).collect();
    let mut points = Vec::new();
    while points.len() < POINTS {
        let first = plant.site(sites[(unit() * sites.len() as f64) as usize]).map(|c| c + unit());
        let way = [(); 3].map(|()| unit() - 0.5);
        let length = libm::sqrt(way.iter().map(|c| c * c).sum());
        let count = if coherent { RUN } else { 1 };
        let at = |k: usize| std::array::from_fn(|a| first[a] + way[a] / length * STRIDE * k as f64);
        let run: Vec<[f64; 3]> = (0..count).map(at).collect();
        if run.iter().all(|point| plant.is_inside(*point)) {
            points.extend(run);
        }
    }
    points
}

fn benches(c: &mut Criterion) {
    let plant = std::env::var_os("FLB_FIELDS").map_or_else(crown, |path| read(&path));
    let coded = plant.code(DetailCoding::Classed);
    println!("{} bases in {} bytes at 45 dB", coded.bases.len(), coded.bytes());
    let classes = Classes::from_bytes(coded.classes.as_ref().expect("classes")).expect("sound tables");
    let map = BlockMap::from_bytes(&coded.map, plant.lattice).expect("a sound map");
    let shared = Shared { map, coding: Coding::Classed(classes) };
    let which = BASE.min(plant.bases.len() - 1);
    let (payloads, field) = (&coded.bases[which], &plant.bases[which].1);
    let mut bytes = payloads.head.to_bytes();
    bytes.extend(&payloads.averages);
    let mut base = CodedBase::from_bytes(&Arc::new(shared), field.bands, &bytes).expect("a sound base");
    for page in &payloads.pages {
        base.add(page.first, page.count, &page.payload).expect("a sound page");
    }

    let mut group = c.benchmark_group("samples near geometry");
    group.throughput(Throughput::Elements(POINTS as u64));
    let mut out = vec![0.0f32; field.bands as usize];
    for (name, coherent) in [("random", false), ("coherent", true)] {
        let points = points(&plant, coherent);
        let mut time = |what: &str, sample: &mut dyn FnMut([f64; 3], &mut [f32])| {
            group.bench_function(format!("{what}, {name}"), |b| {
                b.iter(|| {
                    for point in &points {
                        sample(*point, &mut out);
                        black_box(&out);
                    }
                });
            });
        };
        time("from coded bits", &mut |point, out| base.sample(point, out));
        let mut cursor = Cursor::new(&base);
        time("by a cursor", &mut |point, out| cursor.sample(point, out));
        time("from plain floats", &mut |point, out| trilinear(field, point, out));
    }
    group.finish();

    let mut group = c.benchmark_group("coding at 45 dB");
    group.sample_size(10);
    for (name, coding) in [("classed", DetailCoding::Classed), ("haar", DetailCoding::Haar)] {
        group.bench_function(name, |b| b.iter(|| plant.code(coding).bytes()));
    }
}

criterion_group!(all, benches);
criterion_main!(all);
