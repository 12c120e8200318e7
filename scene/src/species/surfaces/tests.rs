use flb_format::matter::{LeafSurface, WoodSurface};

use super::super::SpeciesFile;
use super::*;
use crate::leaf;

fn surfaces(text: &str) -> Surfaces {
    SpeciesFile::parse("oak.toml", text).unwrap().surfaces.expect("the text gives surfaces")
}

#[test]
fn surfaces_are_taken_as_given() {
    let found = surfaces(
        r#"
[[surfaces]]
name = "R"
leaf = { reflectance = 0.07, transmittance = 0.055 }
wood = { reflectance = 0.12 }
[[surfaces]]
name = "NIR"
leaf = { reflectance = 0.5, transmittance = 0.5 }
wood = { reflectance = 1 }
"#,
    );
    let band = |name: &str, reflectance, transmittance, wood| BandSurfaces {
        name: name.to_owned(),
        leaf: LeafSurface { reflectance, transmittance },
        wood: WoodSurface { reflectance: wood },
    };
    assert_eq!(found.bands, [band("R", 0.07, 0.055, 0.12), band("NIR", 0.5, 0.5, 1.0)]);
}

#[test]
fn an_empty_leaf_model_is_the_common_leaf() {
    assert_eq!(surfaces("[leaf_model]"), LeafModel::default().surfaces(&Bands::Rgb));
}

#[test]
fn every_key_of_a_leaf_model_reaches_the_model() {
    let keys = LeafModel::default().parameters().map(|(key, value, _, _)| (key, value));
    for (index, (key, value)) in keys.into_iter().enumerate() {
        // Doubled, or 1 where the common value is 0; water shows in the near infrared alone.
        let value = if value == 0.0 { 1.0 } else { 2.0 * value };
        let bands = "bands = [{ name = \"a\", nm = [400, 700] }, { name = \"b\", nm = [800, 900] }]";
        let found = surfaces(&format!("[leaf_model]\n{key} = {value}\n{bands}"));
        let mut model = LeafModel::default();
        *[
            &mut model.structure,
            &mut model.chlorophyll_ug_cm2,
            &mut model.carotenoids_ug_cm2,
            &mut model.anthocyanins_ug_cm2,
            &mut model.water_cm,
            &mut model.dry_matter_g_cm2,
        ][index] = value;
        let range = |name: &str, low_nm, high_nm| Range { name: name.to_owned(), low_nm, high_nm };
        let ranges = Bands::Ranges(vec![range("a", 400.0, 700.0), range("b", 800.0, 900.0)]);
        assert_eq!(found, model.surfaces(&ranges), "{key}");
        assert_ne!(found, LeafModel::default().surfaces(&ranges), "{key}");
    }
}

#[test]
fn the_wood_beside_a_leaf_model_is_bark_or_what_the_file_says() {
    let bark: Vec<WoodSurface> = leaf::knapp_carter().bands.iter().map(|band| band.wood).collect();
    let wood = |text| surfaces(text).bands.iter().map(|band| band.wood).collect::<Vec<_>>();
    assert_eq!(wood("[leaf_model]"), bark);
    let given = [0.3, 0.2, 0.1].map(|reflectance| WoodSurface { reflectance });
    assert_eq!(wood("[leaf_model]\nwood = [0.3, 0.2, 0.1]"), given);
}

#[test]
fn the_papers_optics_and_surfaces_may_stand_together() {
    let text = "[leaf_model]\n[[optics]]\nname = \"R\"\nleaf = { sigma_a = 0.1, g = 0 }\nwood = { sigma_a = 0.1, g = 0 }\n";
    let species = SpeciesFile::parse("oak.toml", text).unwrap();
    assert!(species.optics.is_some() && species.surfaces.is_some());
}

#[test]
fn mistakes_are_named_with_their_place() {
    let band = |reflectance: &str, transmittance: &str, wood: &str| {
        format!(
            "[[surfaces]]\nname = \"R\"\nleaf = {{ reflectance = {reflectance}, transmittance = {transmittance} }}\n\
             wood = {{ reflectance = {wood} }}\n"
        )
    };
    let model = |line: &str| format!("[leaf_model]\n{line}\n");
    let range = |nm: &str| model(&format!("bands = [{{ name = \"a\", nm = {nm} }}]"));
    let good = band("0.1", "0.1", "0.1");
    for (text, words) in [
        (
            format!("{good}[leaf_model]"),
            "surfaces: found [[surfaces]] and [leaf_model], expected one of them",
        ),
        ("surfaces = []".to_owned(), "surfaces: found 0 bands, expected 1..=64 bands"),
        (good.repeat(65), "65 bands"),
        (good.repeat(2), "surfaces[1].name: found \"R\" again"),
        (good.replace("\"R\"", "\" \""), "surfaces[0].name: found \" \""),
        (band("1.5", "0", "0"), "surfaces[0].leaf.reflectance: found 1.5, expected 0..=1"),
        (band("0", "-0.1", "0"), "surfaces[0].leaf.transmittance: found -0.1, expected 0..=1"),
        (band("nan", "0", "0"), "surfaces[0].leaf.reflectance: found NaN"),
        (band("0", "0", "inf"), "surfaces[0].wood.reflectance: found inf"),
        (
            band("0.75", "0.5", "0"),
            "surfaces[0].leaf: found reflectance + transmittance = 1.25, expected at most 1",
        ),
        (good.replace("transmittance", "transmission"), "unknown field `transmission`"),
        (good.replace("wood", "bark"), "unknown field `bark`"),
        (model("chlorophyl = 3"), "unknown field `chlorophyl`"),
        (model("structure = 0.5"), "leaf_model.structure: found 0.5, expected 1..=5"),
        (model("chlorophyll_ug_cm2 = -1"), "leaf_model.chlorophyll_ug_cm2: found -1, expected 0..=300"),
        (model("carotenoids_ug_cm2 = 101"), "leaf_model.carotenoids_ug_cm2: found 101, expected 0..=100"),
        (model("anthocyanins_ug_cm2 = nan"), "leaf_model.anthocyanins_ug_cm2: found NaN"),
        (model("water_cm = 1"), "leaf_model.water_cm: found 1, expected 0..=0.5"),
        (model("dry_matter_g_cm2 = 9"), "leaf_model.dry_matter_g_cm2: found 9, expected 0..=0.1"),
        (model("wood = [0.1]"), "leaf_model.wood: found 1 values, expected 3, one per band"),
        (model("wood = [0.1, 2, 0.1]"), "leaf_model.wood[1]: found 2, expected 0..=1"),
        (model("bands = []"), "leaf_model.bands: found 0 bands"),
        (
            range("[390, 500]"),
            "leaf_model.bands[0].nm: found [390, 500], expected two rising wavelengths within 400..=900 nm",
        ),
        (range("[500, 901]"), "leaf_model.bands[0].nm"),
        (range("[500, 500]"), "leaf_model.bands[0].nm"),
        (range("[nan, 500]"), "leaf_model.bands[0].nm: found [NaN, 500]"),
        (range("[400]"), "line 2"),
    ] {
        let error = SpeciesFile::parse("oak.toml", &text).unwrap_err().to_string();
        assert!(error.starts_with("oak.toml: ") && error.contains(words), "{text}: {error}");
    }
}
