use flb_baker::bake::{BakeSettings, ModelSettings, NoStore, PhysicalSettings, bake};
use flb_fixtures::{PlantKind, grow};
use flb_format::Quality;
use flb_format::material_surface::MaterialSurface;
use flb_packer::{EncodeSettings, encode_species, write_library_to};
use flb_runtime::{Library, SpeciesLight};
use flb_scene::{ClassedMesh, MaterialClass, Plant, Unobserved};
use flb_transport::monte_carlo::judge::suns;
use flb_transport::ordinates::Ordinates;

use super::*;
use crate::trade::NoHeap;

/// A few leaves, without wood.
fn leaves() -> ClassedMesh {
    let mesh = flb_testkit::grown::mesh(&grow(PlantKind::Shrub, 1, 300).expect("a good count"), [1.0; 4]);
    let classes = vec![MaterialClass::Leaf; mesh.materials.len()];
    ClassedMesh { mesh, classes }
}

fn quick() -> BakeSettings {
    let physical =
        PhysicalSettings { ordinates: Ordinates::Lattice18, ..PhysicalSettings::of(Quality::Draft) };
    BakeSettings {
        lattice: 16,
        voxels: 64,
        model: ModelSettings::Physical(physical),
        ..BakeSettings::default()
    }
}

#[test]
fn coded_light_is_judged_with_the_surfaces_that_its_file_states() {
    let plain = leaves();
    let mut plant = Plant::new("shrub", plain.mesh.clone(), plain.classes.clone());
    // Brighter than the mean leaf by far.
    let surface = MaterialSurface {
        texel: flb_format::material_surface::Texel::Albedo,
        reflectance: vec![0.45; 3],
        transmittance: vec![0.45; 3],
    };
    let count = plain.mesh.materials.len();
    assert!(plant.classed.mesh.set_surfaces(vec![Some(surface); count]));
    assert!(!plant.classed.mesh.set_surfaces(Vec::new()));
    let baked = bake(plant, &quick(), &NoStore, &Unobserved).expect("a good plant");
    let coding = EncodeSettings::of(Quality::Draft, flb_format::Codec::Classed);
    let mut coded = encode_species(&baked.fields, &coding, &|_| Ok(())).expect("good fields");
    let settings = JudgeSettings { suns: 1, points: 60, samples: 16 };
    // A mesh that was read without those surfaces.
    let error = judge_coded(&mut coded, plain.clone(), &coding, settings, &Unobserved).expect("good light");

    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &[&coded]).expect("memory");
    let library = Library::from_source("shrub", Box::new(bytes)).expect("a good file");
    let meta = &library.container().species()[0].meta;
    assert_eq!(flb_format::mesh::MeshError::of(meta).as_ref(), Some(&error));
    let light = SpeciesLight::load(&library, 0).expect("light");
    let sky = |mesh: &ClassedMesh| {
        let points = judged_points(mesh, settings.points, false).expect("leaves");
        let surfaces = judged_surfaces(meta).expect("a physical file");
        let judge = MeshJudge::new(&light, surfaces, points, suns(1), &Unobserved).expect("a sky");
        let judged = judge.judge(mesh, settings.samples, "shrub", &Unobserved).expect("a good mesh");
        judged.leaf.expect("leaves").sky.expect("lit").ratio[1]
    };
    let kept = error.leaf.expect("leaves").sky.expect("lit").ratio[1];
    let mut stated = plain.clone();
    let of_materials = meta.material_surfaces().expect("sound surfaces").expect("surfaces");
    assert!(stated.mesh.set_surfaces(of_materials));
    assert!((kept - sky(&stated)).abs() < 5.1e-5, "{kept}, {}, {}", sky(&stated), sky(&plain));
    assert!((kept - sky(&plain)).abs() > 0.02, "other surfaces have another truth: {kept}");
}

#[test]
fn a_trade_finds_rows_and_recommends_without_a_count_of_the_heap() {
    let settings = TradeSettings {
        lattices: vec![16],
        quick: true,
        voxels: 64,
        ignore_alpha: false,
        suns: 1,
        points: 40,
        limit_bytes: 4_000_000_000,
    };
    let plants = || -> Result<Plant, EvalError> {
        let ClassedMesh { mesh, classes } = leaves();
        Ok(Plant::new("shrub", mesh, classes))
    };
    let found = trade(&plants, &settings, &NoHeap, &Unobserved).expect("a good plant");
    assert!(found.rows.len() > 10 && found.skipped.len() == 4, "{:?}", found.skipped);
    assert_eq!((found.rows[0].row, found.rows[0].finest_percent), (1, 0.0));
    let chosen = found.recommended.iter().filter_map(|preset| preset.cost);
    assert!(chosen.into_iter().all(|cost| cost > 0.0), "{:?}", found.recommended);
    let none = TradeSettings { limit_bytes: 1, ..settings };
    assert!(matches!(trade(&plants, &none, &NoHeap, &Unobserved), Err(EvalError::Memory { .. })));
}
