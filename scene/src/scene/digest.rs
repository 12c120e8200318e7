//! What tells two scenes apart whose plants do something else to each other's light: which plants stand where, how
//! large and how turned, on which ground.

use std::path::Path;

use super::{Ground, Scene, Terrain};

/// BLAKE3 of a scene's plants and ground, 64 hexadecimal digits. Suns, sky, camera and bands do not count, nor where
/// files are.
pub fn light_digest(scene: &Scene) -> String {
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

fn text(hasher: &mut blake3::Hasher, text: &str) {
    hasher.update(&(text.len() as u64).to_le_bytes());
    hasher.update(text.as_bytes());
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
