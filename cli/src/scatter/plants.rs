//! How large the plants of a scene to be are, and whether their light is theirs: found while the scene is written, not
//! when it is first drawn.

use std::path::Path;

use flb_format::SpeciesMeta;
use flb_scene::classify::classify;
use flb_scene::extents::{Extents, Mend};
use flb_scene::plant::recorded_settings;
use flb_scene::scene::SceneSpecies;
use flb_scene::{ClassedMesh, ImportSettings};

use crate::args::SpeciesArg;
use crate::classes::read_mesh;
use crate::exit::Failure;
use crate::forest::scene_species;
use crate::inputs::{choose_species, open};
use crate::mesh_of_light::mesh_of_species;
use crate::size::Measured;

/// Reads the mesh and the tables of the light, and says on stderr what is odd about them. Another mesh than that of the
/// light is let pass here: it may be shown with `--mesh-differs`.
pub(super) fn measure(species: &SpeciesArg) -> Result<Measured, Failure> {
    let path = &species.mesh;
    let measured = match &species.light {
        _ if is_library(path) => {
            let library = open(path)?;
            let index = choose_species(&library, Some(&species.name), None)?;
            of_meta(&library.container().species()[index].meta)
        }
        None => of_mesh(path)?,
        Some(light) => {
            let library = open(light)?;
            let index = scene_species(&library, &of_scene(species))?;
            let meta = &library.container().species()[index].meta;
            let shown = mesh_of_species(path, meta, None, true)?;
            Measured::of(&shown.mesh, &recorded_settings(meta), Mend::Bake)
        }
    };
    measured.say(path);
    Ok(measured)
}

/// A plan of a scene takes sizes from libraries too.
fn is_library(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("flb"))
}

/// As the scene will name it.
fn of_scene(species: &SpeciesArg) -> SceneSpecies {
    SceneSpecies {
        name: species.name.clone(),
        file: Some(species.mesh.clone()),
        gltf_mesh: None,
        species_file: None,
        light: species.light.clone(),
        light_species: None,
        upright: false,
    }
}

fn of_meta(meta: &SpeciesMeta) -> Measured {
    Measured::of_box(Extents::of_bounds(meta.bounds_m), &recorded_settings(meta), Mend::Bake)
}

/// Of a mesh without light: by the rules that need no flags, or as a box where these leave a material open.
fn of_mesh(path: &Path) -> Result<Measured, Failure> {
    let settings = ImportSettings::default();
    let mesh = read_mesh(path, &settings, false)?;
    Ok(match classify(&mesh, &Default::default()) {
        Ok(decisions) => {
            let classes = decisions.iter().map(|decision| decision.class).collect();
            Measured::of(&ClassedMesh::of(mesh, classes), &settings, Mend::SpeciesFile)
        }
        Err(_) => Measured::of_box(mesh.bounds().and_then(Extents::of_bounds), &settings, Mend::SpeciesFile),
    })
}
