//! Reading a mesh file with its species file and class flags: what `bake`, `materials` and `render` share.

use std::path::{Path, PathBuf};

use flb_format::SpeciesMeta;
use flb_scene::import::{ImportSettings, Up, import};
use flb_scene::plant::{ClassedMesh, PlantReader, recorded_classes, recorded_settings};
use flb_scene::scene::SceneSpecies;
use flb_scene::{ClassRules, Mesh, SpeciesFile};

use crate::args::{MeshArgs, UpArg};
use crate::exit::{Failure, USAGE};
use crate::inputs::check_local;
use crate::print::say;

/// Reads mesh files, and says on stderr what it decided.
pub struct MeshReader {
    pub plants: PlantReader,
    /// Says nothing: the same mesh was read before.
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
        let settings = ImportSettings { up, unit_m: args.unit, gltf_mesh: args.gltf_mesh.clone() };
        let (leaf, wood, ignore) = (args.leaf.clone(), args.wood.clone(), args.ignore.clone());
        let rules = ClassRules { leaf, wood, ignore, ..ClassRules::default() };
        Ok(MeshReader { plants: PlantReader::new(species, settings, rules), quiet: false })
    }

    /// For the mesh of a scene's species.
    pub fn of_scene(species: &SceneSpecies) -> Result<MeshReader, Failure> {
        let (file, gltf_mesh) = (species.species_file.clone(), species.gltf_mesh.clone());
        MeshReader::new(&MeshArgs { species: file, gltf_mesh, ..MeshArgs::default() })
    }

    /// The mesh; what import repaired or ignored goes to stderr.
    pub fn read(&self, path: &Path) -> Result<Mesh, Failure> {
        read_mesh(path, &self.plants.settings, self.quiet)
    }

    /// The mesh with its classes; classes that were not stated are printed on stderr.
    pub fn read_classed(&self, path: &Path) -> Result<ClassedMesh, Failure> {
        let mesh = self.read(path)?;
        let (classed, decisions) = self.plants.class(mesh).map_err(|error| Failure::from(error).at(path))?;
        for (material, decision) in classed.mesh.materials.iter().zip(&decisions).filter(|_| !self.quiet) {
            let class = decision.class.name();
            say!("{}: material {:?} is {class}: {}", path.display(), material.name, decision.rule);
        }
        Ok(classed)
    }

    /// Imports and classes every mesh of a job, to find out before the long work whether each can be baked.
    pub fn rehearse(&mut self, paths: &[PathBuf]) -> Result<(), Failure> {
        paths.iter().try_for_each(|path| check_local(path))?;
        self.plants.rehearse(paths).map_err(|(index, error)| Failure::from(error).at(&paths[index]))
    }
}

/// The mesh that a species was baked from, read with the settings that its file records, or another mesh of a glTF.
/// Says so on stderr if the file's digest of the mesh is another, or the mesh is.
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
    let classes = recorded_classes(meta);
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
