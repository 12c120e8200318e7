//! Reading a mesh file with its species file and class flags: what `bake`, `materials` and `render` share.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use flb_format::SpeciesMeta;
use flb_format::meta::TriangleCounts;
use flb_scene::classify::{ClassRules, Classified, classify};
use flb_scene::import::{ImportSettings, Up, import};
use flb_scene::scene::SceneSpecies;
use flb_scene::species::SpeciesFile;
use flb_scene::{MaterialClass, Mesh};
use serde_json::{Value, json};

use crate::args::{MeshArgs, UpArg};
use crate::exit::{Failure, USAGE};
use crate::inputs::check_local;
use crate::print::say;

/// How to read mesh files.
pub struct MeshReader {
    /// The species file, if one was named.
    pub species: Option<SpeciesFile>,
    /// Unit and up axis: the command line's, else the species file's.
    pub settings: ImportSettings,
    /// Patterns of both.
    pub rules: ClassRules,
    /// Says nothing on stderr: the same mesh was read before.
    pub quiet: bool,
}

impl MeshReader {
    /// From the flags, and the species file that they name.
    pub fn new(args: &MeshArgs) -> Result<MeshReader, Failure> {
        let species = args.species.as_deref().map(SpeciesFile::read).transpose()?;
        let up = args.up.map(|up| match up {
            UpArg::Y => Up::Y,
            UpArg::Z => Up::Z,
        });
        let flags = ImportSettings { up, unit_m: args.unit, gltf_mesh: args.gltf_mesh.clone() };
        let settings =
            species.as_ref().map_or_else(|| flags.clone(), |species| species.import_settings(&flags));
        let rules = ClassRules {
            leaf: args.leaf.clone(),
            wood: args.wood.clone(),
            ignore: args.ignore.clone(),
            species: species.as_ref().map(SpeciesFile::rules),
            elsewhere: Vec::new(),
        };
        Ok(MeshReader { species, settings, rules, quiet: false })
    }

    /// For the mesh of a scene's species.
    pub fn of_scene(species: &SceneSpecies) -> Result<MeshReader, Failure> {
        let (file, gltf_mesh) = (species.species_file.clone(), species.gltf_mesh.clone());
        MeshReader::new(&MeshArgs { species: file, gltf_mesh, ..MeshArgs::default() })
    }

    /// The mesh; what import repaired or ignored goes to stderr.
    pub fn read(&self, path: &Path) -> Result<Mesh, Failure> {
        read_mesh(path, &self.settings, self.quiet)
    }

    /// The mesh with its classes; classes that nobody stated are said on stderr.
    pub fn read_classed(&self, path: &Path) -> Result<ClassedMesh, Failure> {
        let mesh = self.read(path)?;
        let classified = classify(&mesh, &self.rules).map_err(|error| Failure::from(error).at(path))?;
        for (material, decision) in mesh.materials.iter().zip(&classified).filter(|_| !self.quiet) {
            let class = class_name(decision.class);
            say!("{}: material {:?} is {class}: {}", path.display(), material.name, decision.rule);
        }
        let classes = classified.iter().map(|c: &Classified| c.class).collect();
        Ok(ClassedMesh { mesh, classes })
    }

    /// Imports and classes every mesh of a job, to find out before the long work whether each can be baked;
    /// remembers the materials' names, so that a pattern may be meant for one mesh of several.
    pub fn rehearse(&mut self, paths: &[PathBuf]) -> Result<(), Failure> {
        let mut meshes = Vec::new();
        for path in paths {
            check_local(path)?;
            meshes.push(import(path, &self.settings).map_err(|error| Failure::from(error).at(path))?);
            let names = meshes.last().into_iter().flat_map(|mesh| &mesh.materials).map(|m| m.name.clone());
            self.rules.elsewhere.extend(names);
        }
        for (path, mesh) in paths.iter().zip(&meshes) {
            classify(mesh, &self.rules).map_err(|error| Failure::from(error).at(path))?;
        }
        Ok(())
    }

    /// Settings that a file records, so that `render` reads the mesh in the same way.
    pub fn record(&self, classed: &ClassedMesh) -> BTreeMap<String, Value> {
        let up = match self.settings.up {
            None | Some(Up::Y) => "y",
            Some(Up::Z) => "z",
        };
        let names: Vec<&str> = classed.classes.iter().map(|class| class_name(*class)).collect();
        let mut record = BTreeMap::from([
            (UP_KEY.to_owned(), json!(up)),
            (UNIT_KEY.to_owned(), json!(self.settings.unit_m.unwrap_or(1.0))),
            (CLASSES_KEY.to_owned(), json!(names)),
        ]);
        record.extend(self.settings.gltf_mesh.iter().map(|mesh| (MESH_KEY.to_owned(), json!(mesh))));
        record
    }
}

const UP_KEY: &str = "import.up";
const UNIT_KEY: &str = "import.unit_m";
pub const MESH_KEY: &str = "import.gltf_mesh";
const CLASSES_KEY: &str = "classify.materials";

/// A mesh and the class of each of its materials.
pub struct ClassedMesh {
    /// As imported.
    pub mesh: Mesh,
    /// One per material.
    pub classes: Vec<MaterialClass>,
}

impl ClassedMesh {
    /// Triangles by class.
    pub fn triangle_counts(&self) -> TriangleCounts {
        let count = |class| {
            let of_class = |material: &&u32| self.classes[**material as usize] == class;
            self.mesh.triangle_material.iter().filter(of_class).count() as u64
        };
        TriangleCounts {
            total: self.mesh.triangles.len() as u64,
            leaf: count(MaterialClass::Leaf),
            wood: count(MaterialClass::Wood),
        }
    }
}

/// How the mesh was read that a species was baked from.
pub fn recorded_settings(meta: &SpeciesMeta) -> ImportSettings {
    let up = match meta.settings.get(UP_KEY).and_then(Value::as_str) {
        Some("z") => Up::Z,
        _ => Up::Y,
    };
    let gltf_mesh = meta.settings.get(MESH_KEY).and_then(Value::as_str).map(str::to_owned);
    ImportSettings { up: Some(up), unit_m: meta.settings.get(UNIT_KEY).and_then(Value::as_f64), gltf_mesh }
}

/// The mesh that a species was baked from, read with the settings that its file records, or another mesh of a glTF. Says so on
/// stderr if the file's digest of the mesh is another, or the mesh is.
pub fn mesh_of_species(
    path: &Path,
    meta: &SpeciesMeta,
    gltf_mesh: Option<&str>,
) -> Result<ClassedMesh, Failure> {
    let mut settings = recorded_settings(meta);
    if let Some(asked) = gltf_mesh {
        let baked = settings.gltf_mesh.replace(asked.to_owned());
        if let Some(baked) = baked.filter(|baked| baked != asked) {
            say!(
                "warning: {}: species {:?} was baked from mesh {baked:?}, shown is {asked:?}",
                path.display(),
                meta.name
            );
        }
    }
    let mesh = read_mesh(path, &settings, false)?;
    let baked_from = |digest: &str| meta.sources.iter().any(|source| source.blake3 == digest);
    if !mesh.sources.first().is_some_and(|source| baked_from(&source.blake3)) {
        say!(
            "warning: {}: not the file that species {:?} was baked from, or changed since",
            path.display(),
            meta.name
        );
    }
    let recorded = meta.settings.get(CLASSES_KEY).and_then(Value::as_array);
    let classes: Option<Vec<MaterialClass>> =
        recorded.and_then(|names| names.iter().map(|name| class_of_name(name.as_str()?)).collect());
    let found = classes.as_ref().map_or(0, Vec::len);
    match classes {
        Some(classes) if found == mesh.materials.len() => Ok(ClassedMesh { mesh, classes }),
        _ => {
            let expected = mesh.materials.len();
            let message = format!(
                "the mesh has {expected} materials, species {:?} was baked with {found}: not the mesh that it was baked from",
                meta.name
            );
            Err(Failure::new(USAGE, message).at(path))
        }
    }
}

fn read_mesh(path: &Path, settings: &ImportSettings, quiet: bool) -> Result<Mesh, Failure> {
    check_local(path)?;
    let mesh = import(path, settings).map_err(|error| Failure::from(error).at(path))?;
    for warning in mesh.warnings.iter().filter(|_| !quiet) {
        // A warning names its file, which may be a texture; the folder is what it lacks.
        say!("warning: {warning} (reading {})", path.display());
    }
    Ok(mesh)
}

fn class_name(class: MaterialClass) -> &'static str {
    match class {
        MaterialClass::Leaf => "leaf",
        MaterialClass::Wood => "wood",
        MaterialClass::Neither => "neither",
    }
}

fn class_of_name(name: &str) -> Option<MaterialClass> {
    let classes = [MaterialClass::Leaf, MaterialClass::Wood, MaterialClass::Neither];
    classes.into_iter().find(|class| class_name(*class) == name)
}
