//! Fields that are made from formulas.

use std::collections::BTreeMap;

use flb_format::light::{FieldKind, Light, LightError, MonteCarloError, SunBasis};
use flb_format::matter::{
    BandSurfaces, Class, LeafAngles, LeafSurface, Optics, Surfaces, TurbidMedium, WoodSurface,
};
use flb_format::meta::{Bounds, SourceFile, TriangleCounts};
use flb_format::model::Model;
use flb_format::sun::directions::SunDirections;
use flb_format::sun::towards_sun;
use flb_format::{Field, Grid, Medium, SpeciesFields, SpeciesMeta};
use flb_packer::{EncodeSettings, encode_species, write_library_to};

/// Exact arithmetic only, so that every machine grows the same numbers.
fn field(lattice: u32, base: u8, bands: u32) -> Field {
    let mut field = Field::zeros(lattice, bands);
    let n = lattice as usize;
    let scale = if base == 0 { 18.0 } else { 1.0 };
    for (i, value) in field.values_mut().iter_mut().enumerate() {
        let (x, y, z, band) = (i % n, i / n % n, i / (n * n) % n, i / (n * n * n));
        let ramp = (x * (1 + base as usize % 3) + 2 * y + z + 1) as f32 / 80.0;
        let bump = if (x * 7 + y * 3 + z * 5 + band) % 11 == 0 { 0.0625 } else { 0.0 };
        // An empty corner gives blocks with mask 0, a flat one blocks with mask 1.
        *value = match (x < 7 && y < 7, z < 7) {
            (true, true) => 0.0,
            (true, false) => scale * 0.5 / (band + 1) as f32,
            _ => scale * (ramp + bump) / (band + 1) as f32,
        };
    }
    field
}

fn medium(grid: Grid) -> Medium {
    let sites = grid.sites();
    let mut medium = Medium::empty(grid);
    let n = grid.lattice as i32;
    for i in 0..sites {
        let [x, y, z] = grid.site(i).map(|c| c as i32);
        let squared = (2 * x - n + 1).pow(2) + (2 * y - n + 1).pow(2) + (2 * z - n + 1).pow(2);
        if squared >= 144 {
            continue;
        }
        medium.density[i] = (squared + 1) as f32 / 144.0;
        let wood = squared < 27;
        medium.class[i] = if wood { Class::Wood } else { Class::Leaf };
        let area = if wood { &mut medium.wood_area_density } else { &mut medium.leaf_area_density };
        area[i] = 1.0 / (squared + 2) as f32;
    }
    medium
}

pub(crate) fn species(name: &str, bands: u32, bases: &[u8]) -> SpeciesFields {
    species_at(16, name, bands, bases)
}

/// On any lattice; the same ball of 12 sites across in its middle.
pub(crate) fn species_at(lattice: u32, name: &str, bands: u32, bases: &[u8]) -> SpeciesFields {
    let grid = Grid { lattice, origin_m: [-1.0, 0.0, -1.0], spacing_m: 0.125 };
    let mut optics = Optics::paper();
    optics.bands.truncate(bands as usize);
    let meta = SpeciesMeta {
        name: name.to_owned(),
        model: Model::Paper { optics },
        grid,
        bounds_m: Bounds { min: [-0.75, 0.25, -0.75], max: [0.75, 1.75, 0.75] },
        triangles: TriangleCounts { total: 12, leaf: 8, wood: 4 },
        mesh_blake3: None,
        mean_light: None,
        sky_averages: None,
        sources: vec![SourceFile { name: format!("{name}.glb"), blake3: "0123456789abcdef".repeat(4) }],
        settings: BTreeMap::from([("solve.tolerance".to_owned(), serde_json::json!(1e-7))]),
        tool: "flb golden".to_owned(),
        left_out: None,
        extra: BTreeMap::from([("note".to_owned(), serde_json::json!("é\u{1}\"\\"))]),
    };
    let bases = bases.iter().map(|base| (*base, field(lattice, *base, bands))).collect();
    SpeciesFields { meta, medium: medium(grid), turbid: None, bases }
}

/// Extinction where the medium has matter; more leaf above, more wood below.
fn turbid(grid: Grid, angles: LeafAngles) -> TurbidMedium {
    let per_m = |share: fn(f32) -> f32| -> Vec<f32> {
        let of_site = |(i, density): (usize, &f32)| density * share((i / 16 % 16) as f32 / 16.0);
        medium(grid).density.iter().enumerate().map(of_site).collect()
    };
    TurbidMedium { grid, leaf_per_m: per_m(|y| 4.0 * y), wood_per_m: per_m(|y| 0.5 - y / 2.0), angles }
}

/// Of the model `physical`. Coefficients of harmonics may be negative, and their base 0 is not 18 times as bright.
pub(crate) fn physical(name: &str, suns: SunBasis, field_kind: FieldKind, bases: &[u8]) -> SpeciesFields {
    let mut fields = species(name, 2, bases);
    let band = |name: &str, reflectance: f64| BandSurfaces {
        name: name.to_owned(),
        leaf: LeafSurface { reflectance, transmittance: 0.375 },
        wood: WoodSurface { reflectance: 0.25 },
    };
    let angles = match suns {
        SunBasis::Lattice18 | SunBasis::Directions(_) => LeafAngles::spherical(),
        SunBasis::Harmonics { .. } => {
            LeafAngles::from_areas(std::array::from_fn(|bin| 1.0 + bin as f64)).expect("areas above 0")
        }
    };
    let monte_carlo = MonteCarloError { rms: 0.021, bias: -0.004, photons: 1_000_000, suns: 20 };
    let light = Light {
        field: field_kind,
        ordinates: 50,
        rays: 2,
        suns,
        leaf_angles: angles.clone(),
        error: LightError {
            suns_rms: 0.0125,
            held_out: 30,
            solver: 1e-4,
            monte_carlo: (field_kind == FieldKind::Total).then_some(monte_carlo),
        },
        solid_offset: None,
    };
    let surfaces = Surfaces { bands: vec![band("red", 0.0625), band("near infrared", 0.5)] };
    fields.meta.model = Model::Physical { surfaces, light };
    fields.turbid = Some(turbid(fields.meta.grid, angles));
    for (base, field) in &mut fields.bases {
        let change: fn(f32) -> f32 = if *base == 0 { |v| v / 18.0 } else { |v| v - 0.25 };
        field.values_mut().iter_mut().for_each(|value| *value = change(*value));
    }
    fields
}

/// The bytes of a library.
/// With all bases that its suns ask for.
pub(crate) fn whole(name: &str, suns: SunBasis) -> SpeciesFields {
    let bases: Vec<u8> = suns.item_numbers().collect();
    physical(name, suns, FieldKind::Scattered, &bases)
}

/// Suns straight up, straight down, and `around` the horizon; with 4 of them an octahedron's corners.
pub(crate) fn bipyramid(around: u32) -> SunBasis {
    let mut directions = vec![[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
    directions.extend((0..around).map(|k| towards_sun(360.0 * f64::from(k) / f64::from(around), 0.0)));
    let next = |k: u32| 2 + (k + 1) % around;
    let upper = (0..around).map(|k| [0, next(k), 2 + k]);
    let lower = (0..around).map(|k| [1, 2 + k, next(k)]);
    let mut triangles: Vec<[u32; 3]> = upper.chain(lower).collect();
    triangles.sort_unstable();
    SunBasis::Directions(SunDirections::new(directions, triangles).expect("a bipyramid is closed").into())
}

pub(crate) fn pack(fields: &[SpeciesFields], settings: &EncodeSettings) -> Vec<u8> {
    let coded: Vec<_> = fields
        .iter()
        .map(|f| encode_species(f, settings, &|_| Ok(())).expect("golden fields encode"))
        .collect();
    let mut bytes = Vec::new();
    let length = write_library_to(&mut bytes, &coded.iter().collect::<Vec<_>>()).expect("it fits");
    assert_eq!(length, bytes.len() as u64);
    bytes
}
