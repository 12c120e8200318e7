//! Nodes as matrices, and as places in messages.

use glam::{DMat4, DQuat, DVec3};
use gltf::json::Root;

use crate::import::error::quoted;

/// A node for a message.
pub(super) fn place_of(root: &Root, index: usize) -> String {
    match root.nodes.get(index).and_then(|node| node.name.as_deref()).filter(|name| !name.is_empty()) {
        Some(name) => format!("nodes[{index}] '{}'", quoted(name)),
        None => format!("nodes[{index}]"),
    }
}

/// Translation, rotation (quaternion x, y, z, w of any length but 0), scale.
pub(super) fn compose(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> DMat4 {
    let length = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
    let rotation =
        if length > 0.0 { DQuat::from_array(rotation.map(|x| x / length)) } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(DVec3::from_array(scale), rotation, DVec3::from_array(translation))
}
