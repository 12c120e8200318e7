//! What packing refuses, and what it reports about what it packs.

use std::collections::BTreeMap;

use flb_format::bases::BaseSet;
use flb_format::light::{FieldKind, Light, LightError, SunBasis};
use flb_format::matter::{
    BandSurfaces, Class, LeafAngles, LeafSurface, Optics, Surfaces, TurbidMedium, WoodSurface,
};
use flb_format::meta::{Bounds, TriangleCounts};
use flb_format::model::Model;
use flb_format::progress::Cancelled;
use flb_format::sun::directions::SunDirections;
use flb_format::{Codec, Container, Field, Grid, Medium, SpeciesFields, SpeciesMeta};
use flb_packer::leave_out::{keep_bases, keep_coded_bases};
use flb_packer::{EncodeSettings, EncodedSpecies, PackError, encode_species, write_library_to};

fn fields(name: &str) -> SpeciesFields {
    let grid = Grid { lattice: 16, origin_m: [0.0; 3], spacing_m: 0.5 };
    let mut medium = Medium::empty(grid);
    for site in (0..4096).step_by(3) {
        medium.density[site] = 0.25;
        medium.class[site] = Class::Leaf;
    }
    let meta = SpeciesMeta {
        name: name.to_owned(),
        model: Model::Paper { optics: Optics::paper() },
        grid,
        bounds_m: Bounds { min: [1.0; 3], max: [7.0; 3] },
        triangles: TriangleCounts::default(),
        mesh_blake3: None,
        mean_light: None,
        sky_averages: None,
        sources: Vec::new(),
        settings: BTreeMap::new(),
        tool: "test".to_owned(),
        left_out: None,
        extra: BTreeMap::new(),
    };
    let base = |base: u8| {
        let mut field = Field::zeros(16, 3);
        for (i, value) in field.values_mut().iter_mut().enumerate() {
            *value = ((i * 7919 + base as usize) % 1000) as f32 / 1000.0;
        }
        (base, field)
    };
    SpeciesFields { meta, medium, turbid: None, bases: vec![base(3), base(1)] }
}

fn encode(fields: &SpeciesFields, settings: &EncodeSettings) -> Result<EncodedSpecies, PackError> {
    encode_species(fields, settings, &|_| Ok(()))
}

fn refusal(edit: impl FnOnce(&mut SpeciesFields, &mut EncodeSettings)) -> String {
    let (mut fields, mut settings) = (fields("oak"), EncodeSettings::papers());
    edit(&mut fields, &mut settings);
    encode(&fields, &settings).expect_err("it should be refused").to_string()
}

#[test]
fn settings_outside_the_limits_are_refused() {
    assert_eq!(refusal(|_, s| s.threshold = -1.0), "threshold is -1, expected a number from 0 to 2^96");
    assert!(refusal(|_, s| s.threshold = f32::NAN).starts_with("threshold is NaN"));
    assert!(
        refusal(|_, s| s.page_bytes = 1000).starts_with("page size is 1000, expected a multiple of 4096")
    );
}

#[test]
fn every_codec_stops_when_it_is_told_to() {
    for codec in [Codec::RawF32, Codec::HaarPaper, Codec::Haar, Codec::Classed] {
        let settings = EncodeSettings { codec, ..EncodeSettings::papers() };
        let stopped = encode_species(&fields("oak"), &settings, &|_| Err(Cancelled));
        let error = stopped.expect_err("it was stopped");
        assert!(matches!(error, PackError::Cancelled(Cancelled)), "{codec:?}: {error}");
        assert_eq!(error.to_string(), "the work was stopped");
    }
}

#[test]
fn fields_that_do_not_fit_are_refused() {
    assert!(refusal(|f, _| f.bases.clear()).contains("number of bases of species \"oak\" is 0"));
    assert!(refusal(|f, _| f.bases[0].0 = 1).contains("base 1 of species \"oak\" is given twice"));
    assert!(refusal(|f, _| f.bases[0].0 = 19).contains("base of species \"oak\" is 19, expected 0 to 18"));
    let text = refusal(|f, _| f.bases[1].1 = Field::zeros(32, 3));
    assert!(text.contains("(lattice, bands, values) of base 1") && text.contains("(32, 3, 98304)"), "{text}");
    let text = refusal(|f, _| f.bases[0].1.values_mut()[4096 + 17] = f32::INFINITY);
    assert!(text.starts_with("base 3 of species \"oak\", band 1, site 17: value inf"), "{text}");
    assert!(refusal(|f, _| f.bases[0].1.values_mut()[5] = f32::NAN).contains("site 5: value NaN"));
}

#[test]
fn values_above_the_largest_binary16_are_refused_by_raw_f16_alone() {
    let with = |value: f32, codec| {
        let mut fields = fields("oak");
        fields.bases[0].1.values_mut()[2 * 4096 + 77] = value;
        encode(&fields, &EncodeSettings { codec, ..EncodeSettings::papers() })
    };
    for value in [65504.0, -65504.0] {
        with(value, Codec::RawF16).expect("the largest binary16 fits");
    }
    for value in [65504f32.next_up(), -65504f32.next_up(), 65520.0, 1e9, f32::NEG_INFINITY, f32::NAN] {
        let text = with(value, Codec::RawF16).expect_err("not a value of raw-f16").to_string();
        assert_eq!(
            text,
            format!(
                "base 3 of species \"oak\", band 2, site 77: value {value}, expected a finite number of magnitude up \
                 to 65504, the largest that raw-f16 holds"
            )
        );
    }
    for codec in [Codec::RawF32, Codec::HaarPaper] {
        with(1e9, codec).expect("far below 2^96");
    }
}

#[test]
fn bases_that_are_given_though_left_out_are_refused() {
    let text = refusal(|f, _| f.meta.leave_out([3, 5].into_iter().collect(), &[], "no sun"));
    assert_eq!(text, "base 3 of species \"oak\" is given, expected none, as the metadata leave it out");
}

#[test]
fn dropping_bases_before_or_after_coding_gives_the_same_pages_and_says_what_went() {
    let keep: BaseSet = [0, 1].into_iter().collect();
    let settings = EncodeSettings { compress: true, ..EncodeSettings::papers() };
    let mut before = fields("oak");
    keep_bases(&mut before, keep, "no sun");
    let before = encode(&before, &settings).expect("it encodes");
    let mut after = encode(&fields("oak"), &settings).expect("it encodes");
    keep_coded_bases(&mut after, keep, "no sun").expect("the metadata fit");
    for coded in [&before, &after] {
        let left_out = coded.meta.left_out.as_ref().expect("base 3 went");
        // Base 0 was not there before either: no plan left it out.
        assert_eq!((left_out.bases, &left_out.reason[..]), ([3].into_iter().collect(), "no sun"));
        let mut bytes = Vec::new();
        write_library_to(&mut bytes, &[coded]).expect("it fits");
        let container = Container::open(&bytes).expect("it opens");
        assert_eq!(container.species()[0].meta.left_out, coded.meta.left_out);
        assert_eq!(container.species()[0].bases.iter().map(|base| base.base).collect::<Vec<_>>(), [1]);
    }
    assert_eq!(before.sections.last().map(|s| &s.pages), after.sections.last().map(|s| &s.pages));
}

#[test]
fn what_was_left_out_adds_up_with_its_reasons() {
    let mut meta = fields("oak").meta;
    meta.leave_out(BaseSet::NONE, &[], "nothing");
    assert_eq!(meta.left_out, None);
    meta.leave_out([3].into_iter().collect(), &[], "no sun");
    meta.leave_out([7].into_iter().collect(), &["B".to_owned()], &"é".repeat(600));
    let left_out = meta.left_out.expect("both");
    assert_eq!((left_out.bases, &left_out.bands[..]), ([3, 7].into_iter().collect(), &["B".to_owned()][..]));
    assert!(left_out.reason.starts_with("no sun; éé") && left_out.reason.len() == 1000);
}

#[test]
fn media_that_do_not_fit_are_refused() {
    assert!(refusal(|f, _| f.medium.grid.spacing_m = 2.0).contains("the medium's grid"));
    assert!(refusal(|f, _| f.medium.density[3] = 1.5).contains("density of species \"oak\", site 3: 1.5"));
    assert!(refusal(|f, _| f.medium.density[0] = 0.0).contains("site 0: Leaf at density 0"));
    assert!(refusal(|f, _| f.medium.class[1] = Class::Wood).contains("site 1: Wood at density 0"));
    assert!(refusal(|f, _| f.medium.wood_area_density[9] = -1.0).contains("wood area density"));
    assert!(refusal(|f, _| f.medium.leaf_area_density[9] = f32::NAN).contains("site 9: NaN"));
    assert!(refusal(|f, _| f.medium.density.truncate(9)).contains("length of density or class"));
}

#[test]
fn metadata_that_the_format_refuses_are_refused_before_writing() {
    for hidden in ["oak\u{202e}", "oak\u{200b}", "oak\u{9b}", "oak\u{e0041}", "oak\n"] {
        let text = refusal(|f, _| f.meta.name = hidden.to_owned());
        assert!(text.contains("control and invisible characters"), "{hidden:?}: {text}");
    }
    let text = refusal(|f, _| f.meta.name = "a/b".to_owned());
    assert!(text.contains("FLB-5003") && text.contains("name is \"a/b\""), "{text}");
    assert!(refusal(|f, _| f.meta.bounds_m.min[0] = f64::NAN).contains("bounds_m.min[0] is NaN"));
    let text = refusal(|f, _| drop(f.meta.settings.insert("x".into(), (1u64 << 60).into())));
    assert!(text.contains("over 2^53"), "{text}");
}

#[test]
fn libraries_need_species_with_different_names() {
    let oak = encode(&fields("oak"), &EncodeSettings::papers()).expect("it encodes");
    let mut out = Vec::new();
    let error = write_library_to(&mut out, &[]).expect_err("nothing to write");
    assert_eq!(error.to_string(), "no species to write");
    let error = write_library_to(&mut out, &[&oak, &oak]).expect_err("one name");
    assert_eq!(
        error.to_string(),
        "two species are named \"oak\"; a library's names are unique: bake one of them with another --name"
    );
    assert!(out.is_empty());
}

#[test]
fn the_report_tells_sizes_and_finds_a_planted_error() {
    let fields = fields("oak");
    let raw = EncodeSettings { codec: Codec::RawF32, ..EncodeSettings::papers() };
    let report = encode(&fields, &raw).expect("it encodes").report.expect("it was coded");
    assert_eq!((report.raw_bytes, report.coded_bytes), (2 * 3 * 4096 * 4, 2 * 3 * 4096 * 4));
    assert_eq!((report.ratio, report.surface_psnr_db), (1.0, None));
    let f16 = EncodeSettings { codec: Codec::RawF16, ..EncodeSettings::papers() };
    let half = encode(&fields, &f16).expect("it encodes").report.expect("it was coded");
    assert_eq!((half.raw_bytes, half.coded_bytes, half.ratio), (2 * 3 * 4096 * 4, 2 * 3 * 4096 * 2, 2.0));
    for base in &half.bases {
        // Values up to 1: half of the last bit of those above 1/2.
        assert!(base.max_error > 0.0 && base.max_error <= 1.0 / 4096.0, "{}", base.max_error);
        assert!(base.surface_psnr_db.is_some_and(|db| db > 70.0), "{base:?}");
    }
    let psnr = |threshold| {
        let settings = EncodeSettings { threshold, ..EncodeSettings::papers() };
        encode(&fields, &settings).expect("it encodes").report.expect("it was coded")
    };
    let (fine, coarse) = (psnr(0.01), psnr(0.1));
    assert!(
        fine.surface_psnr_db > coarse.surface_psnr_db && coarse.surface_psnr_db > Some(3.0),
        "{coarse:?}"
    );
    assert!(fine.coded_bytes > coarse.coded_bytes);
    assert_eq!(coarse.bases.iter().map(|base| base.base).collect::<Vec<_>>(), [1, 3]);
    assert!(coarse.bases[0].max_error > fine.bases[0].max_error);
    let mut of_sixteenths = fields.clone();
    for value in of_sixteenths.bases.iter_mut().flat_map(|(_, field)| field.values_mut()) {
        *value = (*value * 16.0).floor() / 16.0;
    }
    let exact = encode(&of_sixteenths, &f16).expect("it encodes").report.expect("it was coded");
    assert_eq!(exact.surface_psnr_db, None, "sixteenths are binary16");
    // f32 rounding of a coding without threshold: some 120 dB and more.
    assert!(psnr(0.0).surface_psnr_db.is_none_or(|db| db > 120.0));
}

/// As [`fields`], of the model `physical`.
fn physical(suns: &SunBasis) -> SpeciesFields {
    let mut fields = fields("oak");
    let light = Light {
        field: FieldKind::Scattered,
        ordinates: 18,
        rays: 1,
        suns: suns.clone(),
        leaf_angles: LeafAngles::planophile(),
        error: LightError { suns_rms: 0.01, held_out: 4, solver: 0.001, monte_carlo: None },
        solid_offset: None,
    };
    let band = |name: &str| BandSurfaces {
        name: name.to_owned(),
        leaf: LeafSurface { reflectance: 0.5, transmittance: 0.5 },
        wood: WoodSurface { reflectance: 1.0 },
    };
    let surfaces = Surfaces { bands: ["R", "G", "B"].map(band).to_vec() };
    fields.meta.model = Model::Physical { surfaces, light };
    let leaf_per_m = fields.medium.density.iter().map(|density| density * 3.0).collect();
    let (grid, angles) = (fields.meta.grid, LeafAngles::planophile());
    fields.turbid = Some(TurbidMedium { grid, leaf_per_m, wood_per_m: vec![0.0; 4096], angles });
    if *suns != SunBasis::Lattice18 {
        fields.bases = suns.item_numbers().map(|item| (item, fields.bases[0].1.clone())).collect();
    }
    fields
}

fn physical_refusal(suns: &SunBasis, edit: impl FnOnce(&mut SpeciesFields)) -> String {
    let mut fields = physical(suns);
    encode(&fields, &EncodeSettings::papers()).expect("as it is, it fits");
    edit(&mut fields);
    encode(&fields, &EncodeSettings::papers()).expect_err("it should be refused").to_string()
}

#[test]
fn physical_species_that_do_not_fit_are_refused() {
    let (degree_2, lattice) =
        (&SunBasis::Harmonics { degree: 2, single: false, leaning: false }, &SunBasis::Lattice18);
    let text = physical_refusal(degree_2, |f| f.turbid = None);
    assert!(
        text.contains("the extinction of species \"oak\" is absent, expected given for the model"),
        "{text}"
    );
    let text = refusal(|f, _| f.turbid = physical(lattice).turbid);
    assert!(text.contains("the extinction of species \"oak\" is given"), "{text}");
    let turbid = |edit: fn(&mut TurbidMedium)| {
        physical_refusal(degree_2, |f| edit(f.turbid.as_mut().expect("it is physical")))
    };
    assert!(turbid(|t| t.grid.spacing_m = 1.0).starts_with("the extinction's grid"));
    assert!(turbid(|t| t.angles = LeafAngles::spherical()).starts_with("the leaf angles"));
    assert!(
        turbid(|t| t.wood_per_m.truncate(7)).contains("length of wood extinction of species \"oak\" is 7")
    );
    let text = turbid(|t| t.leaf_per_m[9] = -1.0);
    assert_eq!(text, "leaf extinction of species \"oak\", site 9: -1, expected 0 to 2^96");
    assert!(turbid(|t| t.wood_per_m[8] = f32::NAN).contains("site 8: NaN"));
    let text = physical_refusal(degree_2, |f| f.bases[3].0 = 14);
    assert!(text.contains("base of species \"oak\" is 14, expected 0 to 13"), "{text}");
    let text = physical_refusal(degree_2, |f| drop(f.bases.pop()));
    assert!(text.contains("is 13, expected all 14, as the suns are harmonics"), "{text}");
    assert!(physical_refusal(lattice, |f| f.bases[0].0 = 19).contains("is 19, expected 0 to 18"));
    let text = physical_refusal(&tetrahedron(), |f| f.bases[3].0 = 5);
    assert!(text.contains("base of species \"oak\" is 5, expected 0 to 4"), "{text}");
    let text = physical_refusal(&tetrahedron(), |f| drop(f.bases.pop()));
    assert!(text.contains("is 4, expected all 5, as the suns are directions"), "{text}");
}

fn tetrahedron() -> SunBasis {
    let directions = vec![[0.6, 0.8, 0.0], [0.6, -0.8, 0.0], [-0.6, 0.0, 0.8], [-0.6, 0.0, -0.8]];
    let triangles = vec![[0, 1, 3], [0, 2, 1], [0, 3, 2], [1, 2, 3]];
    SunBasis::Directions(SunDirections::new(directions, triangles).expect("a tetrahedron").into())
}

#[test]
fn bases_of_harmonics_and_of_lists_are_never_dropped() {
    let keep: BaseSet = [0, 1].into_iter().collect();
    for (suns, bases) in
        [(SunBasis::Harmonics { degree: 1, single: false, leaning: false }, 9), (tetrahedron(), 5)]
    {
        let mut fields = physical(&suns);
        let mut coded = encode(&fields, &EncodeSettings::papers()).expect("it encodes");
        keep_bases(&mut fields, keep, "no sun");
        assert_eq!((fields.bases.len(), &fields.meta.left_out), (bases, &None));
        keep_coded_bases(&mut coded, keep, "no sun").expect("nothing changes");
        assert_eq!((coded.sections.len(), &coded.meta.left_out), (1 + 6 + bases, &None));
    }

    let mut lattice = physical(&SunBasis::Lattice18);
    keep_bases(&mut lattice, keep, "no sun");
    assert_eq!(lattice.bases.iter().map(|(base, _)| *base).collect::<Vec<_>>(), [1]);
}
