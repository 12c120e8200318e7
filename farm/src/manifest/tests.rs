use std::fs;

use flb_format::Quality;
use tempfile::{TempDir, tempdir};

use super::*;

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempdir().expect("a folder");
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    folder
}

fn read(files: &[(&str, &str)]) -> Result<Manifest, String> {
    let folder = folder(files);
    Manifest::read(&folder.path().join("library.toml")).map_err(|error| error.to_string())
}

fn names(manifest: &Manifest) -> Vec<&str> {
    manifest.species.iter().map(|entry| entry.name.as_str()).collect()
}

#[test]
fn settings_come_from_the_variant_then_its_species_then_the_file() {
    let text = "
        output = 'out'
        merge = false
        [bake]
        quality = 'draft'
        lattice = 64
        [[species]]
        name = 'oak'
        mesh = 'oak.glb'
        bake = { lattice = 32, suns = 'sh2s' }
        plant = { leaf = ['leaves*'] }
        [[species.variant]]
        name = 'autumn'
        plant = { leaf_colour = 'texture' }
        bake = { suns = 'sh1s' }
    ";
    let manifest = read(&[("library.toml", text)]).expect("a manifest");
    assert_eq!(names(&manifest), ["oak", "oak-autumn"]);
    assert!(manifest.output.ends_with("out") && !manifest.merge);
    let [oak, autumn] = &manifest.species[..] else { panic!("two species") };
    for entry in [autumn, oak] {
        assert_eq!((entry.recipe.quality, entry.recipe.lattice), (Some(Quality::Draft), Some(32)));
        assert!(entry.plant.contains_key("leaf"));
    }
    assert_eq!(autumn.recipe.suns.map(|suns| suns.name()), Some("sh1s"));
    assert_eq!(oak.recipe.suns.map(|suns| suns.name()), Some("sh2s"));
    assert!(autumn.plant.contains_key("leaf_colour") && !oak.plant.contains_key("leaf_colour"));
    assert_eq!(autumn.variant_of.as_deref(), Some("oak"));
}

#[test]
fn a_pattern_makes_a_species_of_each_file_and_included_manifests_add_theirs() {
    let files = [
        (
            "library.toml",
            "include = ['more/shrubs.toml']\n[[species]]\nmesh = 'trees/**/*.obj'\nspecies_file = 'trees/{name}.toml'",
        ),
        ("more/shrubs.toml", "[bake]\nlattice = 16\n[[species]]\nname = 'ivy'\nmesh = 'ivy.glb'"),
        ("trees/oak.obj", ""),
        ("trees/old/ash.obj", ""),
        ("trees/ash.glb", ""),
    ];
    let manifest = read(&files).expect("a manifest");
    assert_eq!(names(&manifest), ["ivy", "oak", "ash"]);
    assert!(manifest.species[0].mesh.ends_with("more/ivy.glb"));
    assert_eq!(manifest.species[0].recipe.lattice, Some(16));
    assert!(manifest.species[2].species_file.as_ref().is_some_and(|file| file.ends_with("trees/ash.toml")));
    assert_eq!(manifest.species[2].recipe.lattice, None);
}

#[test]
fn manifests_that_cannot_be_are_refused_with_their_line() {
    let oak = "[[species]]\nname = 'oak'\nmesh = 'oak.glb'\n";
    let cases: &[(&[(&str, &str)], &str)] = &[
        (&[("library.toml", "")], "line 1, species: found none, expected one [[species]] or more"),
        (
            &[("library.toml", "[[species]]\nmesh = 'a.glb'\nspecies_fil = 'x'")],
            "unknown field `species_fil`, did you mean `species_file`?",
        ),
        (&[("library.toml", "[bake]\nqualty = 'draft'")], "line 2, column 1"),
        (
            &[("library.toml", "[[species]]\nmesh = 'a.glb'\nbake = { suns = 'sh9' }")],
            "found \"sh9\", expected one of lattice18, ico12",
        ),
        (
            &[("library.toml", "[[species]]\nmesh = '*.glb'")],
            "line 2, species.mesh: found \"*.glb\", which no file matches",
        ),
        (&[("library.toml", "[[species]]\nmesh = '[.glb'")], "line 2, species.mesh: found \"[.glb\""),
        (
            &[("library.toml", "[[species]]\nmesh = 'a.glb'\nname = 'a/b'")],
            "expected a printable name that a file can have",
        ),
        (
            &[("library.toml", &format!("{oak}{}", oak.replace("oak'", "Oak'")))],
            "line 4, species.name: found \"Oak\" again",
        ),
        (
            &[("library.toml", &format!("{oak}[[species.variant]]\nname = 'x'"))],
            "line 4, species.variant: found a variant that changes nothing",
        ),
        (
            &[("library.toml", &format!("{oak}budget = {{ bytes = -1 }}"))],
            "species.budget.bytes: found -1, expected a number above 0",
        ),
        (&[("library.toml", "include = ['gone.toml']")], "line 1, include: found"),
        (
            &[("library.toml", "include = ['a.toml']"), ("a.toml", "include = ['library.toml']")],
            "which includes this file, expected no circle",
        ),
        (
            &[("library.toml", "include = ['a.toml', 'a.toml']"), ("a.toml", oak)],
            "a second time, expected each manifest once",
        ),
    ];
    for (files, expected) in cases {
        let error = read(files).expect_err(expected);
        assert!(error.contains(expected), "{error}\nexpected {expected}");
    }
}
