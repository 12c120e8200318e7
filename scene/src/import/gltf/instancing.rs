//! The instances of a node (EXT_mesh_gpu_instancing): accessors of translations, rotations and scales to matrices.
//!
//! What can be refused without reading an instance is refused first, so that a count that a file merely claims costs
//! nothing.

use std::collections::BTreeMap;

use glam::DMat4;
use gltf::json::Node;
use gltf::json::accessor::{ComponentType, Type};
use serde::Deserialize;

use super::accessor::{Accessor, Accessors};
use super::transform::{compose, place_of};
use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::limits;

/// The extension's name.
pub(super) const EXTENSION: &str = "EXT_mesh_gpu_instancing";

/// A quaternion shorter than this says no direction: normalised bytes, the coarsest, are not shorter than 1/127.
const SHORTEST_ROTATION: f64 = 1e-6;

#[derive(Deserialize)]
struct Json {
    attributes: BTreeMap<String, usize>,
}

/// The instances of a node, not yet read.
pub(super) struct Instances<'a> {
    /// Number of instances.
    pub count: usize,
    place: String,
    translations: Option<Accessor<'a>>,
    rotations: Option<Accessor<'a>>,
    scales: Option<Accessor<'a>>,
}

impl<'a> Instances<'a> {
    /// Those of node `index`; `None` where it has no such extension, or one without attributes.
    pub(super) fn open(
        files: &Files,
        accessors: &mut Accessors<'a>,
        index: usize,
        node: &Node,
    ) -> Result<Option<Instances<'a>>, ImportError> {
        let json = node.extensions.as_ref().and_then(|extensions| extensions.others.get(EXTENSION));
        let Some(json) = json else {
            return Ok(None);
        };
        let place = format!("{}, {EXTENSION}", place_of(accessors.root, index));
        let Json { attributes } = Json::deserialize(json)
            .map_err(|error| files.malformed(&place, error, "attributes that name accessors"))?;
        if node.mesh.is_none() {
            return Err(files.malformed(
                place,
                "a node without a mesh",
                "a mesh, of which there are instances",
            ));
        }
        let mut open = |name: &str, type_: Type, components: &[(ComponentType, bool)]| {
            let Some(&accessor) = attributes.get(name) else { return Ok(None) };
            let place = format!("{place}, {name}");
            let opened = accessors.open(files, &place, accessor, &[type_], limits::NODE_VISITS)?;
            opened.check_components(files, &place, components)?;
            Ok(Some(opened))
        };
        let float = [(ComponentType::F32, false)];
        let turn = [(ComponentType::F32, false), (ComponentType::I8, true), (ComponentType::I16, true)];
        let translations = open("TRANSLATION", Type::Vec3, &float)?;
        let rotations = open("ROTATION", Type::Vec4, &turn)?;
        let scales = open("SCALE", Type::Vec3, &float)?;
        let Some(count) = equal_counts(files, accessors, &place, &attributes)? else {
            return Ok(None);
        };
        Ok(Some(Instances { count, place, translations, rotations, scales }))
    }

    /// `node_from_mesh` of instance `at`, below the count.
    pub(super) fn matrix(&self, files: &Files, at: usize) -> Result<DMat4, ImportError> {
        let translation = self.read(files, &self.translations, "TRANSLATION", at, [0.0; 3])?;
        let rotation = self.read(files, &self.rotations, "ROTATION", at, [0.0, 0.0, 0.0, 1.0])?;
        let scale = self.read(files, &self.scales, "SCALE", at, [1.0; 3])?;
        if rotation.iter().map(|x| x * x).sum::<f64>().sqrt() < SHORTEST_ROTATION {
            let place = format!("{}, ROTATION of instance {at}", self.place);
            return Err(files.malformed(place, format!("{rotation:?}"), "a quaternion of length 1"));
        }
        Ok(compose(translation, rotation, scale))
    }

    fn read<const N: usize>(
        &self,
        files: &Files,
        accessor: &Option<Accessor>,
        name: &str,
        at: usize,
        default: [f64; N],
    ) -> Result<[f64; N], ImportError> {
        let value = accessor.as_ref().map_or(default, |accessor| accessor.get(at));
        match value.iter().all(|x| x.is_finite()) {
            true => Ok(value),
            false => {
                let place = format!("{}, {name} of instance {at}", self.place);
                Err(files.malformed(place, format!("{value:?}"), "finite numbers"))
            }
        }
    }
}

/// How many instances all attributes agree on, those that are not read, such as `_ID`, included; `None` without any.
fn equal_counts(
    files: &Files,
    accessors: &Accessors,
    place: &str,
    attributes: &BTreeMap<String, usize>,
) -> Result<Option<usize>, ImportError> {
    let mut first: Option<(&str, u64)> = None;
    for (name, &accessor) in attributes {
        let Some(json) = accessors.root.accessors.get(accessor) else {
            let expected = format!("one of {}", accessors.root.accessors.len());
            return Err(files.malformed(
                format!("{place}, {name}"),
                format!("accessor {accessor}"),
                expected,
            ));
        };
        let count = json.count.0;
        match first {
            None => first = Some((name, count)),
            Some((other, expected)) if count != expected => {
                let found = format!("{expected} of {other} and {count} of {name}");
                return Err(files.malformed(
                    place,
                    found,
                    "as many of each attribute as there are instances",
                ));
            }
            Some(_) => {}
        }
    }
    let Some((name, count)) = first else { return Ok(None) };
    files.limit(format!("{place}, {name}: count"), count, limits::NODE_VISITS)?;
    Ok(Some(count as usize))
}
