//! Weights of morph targets: a node's go before its mesh's (glTF 3.7.2.2).

use std::collections::BTreeMap;

use gltf::json::Root;

use super::transform::place_of;
use crate::import::error::quoted;
use crate::import::files::Files;

/// Weights of the targets of a node's mesh.
pub(super) fn of_node(root: &Root, node: usize, mesh: usize) -> &[f32] {
    root.nodes[node].weights.as_deref().unwrap_or_else(|| of_mesh(root, mesh))
}

/// Weights of the targets of a mesh by itself: what all nodes that place it agree on, or the mesh's own.
pub(super) fn alone(root: &Root, mesh: usize) -> &[f32] {
    let mut placings = placings(root).filter(|(_, placed)| *placed == mesh);
    let Some((first, _)) = placings.next() else { return of_mesh(root, mesh) };
    let first = of_node(root, first, mesh);
    if placings.all(|(node, _)| of_node(root, node, mesh) == first) { first } else { of_mesh(root, mesh) }
}

/// Says so where nodes have one of some meshes in several shapes: a mesh by itself has one.
pub(super) fn tell_of_shapes(files: &mut Files, root: &Root, is_meant: impl Fn(usize) -> bool) {
    // By mesh: the first node, and the first of another shape.
    let mut shapes: BTreeMap<usize, (usize, Option<usize>)> = BTreeMap::new();
    for (node, mesh) in placings(root).filter(|(_, mesh)| is_meant(*mesh)) {
        let (first, other) = shapes.entry(mesh).or_insert((node, None));
        if other.is_none() && of_node(root, node, mesh) != of_node(root, *first, mesh) {
            *other = Some(node);
        }
    }
    for (mesh, first, other) in
        shapes.into_iter().filter_map(|(mesh, (first, other))| Some((mesh, first, other?)))
    {
        let name = root.meshes[mesh].name.as_deref().map_or_else(|| format!("#{mesh}"), str::to_owned);
        files.warn(format!(
            "mesh '{}' has other weights of its morph targets at {} than at {}; by itself it has its own",
            quoted(&name),
            place_of(root, other),
            place_of(root, first)
        ));
    }
}

/// Nodes, and the meshes that they place.
fn placings(root: &Root) -> impl Iterator<Item = (usize, usize)> {
    let mesh_of = |node: usize| root.nodes[node].mesh.map(|mesh| mesh.value());
    let placed = move |node: usize| Some((node, mesh_of(node).filter(|mesh| *mesh < root.meshes.len())?));
    (0..root.nodes.len()).filter_map(placed)
}

fn of_mesh(root: &Root, mesh: usize) -> &[f32] {
    root.meshes[mesh].weights.as_deref().unwrap_or_default()
}
