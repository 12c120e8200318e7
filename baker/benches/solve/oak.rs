//! The plant that is solved.

use flb_baker::{VoxelSettings, downsample, voxelise};
use flb_fixtures::PlantKind;
use flb_format::Medium;
use flb_scene::classify::classify;
use flb_scene::import::import;
use flb_scene::{ClassRules, ImportSettings};

/// The built-in oak at a lattice, as `flb bake` makes it.
pub(crate) fn medium(lattice: u32) -> Medium {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("oak.glb");
    let plant = flb_fixtures::grow(PlantKind::Oak, 1, 80_000).expect("enough triangles");
    std::fs::write(&path, plant.to_glb()).expect("room for the plant");
    let mesh = import(&path, &ImportSettings::default()).expect("a good mesh");
    let classes = classify(&mesh, &ClassRules::default()).expect("materials that tell");
    let classes: Vec<_> = classes.into_iter().map(|decision| decision.class).collect();
    let settings = VoxelSettings { voxels: 1024, lattice, ignore_alpha: false };
    downsample(&voxelise(&mesh, &classes, &settings, &|_| Ok(())).expect("a good mesh"))
        .expect("a good occupancy")
}

/// Non-empty sites.
pub(crate) fn sites_of(medium: &Medium) -> usize {
    medium.density.iter().filter(|density| **density > 0.0).count()
}
