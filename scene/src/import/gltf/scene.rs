//! The node tree of a glTF as a flat list of meshes to draw, each with its world matrices.

use glam::DMat4;
use gltf::json::{Index, Node, Root};

use super::accessor::Accessors;
use super::instancing::Instances;
use super::transform::{compose, place_of};
use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::limits;

/// A mesh at a place.
pub struct Placed {
    /// Index into the file's nodes; `None` for a mesh by itself.
    pub node: Option<usize>,
    /// Which of the node's instances it is, where EXT_mesh_gpu_instancing gives it some.
    pub instance: Option<u32>,
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
    /// How many of `placed` EXT_mesh_gpu_instancing gives.
    pub instanced: u64,
}

/// A mesh by itself, in its own space: neither nodes nor skins move it.
pub fn alone(mesh: usize) -> Scene {
    let placed = Placed { node: None, instance: None, mesh, world: DMat4::IDENTITY, skin: None };
    Scene { placed: vec![placed], worlds: Vec::new(), instanced: 0 }
}

/// Walks the default scene (the first one, or all root nodes, where the file names none).
pub fn walk(files: &mut Files, accessors: &mut Accessors) -> Result<Scene, ImportError> {
    let root = accessors.root;
    let roots = scene_roots(files, root)?;
    let mut scene = Scene { placed: Vec::new(), worlds: vec![None; root.nodes.len()], instanced: 0 };
    let mut on_path = vec![false; root.nodes.len()];
    let mut visits = 0u64;
    // A stack of its own: the tree may be deeper than the thread's.
    let mut stack = Vec::new();
    wait(files, &mut stack, &roots, None)?;
    while let Some(step) = stack.pop() {
        let (index, parent) = match step {
            Step::Enter { node, parent } => (node as usize, parent),
            Step::Leave { node } => {
                on_path[node as usize] = false;
                continue;
            }
        };
        let Some(node) = root.nodes.get(index) else {
            let expected = format!("one of {}", root.nodes.len());
            return Err(files.malformed("the node tree", format!("node {index}"), expected));
        };
        // A parent is on the path, so that its matrix is the one of this visit.
        let parent = parent.and_then(|parent| scene.worlds[parent as usize]).unwrap_or(DMat4::IDENTITY);
        if std::mem::replace(&mut on_path[index], true) {
            return Err(files.malformed(place_of(root, index), "a node below itself", "a tree"));
        }
        visits += 1;
        files.limit("nodes visited", visits, limits::NODE_VISITS)?;
        let world = parent * local_matrix(files, root, index)?;
        scene.worlds[index] = Some(world);
        let instances = Instances::open(files, accessors, index, node)?;
        if let Some(mesh) = node.mesh {
            let count = instances.as_ref().map_or(1, |instances| instances.count);
            visits += count as u64;
            files.limit("nodes and instances visited", visits, limits::NODE_VISITS)?;
            let placed_bytes = (scene.placed.len() + count) * 2 * size_of::<Placed>();
            files.room_for("nodes and instances", placed_bytes as u64)?;
            let (node, mesh, skin) = (Some(index), mesh.value(), node.skin.map(|skin| skin.value()));
            for at in 0..count {
                let (instance, local) = match &instances {
                    Some(instances) => (Some(at as u32), instances.matrix(files, at)?),
                    None => (None, DMat4::IDENTITY),
                };
                scene.instanced += u64::from(instance.is_some());
                scene.placed.push(Placed { node, instance, mesh, world: world * local, skin });
            }
        }
        stack.push(Step::Leave { node: index as u32 });
        if let Some(children) = &node.children {
            wait(files, &mut stack, children, Some(index as u32))?;
        }
    }
    Ok(scene)
}

/// What is to be done in the node tree.
enum Step {
    Enter { node: u32, parent: Option<u32> },
    Leave { node: u32 },
}

/// Puts nodes on the stack, the first one on top.
fn wait(
    files: &Files,
    stack: &mut Vec<Step>,
    nodes: &[Index<Node>],
    parent: Option<u32>,
) -> Result<(), ImportError> {
    files.limit("nodes waiting", (stack.len() + nodes.len()) as u64, 4 * limits::NODE_VISITS)?;
    stack.extend(nodes.iter().rev().map(|node| Step::Enter { node: node.value() as u32, parent }));
    Ok(())
}

fn scene_roots(files: &mut Files, root: &Root) -> Result<Vec<Index<Node>>, ImportError> {
    let index = root.scene.map_or(0, |scene| scene.value());
    if root.scenes.len() > 1 {
        files.warn(format!("scene {index} of {} is read", root.scenes.len()));
    }
    match root.scenes.get(index) {
        Some(scene) => Ok(scene.nodes.clone()),
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
            Ok((0..root.nodes.len())
                .filter(|&node| !is_child[node])
                .map(|node| Index::new(node as u32))
                .collect())
        }
    }
}

fn local_matrix(files: &mut Files, root: &Root, index: usize) -> Result<DMat4, ImportError> {
    let node = &root.nodes[index];
    if node.rotation.is_some_and(|rotation| rotation.0 == [0.0; 4]) {
        files.warn(format!("{} has a rotation of zeros; taken as none", place_of(root, index)));
    }
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
            place_of(root, index),
            "a transform that is not finite",
            "finite numbers",
        ));
    }
    Ok(matrix)
}
