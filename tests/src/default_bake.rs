//! A built-in plant through the default bake: what `flb bake` does, at a coarser lattice.

use flb_baker::bake::{BakeSettings, Baked, NoStore, bake};
use flb_fixtures::{PlantKind, grow};
use flb_packer::{EncodeSettings, EncodedSpecies, encode_species};
use flb_render::Surfaces;
use flb_runtime::Library;
use flb_scene::{ClassedMesh, Plant, PlantReader, Unobserved};

use crate::pipeline::{SEED, import_glb, write};

/// Triangles that a plant of these tests is grown to, at most.
const TRIANGLES: u32 = 6_000;

/// A plant, its fields, its file.
pub struct DefaultBake {
    /// As the bake took it.
    pub mesh: ClassedMesh,
    /// As `bake` returned it.
    pub baked: Baked,
    /// As it goes into the file.
    pub encoded: EncodedSpecies,
    /// The file.
    pub file: Vec<u8>,
}

/// Settings of `flb bake`, but for lattice 32 of 256 voxels.
pub fn settings() -> BakeSettings {
    BakeSettings { lattice: 32, voxels: 256, ..BakeSettings::default() }
}

/// A built-in plant, written and read as a file.
///
/// # Panics
/// If the count of triangles is out of range: the plants are known to be good.
pub fn grown(kind: PlantKind, triangles: u32) -> Plant {
    let glb = grow(kind, SEED, triangles).expect("the count is within the limits").to_glb();
    let reader = PlantReader::default();
    let (mesh, _) = reader.class(import_glb(kind.name(), &glb)).expect("the fixtures' names are known");
    reader.plant(kind.name().to_owned(), mesh)
}

impl DefaultBake {
    /// Grows and bakes.
    ///
    /// # Panics
    /// If a stage fails: the plants are known to be good.
    pub fn of(kind: PlantKind) -> DefaultBake {
        DefaultBake::of_plant(grown(kind, kind.default_triangles().min(TRIANGLES)))
    }

    /// Bakes.
    ///
    /// # Panics
    /// If a stage fails.
    pub fn of_plant(plant: Plant) -> DefaultBake {
        DefaultBake::with(plant, &settings())
    }

    /// Bakes with other settings, and codes as `flb bake` does.
    ///
    /// # Panics
    /// If a stage fails.
    pub fn with(plant: Plant, settings: &BakeSettings) -> DefaultBake {
        DefaultBake::coded(plant, settings, &EncodeSettings::default())
    }

    /// Bakes and codes with other settings.
    ///
    /// # Panics
    /// If a stage fails.
    pub fn coded(plant: Plant, settings: &BakeSettings, coding: &EncodeSettings) -> DefaultBake {
        let mesh = plant.classed.clone();
        let baked = bake(plant, settings, &NoStore, &Unobserved).expect("a good plant");
        let encoded = encode_species(&baked.fields, coding, &|_| Ok(())).expect("good fields");
        let file = write(&encoded);
        DefaultBake { mesh, baked, encoded, file }
    }

    /// What its leaves and wood do with light.
    ///
    /// # Panics
    /// Unless the model is `physical`.
    pub fn surfaces(&self) -> Surfaces {
        let meta = &self.baked.fields.meta;
        let (surfaces, _) = meta.physical().expect("the default model");
        Surfaces::of(surfaces, meta)
    }

    /// The file, opened.
    ///
    /// # Panics
    /// Never: the packer writes valid files.
    pub fn library(&self) -> Library {
        Library::from_source("baked", Box::new(self.file.clone())).expect("a valid file")
    }
}
