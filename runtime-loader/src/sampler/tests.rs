use std::sync::LazyLock;

use flb_format::matter::{BandOptics, ClassOptics, Optics};
use flb_format::meta::{Bounds, LeftOut, TriangleCounts};
use flb_format::model::Model;
use flb_format::sample::trilinear;
use flb_format::sun::{blend, towards_sun};
use flb_format::{Codec, Field, Medium, SpeciesFields, SpeciesMeta};
use flb_packer::{EncodeSettings, encode_species, write_library_to};
use proptest::prelude::*;

use super::*;

const N: u32 = 16;
/// Values are of magnitude 20; up to 64 products per base and four bases.
const ROUNDING: f32 = 20.0 * 256.0 * f32::EPSILON;

fn grid() -> Grid {
    Grid { lattice: N, origin_m: [-0.8, 0.1, 2.0], spacing_m: 0.25 }
}

/// A field that is smooth in places, constant in others, different for every base and band.
fn field(base: u8, bands: u32) -> Field {
    let mut field = Field::zeros(N, bands);
    for (i, value) in field.values_mut().iter_mut().enumerate() {
        let (x, y, z) = (i % 16, i / 16 % 16, i / 256 % 16);
        let wave = ((x * 7 + y * 3 + z * 5 + i / 4096 * 11) % 13) as f32 * 0.05;
        let peak = if base == 0 { 18.0 } else { 1.0 };
        *value = if x < 4 { peak } else { peak * (0.3 + wave + f32::from(base) * 0.01) };
    }
    field
}

fn fields(bands: u32, bases: &[u8]) -> SpeciesFields {
    let optics = ClassOptics { sigma_a: 0.1, g: 0.0 };
    let band = |b: u32| BandOptics { name: format!("band{b}"), leaf: optics, wood: optics };
    SpeciesFields {
        meta: SpeciesMeta {
            name: "oak".to_owned(),
            model: Model::Paper { optics: Optics { bands: (0..bands).map(band).collect() } },
            grid: grid(),
            bounds_m: Bounds { min: [0.0, 1.0, 3.0], max: [1.0, 2.0, 4.0] },
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
        medium: Medium::empty(grid()),
        turbid: None,
        bases: bases.iter().map(|&base| (base, field(base, bands))).collect(),
    }
}

fn library(fields: &SpeciesFields, codec: Codec) -> Library {
    // Small pages, so that a base has several.
    let settings = EncodeSettings { codec, compress: true, page_bytes: 20_480, ..EncodeSettings::papers() };
    let encoded = encode_species(fields, &settings, &|_| Ok(())).unwrap();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[&encoded]).unwrap();
    Library::from_source("oak.flb", Box::new(bytes)).unwrap()
}

/// The fields as a file gives them back.
fn as_stored(library: &Library) -> Vec<(u8, Field)> {
    let bases = library.container().species()[0].bases.iter().map(|base| base.base);
    let field = |base| library.container().read_field(library.source(), 0, base).expect("the base reads");
    bases.map(|base| (base, field(base))).collect()
}

fn assert_near(found: &[f32], expected: &[f32], what: &str) {
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= ROUNDING, "{what}: {found:?} for {expected:?}");
    }
}

/// Points inside, on texels, on faces and outside, in model space.
fn points() -> Vec<[f32; 3]> {
    let along = [-100.0f32, -0.5, 0.0, 0.124, 0.125, 0.5, 0.875, 1.0, 1.99, 2.875, 3.875, 4.0, 77.0];
    let axis = |a: usize, c: f32| grid().origin_m[a] as f32 + c;
    let mut points = Vec::new();
    for (i, &x) in along.iter().enumerate() {
        for (j, &y) in along.iter().enumerate() {
            points.push([axis(0, x), axis(1, y), axis(2, along[(i * 5 + j * 3) % along.len()])]);
        }
    }
    points
}

#[test]
fn samples_of_every_codec_are_those_of_the_field_for_any_number_of_bands() {
    for bands in [1, 2, 3, 4] {
        let fields = fields(bands, &[0, 5, 18]);
        for codec in Codec::ALL {
            let library = library(&fields, codec);
            let stored = as_stored(&library);
            let base = library.container().find_base(0, 5).unwrap();
            let section = base.detail.unwrap_or(base.section);
            let small = bands < 3 || codec.is_near_geometry();
            assert!(library.container().pages(section).len() > 1 || small, "a base of several pages");
            let sampler = SpeciesSampler::load(&library, 0, &[0, 5, 18]).unwrap();
            for point in points() {
                let at = grid().lattice_from_model(point.map(f64::from));
                for (base, field) in &stored {
                    let (mut found, mut expected) =
                        (vec![f32::NAN; bands as usize], vec![0.0; bands as usize]);
                    sampler.sample(*base, point, &mut found);
                    trilinear(field, at, &mut expected);
                    assert_near(&found, &expected, &format!("{codec:?}, base {base} at {point:?}"));
                }
            }
        }
    }
}

#[test]
fn bands_that_are_chosen_are_those_of_the_file_in_the_order_asked_for() {
    let fields = fields(4, &[0, 5]);
    for codec in Codec::ALL {
        let whole = SpeciesSampler::load(&library(&fields, codec), 0, &[5]).unwrap();
        for bands in [&[2, 1, 0][..], &[3], &[3, 3, 0], &[0, 1, 2, 3], &[1, 3]] {
            let chosen = library(&fields, codec).with_bands(0, bands);
            assert_eq!(chosen.container().species()[0].meta.band_count(), bands.len());
            let field = chosen.container().read_field(chosen.source(), 0, 5).unwrap();
            let all = library(&fields, codec);
            let all = all.container().read_field(all.source(), 0, 5).unwrap();
            for (place, &band) in (0..).zip(bands) {
                assert_near(&field.band(place), &all.band(band as u32), &format!("{codec:?}, {bands:?}"));
            }
            let sampler = SpeciesSampler::load(&chosen, 0, &[5]).unwrap();
            // Chosen among those that were chosen.
            let last = SpeciesSampler::load(&chosen.with_bands(0, &[bands.len() - 1]), 0, &[5]).unwrap();
            for point in points() {
                let (mut found, mut expected) = (vec![f32::NAN; bands.len()], [0.0; 4]);
                sampler.sample(5, point, &mut found);
                whole.sample(5, point, &mut expected);
                let picked: Vec<f32> = bands.iter().map(|&band| expected[band]).collect();
                assert_near(&found, &picked, &format!("{codec:?}, {bands:?} at {point:?}"));
                let mut one = [f32::NAN];
                last.sample(5, point, &mut one);
                assert_near(&one, &picked[bands.len() - 1..], "the last");
            }
        }
    }
}

#[test]
fn a_point_that_is_nan_or_infinite_is_clamped() {
    for codec in Codec::ALL {
        let sampler = SpeciesSampler::load(&library(&fields(3, &[1]), codec), 0, &[1]).unwrap();
        let mut out = [f32::NAN; 3];
        for point in [[f32::NAN; 3], [f32::INFINITY; 3], [f32::NEG_INFINITY, 0.0, f32::MAX]] {
            sampler.sample(1, point, &mut out);
            assert!(out.iter().all(|v| v.is_finite()));
        }
    }
}

#[test]
fn a_missing_base_is_named_at_loading() {
    let library = library(&fields(3, &[0, 3, 7]), Codec::HaarPaper);
    let error = SpeciesSampler::load(&library, 0, &[3, 4]).err().expect("refused");
    assert_eq!(
        error.to_string(),
        "oak.flb: species \"oak\" has no base 4, which the light needs; it has 0, 3, 7"
    );
    assert!(matches!(
        SpeciesSampler::load(&library, 0, &[200]),
        Err(RuntimeError::MissingBase { base: 200, .. })
    ));
    let error = SpeciesSampler::load(&library, 1, &[3]).err().expect("refused");
    assert_eq!(error.to_string(), "oak.flb: asked for species 1, the library holds 1");
}

#[test]
fn a_base_that_was_left_out_is_refused_with_the_reason_and_never_dark() {
    let mut fields = fields(3, &[0, 3, 7]);
    let reason = "upright plants under the whole sky".to_owned();
    fields.meta.left_out = Some(LeftOut { bases: [4, 5].into_iter().collect(), bands: vec![], reason });
    let library = library(&fields, Codec::HaarPaper);
    let refusal = |bases: &[u8]| SpeciesSampler::load(&library, 0, bases).err().expect("refused").to_string();
    assert_eq!(
        refusal(&[3, 4]),
        "oak.flb: species \"oak\" has no base 4, which the light needs: it was left out (upright plants under the whole sky)"
    );
    assert!(refusal(&[6]).contains("it has 0, 3, 7"), "base 6 is missing, and no message says why");
    SpeciesSampler::load(&library, 0, &[0, 3, 7]).expect("the others are there");
}

#[test]
fn a_base_without_weight_is_not_asked_for() {
    // Straight down, and between two neighbours.
    let down = flb_format::sun::blend([0.0, 1.0, 0.0]).expect("a direction");
    assert_eq!((bases_needed(&down, false), bases_needed(&down, true)), (vec![4], vec![0, 4]));
    let edge = flb_format::sun::blend([0.25, 1.0, 0.0]).expect("a direction");
    assert_eq!(bases_needed(&edge, false), [4, 8]);
}

#[test]
fn only_what_was_asked_for_is_loaded() {
    let library = library(&fields(3, &[0, 3, 7]), Codec::HaarPaper);
    let sampler = SpeciesSampler::load(&library, 0, &[7, 7]).unwrap();
    assert!(sampler.has_base(7) && !sampler.has_base(0) && !sampler.has_base(3) && !sampler.has_base(99));
    let all = SpeciesSampler::load(&library, 0, &[0, 3, 7]).unwrap();
    assert!(all.size_bytes() > 2 * sampler.size_bytes());
}

#[test]
fn a_page_with_a_flipped_bit_is_refused_at_loading() {
    let settings = EncodeSettings { page_bytes: 20_480, ..EncodeSettings::papers() };
    let encoded = encode_species(&fields(3, &[1, 2]), &settings, &|_| Ok(())).unwrap();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[&encoded]).unwrap();
    let intact = Library::from_source("oak.flb", Box::new(bytes.clone())).unwrap();
    let section = intact.container().find_base(0, 2).unwrap().section;
    let page = intact.container().pages(section)[1];
    bytes[page.offset as usize + 100] ^= 1;
    let library = Library::from_source("oak.flb", Box::new(bytes)).unwrap();
    assert!(SpeciesSampler::load(&library, 0, &[1]).is_ok());
    let error = SpeciesSampler::load(&library, 0, &[2]).err().expect("refused").to_string();
    assert!(error.starts_with("oak.flb: ") && error.contains("page 1"), "{error}");
}

#[test]
fn mapped_and_positioned_libraries_give_the_same_light() {
    let encoded = encode_species(&fields(3, &[1]), &EncodeSettings::papers(), &|_| Ok(())).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("oak.flb");
    write_library_to(&mut std::fs::File::create(&path).unwrap(), &[&encoded]).unwrap();
    let mapped = SpeciesSampler::load(&Library::open_mapped(&path).unwrap(), 0, &[1]).unwrap();
    let read = SpeciesSampler::load(&Library::open(&path).unwrap(), 0, &[1]).unwrap();
    for point in points() {
        let (mut a, mut b) = ([0.0; 3], [1.0; 3]);
        mapped.sample(1, point, &mut a);
        read.sample(1, point, &mut b);
        assert_eq!(a, b);
    }
}

#[test]
fn a_file_that_is_not_a_container_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("not.flb");
    std::fs::write(&path, b"PK\x03\x04 and so on").unwrap();
    for library in [Library::open_mapped(&path), Library::open(&path)] {
        let error = library.err().expect("refused").to_string();
        assert!(error.contains("not.flb: "), "{error}");
    }
}

#[test]
fn bases_of_no_weight_are_not_needed() {
    let overhead = blend([0.0, 1.0, 0.0]).unwrap();
    assert_eq!(bases_needed(&overhead, false), [4]);
    assert_eq!(bases_needed(&overhead, true), [0, 4]);
    let oblique = blend([0.4, 0.8, 0.6]).unwrap();
    assert_eq!(bases_needed(&oblique, true).len(), 4);

    let library = library(&fields(3, &[4]), Codec::HaarPaper);
    let sampler = SpeciesSampler::load(&library, 0, &[4]).unwrap();
    let (mut light, mut alone) = ([0.0; 3], [0.0; 3]);
    sampler.indirect(&overhead, 2.0, 0.0, [0.0, 1.0, 3.0], &mut light);
    sampler.sample(4, [0.0, 1.0, 3.0], &mut alone);
    assert_eq!(light, alone.map(|v| 2.0 * v));
}

#[test]
#[should_panic(expected = "base 9 was not loaded")]
fn sampling_a_base_that_was_not_loaded_says_which() {
    let sampler = SpeciesSampler::load(&library(&fields(1, &[1]), Codec::HaarPaper), 0, &[1]).unwrap();
    sampler.sample(9, [0.0; 3], &mut [0.0]);
}

/// Fields by base.
type Stored = Vec<(u8, Field)>;

/// All bases in every codec, and as they are stored.
static WHOLE: LazyLock<Vec<(Library, Stored)>> = LazyLock::new(|| {
    let fields = fields(3, &(0..=18).collect::<Vec<u8>>());
    let coded = Codec::ALL.into_iter().map(|codec| library(&fields, codec));
    coded.map(|library| (as_stored(&library), library)).map(|(stored, library)| (library, stored)).collect()
});

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn indirect_is_the_blend_of_three_bases_and_ambient(
        azimuth in 0.0f64..360.0, elevation in -90.0f64..90.0, sun in 0.0f32..2.0, ambient in 0.0f32..0.5,
        point in prop::array::uniform3(-1.0f32..6.0)
    ) {
        let blend = blend(towards_sun(azimuth, elevation)).unwrap();
        for (library, stored) in WHOLE.iter() {
            let sampler = SpeciesSampler::load(library, 0, &bases_needed(&blend, true)).unwrap();
            let (mut found, mut expected, mut one) = ([f32::NAN; 3], [0.0f32; 3], [0.0f32; 3]);
            sampler.indirect(&blend, sun, ambient, point, &mut found);
            let at = grid().lattice_from_model(point.map(f64::from));
            let terms = (0..3).map(|k| (blend.bases[k], sun * blend.weights[k])).chain([(0, ambient)]);
            for (base, factor) in terms {
                trilinear(&stored[base as usize].1, at, &mut one);
                for band in 0..3 { expected[band] += factor * one[band]; }
            }
            for band in 0..3 {
                prop_assert!((found[band] - expected[band]).abs() <= ROUNDING, "{found:?} for {expected:?}");
            }
        }
    }
}
