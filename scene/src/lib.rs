//! What a renderer and a bake read: plant meshes with their materials, leaf optics, species files and scenes.
//!
//! ```text
//! glTF/OBJ -import-> Mesh -classify-> leaf or wood, per material
//! ClassedMesh -color-> what its texels mean, and what it reflects in the mean
//! ClassedMesh -extents-> its size, and doubts about it
//! species file -> SpeciesFile (classes, units, optics)
//! scene file, or glTF -> scene::Scene (where plants stand, camera, suns)
//! sun and turbidity, or an image -> sky::Sky (radiance from every side)
//! ```
//!
//! ```
//! use flb_scene::{ClassRules, ImportSettings, MaterialClass, PlantReader};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let file = folder.path().join("fern.obj");
//! # std::fs::write(&file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl frond_leaf\nf 1 2 3\n")?;
//! // Materials whose names tell nothing are an error, unless the rules or a species file class them.
//! let reader = PlantReader::new(None, ImportSettings::default(), ClassRules::default());
//! let (fern, _why) = reader.read(&file)?;
//! assert_eq!(fern.mesh.triangles.len(), 1);
//! assert_eq!(fern.classes, [MaterialClass::Leaf]);
//! let plant = reader.plant("fern".to_owned(), fern); // what a bake takes
//! assert_eq!(plant.name, "fern");
//! # Ok(())
//! # }
//! ```
//!
//! Model space is right-handed, +Y up, in metres. Nothing here solves light.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod alpha;
mod class;
pub mod classify;
pub mod color;
pub mod extents;
pub mod import;
pub mod leaf;
pub mod mesh;
mod name_pattern;
mod observer;
pub mod plant;
pub mod rays;
pub mod sampling;
pub mod scene;
pub mod sheets;
pub mod sky;
pub mod solar;
pub mod species;
pub mod surface_points;
pub mod texture;
pub mod unit;
pub mod waves;

pub use class::MaterialClass;
pub use classify::ClassRules;
pub use import::{ImportError, ImportSettings};
pub use mesh::Mesh;
pub use observer::{Observer, Step, Unobserved};
pub use plant::{ClassedMesh, Plant, PlantReader};
pub use species::SpeciesFile;
