//! What a glTF itself says is not to be drawn: hidden nodes (KHR_node_visibility) and lower levels of detail
//! (MSFT_lod).

use std::collections::{BTreeMap, HashSet};

use gltf::json::{Node, Root};
use serde::Deserialize;

use super::transform::place_of;
use crate::import::error::{ImportError, quoted};
use crate::import::files::Files;

const VISIBILITY: &str = "KHR_node_visibility";
const LEVELS: &str = "MSFT_lod";

/// Names that a message lists.
pub(super) const LISTED: usize = 8;

#[derive(Deserialize)]
struct Visibility {
    #[serde(default = "yes")]
    visible: bool,
}

fn yes() -> bool {
    true
}

#[derive(Deserialize)]
struct Levels {
    ids: Vec<usize>,
}

/// Whether a node says that it is to be drawn; what lies above it has a say, too.
pub(super) fn is_visible(files: &Files, root: &Root, index: usize) -> Result<bool, ImportError> {
    match extension::<Visibility>(files, root, index, VISIBILITY, "visible, true or false")? {
        Some(Visibility { visible }) => Ok(visible),
        None => Ok(true),
    }
}

/// Nodes that are lower levels of detail of another.
pub(super) fn lower_levels(files: &Files, root: &Root) -> Result<HashSet<usize>, ImportError> {
    let mut lower = HashSet::new();
    for index in 0..root.nodes.len() {
        if let Some(Levels { ids }) = extension(files, root, index, LEVELS, "ids, numbers of nodes")? {
            lower.extend(ids);
        }
    }
    Ok(lower)
}

fn extension<'a, T: Deserialize<'a>>(
    files: &Files,
    root: &'a Root,
    index: usize,
    name: &str,
    expected: &str,
) -> Result<Option<T>, ImportError> {
    let others = root.nodes[index].extensions.as_ref().map(|extensions| &extensions.others);
    let Some(json) = others.and_then(|others| others.get(name)) else { return Ok(None) };
    let malformed = |error| files.malformed(format!("{}, {name}", place_of(root, index)), error, expected);
    T::deserialize(json).map(Some).map_err(malformed)
}

/// The names of a node and of its mesh.
pub(super) fn names_of(root: &Root, index: usize) -> impl Iterator<Item = &str> {
    let node: Option<&Node> = root.nodes.get(index);
    let mesh =
        node.and_then(|node| root.meshes.get(node.mesh?.value())).and_then(|mesh| mesh.name.as_deref());
    let own = node.and_then(|node| node.name.as_deref());
    own.into_iter().chain(mesh).filter(|name| !name.is_empty())
}

/// A word for a node that [`ImportSettings::nodes`](crate::ImportSettings::nodes) takes.
pub(super) fn word_of(root: &Root, index: usize) -> String {
    names_of(root, index).next().map_or_else(|| format!("#{index}"), str::to_owned)
}

/// A reason for which a file does not show a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Why {
    Hidden,
    LowerLevel,
    /// In no scene.
    Outside,
}

impl Why {
    fn words(self) -> String {
        match self {
            Why::Hidden => format!("hidden ({VISIBILITY})"),
            Why::LowerLevel => format!("lower levels of detail ({LEVELS})"),
            Why::Outside => "parts of no scene".to_owned(),
        }
    }
}

/// Nodes with meshes that the file does not show.
#[derive(Default)]
pub(super) struct LeftOut(BTreeMap<Why, (u64, Vec<String>)>);

impl LeftOut {
    /// Counts one.
    pub(super) fn add(&mut self, root: &Root, index: usize, why: Why) {
        let (count, names) = self.0.entry(why).or_default();
        *count += 1;
        if names.len() < LISTED {
            names.push(format!("'{}'", quoted(&word_of(root, index))));
        }
    }

    /// Says so.
    pub(super) fn tell(&self, files: &mut Files) {
        for (why, (count, names)) in &self.0 {
            let more = if *count > names.len() as u64 { ", ..." } else { "" };
            let nodes =
                if *count == 1 { "1 node with a mesh is" } else { &format!("{count} nodes with meshes are") };
            let (why, names) = (why.words(), names.join(", "));
            files.note(format!("{nodes} left out as {why}: {names}{more}; --node chooses nodes"));
        }
    }
}
