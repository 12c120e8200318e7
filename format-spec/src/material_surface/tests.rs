use super::*;
use crate::Grid;
use crate::meta::{Bounds, TriangleCounts};
use crate::model::Model;
use crate::optics::Optics;

/// Of three bands.
fn meta(value: Option<Value>) -> SpeciesMeta {
    SpeciesMeta {
        name: "maple".to_owned(),
        model: Model::Paper { optics: Optics::paper() },
        grid: Grid { lattice: 16, origin_m: [0.0; 3], spacing_m: 1.0 },
        bounds_m: Bounds { min: [0.0; 3], max: [1.0; 3] },
        triangles: TriangleCounts::default(),
        mesh_blake3: None,
        mean_light: None,
        sky_averages: None,
        sources: vec![],
        settings: value.into_iter().map(|value| (MATERIALS.to_owned(), value)).collect(),
        left_out: None,
        tool: "test".to_owned(),
        extra: Default::default(),
    }
}

#[test]
fn surfaces_survive_a_file_and_plain_plants_have_none() {
    let maple = MaterialSurface {
        texel: Texel::Albedo,
        reflectance: vec![1.0; 3],
        transmittance: vec![0.8, 1.2, 0.5],
    };
    let all = vec![None, Some(maple.clone())];
    let value = setting(&all).unwrap();
    assert_eq!(value[1]["texel"], "albedo");
    assert_eq!(meta(Some(value)).material_surfaces(), Ok(Some(all)));
    assert_eq!(setting(&[None, None]), None);
    assert_eq!(meta(None).material_surfaces(), Ok(None));
    assert_eq!(maple.of_bands(&[2, 0]).transmittance, [0.5, 0.8]);
}

#[test]
fn surfaces_that_cannot_be_are_named_with_their_place() {
    let of = |surface: Value| meta(Some(json!([null, surface]))).material_surfaces().unwrap_err();
    let shares =
        |texel: &str, r: Value| json!({"texel": texel, "reflectance": r, "transmittance": [0, 0, 0]});
    let short = of(shares("tint", json!([0.5, 0.5])));
    assert_eq!(short, "settings.surfaces.materials[1].reflectance: 2 values, expected 3");
    let bright = of(shares("tint", json!([0.5, 1.5, 0.5])));
    assert_eq!(bright, "settings.surfaces.materials[1].reflectance: 1.5, expected 0 to 1");
    assert!(of(shares("albedo", json!([0.5, -1.5, 0.5]))).contains("-1.5, expected 0 to 1000000"));
    assert!(of(shares("colour", json!([0.5, 0.5, 0.5]))).contains("unknown variant `colour`"));
    assert!(of(json!("red")).contains("expected surfaces of SPEC.md section 9.3"));
}
