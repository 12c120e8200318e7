use super::*;
use crate::leaf::{Bands, LeafModel};

#[test]
fn the_example_of_the_module_s_head_is_valid() {
    let text = r#"
name = "oak"
up = "z"
unit_m = 0.01
gltf_mesh = "Oak"
leaf = ["leaves*"]
wood = ["bark", "stem*"]
ignore = ["ground"]
ignore_alpha = false
ignore_vertex_colours = true
[[optics]]
name = "R"
leaf = { sigma_a = 0.109, fs = 0.055, bs = 0.070 }
wood = { sigma_a = 0.109, g = -1.0 }
"#;
    let species = SpeciesFile::parse("oak.toml", text).unwrap();
    assert_eq!((species.up, species.unit_m), (Some(Up::Z), Some(0.01)));
    assert_eq!(species.optics.as_ref().unwrap().bands[0], Optics::paper().bands[0]);
    assert_eq!(species.rules().wood, ["bark", "stem*"]);
    let over = ImportSettings { up: Some(Up::Y), ..ImportSettings::default() };
    let of = |mesh: &str| ImportSettings {
        up: Some(Up::Y),
        unit_m: Some(0.01),
        gltf_mesh: Some(mesh.to_owned()),
        ignore_vertex_colors: true,
        ..ImportSettings::default()
    };
    assert_eq!(species.import_settings(&over), of("Oak"));
    let over = ImportSettings { gltf_mesh: Some("#1".to_owned()), ..over };
    assert_eq!(species.import_settings(&over), of("#1"));
}

#[test]
fn the_leaf_model_of_the_module_s_head_is_the_default_leaf() {
    let head = include_str!("../species.rs");
    let lines = head.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim);
    let example: Vec<&str> =
        lines.skip_while(|line| *line != "[leaf_model]").take_while(|line| *line != "```").collect();
    let found = SpeciesFile::parse("oak.toml", &example.join("\n")).unwrap().surfaces.unwrap();
    let common = LeafModel::default().surfaces(&Bands::Rgb);
    for (band, common) in found.bands.iter().zip(&common.bands) {
        assert_eq!((&band.name, band.leaf), (&common.name, common.leaf));
    }
    assert_eq!(found.bands[0].wood.reflectance, 0.15);
}

#[test]
fn an_empty_file_says_nothing() {
    let species = SpeciesFile::parse("a.toml", "").unwrap();
    assert!(
        species.optics.is_none()
            && species.surfaces.is_none()
            && species.leaf.is_empty()
            && species.name.is_none()
    );
}

#[test]
fn mistakes_are_named_with_their_place() {
    let band = |leaf: &str| {
        format!("[[optics]]\nname = \"R\"\nleaf = {{ {leaf} }}\nwood = {{ sigma_a = 0, g = 0 }}\n")
    };
    for (text, words) in [
        ("up = \"x\"".to_owned(), "line 1, column 6"),
        ("leafs = []".to_owned(), "unknown field `leafs`"),
        ("name = \"\"".to_owned(), "name: found"),
        ("unit_m = 0".to_owned(), "unit_m: found 0"),
        ("unit_m = nan".to_owned(), "unit_m: found NaN"),
        ("optics = []".to_owned(), "0 bands"),
        (band("sigma_a = 1.5, g = 0.0"), "optics[0].leaf.sigma_a: found 1.5, expected 0..=1"),
        (band("sigma_a = nan, g = 0.0"), "optics[0].leaf.sigma_a: found NaN"),
        (band("sigma_a = 0.5, g = -1.1"), "optics[0].leaf.g: found -1.1, expected -1..=1"),
        (band("sigma_a = 0.5, fs = 0.1"), "found [fs], expected g, or fs and bs"),
        (band("sigma_a = 0.5"), "found [], expected g, or fs and bs"),
        (band("sigma_a = 0.5, fs = 0.0, bs = 0.0"), "fs + bs = 0"),
        (band("sigma_a = 0.5, g = 0.0").repeat(2), "optics[1].name"),
        (band("sigma_a = 0.5, g = 0.0").repeat(65), "65 bands"),
        (format!("leaf = [{}]", "\"*\",".repeat(257)), "leaf: found 257 patterns, expected at most 256"),
        (format!("wood = [\"{}\"]", "x".repeat(257)), "wood: found a pattern of 257 bytes"),
        (format!("up = \"{}\"", "x".repeat(100_000)), "expected `y` or `z`"),
        (format!("name = {}", "[".repeat(100_000)), "recurs"),
        (format!("{} = 1", "a.".repeat(100_000) + "a"), "recursion limit"),
        (format!("[{}]", "a.".repeat(100_000) + "a"), "recursion limit"),
        (format!("x = {}1{}", "{a=".repeat(100_000), "}".repeat(100_000)), "recurs"),
    ] {
        let error = SpeciesFile::parse("oak.toml", &text).unwrap_err().to_string();
        let shown = &text[..text.len().min(80)];
        assert!(error.starts_with("oak.toml: ") && error.contains(words), "{shown}: {error}");
        assert!(error.len() < 1000, "{shown}: a message of {} bytes", error.len());
    }
}

#[test]
fn files_are_read_with_their_digest_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("oak.toml");
    std::fs::write(&path, b"\xEF\xBB\xBFname = \"oak\"\n").unwrap();
    let species = SpeciesFile::read(&path).unwrap();
    assert_eq!(species.name.as_deref(), Some("oak"));
    assert_eq!(species.blake3, blake3::hash(b"\xEF\xBB\xBFname = \"oak\"\n").to_hex().to_string());
    std::fs::write(&path, b"name = \"\xFF\"").unwrap();
    assert!(SpeciesFile::read(&path).unwrap_err().to_string().contains("byte 8 is not UTF-8"));
    assert!(SpeciesFile::read(&folder.path().join("none.toml")).is_err());
}

#[test]
fn a_line_that_is_shown_holds_no_more_of_a_url_than_the_host() {
    for text in [
        "leaf = \"http://u:p/S3CR3T@h/x\"",
        "unit_m = \"https://h/x?a=b S3CR3T\"",
        "a = [\n'ftp:/h/x#S3CR3T'",
    ] {
        let error = SpeciesFile::parse("oak.toml", text).expect_err("it is unsound").to_string();
        assert!(error.contains("TOML parse error") && !error.contains("S3CR3T"), "{error}");
    }
}
