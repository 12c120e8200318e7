//! `golden/shrub.flb`, on which the crate's first example runs: a file of the kind that `flb bake` makes by default,
//! but small.
//!
//! `FLB_WRITE_GOLDEN=1` with this test writes it anew.

use std::path::PathBuf;

use flb_format::Field;
use flb_format::sample::site_of;

use super::*;

/// The model `physical`, thirteen bases of harmonics of degree 2 and the near beam, coded as `classed`; of fields that
/// are smooth, so that it stays small.
fn shrub() -> SpeciesFields {
    let mut fields =
        plant("shrub", Some(&SunBasis::Harmonics { degree: 2, single: true, leaning: false }), LATTICE, 3);
    fields.bases.iter_mut().for_each(|(base, field)| *field = smooth(*base));
    fields
}

/// Brighter towards the top and, for some bases, the east or the south.
fn smooth(base: u8) -> Field {
    let mut field = Field::zeros(LATTICE, BANDS as u32);
    let sites = (LATTICE as usize).pow(3);
    for (i, value) in field.values_mut().iter_mut().enumerate() {
        let [x, y, z] = site_of(i % sites, LATTICE).map(|c| c as f32 / LATTICE as f32);
        let band = 1.0 + (i / sites) as f32;
        *value = match base {
            0 => 0.3 * (0.2 + 0.8 * y) / band,
            base => 0.05 * (y + [x, z, 1.0 - x][usize::from(base % 3)]) / (band * f32::from(base)),
        };
    }
    field
}

#[test]
fn the_file_of_the_first_example_is_what_is_written_today() {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/golden/shrub.flb"));
    let settings = EncodeSettings { compress: true, ..plants::settings(Codec::Classed) };
    let coded = encode_species(&shrub(), &settings, &|_| Ok(())).expect("good fields");
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[&coded]).expect("memory takes it");
    if std::env::var_os("FLB_WRITE_GOLDEN").is_some() {
        std::fs::write(&path, &bytes).expect("the folder is writable");
    }
    assert_eq!(std::fs::read(&path).expect("it is committed"), bytes);
    assert!(bytes.len() < 16 << 10, "{} bytes are not small", bytes.len());
}
