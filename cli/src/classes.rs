//! Reading a mesh file with its species file and class flags: what `bake`, `materials` and `trade` share.

use std::path::{Path, PathBuf};

use flb_scene::extents::Mend;
use flb_scene::scene::SceneSpecies;
use flb_scene::{
    ClassRules, ClassedMesh, ImportSettings, Mesh, Observer, PlantReader, SpeciesFile, Unobserved,
};
use flb_stage::{open, read};

use crate::args::MeshArgs;
use crate::exit::Failure;
use crate::inputs::check_local;
use crate::mesh_of_light::Said;
use crate::size::Measured;

/// Reads mesh files, and says on stderr what it decided.
pub(crate) struct MeshReader {
    pub plants: PlantReader,
    /// Says nothing: the same mesh was read before.
    pub quiet: bool,
    /// Where unit and up axis are said.
    pub mend: Mend,
}

impl MeshReader {
    /// From the flags, and the species file that they name.
    pub(crate) fn new(args: &MeshArgs) -> Result<MeshReader, Failure> {
        let species = args.species.as_deref().map(SpeciesFile::read).transpose()?;
        let (gltf_mesh, nodes) = (args.gltf_mesh.clone(), args.node.clone());
        let settings = ImportSettings {
            up: args.up,
            unit_m: args.unit,
            gltf_mesh,
            nodes,
            ignore_vertex_colors: args.ignore_vertex_colours,
            ..ImportSettings::default()
        };
        let (leaf, wood, ignore) = (args.leaf.clone(), args.wood.clone(), args.ignore.clone());
        let rules = ClassRules { leaf, wood, ignore, ..ClassRules::default() };
        let mut plants = PlantReader::new(species, settings, rules);
        (plants.colors.flag, plants.colors.wood_flag) = (args.leaf_colour, args.wood_colour);
        Ok(MeshReader { plants, quiet: false, mend: Mend::Flags })
    }

    /// For the mesh of a scene's species.
    pub(crate) fn of_scene(species: &SceneSpecies) -> Result<MeshReader, Failure> {
        Ok(MeshReader { plants: open::scene_reader(species)?, quiet: false, mend: Mend::SpeciesFile })
    }

    /// The mesh; what import repaired or ignored goes to stderr.
    pub(crate) fn read(&self, path: &Path) -> Result<Mesh, Failure> {
        read_mesh(path, &self.plants.settings, self.quiet)
    }

    /// The mesh with its classes; classes that were not stated are printed on stderr.
    pub(crate) fn read_classed(&self, path: &Path) -> Result<ClassedMesh, Failure> {
        check_local(path)?;
        Ok(read::read_classed(path, &self.plants, observer(self.quiet))?)
    }

    /// Says on stderr what of a mesh is there twice and counts once.
    pub(crate) fn say_sheets(&self, path: &Path, classed: &ClassedMesh) {
        read::tell_sheets(path, classed, observer(self.quiet));
    }

    /// The size of a mesh that was read, and doubts about it, which go to stderr.
    pub(crate) fn measure(&self, path: &Path, classed: &ClassedMesh) -> Measured {
        let measured = Measured::of_reader(classed, &self.plants, self.mend);
        measured.say(path);
        measured
    }

    /// Imports and classes every mesh of a job, to find out before the long work whether each can be baked.
    pub(crate) fn rehearse(&mut self, paths: &[PathBuf]) -> Result<(), Failure> {
        paths.iter().try_for_each(|path| check_local(path))?;
        self.plants.rehearse(paths).map_err(|(index, error)| Failure::from(error).at(&paths[index]))
    }
}

/// The mesh; what import repaired or ignored goes to stderr, unless `quiet`.
pub(crate) fn read_mesh(path: &Path, settings: &ImportSettings, quiet: bool) -> Result<Mesh, Failure> {
    check_local(path)?;
    read::read_mesh(path, settings, observer(quiet)).map_err(|error| Failure::from(error).at(path))
}

/// Hears what is said on stderr, unless `quiet`.
fn observer(quiet: bool) -> &'static dyn Observer {
    if quiet { &Unobserved } else { &Said }
}
