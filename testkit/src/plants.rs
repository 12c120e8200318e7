//! Libraries for the tests of streaming: round plants whose fields are rough, so that their bases have several pages.

use flb_format::light::SunBasis;
use flb_format::matter::{Class, LeafAngles, TurbidMedium};
use flb_format::meta::{Bounds, TriangleCounts};
use flb_format::{Codec, Field, Grid, Medium, SpeciesFields, SpeciesMeta};
use flb_packer::rate::Target;
use flb_packer::{EncodeSettings, encode_species, write_library_to};

use crate::model::model;

/// Bands of all of them.
pub const BANDS: usize = 3;

/// Small pages of much detail, so that there are many.
pub fn settings(codec: Codec) -> EncodeSettings {
    EncodeSettings { codec, page_bytes: 20_480, target: Target::Psnr(50.0), ..EncodeSettings::papers() }
}

/// A plant 4 m across on a lattice; `None` is the model `paper`.
pub fn plant(name: &str, suns: Option<&SunBasis>, lattice: u32, seed: u32) -> SpeciesFields {
    let spacing_m = 4.0 / f64::from(lattice);
    let grid = Grid { lattice, origin_m: [-2.0, 0.0, -2.0], spacing_m };
    let mut medium = Medium::empty(grid);
    let (mut leaf_per_m, wood_per_m) = (vec![0.0; grid.sites()], vec![0.0; grid.sites()]);
    let n = lattice as usize;
    for (site, leaf_per_m) in leaf_per_m.iter_mut().enumerate() {
        let middle = (n as f32 - 1.0) / 2.0;
        let from_middle = [site % n, site / n % n, site / (n * n)].map(|c| (c as f32 - middle) / middle);
        if from_middle.iter().map(|c| c * c).sum::<f32>() < 0.7 && noise(site as u32, seed) > 0.3 {
            medium.density[site] = 0.2;
            medium.class[site] = Class::Leaf;
            medium.leaf_area_density[site] = 1.0;
            *leaf_per_m = 0.5;
        }
    }
    let turbid = TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::planophile() };
    let (model, items, turbid) = model(suns, turbid);
    SpeciesFields {
        meta: SpeciesMeta {
            name: name.to_owned(),
            model,
            grid,
            bounds_m: Bounds { min: [-2.0, 0.0, -2.0], max: [2.0, 4.0, 2.0] },
            triangles: TriangleCounts::default(),
            mesh_blake3: None,
            mean_light: None,
            sky_averages: None,
            sources: Vec::new(),
            settings: Default::default(),
            tool: "test".to_owned(),
            left_out: None,
            extra: Default::default(),
        },
        medium,
        turbid,
        bases: (0..items as u8).map(|base| (base, field(lattice, base, seed))).collect(),
    }
}

/// Waves with noise, another for every base.
fn field(lattice: u32, base: u8, seed: u32) -> Field {
    let mut field = Field::zeros(lattice, BANDS as u32);
    let n = lattice as usize;
    let outside = if base == 0 { 9.0 } else { 0.5 };
    for (i, value) in field.values_mut().iter_mut().enumerate() {
        let wave = [i % n, i / n % n, i / (n * n) % n].map(|c| c as f32 / n as f32);
        let slow = wave[0] * (1.0 - wave[1]) + wave[2] * f32::from(base % 5) * 0.1;
        *value = outside * (0.4 + slow + 0.3 * noise(i as u32, seed + 1 + u32::from(base)));
    }
    field
}

/// From 0 to 1, by a hash (the finaliser of MurmurHash3, Appleby 2008).
pub fn noise(at: u32, seed: u32) -> f32 {
    let mut h = at.wrapping_mul(0x9E37_79B9) ^ seed.wrapping_mul(0x85EB_CA6B);
    h = (h ^ (h >> 16)).wrapping_mul(0x85EB_CA6B);
    h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
    ((h ^ (h >> 16)) >> 8) as f32 / (1 << 24) as f32
}

/// The bytes of a library.
///
/// # Panics
/// If a plant has fields that no encoder takes.
pub fn bytes(plants: &[SpeciesFields], codec: Codec) -> Vec<u8> {
    let coded: Vec<_> = plants
        .iter()
        .map(|plant| encode_species(plant, &settings(codec), &|_| Ok(())).expect("these are good fields"))
        .collect();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &coded.iter().collect::<Vec<_>>()).expect("memory takes it");
    bytes
}

/// Three plants of the three kinds of suns.
pub fn three() -> Vec<SpeciesFields> {
    let harmonics = SunBasis::Harmonics { degree: 2, single: true, leaning: false };
    vec![
        plant("oak", None, 64, 1),
        plant("pine", Some(&SunBasis::Lattice18), 32, 2),
        plant("shrub", Some(&harmonics), 16, 3),
    ]
}
