//! near.wgsl against the marches of the CPU.

use flb_format::light::SunBasis;
use flb_format::matter::{LeafAngles, TurbidMedium};
use flb_format::{Codec, Grid};

use super::super::{GpuError, GpuLight, GpuSpeciesId, LightSettings, Term};
use super::made::{self, Random};
use super::probe::{self, Ask};
use crate::extinction::Extinction;
use crate::near_beam::{Marcher, offset};
use crate::physical::PhysicalSampler;
use crate::plants::{library, noise, plant};

/// In place of what [`probe::SAMPLES`] finds. The direction of the sun is the first of the points, the seed is a
/// point's number, and `second` is the number of offsets.
const NEAR: &str = "flb_near(ask.species, points[at.x].xyz, points[0].xyz, ask.second, at.x)";

/// Finds means of the near beam.
pub(super) fn near() -> String {
    probe::finding(NEAR)
}

/// Finds the light of them, where `first` packs the number of terms (low 8 bits) and of near ones.
pub(super) fn light() -> String {
    let sample = "flb_sample_near(ask.species, 3u, ask.first & 255u, ask.first >> 8u, points[at.x].xyz";
    probe::finding(&format!("vec4<f32>({sample}, {NEAR}), 1.0)"))
}

const SUN: [f64; 3] = [0.48, 0.6, -0.64];
const COUNT: u32 = 4000;

/// A round crown with holes, whose depths are the same in binary16; spacing 1/4 m.
fn crown(lattice: u32) -> TurbidMedium {
    let grid = Grid { lattice, origin_m: [-4.0, 0.25, 2.0], spacing_m: 0.25 };
    let (mut leaf_per_m, mut wood_per_m) = (vec![0.0; grid.sites()], vec![0.0; grid.sites()]);
    let middle = (lattice as f32 - 1.0) / 2.0;
    for site in 0..grid.sites() {
        let at = grid.site(site).map(|c| (c as f32 - middle) / middle);
        let share = noise(site as u32, 3);
        if at.iter().map(|c| c * c).sum::<f32>() < 0.8 && share > 0.5 {
            leaf_per_m[site] = (share * 256.0).floor() / 128.0;
            wood_per_m[site] = if share > 0.95 { 2.0 } else { 0.0 };
        }
    }
    TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::planophile() }
}

/// The sun's direction, then points all over the lattice and beyond.
fn asked(grid: &Grid) -> Vec<[f32; 4]> {
    let along = |i: u32, axis: usize| {
        let site = noise(i, 20 + axis as u32) * (grid.lattice + 4) as f32 - 2.0;
        (grid.origin_m[axis] + f64::from(site) * grid.spacing_m) as f32
    };
    let mut points: Vec<[f32; 4]> =
        (0..COUNT).map(|i| [along(i, 0), along(i, 1), along(i, 2), 0.0]).collect();
    points[0] = [SUN[0] as f32, SUN[1] as f32, SUN[2] as f32, 0.0];
    points
}

fn offsets(seed: u32, count: u32) -> Vec<[f32; 3]> {
    (0..count).map(|i| offset(seed, i)).collect()
}

/// Where a ray runs along a face, or a choice stands at its edge, rounding decides: then all may differ. So a few may,
/// the mean must not.
fn assert_close(found: &[f32], expected: &[f32], what: &str) {
    let pairs = || found.iter().zip(expected);
    let far = pairs().filter(|(found, expected)| (*found - *expected).abs() > 1e-4).count();
    let mean = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64;
    let off = (mean(found) / mean(expected) - 1.0).abs();
    assert!(far * 200 < found.len() && off < 1e-3, "{what}: {far} of {} far, means {off} off", found.len());
    assert!(found.iter().all(|value| value.is_finite()), "{what}");
}

#[test]
fn means_of_the_near_beam_are_those_of_the_cpu() {
    let gpu = probe::gpu();
    let mut light = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default()).expect("buffers");
    for lattice in [16, 64] {
        let turbid = crown(lattice);
        let extinction = Extinction::of(&turbid);
        let shared = made::shared(&mut Random(4), lattice, false, false);
        let species = light.add_species(&turbid.grid, &shared).expect("there is room");
        let points = asked(&turbid.grid);
        for (single, count) in [(false, 0), (false, 4), (true, 1), (true, 4)] {
            light.set_extinction(species, &extinction, single).expect("there is room");
            let ask = Ask { species, first: 0, second: count };
            let found = probe::asked(&gpu, &light, &near(), ask, &points);
            let marcher = Marcher::of(&extinction, single);
            let near = |(seed, point): (u32, &[f32; 4])| {
                marcher.near([point[0], point[1], point[2]], SUN, &offsets(seed, count))
            };
            let expected: Vec<[f32; 4]> = (0..).zip(&points).map(near).collect();
            for j in 0..4 {
                let of = |all: &[[f32; 4]]| all[1..].iter().map(|near| near[j]).collect::<Vec<f32>>();
                let expected = of(&expected);
                if expected.iter().any(|near| *near != 0.0) {
                    assert_close(
                        &of(&found),
                        &expected,
                        &format!("{lattice}, single {single}, {count}, near_{j}"),
                    );
                } else {
                    assert!(
                        of(&found).iter().all(|near| *near == 0.0),
                        "single {single}: near_{j} is not there"
                    );
                }
            }
        }
    }
}

#[test]
fn light_of_harmonics_is_that_of_the_cpu() {
    let gpu = probe::gpu();
    for single in [false, true] {
        let suns = SunBasis::Harmonics { degree: 2, single, leaning: true };
        let library = library(&[plant("oak", Some(&suns), 32, 7)], Codec::Classed);
        let (container, source) = (library.container(), library.source());
        let sampler = PhysicalSampler::load(&library, 0).expect("it loads");
        let mut light = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default()).expect("buffers");
        let shared = container.read_shared(source, 0).expect("a sound file");
        let species = light.add_species(sampler.grid(), &shared).expect("there is room");
        light.set_extinction(species, &Extinction::of(sampler.turbid()), single).expect("there is room");
        let y = flb_format::sun::harmonics::evaluate(SUN);
        let factors = y[..9]
            .iter()
            .map(|y| 1.5 * *y as f32)
            .chain([1.5 * sampler.turbid().angles.relative(SUN[1]) as f32; 4]);
        let mut terms = Vec::new();
        let near_count = if single { 3 } else { 4 };
        for (item, factor) in (1..1 + 9 + near_count as u8).zip(factors) {
            let coded = container.read_coded_base(source, 0, item, &shared).expect("a sound file");
            let base = light.set_base(species, item, &coded).expect("there is room");
            terms.push(Term { base, factor });
        }
        light.set_terms(3, &terms).expect("there is room");
        let points = asked(sampler.grid());
        let ask = Ask { species, first: terms.len() as u32 | near_count << 8, second: 2 };
        let found = probe::asked(&gpu, &light, &self::light(), ask, &points);
        let marcher = sampler.marcher();
        let terms = sampler.terms(SUN).expect("a direction");
        let light = |(seed, point): (u32, &[f32; 4])| {
            let (point, mut out) = ([point[0], point[1], point[2]], [0.0; 3]);
            let near = marcher.near(point, SUN, &offsets(seed, 2));
            sampler.fluence_of(&terms, near, 1.5, 0.0, point, &mut out);
            out
        };
        let expected: Vec<[f32; 3]> = (0..).zip(&points).map(light).collect();
        for band in 0..3 {
            let found: Vec<f32> = found[1..].iter().map(|light| light[band]).collect();
            let expected: Vec<f32> = expected[1..].iter().map(|light| light[band]).collect();
            assert_close(&found, &expected, &format!("single {single}, band {band}"));
        }
    }
}

#[test]
fn without_extinction_half_is_lit_and_its_memory_comes_back() {
    let gpu = probe::gpu();
    let mut light = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default()).expect("buffers");
    let (turbid, shared) = (crown(16), made::shared(&mut Random(4), 16, false, false));
    let empty = light.free_bytes();
    let species = light.add_species(&turbid.grid, &shared).expect("there is room");
    let (free, bytes) = (light.free_bytes(), light.species_bytes(species).expect("it is there"));
    let points = asked(&turbid.grid);
    let ask = Ask { species, first: 0, second: 2 };
    assert!(probe::asked(&gpu, &light, &near(), ask, &points).iter().all(|near| *near == [0.5; 4]));
    let extinction = Extinction::of(&turbid);
    light.set_extinction(species, &extinction, true).expect("there is room");
    light.set_extinction(species, &extinction, true).expect("in place of the first");
    let taken = free - light.free_bytes();
    assert!(taken > 0 && light.species_bytes(species).expect("it is there") == bytes + taken);
    assert!(
        probe::asked(&gpu, &light, &near(), ask, &points).iter().any(|near| *near != [0.5, 0.5, 0.0, 0.0])
    );
    light.remove_extinction(species).expect("it is there");
    assert_eq!(light.free_bytes(), free);
    assert!(
        probe::asked(&gpu, &light, &near(), ask, &points).iter().all(|near| *near == [0.5, 0.5, 0.0, 0.0])
    );
    let other =
        light.set_extinction(species, &Extinction::of(&crown(64)), true).expect_err("another lattice");
    assert!(matches!(other, GpuError::OtherExtinction { species: GpuSpeciesId(0) }), "{other}");
    let none = light.set_extinction(GpuSpeciesId(9), &extinction, true).expect_err("no such species");
    assert!(matches!(none, GpuError::NoSpecies { species: GpuSpeciesId(9) }), "{none}");
    let of_budget = |budget_bytes| {
        let settings = LightSettings { budget_bytes, ..LightSettings::default() };
        let mut light = GpuLight::new(&gpu.device, &gpu.queue, settings).expect("buffers");
        let number = light.add_species(&turbid.grid, &shared).expect("there is room");
        (light, number)
    };
    let enough = 610_000;
    let spare = of_budget(enough).0.free_bytes();
    assert!(spare > taken, "{spare} bytes are free for {taken}");
    let (mut small, number) = of_budget(enough - (spare - taken / 2));
    let full = small.set_extinction(number, &extinction, false).expect_err("no room");
    assert!(matches!(full, GpuError::Full { .. }), "{full}");
    light.set_extinction(species, &extinction, false).expect("there is room");
    light.remove_species(species).expect("it is there");
    assert_eq!(light.free_bytes(), empty);
}
