//! The node tree of a glTF as a flat list of meshes to draw, each with its world matrices.

use glam::{DMat4, DQuat, DVec3};
use gltf::json::accessor::Type;
use gltf::json::{Node, Root};
use serde::Deserialize;
use std::collections::BTreeMap;

use super::accessor::Accessors;
use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::limits;

/// A mesh at a place.
pub struct Placed {
    /// Index into the file's nodes.
    pub node: usize,
    /// Index into the file's meshes.
    pub mesh: usize,
    /// `world_from_mesh`.
    pub world: DMat4,
    /// The skin, which replaces `world` where it can be read.
    pub skin: Option<usize>,
}

/// The meshes of the default scene in depth-first order, and the world matrix of each node visited.
pub struct Scene {
    /// What to draw.
    pub placed: Vec<Placed>,
    /// `world_from_node`.
    pub worlds: Vec<Option<DMat4>>,
}

#[derive(Deserialize)]
struct Instancing {
    attributes: BTreeMap<String, usize>,
}

/// Walks the default scene (the first one, or all root nodes, where the file names none).
pub fn walk(files: &mut Files, accessors: &mut Accessors) -> Result<Scene, ImportError> {
    let root = accessors.root;
    let roots = scene_roots(files, root)?;
    let mut scene = Scene { placed: Vec::new(), worlds: vec![None; root.nodes.len()] };
    let mut on_path = vec![false; root.nodes.len()];
    let mut visits = 0u64;
    // A stack of its own: the tree may be deeper than the thread's. `None` leaves the node.
    let mut stack: Vec<(usize, Option<DMat4>)> =
        roots.iter().rev().map(|&node| (node, Some(DMat4::IDENTITY))).collect();
    while let Some((index, parent)) = stack.pop() {
        let Some(node) = root.nodes.get(index) else {
            let expected = format!("one of {}", root.nodes.len());
            return Err(files.malformed("the node tree", format!("node {index}"), expected));
        };
        let Some(parent) = parent else {
            on_path[index] = false;
            continue;
        };
        if std::mem::replace(&mut on_path[index], true) {
            return Err(files.malformed(format!("nodes[{index}]"), "a node below itself", "a tree"));
        }
        visits += 1;
        files.limit("nodes visited", visits, limits::NODE_VISITS)?;
        let world = parent * local_matrix(files, index, node)?;
        scene.worlds[index] = Some(world);
        if let Some(mesh) = node.mesh {
            let copies = instances(files, accessors, index, node)?;
            visits += copies.len() as u64;
            files.limit("nodes and instances visited", visits, limits::NODE_VISITS)?;
            let skin = node.skin.map(|skin| skin.value());
            for local in copies {
                scene.placed.push(Placed { node: index, mesh: mesh.value(), world: world * local, skin });
            }
        }
        stack.push((index, None));
        let children = node.children.iter().flatten().rev();
        stack.extend(children.map(|child| (child.value(), Some(world))));
        files.limit("nodes waiting", stack.len() as u64, 4 * limits::NODE_VISITS)?;
    }
    Ok(scene)
}

fn scene_roots(files: &mut Files, root: &Root) -> Result<Vec<usize>, ImportError> {
    let index = root.scene.map_or(0, |scene| scene.value());
    if root.scenes.len() > 1 {
        files.warn(format!("scene {index} of {} is read", root.scenes.len()));
    }
    match root.scenes.get(index) {
        Some(scene) => Ok(scene.nodes.iter().map(|node| node.value()).collect()),
        None if root.scene.is_some() => {
            Err(files.malformed("scene", index, format!("one of {}", root.scenes.len())))
        }
        None => {
            let mut is_child = vec![false; root.nodes.len()];
            for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
                if let Some(flag) = is_child.get_mut(child.value()) {
                    *flag = true;
                }
            }
            Ok((0..root.nodes.len()).filter(|&node| !is_child[node]).collect())
        }
    }
}

fn local_matrix(files: &Files, index: usize, node: &Node) -> Result<DMat4, ImportError> {
    let matrix = match node.matrix {
        Some(matrix) => DMat4::from_cols_array(&matrix.map(f64::from)),
        None => compose(
            node.translation.map_or([0.0; 3], |t| t.map(f64::from)),
            node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |r| r.0.map(f64::from)),
            node.scale.map_or([1.0; 3], |s| s.map(f64::from)),
        ),
    };
    if !matrix.is_finite() {
        return Err(files.malformed(
            format!("nodes[{index}]"),
            "a transform that is not finite",
            "finite numbers",
        ));
    }
    Ok(matrix)
}

/// Translation, rotation (quaternion x, y, z, w of any length but 0), scale.
fn compose(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> DMat4 {
    let length = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
    let rotation =
        if length > 0.0 { DQuat::from_array(rotation.map(|x| x / length)) } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(DVec3::from_array(scale), rotation, DVec3::from_array(translation))
}

/// The matrices of EXT_mesh_gpu_instancing, or one identity.
fn instances(
    files: &Files,
    accessors: &mut Accessors,
    index: usize,
    node: &Node,
) -> Result<Vec<DMat4>, ImportError> {
    let json =
        node.extensions.as_ref().and_then(|extensions| extensions.others.get("EXT_mesh_gpu_instancing"));
    let Some(json) = json else {
        return Ok(vec![DMat4::IDENTITY]);
    };
    let place = format!("nodes[{index}].extensions.EXT_mesh_gpu_instancing");
    let instancing = Instancing::deserialize(json)
        .map_err(|error| files.malformed(&place, error, "attributes that name accessors"))?;
    let mut open = |name: &str, type_: Type| match instancing.attributes.get(name) {
        Some(&accessor) => accessors
            .open(files, &format!("{place}, {name}"), accessor, &[type_], limits::NODE_VISITS)
            .map(Some),
        None => Ok(None),
    };
    let translations = open("TRANSLATION", Type::Vec3)?;
    let rotations = open("ROTATION", Type::Vec4)?;
    let scales = open("SCALE", Type::Vec3)?;
    let mut counts =
        [&translations, &rotations, &scales].into_iter().flatten().map(|accessor| accessor.count);
    let Some(count) = counts.next() else {
        return Ok(vec![DMat4::IDENTITY]);
    };
    if let Some(other) = counts.find(|&other| other != count) {
        return Err(files.malformed(
            place,
            format!("attributes of {count} and {other} instances"),
            "equal counts",
        ));
    }
    let matrix = |at: usize| {
        compose(
            translations.as_ref().map_or([0.0; 3], |accessor| accessor.get(at)),
            rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |accessor| accessor.get(at)),
            scales.as_ref().map_or([1.0; 3], |accessor| accessor.get(at)),
        )
    };
    Ok((0..count).map(matrix).collect())
}
