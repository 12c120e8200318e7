//! A library of one species, a crown whose fields a benchmark makes by a formula.

use flb_format::matter::{BandOptics, ClassOptics, Optics};
use flb_format::meta::{Bounds, TriangleCounts};
use flb_format::model::Model;
use flb_format::{Codec, Field, Medium, SpeciesFields, SpeciesMeta};
use flb_packer::{EncodeSettings, encode_species, write_library_to};

/// Its bytes, coded at the default quality.
///
/// # Panics
/// If the fields do not fit the medium.
pub fn bytes(bounds_m: Bounds, medium: Medium, bases: Vec<(u8, Field)>) -> Vec<u8> {
    let optics = ClassOptics { sigma_a: 0.1, g: 0.0 };
    let band = |name: &str| BandOptics { name: name.to_owned(), leaf: optics, wood: optics };
    let meta = SpeciesMeta {
        name: "crown".to_owned(),
        model: Model::Paper { optics: Optics { bands: ["R", "G", "B"].map(band).to_vec() } },
        grid: medium.grid,
        bounds_m,
        triangles: TriangleCounts::default(),
        mesh_blake3: None,
        mean_light: None,
        sky_averages: None,
        sources: Vec::new(),
        settings: Default::default(),
        tool: "flb bench".to_owned(),
        left_out: None,
        extra: Default::default(),
    };
    let fields = SpeciesFields { meta, medium, turbid: None, bases };
    let settings = EncodeSettings { codec: Codec::Classed, ..EncodeSettings::papers() };
    let coded = encode_species(&fields, &settings, &|_| Ok(())).expect("it encodes");
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[&coded]).expect("it is written to memory");
    bytes
}
