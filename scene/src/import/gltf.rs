//! glTF 2.0 and GLB to triangles and materials.
//!
//! The `gltf` crate gives the JSON's types. Everything behind them (container, buffers, accessors,
//! node tree) is read here with checks of its own: that crate's readers panic on some hostile or
//! quantised accessors, and its validation refuses required extensions that are read here.

mod accessor;
mod attributes;
mod buffers;
mod chosen;
mod document;
mod instancing;
mod materials;
mod meshopt_view;
mod morphs;
mod primitive;
mod scene;
mod shown;
mod stand;
mod transform;

use std::collections::{BTreeMap, HashMap};

use gltf::json::Root;

use self::accessor::Accessors;
use self::buffers::Buffers;
use self::chosen::Words;
use self::materials::Library;
use self::scene::{Placed, Scene};
use super::choice::Choice;
use super::error::ImportError;
use super::files::Files;
use super::images::Images;
use super::limits;
use super::soup::{FileFrame, Soup};
use crate::mesh::{Image, Material, PART_NAMES, Part};

pub use self::chosen::WHOLE;
pub(super) use self::document::is_glb;
pub(super) use self::stand::read as read_stand;
pub use self::stand::{Plant, Stand, StandSpecies};

/// What a file holds besides triangles.
pub(super) struct Surfaces {
    /// Materials that a triangle names, in the file's order; then one per mesh without material.
    pub materials: Vec<Material>,
    /// Images that the materials use.
    pub images: Vec<Image>,
    /// Nodes or groups; their `uses` are empty.
    pub parts: Vec<Part>,
}

/// The JSON of a .gltf or .glb alone.
pub(super) fn root(files: &mut Files, bytes: Vec<u8>) -> Result<gltf::json::Root, ImportError> {
    Ok(document::parse(files, bytes)?.root)
}

/// A material as the primitives of a file name it: by index, or by the mesh that has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    Material(usize),
    Without { mesh: usize },
}

/// Reads the bytes of a .gltf or .glb into `soup`: its default scene, or the mesh that a word means.
pub(super) fn import(
    files: &mut Files,
    bytes: Vec<u8>,
    mesh: Option<&str>,
    choice: &Choice,
    frame: FileFrame,
    soup: &mut Soup,
) -> Result<Surfaces, ImportError> {
    let document = document::parse(files, bytes)?;
    let root = document.root;
    let buffers = Buffers::load(files, &root, document.binary)?;
    let held_bytes = document.held_bytes + buffers.held_bytes;
    let mut accessors = Accessors { root: &root, buffers: &buffers, work: 0 };
    let scene = match mesh {
        Some(word) if word != WHOLE => {
            let mesh = Words::of(&root).find(files, word)?;
            morphs::tell_of_shapes(files, &root, |other| other == mesh);
            scene::alone(&root, mesh)
        }
        _ => scene::walk(files, &mut accessors, &document.transforms, choice)?,
    };
    if mesh.is_none() && scene.instanced > 1 {
        let (file, meshes) = (files.file.clone(), Words::of(&root).listed());
        return Err(ImportError::Instanced { file, instances: scene.instanced, meshes });
    }

    let mut keys: BTreeMap<Key, (u32, Option<u32>)> = BTreeMap::new();
    let mut mesh_used = vec![false; root.meshes.len()];
    for placed in &scene.placed {
        let Some(mesh) = root.meshes.get(placed.mesh) else {
            let expected = format!("one of {}", root.meshes.len());
            let place = placed.node.map_or_else(String::new, |node| transform::place_of(&root, node));
            return Err(files.malformed(place, format!("mesh {}", placed.mesh), expected));
        };
        if !std::mem::replace(&mut mesh_used[placed.mesh], true) {
            for primitive in &mesh.primitives {
                keys.insert(key_of(files, &root, placed.mesh, primitive)?, (0, None));
            }
        }
    }
    files.limit("materials", keys.len() as u64, limits::MATERIALS)?;
    let mut library = Library { root: &root, buffers: &buffers, images: Images::default() };
    let mut materials = Vec::with_capacity(keys.len());
    for (&key, slot) in &mut keys {
        let (material, tex_coord) = match key {
            Key::Material(index) => {
                let loaded = library.load(files, index)?;
                (loaded.material, loaded.tex_coord)
            }
            Key::Without { mesh } => {
                (Material::opaque(name_without_material(files, &root, &scene, mesh)?), None)
            }
        };
        *slot = (materials.len() as u32, tex_coord);
        materials.push(material);
    }

    let mut primitives_added = 0u64;
    let mut parts = Parts::default();
    for placed in &scene.placed {
        let part = parts.of(files, &root, &scene, placed)?;
        soup.begin_part(files, part)?;
        for (index, primitive) in root.meshes[placed.mesh].primitives.iter().enumerate() {
            primitives_added += 1;
            files.limit("primitives of all nodes", primitives_added, limits::NODE_VISITS)?;
            let (material, tex_coord) = keys[&key_of(files, &root, placed.mesh, primitive)?];
            let name = format!("meshes[{}].primitives[{index}]", placed.mesh);
            let target = primitive::Target { soup, frame, material, tex_coord };
            primitive::add(files, &mut accessors, &scene, placed, primitive, &name, target)?;
        }
    }
    files.release(held_bytes);
    Ok(Surfaces { materials, images: library.images.images, parts: parts.parts })
}

/// The nodes, or the mesh, that triangles come from.
#[derive(Default)]
struct Parts {
    parts: Vec<Part>,
    by_node: HashMap<usize, u32>,
}

impl Parts {
    /// The part of a placed mesh. All instances of a node are one.
    fn of(
        &mut self,
        files: &mut Files,
        root: &Root,
        scene: &Scene,
        placed: &Placed,
    ) -> Result<u32, ImportError> {
        let next = self.parts.len() as u32;
        let mut names: Vec<String> = Vec::new();
        let mut add = |name: Option<&String>| {
            if let Some(name) = name.filter(|name| !name.is_empty() && names.len() < PART_NAMES) {
                names.push(name.clone());
            }
        };
        let of_mesh = root.meshes[placed.mesh].name.as_ref();
        match placed.node {
            None => add(of_mesh),
            Some(node) => {
                if let Some(&known) = self.by_node.get(&node) {
                    return Ok(known);
                }
                self.by_node.insert(node, next);
                add(root.nodes[node].name.as_ref());
                add(of_mesh);
                let mut above = scene.parents[node];
                for _ in 0..ABOVE {
                    let Some(node) = above else { break };
                    add(root.nodes[node as usize].name.as_ref());
                    above = scene.parents[node as usize];
                }
            }
        }
        let bytes = names.iter().map(|name| name.len() as u64 + 64).sum::<u64>() + 160;
        files.hold("nodes with meshes", bytes)?;
        for name in &names {
            files.name("the node tree", name)?;
        }
        self.parts.push(Part { names, node: placed.node.map(|node| node as u32), uses: Vec::new() });
        Ok(next)
    }
}

/// How far up the tree a node's names are looked for.
const ABOVE: usize = 8;

fn key_of(
    files: &Files,
    root: &gltf::json::Root,
    mesh: usize,
    primitive: &gltf::json::mesh::Primitive,
) -> Result<Key, ImportError> {
    match primitive.material.map(|material| material.value()) {
        None => Ok(Key::Without { mesh }),
        Some(index) if index < root.materials.len() => Ok(Key::Material(index)),
        Some(index) => {
            let expected = format!("one of {}", root.materials.len());
            Err(files.malformed(format!("meshes[{mesh}]"), format!("material {index}"), expected))
        }
    }
}

/// A mesh without material is told by its own name, or by that of the first node that shows it.
fn name_without_material(
    files: &Files,
    root: &gltf::json::Root,
    scene: &scene::Scene,
    mesh: usize,
) -> Result<String, ImportError> {
    fn given(name: &Option<String>) -> Option<&str> {
        name.as_deref().filter(|name| !name.is_empty())
    }
    let node = || scene.placed.iter().find(|placed| placed.mesh == mesh).and_then(|placed| placed.node);
    match given(&root.meshes[mesh].name).or_else(|| given(&root.nodes[node()?].name)) {
        Some(name) => files.name(format!("meshes[{mesh}]"), name),
        None => Ok(format!("mesh_{mesh}")),
    }
}

#[cfg(test)]
mod tests;
