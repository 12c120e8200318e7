//! A built-in plant through every stage of the papers' model, with each stage's result kept for a look.
//!
//! The stages are called here one by one: [`flb_baker::bake::bake`] keeps voxels and the report of each solve to
//! itself, and snapshots hold both. `tests/tests/it/stages.rs` holds that a bake makes the same medium and fields.

use flb_baker::{Occupancy, VoxelSettings, downsample, voxelise};
use flb_fixtures::{Plant, PlantKind, grow};
use flb_format::matter::Optics;
use flb_format::meta::{Bounds, TriangleCounts};
use flb_format::model::Model;
use flb_format::{Medium, SpeciesFields, SpeciesMeta};
use flb_packer::{EncodeSettings, EncodedSpecies, encode_species, write_library_to};
use flb_scene::classify::Classified;
use flb_scene::classify::classify;
use flb_scene::import::import;
use flb_scene::plant::plant_bounds;
use flb_scene::{ClassRules, ImportSettings, MaterialClass, Mesh};
use flb_transport::lattice::{Solution, SolveSettings, solve};

/// What to bake and how finely.
#[derive(Debug, Clone, Copy)]
pub struct Recipe {
    /// The plant.
    pub kind: PlantKind,
    /// Triangles to aim at.
    pub triangles: u32,
    /// Sites per edge.
    pub lattice: u32,
    /// Voxels per edge.
    pub voxels: u32,
    /// Relative threshold of the codec.
    pub threshold: f32,
}

impl Recipe {
    /// Small enough that all plants bake in seconds: lattice 32, 256 voxels, the default quality.
    pub fn small(kind: PlantKind) -> Recipe {
        let triangles = kind.default_triangles().min(6_000);
        Recipe { kind, triangles, lattice: 32, voxels: 256, threshold: 0.005 }
    }
}

/// The seed of every plant in these tests.
pub const SEED: u64 = 1;

/// Results of all stages.
pub struct Baked {
    /// As grown.
    pub plant: Plant,
    /// As written by the fixtures.
    pub glb: Vec<u8>,
    /// As imported from `glb`.
    pub mesh: Mesh,
    /// Per material, with the rule.
    pub classified: Vec<Classified>,
    /// Fine voxels.
    pub occupancy: Occupancy,
    /// Lattice.
    pub medium: Medium,
    /// The 19 bases.
    pub solution: Solution,
    /// As it goes into the file.
    pub encoded: EncodedSpecies,
    /// The file.
    pub file: Vec<u8>,
}

impl Baked {
    /// One class per material.
    pub fn classes(&self) -> Vec<MaterialClass> {
        self.classified.iter().map(|c| c.class).collect()
    }

    /// Field of a base.
    pub fn field(&self, base: u8) -> &flb_format::Field {
        &self.solution.bases[base as usize].1
    }
}

/// Grows and bakes.
///
/// # Panics
/// If a stage fails: the plants are known to be good.
pub fn bake(recipe: &Recipe) -> Baked {
    let plant = grow(recipe.kind, SEED, recipe.triangles).expect("the count is within the limits");
    let glb = plant.to_glb();
    let mesh = import_glb(recipe.kind.name(), &glb);
    let classified = classify(&mesh, &ClassRules::default()).expect("the fixtures' names are known");
    let classes: Vec<MaterialClass> = classified.iter().map(|c| c.class).collect();
    let occupancy =
        voxelise(&mesh, &classes, &voxel_settings(recipe), &|_| Ok(())).expect("a plant has triangles");
    let medium = downsample(&occupancy).expect("an occupancy of voxelise downsamples");
    let solution = solve(&medium, &Optics::paper(), &SolveSettings::default(), &|_| Ok(()))
        .expect("the medium is valid");
    let encoded = encode(recipe, &mesh, &classes, &medium, &solution);
    let file = write(&encoded);
    Baked { plant, glb, mesh, classified, occupancy, medium, solution, encoded, file }
}

/// The GLB as a file on disk, imported; the folder is gone afterwards.
pub fn import_glb(name: &str, glb: &[u8]) -> Mesh {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(format!("{name}.glb"));
    std::fs::write(&path, glb).expect("a temporary file");
    import(&path, &ImportSettings::default()).expect("the fixtures write valid GLB")
}

/// Settings of the voxeliser.
pub fn voxel_settings(recipe: &Recipe) -> VoxelSettings {
    VoxelSettings { voxels: recipe.voxels, lattice: recipe.lattice, ignore_alpha: false }
}

/// Codes the solution.
pub fn encode(
    recipe: &Recipe,
    mesh: &Mesh,
    classes: &[MaterialClass],
    medium: &Medium,
    solution: &Solution,
) -> EncodedSpecies {
    let meta = species_meta(recipe.kind.name(), mesh, classes, medium);
    let fields = SpeciesFields { meta, medium: medium.clone(), turbid: None, bases: solution.bases.clone() };
    let settings = EncodeSettings { threshold: recipe.threshold, ..EncodeSettings::papers() };
    encode_species(&fields, &settings, &|_| Ok(())).expect("fields of a solve fit their medium")
}

/// What the file says of a species with the papers' light.
pub fn species_meta(name: &str, mesh: &Mesh, classes: &[MaterialClass], medium: &Medium) -> SpeciesMeta {
    let count = |class: MaterialClass| {
        mesh.triangle_material.iter().filter(|&&m| classes[m as usize] == class).count() as u64
    };
    let none = Bounds { min: [0.0; 3], max: [0.0; 3] };
    SpeciesMeta {
        name: name.to_owned(),
        model: Model::Paper { optics: Optics::paper() },
        grid: medium.grid,
        bounds_m: plant_bounds(mesh, classes).unwrap_or(none),
        triangles: TriangleCounts {
            total: mesh.triangles.len() as u64,
            leaf: count(MaterialClass::Leaf),
            wood: count(MaterialClass::Wood),
        },
        mesh_blake3: mesh.digest(),
        mean_light: None,
        sky_averages: None,
        sources: mesh.sources.clone(),
        settings: Default::default(),
        tool: "flb-tests".to_owned(),
        left_out: None,
        extra: Default::default(),
    }
}

/// A library of one species.
pub fn write(encoded: &EncodedSpecies) -> Vec<u8> {
    let mut file = Vec::new();
    write_library_to(&mut file, &[encoded]).expect("a vector takes every byte");
    file
}
