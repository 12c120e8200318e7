//! Libraries of species without leaves: as many bytes as a test needs.

use flb_format::matter::{BandOptics, ClassOptics, Optics};
use flb_format::meta::{Bounds, TriangleCounts};
use flb_format::model::Model;
use flb_format::{Codec, Field, Grid, Medium, SpeciesFields, SpeciesMeta};
use flb_packer::{EncodeSettings, encode_species, write_library_to};

/// Bases of every species.
pub(crate) const BASES: [u8; 3] = [0, 4, 7];

/// The values of a base: another in every site, and with every `seed`.
pub(crate) fn field(lattice: u32, base: u8, seed: u32) -> Field {
    let mut field = Field::zeros(lattice, 1);
    for (i, value) in field.values_mut().iter_mut().enumerate() {
        *value = (i as u32 * 7 + seed * 131 + u32::from(base) * 1009) as f32 / 1e6;
    }
    field
}

/// A library of one species per name, whose values depend on `seed` plus its number: plain floats in pages of 64 KiB.
pub(crate) fn forest(names: &[&str], lattice: u32, seed: u32) -> Vec<u8> {
    let grid = Grid { lattice, origin_m: [0.0; 3], spacing_m: 0.1 };
    let optics = ClassOptics { sigma_a: 0.1, g: 0.0 };
    let bands = vec![BandOptics { name: "light".to_owned(), leaf: optics, wood: optics }];
    let species = |(number, name): (u32, &&str)| {
        let fields = SpeciesFields {
            meta: SpeciesMeta {
                name: (*name).to_owned(),
                model: Model::Paper { optics: Optics { bands: bands.clone() } },
                grid,
                bounds_m: Bounds { min: [0.0; 3], max: [1.0; 3] },
                triangles: TriangleCounts::default(),
                mesh_blake3: None,
                mean_light: None,
                sky_averages: None,
                sources: Vec::new(),
                settings: Default::default(),
                tool: "flb 0.1.0".to_owned(),
                left_out: None,
                extra: Default::default(),
            },
            medium: Medium::empty(grid),
            turbid: None,
            bases: BASES.iter().map(|&base| (base, field(lattice, base, seed + number))).collect(),
        };
        let settings = EncodeSettings { codec: Codec::RawF32, ..EncodeSettings::papers() };
        encode_species(&fields, &settings, &|_| Ok(())).expect("these are good fields")
    };
    let coded: Vec<_> = (0..).zip(names).map(species).collect();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &coded.iter().collect::<Vec<_>>()).expect("memory takes it");
    bytes
}
