use std::path::Path;

use flb_format::meta::Bounds;
use flb_format::model::Model;
use flb_format::{Grid, SpeciesMeta};

use super::*;
use crate::import::Up;
use crate::mesh::testing::soup;

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn moved(by: f32) -> [[f32; 3]; 3] {
    TRIANGLE.map(|corner| corner.map(|c| c + by))
}

#[test]
fn bounds_are_of_leaf_and_wood_and_else_of_all() {
    let mut mesh = soup(&[TRIANGLE, moved(5.0)]);
    mesh.triangle_material = vec![0, 1];
    let classes = vec![MaterialClass::Leaf, MaterialClass::Neither];
    let mut classed = ClassedMesh { mesh, classes };
    assert_eq!(classed.bounds(), Some(Bounds { min: [0.0; 3], max: [1.0, 1.0, 0.0] }));
    assert_eq!((classed.triangle_counts().total, classed.triangle_counts().leaf), (2, 1));
    classed.classes[0] = MaterialClass::Neither;
    assert_eq!(classed.bounds(), Some(Bounds { min: [0.0; 3], max: [6.0, 6.0, 5.0] }));
}

#[test]
fn a_species_is_named_by_its_file_then_its_mesh_then_the_mesh_file() {
    let mut reader = PlantReader::default();
    let path = Path::new("folder/oak.tree.glb");
    assert_eq!(reader.name(path).as_deref(), Some("oak.tree"));
    reader.settings.gltf_mesh = Some("Old/Oak".to_owned());
    assert_eq!(reader.name(path).as_deref(), Some("Old_Oak"));
    reader.settings.gltf_mesh = Some("#2".to_owned());
    assert_eq!(reader.name(path).as_deref(), Some("oak.tree"));
}

#[test]
fn what_a_file_records_is_how_its_mesh_is_read_again() {
    let settings = ImportSettings {
        up: Some(Up::Z),
        unit_m: Some(0.01),
        gltf_mesh: Some("Oak".to_owned()),
        split: vec!["*@Trunk".to_owned()],
        nodes: vec!["Oak*".to_owned()],
        ignore_vertex_colors: true,
        offset_m: Some([0.0, 3.0, -7.0]),
    };
    let classes = vec![MaterialClass::Wood, MaterialClass::Neither, MaterialClass::Leaf];
    let mesh = Mesh { offset_m: [0.0, 3.0, -7.0], ..Mesh::default() };
    let mut meta = SpeciesMeta {
        name: "oak".to_owned(),
        model: Model::Paper { optics: Optics::paper() },
        grid: Grid { lattice: 16, origin_m: [0.0; 3], spacing_m: 1.0 },
        bounds_m: Bounds { min: [0.0; 3], max: [1.0; 3] },
        triangles: TriangleCounts { total: 0, leaf: 0, wood: 0 },
        mesh_blake3: None,
        mean_light: None,
        sky_averages: None,
        sources: Vec::new(),
        settings: Default::default(),
        tool: "tests".to_owned(),
        left_out: None,
        extra: Default::default(),
    };
    Record::of(&settings, &mesh, &classes).write(&mut meta);
    assert_eq!(recorded_settings(&meta), settings);
    assert_eq!(recorded_classes(&meta), Some(classes));
}

#[test]
fn a_plant_in_memory_has_the_surfaces_of_common_leaves() {
    let plant = Plant::new("fern", soup(&[TRIANGLE]), vec![MaterialClass::Leaf, MaterialClass::Wood]);
    assert_eq!((plant.name.as_str(), plant.surfaces), ("fern", knapp_carter()));
    assert!(plant.sources.is_empty() && !plant.ignore_alpha);
}
