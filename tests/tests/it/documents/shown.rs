//! What documents show: Rust, scene and species files, and a table of what a bake takes.

use std::path::Path;

use super::text::blocks;
use super::{File, documents, nothing, root};

#[test]
fn every_document_with_rust_is_compiled() {
    let compiled = std::fs::read_to_string(root().join("tests/src/lib.rs")).expect("the crate has it");
    let (documents, _) = documents();
    let with_rust: Vec<&File> =
        documents.iter().filter(|file| file.text.lines().any(|l| l == "```rust")).collect();
    assert!(with_rust.len() > 1, "README and the book show Rust");
    let left_out =
        with_rust.iter().filter(|f| !compiled.contains(&format!("include_str!(\"../../{}\")", f.path)));
    nothing(left_out.map(|file| format!("tests/src/lib.rs does not compile {}", file.path)).collect());
    // Any other mark of Rust would be left out of sight: no_run, ignore, ...
    let marked =
        documents.iter().filter(|file| file.text.lines().any(|l| l.starts_with("```rust") && l != "```rust"));
    nothing(
        marked.map(|file| format!("{}: a block of Rust that is not compiled as it is", file.path)).collect(),
    );
}

#[test]
fn every_scene_and_species_file_that_a_document_shows_is_read() {
    let (documents, _) = documents();
    let (mut scenes, mut species, mut manifests) = (0, 0, 0);
    for file in &documents {
        for block in blocks(&file.text, "toml") {
            let read = if block.contains("[[instance]]") {
                scenes += 1;
                flb_scene::scene::Scene::parse(&file.path, Path::new("."), &block).map(drop)
            } else if block.contains("\n[[species]]") {
                manifests += 1;
                flb_farm::Manifest::check_text(&file.path, &block)
            } else {
                species += 1;
                flb_scene::SpeciesFile::parse(&file.path, &block).map(drop)
            };
            assert!(read.is_ok(), "{}: {}\n{block}", file.path, read.expect_err("just seen"));
        }
    }
    assert!(
        scenes > 1 && species > 2 && manifests > 0,
        "{scenes} scenes, {species} species files, {manifests} manifests"
    );
}

#[test]
fn the_table_of_surfaces_is_what_a_bake_takes() {
    use flb_scene::leaf::{Bands, LeafModel, knapp_carter};
    let page = std::fs::read_to_string(root().join("docs/book/src/bake.md")).expect("the page is there");
    let of_model = LeafModel::default().surfaces(&Bands::Rgb);
    for (begins, surfaces) in
        [("| leaf, without either", &knapp_carter()), ("| leaf, `[leaf_model]`", &of_model)]
    {
        let row = page.lines().find(|line| line.starts_with(begins)).expect(begins);
        let stated: Vec<f64> = row
            .split('|')
            .skip(2)
            .flat_map(|cell| cell.split('/'))
            .filter_map(|number| number.trim().parse().ok())
            .collect();
        let found: Vec<f64> =
            surfaces.bands.iter().flat_map(|band| [band.leaf.reflectance, band.leaf.transmittance]).collect();
        assert_eq!(stated.len(), 6, "{row}");
        assert!(
            stated.iter().zip(&found).all(|(stated, found)| (stated - found).abs() <= 5e-4),
            "{row}: {found:?}"
        );
        let row = page.lines().find(|line| line.starts_with("| wood, unless given")).expect("a row of wood");
        let stated = row.split('|').skip(2).filter_map(|number| number.trim().parse::<f64>().ok());
        let wood: Vec<f64> = surfaces.bands.iter().map(|band| band.wood.reflectance).collect();
        assert!(
            stated.zip(&wood).filter(|(stated, found)| (stated - *found).abs() <= 5e-4).count() == 3,
            "{wood:?}"
        );
    }
}
