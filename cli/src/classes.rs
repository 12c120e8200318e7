//! Reading a mesh file with its species file and class flags: what `bake`, `materials` and `render` share.

use std::path::Path;

use flb_baker::classify::{ClassRules, Classified, classify};
use flb_baker::import::{ImportSettings, Up, import};
use flb_baker::species::SpeciesFile;
use flb_baker::{MaterialClass, Mesh};
use flb_format::meta::TriangleCounts;

use crate::args::{MeshArgs, UpArg};
use crate::exit::Failure;

/// How to read mesh files.
pub struct MeshReader {
    /// The species file, if one was named.
    pub species: Option<SpeciesFile>,
    /// Unit and up axis: the command line's, else the species file's.
    pub settings: ImportSettings,
    /// Patterns of both.
    pub rules: ClassRules,
}

/// A mesh and the class of each of its materials.
pub struct ClassedMesh {
    /// As imported.
    pub mesh: Mesh,
    /// One per material, with the rule that gave it.
    pub classified: Vec<Classified>,
}

impl ClassedMesh {
    /// One class per material.
    pub fn classes(&self) -> Vec<MaterialClass> {
        self.classified.iter().map(|c| c.class).collect()
    }

    /// Triangles by class.
    pub fn triangle_counts(&self) -> TriangleCounts {
        let classes = self.classes();
        let count = |class| {
            let of_class = |material: &&u32| classes[**material as usize] == class;
            self.mesh.triangle_material.iter().filter(of_class).count() as u64
        };
        TriangleCounts {
            total: self.mesh.triangles.len() as u64,
            leaf: count(MaterialClass::Leaf),
            wood: count(MaterialClass::Wood),
        }
    }
}
