//! Atlases against `flb_sample`, of which they are a rounded copy.

use flb_format::blocks::CodedBase;

use super::super::{AtlasDecoder, GpuError, GpuLight, GpuSpeciesId, LightSettings, Term};
use super::made::{self, Random};
use super::probe::{self, Ask};

/// Of the largest light: binary16 has 11 bits, and software filters with 8 bits of weight at least.
const ROUNDING: f32 = 1.0 / 200.0;
/// The same of hardware, whose weights have 8 bits along each axis: an H200 was off by 1 / 173.
const ROUNDING_OF_HARDWARE: f32 = 1.0 / 128.0;

fn rounding() -> f32 {
    if probe::gpu().is_software { ROUNDING } else { ROUNDING_OF_HARDWARE }
}

/// Light at points of all blocks, by both ways: `flb_sample` first.
fn both(haar: bool, full: bool, only_surfaces: bool) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let gpu = probe::gpu();
    let random = &mut Random(5);
    let grid = made::grid(32);
    let shared = made::shared(random, 32, haar, full);
    let mut light = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default()).unwrap();
    let species = light.add_species(&grid, &shared).unwrap();
    let bases: Vec<CodedBase> =
        (0..2).map(|_| made::made(random, &shared, 3, 3).with(|page| page != 1)).collect();
    let terms: Vec<Term> = (0..)
        .zip(&bases)
        .map(|(number, base)| Term { base: light.set_base(species, number, base).unwrap(), factor: 0.6 })
        .collect();
    light.set_terms(3, &terms).unwrap();
    let decoder = AtlasDecoder::new(&gpu.device, &light);
    let atlas = decoder.atlas(&light, species, 32 << 20).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    decoder.fill(&mut encoder, &gpu.queue, &light, &atlas, 3, 2);
    gpu.queue.submit([encoder.finish()]);
    let mut points = Vec::new();
    while points.len() < 4000 {
        let site = [(); 3].map(|()| random.unit() * 34.0 - 1.0);
        let lower = site.map(|c| (c - 0.5).clamp(0.0, 30.0) as u32);
        let is_stored = |corner: u32| {
            let block = std::array::from_fn(|a| (lower[a] + (corner >> a & 1)) / 4);
            shared.map.rank(block).is_some()
        };
        let stored = (0..8).filter(|corner| is_stored(*corner)).count();
        // Of surfaces all eight texels are stored; far from them none is.
        if stored == if only_surfaces { 8 } else { 0 } {
            let place = |axis: usize| (grid.origin_m[axis] + site[axis] * grid.spacing_m) as f32;
            points.push([place(0), place(1), place(2)]);
        }
    }
    let ask = Ask { species, first: 3, second: 2 };
    let straight = probe::samples(&gpu, &light, ask, &points);
    (straight, probe::atlas_samples(&gpu, &light, &decoder, &atlas, &points))
}

/// Largest difference relative to the largest light.
fn worst((straight, atlas): &(Vec<[f32; 3]>, Vec<[f32; 3]>)) -> f32 {
    let peak = straight.iter().flatten().fold(0.0f32, |peak, value| peak.max(value.abs()));
    let pairs = straight.iter().flatten().zip(atlas.iter().flatten());
    pairs
        .fold(0.0f32, |worst, (a, b)| if (a - b).is_nan() { f32::INFINITY } else { worst.max((a - b).abs()) })
        / peak
}

#[test]
fn an_atlas_has_the_light_of_its_blend_at_surfaces() {
    for (haar, full) in [(false, false), (true, false), (false, true)] {
        let found = both(haar, full, true);
        let worst = worst(&found);
        assert!(worst < rounding(), "haar {haar}, full {full}: {worst}");
    }
}

#[test]
fn far_from_surfaces_an_atlas_has_the_coarse_level() {
    let found = both(false, false, false);
    let worst = worst(&found);
    assert!(worst < rounding(), "{worst}");
}

#[test]
fn light_of_another_point_is_found_to_differ() {
    let (straight, mut atlas) = both(false, false, true);
    atlas.rotate_left(1);
    assert!(worst(&(straight, atlas)) > 10.0 * ROUNDING);
}

#[test]
fn an_atlas_over_its_budget_is_refused_with_both_numbers() {
    let gpu = probe::gpu();
    let shared = made::shared(&mut Random(1), 32, true, true);
    let mut light = GpuLight::new(&gpu.device, &gpu.queue, LightSettings::default()).unwrap();
    let species = light.add_species(&made::grid(32), &shared).unwrap();
    let decoder = AtlasDecoder::new(&gpu.device, &light);
    // 512 blocks are 8^3 bricks, so nothing is wasted.
    assert_eq!(decoder.atlas(&light, species, 512_000).map(|atlas| atlas.size_bytes()), Ok(512_000));
    let error = decoder.atlas(&light, species, 511_999).map(|atlas| atlas.size_bytes()).unwrap_err();
    assert!(matches!(error, GpuError::AtlasBudget { needed: 512_000, budget: 511_999, .. }), "{error}");
    assert!(error.to_string().contains("512 blocks takes 512000 bytes, expected at most 511999"), "{error}");
    let error = decoder.atlas(&light, GpuSpeciesId(7), 1).map(|atlas| atlas.size_bytes()).unwrap_err();
    assert_eq!(error, GpuError::NoSpecies { species: GpuSpeciesId(7) });
}
