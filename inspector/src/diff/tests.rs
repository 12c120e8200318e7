use flb_format::light::{FieldKind, Light, LightError, SunBasis};
use flb_format::matter::{BandSurfaces, Class, LeafAngles, LeafSurface, Optics, Surfaces, WoodSurface};
use flb_format::meta::{Bounds, SourceFile, TriangleCounts};
use flb_format::model::Model;
use flb_format::{Grid, SpeciesFields, SpeciesMeta};
use flb_packer::{EncodeSettings, encode_species, write_library_to};
use serde_json::json;

use super::*;

const EXACT: Settings = Settings { tolerance: None };

/// A species with three bases and some leaf and wood.
fn species(name: &str) -> SpeciesFields {
    let grid = Grid { lattice: 16, origin_m: [0.0; 3], spacing_m: 0.5 };
    let mut medium = Medium::empty(grid);
    for site in (0..400).map(|i| 1000 + i) {
        medium.density[site] = 0.25;
        medium.class[site] = if site % 5 == 0 { Class::Wood } else { Class::Leaf };
        medium.leaf_area_density[site] = 3.0;
    }
    let base = |base: u8| {
        let mut field = Field::zeros(16, 3);
        field.values_mut().iter_mut().enumerate().for_each(|(i, v)| *v = 0.5 + (i % 97) as f32 / 200.0);
        (base, field)
    };
    SpeciesFields {
        meta: SpeciesMeta {
            name: name.to_owned(),
            model: Model::Paper { optics: Optics::paper() },
            grid,
            bounds_m: Bounds { min: [1.0; 3], max: [7.0; 3] },
            triangles: TriangleCounts { total: 3, leaf: 2, wood: 1 },
            mesh_blake3: None,
            mean_light: None,
            sky_averages: None,
            sources: vec![SourceFile { name: "oak.glb".to_owned(), blake3: "0".repeat(64) }],
            settings: [("voxelise.voxels".to_owned(), json!(1024))].into(),
            tool: "flb 0.1.0".to_owned(),
            left_out: None,
            extra: Default::default(),
        },
        medium,
        turbid: None,
        bases: [0, 4, 7].map(base).to_vec(),
    }
}

fn optics_of(fields: &mut SpeciesFields) -> &mut Optics {
    match &mut fields.meta.model {
        Model::Paper { optics } => optics,
        other => panic!("a species of the model {}", other.name()),
    }
}

/// As [`species`], of the model `physical` with 18 directions.
fn physical(name: &str) -> SpeciesFields {
    let mut fields = species(name);
    let light = Light {
        field: FieldKind::Scattered,
        ordinates: 50,
        rays: 2,
        suns: SunBasis::Lattice18,
        leaf_angles: LeafAngles::spherical(),
        error: LightError { suns_rms: 0.0, held_out: 0, solver: 0.001, monte_carlo: None },
        solid_offset: None,
    };
    let band = |name: &str| BandSurfaces {
        name: name.to_owned(),
        leaf: LeafSurface { reflectance: 0.3, transmittance: 0.25 },
        wood: WoodSurface { reflectance: 0.5 },
    };
    let surfaces = Surfaces { bands: ["R", "G", "B"].map(band).to_vec() };
    fields.meta.model = Model::Physical { surfaces, light };
    let (grid, angles) = (fields.meta.grid, LeafAngles::spherical());
    let leaf_per_m = fields.medium.leaf_area_density.iter().map(|area| area / 2.0).collect();
    fields.turbid = Some(TurbidMedium { grid, leaf_per_m, wood_per_m: vec![0.0; grid.sites()], angles });
    fields
}

fn file(species: &[&SpeciesFields], settings: &EncodeSettings) -> Vec<u8> {
    let encoded: Vec<_> = species.iter().map(|s| encode_species(s, settings, &|_| Ok(())).unwrap()).collect();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &encoded.iter().collect::<Vec<_>>()).unwrap();
    bytes
}

fn diff_of(a: &[u8], b: &[u8], settings: &Settings) -> Diff {
    let open = |bytes: &[u8]| Container::open(&bytes.to_vec()).unwrap();
    diff((&open(a), &a.to_vec()), (&open(b), &b.to_vec()), settings).unwrap()
}

/// Diff of a species with a changed copy of itself, in raw files, so that only the change differs.
fn planted(settings: &Settings, change: impl FnOnce(&mut SpeciesFields)) -> Diff {
    let raw = EncodeSettings { codec: Codec::RawF32, ..EncodeSettings::papers() };
    let a = species("oak");
    let mut b = a.clone();
    change(&mut b);
    diff_of(&file(&[&a], &raw), &file(&[&b], &raw), settings)
}

#[test]
fn a_file_equals_itself() {
    for tolerance in [None, Some(0.0), Some(1e-3)] {
        let diff = planted(&Settings { tolerance }, |_| {});
        assert!(diff.equal, "{diff:?}");
        let oak = &diff.species[0];
        assert!(oak.metadata.is_empty() && oak.notes.is_empty() && diff.notes.is_empty());
        assert_eq!(oak.bases.iter().map(|b| b.base).collect::<Vec<_>>(), [0, 4, 7]);
        assert!(oak.bases.iter().all(|b| b.values.differing == 0 && b.values.worst.is_none()));
        assert_eq!(oak.medium.len(), 4);
    }
}

#[test]
fn one_changed_value_of_one_base_is_found() {
    let change = |s: &mut SpeciesFields| s.bases[1].1.values_mut()[4096 + 16 * 3 + 9] += 0.125;
    let diff = planted(&EXACT, change);
    assert!(!diff.equal && !diff.species[0].equal);
    let unequal: Vec<u8> = diff.species[0].bases.iter().filter(|b| !b.equal).map(|b| b.base).collect();
    assert_eq!(unequal, [4]);
    let values = &diff.species[0].bases[1].values;
    assert_eq!((values.differing, values.max_abs), (1, Some(0.125)));
    let worst = values.worst.as_ref().unwrap();
    assert_eq!((worst.band, worst.site), (1, [9, 3, 0]));

    // The peak is 0.5 + 96/200 = 0.98, so 0.125 is within 0.13 of it and not within 0.12.
    assert!(planted(&Settings { tolerance: Some(0.13) }, change).equal);
    assert!(!planted(&Settings { tolerance: Some(0.12) }, change).equal);
}

#[test]
fn the_least_change_of_a_value_is_found() {
    let diff = planted(&EXACT, |s| {
        let value = &mut s.bases[2].1.values_mut()[0];
        *value = f32::from_bits(value.to_bits() + 1);
    });
    assert!(!diff.equal && diff.species[0].bases[2].values.differing == 1);
}

#[test]
fn changed_metadata_are_found_by_key_path() {
    let diff = planted(&EXACT, |s| {
        optics_of(s).bands[2].leaf.g = 0.5;
        s.meta.settings.insert("voxelise.voxels".to_owned(), json!(512));
        s.meta.sources.clear();
        s.meta.extra.insert("zone".to_owned(), json!("temperate"));
    });
    let found: Vec<&str> = diff.species[0].metadata.iter().map(|m| m.path.as_str()).collect();
    assert_eq!(found, ["optics[2].leaf.g", "settings.voxelise.voxels", "sources[0]", "zone"]);
    let zone = &diff.species[0].metadata[3];
    assert_eq!((&zone.a, &zone.b), (&None, &Some(json!("temperate"))));
    assert!(!diff.equal && diff.species[0].metadata.iter().all(|m| m.decides));
    assert!(diff.species[0].bases.iter().all(|b| b.equal));
}

#[test]
fn with_a_tolerance_history_does_not_decide_but_optics_do() {
    let tolerant = Settings { tolerance: Some(0.0) };
    let diff = planted(&tolerant, |s| {
        s.meta.tool = "flb 9.9.9".to_owned();
        s.meta.sources.clear();
        s.meta.settings.clear();
        s.meta.mesh_blake3 = Some("0".repeat(64));
    });
    assert!(diff.equal && diff.species[0].metadata.len() == 4, "{diff:?}");
    assert!(!planted(&tolerant, |s| optics_of(s).bands[0].wood.sigma_a = 0.2).equal);
    assert!(!planted(&EXACT, |s| s.meta.mesh_blake3 = Some("0".repeat(64))).equal);
}

#[test]
fn surfaces_light_and_extinction_of_physical_species_are_compared() {
    let raw = EncodeSettings { codec: Codec::RawF32, ..EncodeSettings::papers() };
    let planted = |change: &dyn Fn(&mut SpeciesFields)| {
        let a = physical("oak");
        let mut b = a.clone();
        change(&mut b);
        diff_of(&file(&[&a], &raw), &file(&[&b], &raw), &EXACT)
    };
    let same = planted(&|_| ());
    assert!(same.equal && same.species[0].medium.len() == 6, "{same:?}");
    let light = |edit: fn(&mut Light, &mut Surfaces)| {
        planted(&move |s| match &mut s.meta.model {
            Model::Physical { surfaces, light } => edit(light, surfaces),
            Model::Paper { .. } => panic!("it is physical"),
        })
    };
    let paths = |diff: &Diff| -> Vec<String> {
        assert!(!diff.equal);
        diff.species[0].metadata.iter().map(|m| m.path.clone()).collect()
    };
    assert_eq!(paths(&light(|l, _| l.error.solver = 0.5)), ["light.error.solver"]);
    assert_eq!(paths(&light(|_, s| s.bands[1].leaf.reflectance = 0.5)), ["surfaces[1].leaf.reflectance"]);
    let total = light(|l, _| l.field = FieldKind::Total);
    assert_eq!(paths(&total), ["light.field"]);
    assert!(total.species[0].notes[0].contains("the beam of the sun"), "{:?}", total.species[0].notes);
    let wood = planted(&|s| s.turbid.as_mut().unwrap().wood_per_m[1003] = 0.25);
    let unequal: Vec<&str> = wood.species[0].medium.iter().filter(|m| !m.equal).map(|m| m.name).collect();
    assert_eq!(unequal, ["wood_extinction"]);

    let (a, b) = (file(&[&species("oak")], &raw), file(&[&physical("oak")], &raw));
    let models = diff_of(&a, &b, &Settings { tolerance: Some(1e9) });
    assert!(!models.equal && models.species[0].medium.len() == 4);
    assert!(
        models.species[0].notes[0].contains("\"paper\" and \"physical\""),
        "{:?}",
        models.species[0].notes
    );
}

#[test]
fn changed_media_are_found_array_by_array() {
    let name = |diff: &Diff| -> Vec<&str> {
        diff.species[0].medium.iter().filter(|m| !m.equal).map(|m| m.name).collect()
    };
    let density = planted(&EXACT, |s| s.medium.density[1003] = 0.5);
    assert_eq!(name(&density), ["density"]);
    assert_eq!(density.species[0].medium[0].values.max_abs, Some(0.25));
    assert!(!density.equal);
    let wood = |s: &mut SpeciesFields| s.medium.class[1003] = Class::Wood;
    assert_eq!(name(&planted(&EXACT, wood)), ["class"]);
    assert!(!planted(&Settings { tolerance: Some(10.0) }, wood).equal, "no tolerance makes leaf wood");
    assert_eq!(name(&planted(&EXACT, |s| s.medium.leaf_area_density[1003] = 4.0)), ["leaf_area_density"]);
    assert_eq!(name(&planted(&EXACT, |s| s.medium.wood_area_density[1003] = 4.0)), ["wood_area_density"]);
}

#[test]
fn bases_of_one_file_only_are_listed() {
    let diff = planted(&EXACT, |s| s.bases[2].0 = 9);
    let oak = &diff.species[0];
    assert_eq!((&oak.bases_only_in_a[..], &oak.bases_only_in_b[..]), (&[7][..], &[9][..]));
    assert!(!diff.equal && oak.bases.iter().all(|b| b.equal));
}

#[test]
fn species_of_one_file_only_are_listed_and_order_is_a_note() {
    let (oak, spruce, shrub) = (species("oak"), species("spruce"), species("shrub"));
    let settings = EncodeSettings::papers();
    let (a, b) = (file(&[&oak, &spruce], &settings), file(&[&shrub, &oak], &settings));
    let diff = diff_of(&a, &b, &EXACT);
    assert_eq!(
        (&diff.species_only_in_a[..], &diff.species_only_in_b[..]),
        (&["spruce".to_owned()][..], &["shrub".to_owned()][..])
    );
    assert!(!diff.equal && diff.species.len() == 1 && diff.species[0].equal && diff.notes.is_empty());

    let turned = diff_of(&a, &file(&[&spruce, &oak], &settings), &EXACT);
    assert!(turned.equal);
    assert_eq!(turned.notes, ["the species that both files have are in another order"]);
}

#[test]
fn another_lattice_is_other_physics() {
    let a = species("oak");
    let mut b = a.clone();
    b.meta.grid = Grid { lattice: 32, origin_m: [0.0; 3], spacing_m: 0.25 };
    b.medium = Medium::empty(b.meta.grid);
    b.bases = vec![(4, Field::zeros(32, 3))];
    let settings = EncodeSettings::papers();
    let diff = diff_of(&file(&[&a], &settings), &file(&[&b], &settings), &Settings { tolerance: Some(1e9) });
    assert!(!diff.equal && diff.species[0].bases.is_empty() && diff.species[0].medium.is_empty());
    assert_eq!(diff.species[0].notes.len(), 1);
    assert!(diff.species[0].notes[0].contains("different physics"), "{:?}", diff.species[0].notes);
}

#[test]
fn coded_light_is_near_the_raw_light_and_storage_is_listed() {
    let oak = species("oak");
    let raw = EncodeSettings { codec: Codec::RawF32, ..EncodeSettings::papers() };
    let coded = EncodeSettings { threshold: 0.01, ..EncodeSettings::papers() };
    let (a, b) = (file(&[&oak], &raw), file(&[&oak], &coded));
    assert!(!diff_of(&a, &b, &EXACT).equal);
    let diff = diff_of(&a, &b, &Settings { tolerance: Some(0.5) });
    assert!(diff.equal, "{diff:?}");
    let base = &diff.species[0].bases[1];
    assert_eq!(base.codec, Some(Change { a: "raw-f32", b: "haar-paper" }));
    assert_eq!(base.threshold, Some(Change { a: 0.0, b: 0.01 }));
    assert!(base.values.psnr_db.unwrap() > 20.0 && base.values.differing > 0);
    assert!(diff_of(&b, &b, &EXACT).equal);

    let f16 = EncodeSettings { codec: Codec::RawF16, ..EncodeSettings::papers() };
    let c = file(&[&oak], &f16);
    assert!(!diff_of(&a, &c, &EXACT).equal);
    let diff = diff_of(&a, &c, &Settings { tolerance: Some(1.0 / 2048.0) });
    assert!(diff.equal, "{diff:?}");
    let base = &diff.species[0].bases[1];
    assert_eq!(base.codec, Some(Change { a: "raw-f32", b: "raw-f16" }));
    assert_eq!(base.threshold, None);
    assert!(base.values.psnr_db.unwrap() > 66.0 && base.values.differing > 0);
}

#[test]
fn json_holds_the_verdict_and_the_numbers() {
    let diff = planted(&EXACT, |s| s.bases[0].1.values_mut()[5] += 1.0);
    let json = serde_json::to_value(&diff).unwrap();
    assert_eq!(json["equal"], json!(false));
    assert_eq!(json["species"][0]["bases"][0]["max_abs"], json!(1.0));
    assert_eq!(json["species"][0]["bases"][0]["worst"]["site"], json!([5, 0, 0]));
    assert_eq!(json["species"][0]["bases"][1]["psnr_db"], Value::Null);
}

#[test]
fn a_page_that_cannot_be_trusted_is_an_error_and_no_verdict() {
    let bytes = file(&[&species("oak")], &EncodeSettings::papers());
    let container = Container::open(&bytes).unwrap();
    let section = container.find_base(0, 7).unwrap().section;
    let mut flipped = bytes.clone();
    flipped[container.pages(section)[0].offset as usize + 9] ^= 4;
    let error = diff((&container, &bytes), (&container, &flipped), &EXACT).unwrap_err();
    assert!(error.to_string().contains("page 0"), "{error}");
}
