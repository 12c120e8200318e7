//! Parts that are no part of the plant, by the names of their nodes or groups, whatever material they borrow: the hull
//! of a trunk that wears its bark, a pot of bark, a ground of grass.

use crate::classify::words::{Told, is_first_node, stand_in, told};
use crate::mesh::{Image, Material, Part};

/// Reads the evidence of the names of a material and of its texture, if they say what it is.
pub(crate) fn told_of_material(images: &[Image], material: &Material) -> Option<Told> {
    let image = material.color_texture.and_then(|texture| images.get(texture.image as usize));
    for name in std::iter::once(material.name.as_str()).chain(image.map(|image| image.stem())) {
        match told(name) {
            found @ (Told::Class(..) | Told::Foreign(_)) => return Some(found),
            Told::Both(_) => return None,
            Told::Unsure(_) | Told::Nothing => {}
        }
    }
    None
}

/// Reads the evidence of the names of a part, and the name that gives it: what stands beside a plant by any of them,
/// then its own name before those of what it is a part of. The first node of a file (`RootNode`) is no root of a plant.
pub fn told_of_part(part: &Part) -> Option<(Told, &str)> {
    let beside = part.names.iter().find_map(|name| Some((Told::Foreign(stand_in(name)?), name.as_str())));
    let said = part.names.iter().filter(|name| !is_first_node(name));
    let mut told = said.map(|name| (told(name), name.as_str()));
    beside.or_else(|| told.find(|(told, _)| matches!(told, Told::Class(..) | Told::Foreign(_))))
}

/// Which parts are things whatever their materials are called.
#[derive(Default)]
pub(crate) struct Things {
    /// As long as the parts, or empty where none is.
    flags: Vec<bool>,
}

impl Things {
    /// A stand-in (`UCX_trunk`) is one. A part named after something else (`flower_pot`) is where all its materials are
    /// of one class: a plant may be named after its pot. None is where no other part is left to be the plant.
    ///
    /// `told` is what each material says by itself, `used` the materials that each part uses.
    pub(crate) fn of(told: &[Option<Told>], parts: &[Part], used: impl FnOnce() -> Vec<Vec<u32>>) -> Things {
        let is_stand_in = |part: &Part| part.names.iter().any(|name| stand_in(name).is_some());
        let is_named_so = |part: &Part| match told_of_part(part) {
            Some((Told::Foreign(_), by)) => {
                is_stand_in(part) || part.own_names().iter().any(|name| name == by)
            }
            _ => false,
        };
        let named: Vec<bool> = parts.iter().map(is_named_so).collect();
        if !named.contains(&true) {
            return Things::default();
        }
        let used = used();
        let class = |material: &u32| match &told[*material as usize] {
            Some(Told::Class(class, _)) => Some(*class),
            _ => None,
        };
        let is_one_class = |used: &Vec<u32>| {
            used.first().and_then(class).is_some_and(|first| used.iter().all(|one| class(one) == Some(first)))
        };
        let has_others = named.iter().zip(&used).any(|(is_named, used)| !is_named && !used.is_empty());
        let flags = parts.iter().zip(named).zip(&used).map(|((part, is_named), used)| {
            has_others && is_named && (is_stand_in(part) || is_one_class(used))
        });
        Things { flags: flags.collect() }
    }

    /// Whether the part of that number is one.
    pub(crate) fn has(&self, part: u32) -> bool {
        self.flags.get(part as usize) == Some(&true)
    }
}
