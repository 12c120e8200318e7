//! What tells two stands apart: which plants stand where, how large and how turned, on which ground; and what tells two
//! plants, or two lattices, apart.

use std::path::Path;

use flb_format::{FieldKind, Surfaces, Turbid};
use flb_scene::scene::{Ground, Scene, Terrain};

use super::Stand;

/// BLAKE3 of a scene's plants and ground, 64 hexadecimal digits. Suns, sky, camera and bands do not count, nor where
/// files are.
pub fn digest(scene: &Scene) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut number = |value: f64| {
        hasher.update(&value.to_bits().to_le_bytes());
    };
    number(scene.instances.len() as f64);
    for instance in &scene.instances {
        number(instance.species as f64);
        instance.transform.position_m.into_iter().for_each(&mut number);
        instance.transform.rotation.as_flattened().iter().copied().for_each(&mut number);
        number(instance.transform.scale);
    }
    if let Some(Ground { terrain, color }) = &scene.ground {
        color.iter().copied().for_each(&mut number);
        match terrain {
            Terrain::Plane { height_m } => number(*height_m),
            Terrain::Map(map) => {
                map.origin_m.into_iter().chain(map.size_m).chain(map.height_m).for_each(&mut number);
                text(&mut hasher, &name(&map.file));
            }
        }
    }
    scene.species.iter().for_each(|species| text(&mut hasher, &species.name));
    hasher.finalize().to_hex().to_string()
}

/// BLAKE3 of all that a plant does to light, 64 hexadecimal digits: its surfaces, what its fields hold, its fine
/// medium.
pub fn plant_digest(surfaces: &Surfaces, field: FieldKind, turbid: &Turbid) -> String {
    let surfaces = serde_json::to_vec(surfaces).expect("names and numbers make JSON");
    let mut hasher = blake3::Hasher::new();
    hasher.update(&surfaces).update(field.name().as_bytes());
    hash_turbid(&mut hasher, turbid);
    hasher.finalize().to_hex().to_string()
}

/// BLAKE3 of all that a stand's light depends on, beside the settings of its solve and its mean surfaces.
pub fn stand_digest(stand: &Stand) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hash_turbid(&mut hasher, &stand.turbid);
    for value in stand.albedos.as_flattened().iter().chain([&stand.below]) {
        hasher.update(&value.to_le_bytes());
    }
    *hasher.finalize().as_bytes()
}

/// All of a medium.
fn hash_turbid(hasher: &mut blake3::Hasher, turbid: &Turbid) {
    let Turbid { grid, leaf_per_m, wood_per_m, angles } = turbid;
    hasher.update(&grid.lattice.to_le_bytes());
    for value in grid.origin_m.iter().chain([&grid.spacing_m]).chain(angles.shares()) {
        hasher.update(&value.to_le_bytes());
    }
    for value in leaf_per_m.iter().chain(wood_per_m) {
        hasher.update(&value.to_le_bytes());
    }
}

fn text(hasher: &mut blake3::Hasher, text: &str) {
    hasher.update(&(text.len() as u64).to_le_bytes());
    hasher.update(text.as_bytes());
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
