//! The golden files under `format-spec/golden/`: made here from formulas, and never to change. An encoder that chooses
//! otherwise makes another file, and the one before stays for readers, whose tests take every file of the folder:
//! `classed-first.flb` is `classed.flb` as it was before sums for pairs of rows were shared, its values the last bit
//! away. `FLB_WRITE_GOLDEN=1 cargo test -p flb-packer --test it golden` writes them anew.

use std::path::PathBuf;

use crate::common::{bipyramid, pack, physical, species, whole};
use flb_format::light::{FieldKind, SunBasis};
use flb_format::matter::Class;
use flb_format::meta::LeftOut;
use flb_format::{Codec, Container, SpeciesFields};
use flb_packer::rate::Target;
use flb_packer::{
    EncodeSettings, StoredBlocks, copy_species, encode_species, load_species, write_library_to,
};

fn golden() -> Vec<(&'static str, Vec<SpeciesFields>, EncodeSettings)> {
    let haar = |threshold, compress| EncodeSettings {
        codec: Codec::HaarPaper,
        threshold,
        compress,
        page_bytes: 20_480,
        ..EncodeSettings::papers()
    };
    let near =
        |codec, target, blocks, compress| EncodeSettings { codec, target, blocks, ..haar(0.0, compress) };
    let raw = EncodeSettings { codec: Codec::RawF32, ..haar(0.0, false) };
    let f16 = EncodeSettings { codec: Codec::RawF16, ..raw.clone() };
    let lattice18 = |name| physical(name, SunBasis::Lattice18, FieldKind::Scattered, &[4]);
    let mut part = species("part", 2, &[0, 4, 9]);
    let bases = [3, 7, 10, 15, 17].into_iter().collect();
    let reason = "upright plants under the whole sky; band B is not drawn".to_owned();
    part.meta.left_out = Some(LeftOut { bases, bands: vec!["B".to_owned()], reason });
    let harmonics = SunBasis::Harmonics { degree: 1, single: false, leaning: false };
    let all: Vec<u8> = harmonics.item_numbers().collect();
    let mut total = physical("total", SunBasis::Lattice18, FieldKind::Total, &[0, 4]);
    let bases = [3, 7].into_iter().collect();
    total.meta.left_out =
        Some(LeftOut { bases, bands: vec!["green".to_owned()], reason: "no sun".to_owned() });
    let scattered = physical("scattered", harmonics, FieldKind::Scattered, &all);
    let once = SunBasis::Harmonics { degree: 1, single: true, leaning: false };
    let once = whole("once", once);
    let leaning = whole("leaning", SunBasis::Harmonics { degree: 1, single: true, leaning: true });
    let near_physical = physical(
        "once",
        SunBasis::Harmonics { degree: 1, single: true, leaning: false },
        FieldKind::Scattered,
        &all[..8],
    );
    // Of two versions of a species, the second with half of base 4.
    let mut second = species("second", 3, &[0, 4]);
    second.bases[1].1.values_mut().iter_mut().for_each(|value| *value *= 0.5);
    // The digest of the mesh that it was made of.
    let mut of_mesh = species("sphere", 1, &[4]);
    of_mesh.meta.mesh_blake3 = Some("fedcba9876543210".repeat(4));
    vec![
        (
            "classed",
            vec![species("sphere", 3, &[0, 4]), species("other", 1, &[18])],
            near(Codec::Classed, Target::Psnr(45.0), StoredBlocks::Usual, false),
        ),
        (
            "classed-all-blocks",
            vec![near_physical],
            near(Codec::Classed, Target::Psnr(40.0), StoredBlocks::All, true),
        ),
        (
            "haar",
            vec![species("sphere", 3, &[0, 4])],
            near(Codec::Haar, Target::Psnr(45.0), StoredBlocks::Usual, true),
        ),
        (
            "directions",
            vec![whole("octahedron", bipyramid(4)), whole("bipyramid", bipyramid(33))],
            near(Codec::Haar, Target::Psnr(30.0), StoredBlocks::Usual, false),
        ),
        ("physical-single", vec![once], haar(0.02, true)),
        ("leaning", vec![leaning, species("paper", 1, &[4])], haar(0.02, false)),
        ("physical", vec![scattered, total, species("paper", 1, &[4])], haar(0.01, false)),
        ("raw-f32", vec![species("sphere", 3, &[0, 1])], raw.clone()),
        ("shared", vec![species("first", 3, &[0, 4]), second], haar(0.01, true)),
        ("raw-f16", vec![species("sphere", 3, &[0, 1]), lattice18("leafy")], f16),
        ("haar-paper-exact", vec![species("sphere", 2, &[7])], haar(0.0, false)),
        ("haar-paper", vec![species("sphere", 3, &[0, 4]), species("other", 1, &[18])], haar(0.01, false)),
        ("haar-paper-zstd", vec![species("sphere", 3, &[0, 4])], haar(0.005, true)),
        ("left-out", vec![part], haar(0.01, false)),
        ("mesh", vec![of_mesh], haar(0.05, false)),
    ]
}

fn path(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../format-spec/golden")).join(format!("{name}.flb"))
}

#[test]
fn the_writer_reproduces_every_golden_file_for_any_thread_count() {
    for (name, fields, settings) in golden() {
        let bytes = pack(&fields, &settings);
        if std::env::var_os("FLB_WRITE_GOLDEN").is_some() {
            std::fs::write(path(name), &bytes).expect("the golden folder is writable");
        }
        let committed = std::fs::read(path(name)).expect("every golden file is committed");
        assert!(bytes == committed, "{name}: the writer's bytes differ from the committed file");
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a small pool");
            let again = pool.install(|| pack(&fields, &settings));
            assert!(again == committed, "{name}: other bytes with {threads} threads");
        }
    }
}

/// Files of the draft are kept as that version's writer made them, and are read for ever.
#[test]
fn files_of_the_draft_hold_what_those_of_version_1_hold_and_become_them_when_rewritten() {
    let drafts = [
        "haar-paper",
        "haar-paper-exact",
        "haar-paper-zstd",
        "left-out",
        "physical",
        "physical-single",
        "raw-f16",
        "raw-f32",
    ];
    for name in drafts {
        let draft = std::fs::read(path(&format!("v0.1/{name}"))).expect("the draft's files are committed");
        let container = Container::open(&draft).expect("a file of the draft opens");
        assert_eq!(container.format_version(), (0, 1), "{name}");
        let count = container.species().len();
        let copied: Vec<_> =
            (0..count).map(|i| copy_species(&container, &draft, i).expect("it can be copied")).collect();
        let mut migrated = Vec::new();
        write_library_to(&mut migrated, &copied.iter().collect::<Vec<_>>()).expect("a sound library");
        let committed = std::fs::read(path(name)).expect("every golden file is committed");
        assert!(
            migrated == committed,
            "{name}: migrated, it is not what the writer makes of the same fields"
        );
        let again = Container::open(&migrated).expect("it opens");
        assert_eq!(again.format_version(), (1, 0), "{name}");
        for i in 0..count {
            let [old, new] = [(&container, &draft), (&again, &migrated)]
                .map(|(container, bytes)| load_species(container, bytes, i).expect("it loads"));
            assert!(old == new, "{name}: species {i} is another");
        }
    }
}

#[test]
fn what_was_packed_is_what_is_loaded() {
    for (name, fields, settings) in golden() {
        let bytes = pack(&fields, &settings);
        let container = Container::open(&bytes).expect("the writer's own file opens");
        for (i, expected) in fields.iter().enumerate() {
            let loaded = load_species(&container, &bytes, i).expect("the writer's own file loads");
            assert_eq!(loaded.medium, expected.medium, "{name}");
            assert_eq!(loaded.turbid, expected.turbid, "{name}");
            assert_eq!(loaded.meta.model, expected.meta.model, "{name}");
            let expected_meta = &expected.meta;
            for ((_, found), (base, expected)) in loaded.bases.iter().zip(&expected.bases) {
                let unit = expected_meta.model.empty_value(*base);
                let sites = expected_meta.grid.sites();
                for (i, (a, b)) in found.values().iter().zip(expected.values().iter()).enumerate() {
                    let limit = coding_limit(&settings, unit, *b);
                    // Away from geometry there may be the coarse level alone.
                    let is_near = loaded.medium.class[i % sites] != Class::Empty;
                    if is_near || !settings.codec.is_near_geometry() {
                        assert!((a - b).abs() <= limit, "{name}, base {base}: {a} for {b}");
                    }
                }
            }
            assert_eq!(loaded.meta.extra, expected.meta.extra);
            assert_eq!(loaded.meta.mesh_blake3, expected.meta.mesh_blake3);
            assert_eq!(loaded.meta.settings["solve.tolerance"], 1e-7);
        }
    }
}

/// Whether a coding leaves nothing for the next one of its kind to change.
fn is_raw(codec: Codec) -> bool {
    matches!(codec, Codec::RawF32 | Codec::RawF16)
}

/// Most that a value of a base may be off after coding; `unit` is the base's value in empty space.
fn coding_limit(settings: &EncodeSettings, unit: f32, value: f32) -> f32 {
    match settings.codec {
        Codec::RawF32 => 0.0,
        // Half of the last of 11 bits, or of the step between subnormal numbers: SPEC.md, section 8.1.
        Codec::RawF16 => (value.abs() / 2048.0).max(1.0 / 33_554_432.0),
        // 64 coefficients, of which a texel sums 1 average and 6 or fewer details per axis
        // combination, each off by at most the threshold; f32 rounding on top.
        Codec::HaarPaper => unit * (settings.threshold * 26.0 + 1e-6),
        // Eight times the root of the mean square error, of a peak of 1.2 times the value in empty space.
        Codec::Classed | Codec::Haar => {
            let psnr_db = settings.target.errors().0.expect("a mean error is asked for");
            unit * 9.6 * libm::exp10(-psnr_db / 20.0) as f32
        }
    }
}

#[allow(clippy::ptr_arg, reason = "an unsized slice makes no &dyn Source")]
fn load_all(bytes: &Vec<u8>) -> Vec<SpeciesFields> {
    let container = Container::open(bytes).expect("it opens");
    let count = container.species().len();
    (0..count).map(|i| load_species(&container, bytes, i).expect("it loads")).collect()
}

#[test]
fn raw_codecs_pack_again_to_the_same_bytes() {
    for (name, fields, settings) in golden() {
        if is_raw(settings.codec) {
            let bytes = pack(&fields, &settings);
            assert!(pack(&load_all(&bytes), &settings) == bytes, "{name}");
        }
    }
}

#[test]
fn raw_f16_rounds_every_value_says_what_that_cost_and_sets_its_feature_bit() {
    let fields = [species("sphere", 3, &[0, 1])];
    let settings = |codec| EncodeSettings { codec, ..EncodeSettings::papers() };
    let (f32_bytes, f16_bytes) =
        (pack(&fields, &settings(Codec::RawF32)), pack(&fields, &settings(Codec::RawF16)));
    assert!(pack(&load_all(&f32_bytes), &settings(Codec::RawF16)) == f16_bytes, "by way of raw-f32");
    let features = |bytes| Container::open(bytes).expect("it opens").header().required_features;
    assert_eq!((features(&f32_bytes), features(&f16_bytes)), (0, 4));

    let rounded = load_all(&f16_bytes);
    let loss = rounded[0].meta.settings["encode.surface_psnr_db"].as_f64().expect("rounding has an error");
    // No sample is off by more than 2^-11 of the peak, 66 dB; rounding to f32 alone would leave more than 120.
    assert!((66.0..110.0).contains(&loss), "{loss} dB");
    assert!(rounded[0].bases[1].1 != fields[0].bases[1].1, "some values are no binary16");
    let wider = load_all(&pack(&rounded, &settings(Codec::RawF32)));
    assert_eq!(wider[0].bases, rounded[0].bases);
    assert_eq!(wider[0].meta.settings["encode.surface_psnr_db"], loss, "the loss is remembered");
}

#[test]
fn physical_species_pack_and_load_in_every_codec() {
    let suns = SunBasis::Harmonics { degree: 3, single: true, leaning: false };
    let fields = whole("oak", suns);
    for codec in Codec::ALL {
        let settings = EncodeSettings { codec, compress: true, ..EncodeSettings::papers() };
        let bytes = pack(std::slice::from_ref(&fields), &settings);
        let container = Container::open(&bytes).expect("it opens");
        let features = match codec {
            Codec::RawF16 => 7,
            Codec::Classed | Codec::Haar => 11,
            Codec::RawF32 | Codec::HaarPaper => 3,
        };
        assert_eq!(container.header().required_features, features, "zstd, physical, raw-f16, blocks");
        let loaded = load_species(&container, &bytes, 0).expect("it loads");
        assert_eq!((loaded.bases.len(), loaded.bases[19].0), (20, 19));
        assert_eq!(loaded.turbid, fields.turbid);
        for ((_, found), (_, expected)) in loaded.bases.iter().zip(&fields.bases) {
            for (i, (a, b)) in found.values().iter().zip(expected.values().iter()).enumerate() {
                let is_near = loaded.medium.class[i % loaded.medium.class.len()] != Class::Empty;
                if is_near || !codec.is_near_geometry() {
                    assert!((a - b).abs() <= coding_limit(&settings, 1.0, *b), "{codec:?}: {a} for {b}");
                }
            }
        }
        if is_raw(codec) {
            assert!(pack(&[loaded], &settings) == bytes, "packed again, the same bytes");
        }
    }
}

#[test]
fn copied_species_make_the_same_file_and_merge_with_others() {
    for (name, fields, settings) in golden() {
        let bytes = pack(&fields, &settings);
        let container = Container::open(&bytes).expect("it opens");
        let copies: Vec<_> =
            (0..fields.len()).map(|i| copy_species(&container, &bytes, i).expect("it copies")).collect();
        let mut again = Vec::new();
        write_library_to(&mut again, &copies.iter().collect::<Vec<_>>()).expect("it fits");
        assert!(again == bytes, "{name}: a copy differs");
    }
    let (_, fields, settings) =
        golden().into_iter().find(|(name, ..)| *name == "raw-f32").expect("it is there");
    let other = species("fourth", 1, &[3, 2]);
    let coded = encode_species(&other, &EncodeSettings::papers(), &|_| Ok(())).expect("it encodes");
    let bytes = pack(&fields, &settings);
    let container = Container::open(&bytes).expect("it opens");
    let copied = copy_species(&container, &bytes, 0).expect("it copies");
    let mut merged = Vec::new();
    write_library_to(&mut merged, &[&coded, &copied]).expect("it fits");
    let container = Container::open(&merged).expect("the merged file opens");
    assert_eq!(container.species().len(), 2);
    let bases: Vec<u8> = container.species()[0].bases.iter().map(|base| base.base).collect();
    assert_eq!(bases, [2, 3]);
    assert_eq!(container.find_species("sphere"), Some(1));
}
