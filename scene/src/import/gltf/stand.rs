//! Where the meshes of a glTF stand, as species and plants of a scene; with the first camera and the first sun.
//!
//! Nodes that share a mesh and instances of EXT_mesh_gpu_instancing come out the same: a mesh is a species, every place
//! of it a plant. Geometry is not read. One bake serves rotations and uniform scales, so that any other transform is
//! refused here, by its node, rather than drawn in light that is not its own.

mod similar;
mod view;

use flb_format::eye::Eye;
use flb_format::text::is_hidden;
use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use gltf::json::Root;
use gltf::json::mesh::{Mesh, Mode, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::buffers::Buffers;
use super::chosen::Words;
use super::document;
use super::morphs;
use super::scene::{self, Placed};
use super::transform::place_of;
use crate::import::choice::Choice;
use crate::import::error::{ImportError, quoted};
use crate::import::files::{Files, Records};
use crate::import::limits::MAX_SPECIES;
use crate::import::points::Reach;
use crate::import::soup::Up;

/// The plants of a glTF's default scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Stand {
    /// The meshes that stand somewhere, in the file's order.
    pub species: Vec<StandSpecies>,
    /// Plants in the order of the node tree, instances of a node in their own order.
    pub plants: Vec<Plant>,
    /// The first perspective camera.
    pub camera: Option<Eye>,
    /// Azimuth and elevation of the first directional light, degrees.
    pub sun: Option<[f64; 2]>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// A mesh as a species.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StandSpecies {
    /// A name that a library may hold too, no other's: the mesh's name where that will do.
    pub name: String,
    /// The word that means the mesh: [`ImportSettings::gltf_mesh`](crate::ImportSettings::gltf_mesh).
    pub gltf_mesh: String,
    /// Index of the mesh.
    pub mesh: usize,
    /// Whether an import of the mesh takes an offset off its coordinates, as far as its accessors tell.
    pub is_far: bool,
}

/// A place of a mesh: first scaled, then turned, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plant {
    /// Index of its species.
    pub species: usize,
    /// Position of the mesh's origin, metres.
    pub position_m: [f64; 3],
    /// A quaternion x, y, z, w of length 1, w not negative.
    pub rotation: [f64; 4],
    /// Scale, above 0.
    pub scale: f64,
}

impl Stand {
    /// The species that a user's word means: its name, the word for its mesh, or the mesh's number.
    pub fn find(&self, word: &str) -> Option<usize> {
        let number = word.strip_prefix('#').and_then(|number| number.parse::<usize>().ok());
        let is_it = |species: &StandSpecies| {
            species.name == word || species.gltf_mesh == word || number == Some(species.mesh)
        };
        self.species.iter().position(is_it)
    }
}

impl Plant {
    /// Returns the plant with its mesh in the same place, where the model is the mesh read with these axes and this
    /// unit, less an offset in metres.
    pub fn of_model(self, up: Up, unit_m: f64, offset_m: [f64; 3]) -> Plant {
        let rotation = match up {
            Up::Y => self.rotation,
            Up::Z => similar::with_z_up(self.rotation),
        };
        let scale = self.scale / unit_m;
        let moved = DQuat::from_array(rotation) * (DVec3::from_array(offset_m) * scale);
        let position_m = match offset_m == [0.0; 3] {
            true => self.position_m,
            false => (DVec3::from_array(self.position_m) + moved).to_array(),
        };
        Plant { rotation, scale, position_m, ..self }
    }
}

/// Reads the bytes of a .gltf or .glb.
pub(crate) fn read(
    mut files: Files,
    bytes: Vec<u8>,
    leave_out: &[String],
    choice: &Choice,
) -> Result<Stand, ImportError> {
    let document = document::parse(&mut files, bytes)?;
    let root = document.root;
    let words = Words::of(&root);
    let left_out: Vec<usize> =
        leave_out.iter().map(|word| words.find(&files, word)).collect::<Result<_, _>>()?;
    let buffers = Buffers::load(&mut files, &root, document.binary)?;
    let mut accessors = Accessors { root: &root, buffers: &buffers, work: 0 };
    let scene = scene::walk(&mut files, &mut accessors, &document.transforms, choice)?;

    let mut species_of: BTreeMap<usize, Option<usize>> = BTreeMap::new();
    for placed in &scene.placed {
        let Some(mesh) = root.meshes.get(placed.mesh) else {
            let place = placed.node.map_or_else(String::new, |node| place_of(&root, node));
            let expected = format!("one of {}", root.meshes.len());
            return Err(files.malformed(place, format!("mesh {}", placed.mesh), expected));
        };
        species_of.entry(placed.mesh).or_insert_with(|| {
            let is_drawn = has_triangles(mesh);
            if !is_drawn {
                let word = quoted(&words.word(placed.mesh));
                files.warn(format!("mesh '{word}' has no triangles; its plants are left out"));
            }
            (is_drawn && !left_out.contains(&placed.mesh)).then_some(0)
        });
    }
    let mut species: Vec<StandSpecies> = Vec::new();
    for (&mesh, index) in species_of.iter_mut().filter(|(_, index)| index.is_some()) {
        files.limit("meshes that stand somewhere", species.len() as u64 + 1, MAX_SPECIES as u64)?;
        *index = Some(species.len());
        let gltf_mesh = files.name(format!("meshes[{mesh}]"), &words.word(mesh))?;
        let name = species_name(&species, &words, &root.meshes[mesh], mesh);
        let is_far = is_far(&root, mesh);
        species.push(StandSpecies { name, gltf_mesh, mesh, is_far });
    }
    files.room_for("plants", (scene.placed.len() * 2 * size_of::<Plant>()) as u64)?;
    let mut plants = Vec::with_capacity(scene.placed.len());
    for placed in &scene.placed {
        if let Some(species) = species_of[&placed.mesh] {
            plants.push(plant(&files, &root, placed, species)?);
        }
    }
    if plants.is_empty() {
        let found = format!("none of the meshes {}", words.listed());
        return Err(files.malformed("the default scene", found, "one that stands somewhere"));
    }
    warn_of_parts(&mut files, &species, &plants);
    let is_species = |mesh: usize| species_of.get(&mesh).is_some_and(Option::is_some);
    morphs::tell_of_shapes(&mut files, &root, is_species);
    let camera = view::camera(&mut files, &root, &scene.worlds)?;
    let sun = view::sun(&mut files, &root, &scene)?;
    let Records { mut warnings, notes, .. } = files.into_records();
    warnings.extend(notes);
    Ok(Stand { species, plants, camera, sun, warnings })
}

/// Whether a mesh lies far from its origin, by the least and largest coordinates that its accessors state.
fn is_far(root: &Root, mesh: usize) -> bool {
    let mut reach = Reach::NONE;
    for primitive in &root.meshes[mesh].primitives {
        let position = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let Some(accessor) = position.and_then(|index| root.accessors.get(index.value())) else { continue };
        for corner in [&accessor.min, &accessor.max].into_iter().flatten() {
            let numbers: Option<Vec<f64>> =
                corner.as_array().and_then(|list| list.iter().map(|number| number.as_f64()).collect());
            if let Some(Ok(point)) = numbers.map(<[f64; 3]>::try_from) {
                reach.add(point);
            }
        }
    }
    reach.is_far()
}

fn has_triangles(mesh: &Mesh) -> bool {
    let is_of = |mode: &Checked<Mode>| {
        matches!(mode, Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan))
    };
    mesh.primitives.iter().any(|primitive| is_of(&primitive.mode))
}

/// Bytes of a name that goes into the names of others.
const SHORT_NAME_BYTES: usize = 200;

/// The mesh's name where it is its own and printable, else one with its number.
fn species_name(taken: &[StandSpecies], words: &Words, mesh: &Mesh, index: usize) -> String {
    let printable = |name: &str| name.trim().replace(|c: char| is_hidden(c) || "/\\".contains(c), "_");
    let given = |name: &str| Some(printable(name)).filter(|name| !name.is_empty());
    let mut name = match words.name(index).and_then(given) {
        Some(name) => name,
        None => {
            let short = mesh.name.as_deref().filter(|name| name.len() <= SHORT_NAME_BYTES);
            let mut name = format!("{}_{index}", short.and_then(given).unwrap_or_else(|| "mesh".to_owned()));
            // Not that of a mesh which has it by itself.
            while words.is_name(&name) {
                name.push('_');
            }
            name
        }
    };
    while taken.iter().any(|species| species.name == name) {
        name.push('_');
    }
    name
}

fn plant(
    files: &Files,
    root: &gltf::json::Root,
    placed: &Placed,
    species: usize,
) -> Result<Plant, ImportError> {
    let refuse = |(found, expected): (String, &str)| {
        let node = placed.node.map_or_else(String::new, |node| place_of(root, node));
        let instance = placed.instance.map_or_else(String::new, |at| format!(", instance {at}"));
        files.malformed(format!("{node}{instance}"), found, expected)
    };
    if placed.skin.is_some() {
        let expected = "a plant that stands still (apply the skin's pose before the export)";
        return Err(refuse(("a skin".to_owned(), expected)));
    }
    similar::plant(placed.world, species).map_err(refuse)
}

/// Meshes in the very same places may be the parts of one plant.
fn warn_of_parts(files: &mut Files, species: &[StandSpecies], plants: &[Plant]) {
    let mut places: Vec<(blake3::Hasher, usize)> = vec![(blake3::Hasher::new(), 0); species.len()];
    for plant in plants {
        let (places, count) = &mut places[plant.species];
        let numbers = plant.position_m.iter().chain(&plant.rotation).chain([&plant.scale]);
        for number in numbers {
            places.update(&number.to_le_bytes());
        }
        *count += 1;
    }
    let mut first: BTreeMap<[u8; 32], usize> = BTreeMap::new();
    for (index, (places, count)) in places.iter().enumerate() {
        let other = *first.entry(*places.finalize().as_bytes()).or_insert(index);
        if other != index {
            files.warn(format!(
                "meshes '{}' and '{}' stand in the same {count} places: if they are parts of one plant, join them to one mesh \
                 before the export, as each is lit by itself",
                quoted(&species[other].gltf_mesh),
                quoted(&species[index].gltf_mesh)
            ));
        }
    }
}
