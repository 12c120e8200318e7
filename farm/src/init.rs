//! The first manifest of a folder of meshes.

use std::collections::HashSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use flb_format::text::is_hidden;
use flb_scene::classify::table::triangle_counts;
use flb_scene::classify::{Found, found};
use flb_scene::extents::{Mend, doubts_of};
use flb_scene::import::import;
use flb_scene::plant::file_name;
use flb_scene::{ClassRules, ImportError, ImportSettings, PlantReader, SpeciesFile};
use rayon::prelude::*;

use crate::manifest::{NOT_IN_NAMES, glob};

/// Meshes in any folder below.
const PATTERN: &str = "**/*.{glb,gltf,obj,GLB,GLTF,OBJ}";

/// A mesh that was found, and what of it is to be decided.
#[derive(Debug)]
pub struct Surveyed {
    /// Name of the species: the file's; with the folder's before it where another mesh has that name.
    pub name: String,
    /// Mesh file.
    pub mesh: PathBuf,
    /// File of the mesh's name that ends in ".toml", if there is one.
    pub species_file: Option<PathBuf>,
    /// Materials of an unknown class, or why the mesh cannot be read.
    pub undecided: Result<Vec<OpenMaterial>, ImportError>,
    /// Doubts about the plant, in sentences.
    pub doubts: Vec<String>,
}

/// A material of an unknown class.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenMaterial {
    /// Name in the mesh.
    pub name: String,
    /// Triangles of it.
    pub triangles: u64,
    /// Why no rule decides.
    pub why: String,
}

/// Reads every mesh below a folder, in the order of their paths.
///
/// # Errors
/// [`ImportError::Malformed`] for a folder without a mesh; [`ImportError::Io`].
pub fn survey(folder: &Path) -> Result<Vec<Surveyed>, ImportError> {
    std::fs::read_dir(folder).map_err(|source| ImportError::Io { path: folder.to_owned(), source })?;
    let none = |found: String| ImportError::Malformed {
        file: folder.display().to_string(),
        place: "folder".to_owned(),
        found,
        expected: "meshes: .glb, .gltf or .obj".to_owned(),
    };
    let meshes = glob::files(folder, PATTERN).map_err(none)?;
    if meshes.is_empty() {
        return Err(none("no mesh".to_owned()));
    }
    let mut all: Vec<Surveyed> = meshes.into_par_iter().map(look_at).collect();
    let mut taken = HashSet::new();
    for one in &mut all {
        let base = one.name.clone();
        if taken.contains(&base.to_lowercase()) {
            let parent = one.mesh.parent().and_then(Path::file_name).unwrap_or_default();
            one.name = fit_name(&format!("{}-{base}", parent.to_string_lossy()));
        }
        let longer = one.name.clone();
        for number in 2.. {
            if taken.insert(one.name.to_lowercase()) {
                break;
            }
            one.name = format!("{longer}-{number}");
        }
    }
    Ok(all)
}

fn look_at(mesh: PathBuf) -> Surveyed {
    let species_file = Some(mesh.with_extension("toml")).filter(|path| path.is_file());
    let mut doubted = Vec::new();
    let undecided = read(&mesh, species_file.as_deref(), &mut doubted);
    let name = fit_name(&file_name(&mesh).unwrap_or_default());
    Surveyed { name, mesh, species_file, undecided, doubts: doubted }
}

fn read(
    path: &Path,
    species_file: Option<&Path>,
    doubted: &mut Vec<String>,
) -> Result<Vec<OpenMaterial>, ImportError> {
    let species = species_file.map(SpeciesFile::read).transpose()?;
    let reader = PlantReader::new(species, ImportSettings::default(), ClassRules::default());
    let mesh = import(path, &reader.settings)?;
    let counts = triangle_counts(&mesh);
    let mut open = Vec::new();
    for (at, found) in found(&mesh, &reader.rules)?.into_iter().enumerate() {
        if let Found::Open(why) = found {
            let name = mesh.materials[at].name.clone();
            open.push(OpenMaterial { name, triangles: counts[at], why });
        }
    }
    if open.is_empty() {
        let (classed, _) = reader.class(mesh)?;
        doubted.extend(doubts_of(&classed, &reader).iter().map(|doubt| Mend::Manifest.said(doubt)));
    }
    Ok(open)
}

/// A name that a manifest takes.
fn fit_name(name: &str) -> String {
    let name = name.trim().replace(|c: char| is_hidden(c) || NOT_IN_NAMES.contains(c), "_");
    match name.trim_start_matches('.') {
        "" => "species".to_owned(),
        name => name[..name.floor_char_boundary(crate::manifest::MAX_NAME_BYTES / 2)].to_owned(),
    }
}

/// The text of a manifest in `folder` with all that was found. Species with undecided materials say which; meshes that
/// cannot be read are comments.
pub fn text(all: &[Surveyed], folder: &Path) -> String {
    let mut text = "# Species to bake; `flb library build` bakes those that changed.\n\n[bake]\nquality = \"standard\"\n"
        .to_owned();
    for one in all {
        text.push('\n');
        let lines = entry(one, folder);
        match &one.undecided {
            Ok(open) => {
                text += &lines;
                add_open(&mut text, open);
            }
            Err(error) => {
                comment(&mut text, &format!("Cannot be read: {error}"));
                lines.lines().for_each(|line| comment(&mut text, line));
            }
        }
        one.doubts.iter().for_each(|doubt| comment(&mut text, &format!("Doubt: {doubt}")));
    }
    text
}

/// The keys of a species.
fn entry(one: &Surveyed, folder: &Path) -> String {
    let mesh = below(&one.mesh, folder);
    let mesh = if glob::is_pattern(&mesh) { globset::escape(&mesh) } else { mesh };
    let mut lines = format!("[[species]]\nmesh = {}\n", quoted(&mesh));
    if file_name(&one.mesh).as_ref() != Some(&one.name) {
        lines += &format!("name = {}\n", quoted(&one.name));
    }
    if let Some(file) = &one.species_file {
        lines += &format!("species_file = {}\n", quoted(&below(file, folder)));
    }
    lines
}

fn add_open(text: &mut String, open: &[OpenMaterial]) {
    if open.is_empty() {
        return;
    }
    comment(text, "Undecided: say of each material whether it is leaf, wood, or ignored.");
    for material in open {
        let OpenMaterial { name, triangles, why } = material;
        comment(text, &format!("  {name:?}, {triangles} triangles: {why}"));
    }
    let names: Vec<String> = open.iter().map(|material| quoted(&material.name)).collect();
    comment(text, &format!("plant = {{ leaf = [{}], wood = [] }}", names.join(", ")));
}

/// A path as a manifest in `folder` names it.
fn below(path: &Path, folder: &Path) -> String {
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let (path, folder) = (whole(path), whole(folder));
    path.strip_prefix(&folder).unwrap_or(&path).to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/")
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A line that TOML passes over, whatever characters it is given.
fn comment(text: &mut String, line: &str) {
    let line = line.replace(is_hidden, " ");
    let _ = writeln!(text, "# {}", line.trim_end());
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::Manifest;

    const CARD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl MATERIAL\nf 1 2 3 4\n";

    #[test]
    fn a_folder_becomes_a_manifest_that_says_what_is_undecided() {
        let temporary = tempfile::tempdir().expect("a folder");
        let folder = temporary.path();
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("a file");
        };
        write("trees/oak.obj", &CARD.replace("MATERIAL", "leaves"));
        write("trees/old/oak.obj", &CARD.replace("MATERIAL", "leaves").replace("v 1 ", "v 1500 "));
        write("trees/elm.obj", &CARD.replace("MATERIAL", "Mat \"7\""));
        write("ash [1].OBJ", &CARD.replace("MATERIAL", "stuff"));
        write("ash [1].toml", "leaf = ['stuff']\n");
        write("broken.glb", "no glTF");
        write(".hidden/x.txt", "no mesh");
        let all = survey(folder).expect("a survey");
        let names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["ash [1]", "broken", "elm", "oak", "old-oak"]);
        let text = text(&all, folder);
        assert!(text.contains("#   \"Mat \\\"7\\\"\", 2 triangles: "), "{text}");
        assert!(text.contains("# Cannot be read: ") && text.contains("# mesh = \"broken.glb\""), "{text}");
        let mend = "# Doubt: the plant's longest edge is 1500 m, expected 0.05 to 100 m; unit_m in its table `plant` says";
        assert!(text.contains(mend), "{text}");
        fs::write(folder.join("library.toml"), &text).expect("a file");
        let manifest = Manifest::read(&folder.join("library.toml")).expect("a manifest");
        let names: Vec<&str> = manifest.species.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(names, ["ash [1]", "elm", "oak", "old-oak"]);
        assert_eq!(manifest.species[0].species_file, Some(folder.join("ash [1].toml")));
        assert!(manifest.species.iter().all(|entry| entry.mesh.is_file()), "{manifest:?}");

        let empty = survey(&folder.join(".hidden")).expect_err("no mesh").to_string();
        assert!(empty.contains("no mesh") && empty.contains(".glb, .gltf or .obj"), "{empty}");
        let missing = survey(&folder.join("gone")).expect_err("no folder").to_string();
        assert!(missing.contains("gone"), "{missing}");
    }
}
