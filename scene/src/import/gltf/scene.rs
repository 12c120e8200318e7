//! The node tree of a glTF as a flat list of meshes to draw, each with its world matrices.

use glam::DMat4;
use gltf::json::{Index, Node, Root};

use super::accessor::Accessors;
use super::document::NodeTransform;
use super::instancing::Instances;
use super::morphs;
use super::shown::{LISTED, LeftOut, Why, is_visible, lower_levels, names_of, word_of};
use super::transform::{compose, place_of};
use crate::import::choice::Choice;
use crate::import::error::{ImportError, quoted};
use crate::import::files::Files;
use crate::import::limits;

/// A mesh at a place.
pub(super) struct Placed {
    /// Index into the file's nodes; `None` for a mesh by itself.
    pub node: Option<usize>,
    /// Number of the node's instance, where EXT_mesh_gpu_instancing gives it some.
    pub instance: Option<u32>,
    /// Index into the file's meshes.
    pub mesh: usize,
    /// `world_from_mesh`.
    pub world: DMat4,
    /// The skin, which replaces `world` where it can be read.
    pub skin: Option<usize>,
}

/// The meshes of the default scene in depth-first order, and the world matrix of each node visited.
pub(super) struct Scene {
    /// Meshes to draw.
    pub placed: Vec<Placed>,
    /// `world_from_node`.
    pub worlds: Vec<Option<DMat4>>,
    /// The node above each node visited.
    pub parents: Vec<Option<u32>>,
    /// Whether the file shows each node, with what lies above it.
    pub shown: Vec<bool>,
    /// Weights of the morph targets of a mesh by itself.
    pub weights: Vec<f32>,
    /// Number of entries of `placed` that EXT_mesh_gpu_instancing gives.
    pub instanced: u64,
}

/// A mesh by itself, in its own space: neither nodes nor skins move it.
pub(super) fn alone(root: &Root, mesh: usize) -> Scene {
    let placed = Placed { node: None, instance: None, mesh, world: DMat4::IDENTITY, skin: None };
    Scene {
        placed: vec![placed],
        worlds: Vec::new(),
        parents: Vec::new(),
        shown: Vec::new(),
        weights: morphs::alone(root, mesh).to_vec(),
        instanced: 0,
    }
}

/// Walks the default scene (the first one, or all root nodes, where the file names none). With a choice, nothing but
/// what it means is placed, hidden or not, and nodes outside of the scene count where the scene has none that it means.
///
/// `transforms` are those of the nodes in f64, or empty.
pub(super) fn walk(
    files: &mut Files,
    accessors: &mut Accessors,
    transforms: &[NodeTransform],
    choice: &Choice,
) -> Result<Scene, ImportError> {
    let root = accessors.root;
    let roots = scene_roots(files, root, choice)?;
    let scene = walk_from(files, accessors, transforms, choice, &roots)?;
    if choice.is_met() {
        if !choice.is_made() {
            tell_outside(files, root)?;
        }
        return Ok(scene);
    }
    let scene = walk_from(files, accessors, transforms, choice, &all_roots(root))?;
    let with_mesh = (0..root.nodes.len()).filter(|&node| root.nodes[node].mesh.is_some());
    choice.check(&files.file, with_mesh.map(|node| word_of(root, node)))?;
    Ok(scene)
}

fn walk_from(
    files: &mut Files,
    accessors: &mut Accessors,
    transforms: &[NodeTransform],
    choice: &Choice,
    roots: &[Index<Node>],
) -> Result<Scene, ImportError> {
    let root = accessors.root;
    let nodes = root.nodes.len();
    let (worlds, parents) = (vec![None; nodes], vec![None; nodes]);
    let shown = vec![false; nodes];
    let mut scene = Scene { placed: Vec::new(), worlds, parents, shown, weights: Vec::new(), instanced: 0 };
    let lower_levels = lower_levels(files, root)?;
    let mut left_out = LeftOut::default();
    let mut on_path = vec![false; nodes];
    let mut visits = 0u64;
    // A stack of its own: the tree may be deeper than the thread's.
    let mut stack = Vec::new();
    wait(files, &mut stack, roots, None, Shown { by_file: true, by_choice: !choice.is_made() })?;
    while let Some(step) = stack.pop() {
        let (index, parent, mut shown) = match step {
            Step::Enter { node, parent, shown } => (node as usize, parent, shown),
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
        let above = parent.and_then(|parent| scene.worlds[parent as usize]).unwrap_or(DMat4::IDENTITY);
        if std::mem::replace(&mut on_path[index], true) {
            return Err(files.malformed(place_of(root, index), "a node below itself", "a tree"));
        }
        visits += 1;
        files.limit("nodes visited", visits, limits::NODE_VISITS)?;
        let world = above * local_matrix(files, root, transforms.get(index), index)?;
        scene.worlds[index] = Some(world);
        scene.parents[index] = parent;
        let is_hidden = !is_visible(files, root, index)?;
        shown.by_file &= !is_hidden && !lower_levels.contains(&index);
        scene.shown[index] = shown.by_file;
        if choice.is_made() && choice.means(names_of(root, index).chain([format!("#{index}").as_str()])) {
            shown.by_choice = true;
        }
        let is_shown = shown.by_choice && (choice.is_made() || shown.by_file);
        let instances = Instances::open(files, accessors, index, node)?;
        if let Some(mesh) = node.mesh.filter(|_| is_shown) {
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
        } else if node.mesh.is_some() && !choice.is_made() {
            let is_lower = lower_levels.contains(&index);
            left_out.add(root, index, if is_lower { Why::LowerLevel } else { Why::Hidden });
        }
        stack.push(Step::Leave { node: index as u32 });
        if let Some(children) = &node.children {
            wait(files, &mut stack, children, Some(index as u32), shown)?;
        }
    }
    left_out.tell(files);
    Ok(scene)
}

/// Whether a node and what lies above it are to be drawn.
#[derive(Clone, Copy)]
struct Shown {
    /// By its file: neither hidden nor a lower level of detail.
    by_file: bool,
    /// By the choice.
    by_choice: bool,
}

/// What is to be done in the node tree.
enum Step {
    Enter { node: u32, parent: Option<u32>, shown: Shown },
    Leave { node: u32 },
}

/// Puts nodes on the stack, the first one on top.
fn wait(
    files: &Files,
    stack: &mut Vec<Step>,
    nodes: &[Index<Node>],
    parent: Option<u32>,
    shown: Shown,
) -> Result<(), ImportError> {
    files.limit("nodes waiting", (stack.len() + nodes.len()) as u64, 4 * limits::NODE_VISITS)?;
    stack.extend(nodes.iter().rev().map(|node| Step::Enter { node: node.value() as u32, parent, shown }));
    Ok(())
}

/// Says which nodes with meshes are in no scene. Lower levels of detail often are in none.
fn tell_outside(files: &mut Files, root: &Root) -> Result<(), ImportError> {
    let mut found = vec![root.scenes.is_empty(); root.nodes.len()];
    let mut find = |roots: Vec<usize>| {
        let (mut waiting, mut new) = (roots, Vec::new());
        while let Some(node) = waiting.pop() {
            if found.get(node).is_some_and(|found| !found) {
                found[node] = true;
                new.push(node);
                let children = root.nodes[node].children.iter().flatten();
                waiting.extend(children.map(|child| child.value()));
            }
        }
        new
    };
    find(root.scenes.iter().flat_map(|scene| &scene.nodes).map(|node| node.value()).collect());
    let lower = lower_levels(files, root)?.into_iter().collect();
    let mut left_out = LeftOut::default();
    for (why, roots) in [(Why::LowerLevel, lower), (Why::Outside, (0..root.nodes.len()).collect())] {
        let mut nodes = find(roots);
        nodes.retain(|node| root.nodes[*node].mesh.is_some());
        nodes.sort_unstable();
        nodes.into_iter().for_each(|node| left_out.add(root, node, why));
    }
    left_out.tell(files);
    Ok(())
}

fn scene_roots(files: &mut Files, root: &Root, choice: &Choice) -> Result<Vec<Index<Node>>, ImportError> {
    let index = root.scene.map_or(0, |scene| scene.value());
    if root.scenes.len() > 1 && !choice.is_made() {
        let named = |at: usize| {
            let name = root.scenes.get(at).and_then(|scene| scene.name.as_deref());
            name.map_or_else(|| format!("scene {at}"), |name| format!("scene {at} '{}'", quoted(name)))
        };
        let others = (0..root.scenes.len()).filter(|&at| at != index).take(LISTED).map(named);
        let others = others.collect::<Vec<_>>().join(", ");
        let count = root.scenes.len();
        let why = if root.scene.is_none() { ", as the file names no default" } else { "" };
        files.warn(format!(
            "{} of {count} is read{why}, not {others}; --node chooses nodes of any",
            named(index)
        ));
    }
    match root.scenes.get(index) {
        Some(scene) => Ok(scene.nodes.clone()),
        None if root.scene.is_some() => {
            Err(files.malformed("scene", index, format!("one of {}", root.scenes.len())))
        }
        None => Ok(all_roots(root)),
    }
}

/// Nodes that are no node's child.
fn all_roots(root: &Root) -> Vec<Index<Node>> {
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(flag) = is_child.get_mut(child.value()) {
            *flag = true;
        }
    }
    let roots = (0..root.nodes.len()).filter(|&node| !is_child[node]);
    roots.map(|node| Index::new(node as u32)).collect()
}

fn local_matrix(
    files: &mut Files,
    root: &Root,
    precise: Option<&NodeTransform>,
    index: usize,
) -> Result<DMat4, ImportError> {
    let node = &root.nodes[index];
    if node.rotation.is_some_and(|rotation| rotation.0 == [0.0; 4]) {
        files.warn(format!("{} has a rotation of zeros; taken as none", place_of(root, index)));
    }
    let NodeTransform { matrix, translation, rotation, scale } = precise.copied().unwrap_or(NodeTransform {
        matrix: node.matrix.map(|matrix| matrix.map(f64::from)),
        translation: node.translation.map(|translation| translation.map(f64::from)),
        rotation: node.rotation.map(|rotation| rotation.0.map(f64::from)),
        scale: node.scale.map(|scale| scale.map(f64::from)),
    });
    let matrix = match matrix {
        Some(matrix) => DMat4::from_cols_array(&matrix),
        None => compose(
            translation.unwrap_or_default(),
            rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
            scale.unwrap_or([1.0; 3]),
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
