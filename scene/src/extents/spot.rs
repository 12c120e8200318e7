//! Whether several whole plants stand on one spot: variants of a plant, a young one in an old one, one imported twice.
//!
//! A plant is a part of the file, or the parts of one name (the node above them), with leaves and wood. Two plants
//! stand on one spot where the feet of their trunks go through each other and both crowns are about their own foot.
//! Stems of a shrub that begin at one point lean away from it, each to its side.

use std::collections::BTreeMap;

use super::plan::{self, MAX_FOOT, middle, over_ground, width};
use super::{Doubt, Extents};
use crate::mesh::{Foot, Part, around};
use crate::{ClassedMesh, MaterialClass};

/// A crown is about its foot: its middle is so far from it at most, as a share of its width.
const CENTERED: f64 = 0.25;
/// Height of a plant, as a share of the height of all, at least.
const MIN_HEIGHT: f64 = 0.2;
/// Plants that are compared with each other.
const COMPARED: usize = 256;
/// Names that a doubt lists.
const LISTED: usize = 8;

/// Part of the file that is a plant.
struct Whole<'m> {
    name: &'m str,
    /// Numbers of its parts, which ascend.
    parts: Vec<usize>,
    foot: Foot,
}

/// The doubt, if several plants stand on one spot.
pub(super) fn doubt(plant: &ClassedMesh, extents: &Extents) -> Option<Doubt> {
    let mut by_name: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (number, part) in plant.mesh.parts.iter().enumerate() {
        for name in &part.names {
            let parts = by_name.entry(name).or_default();
            if parts.last() != Some(&number) {
                parts.push(number);
            }
        }
    }
    // A name may be that of several nodes' mesh.
    let labels: Vec<String> = plant.mesh.parts.iter().map(Part::label).collect();
    let single = labels.iter().enumerate().map(|(number, label)| (label.as_str(), vec![number]));
    let all = single.chain(by_name);
    let mut wholes: Vec<Whole> =
        all.filter_map(|(name, parts)| whole(plant, extents, name, parts)).take(COMPARED).collect();
    // In the file's order. Of a node and its mesh, the node's name is enough.
    let place = |whole: &Whole| {
        let names = &plant.mesh.parts[whole.parts[0]].names;
        (whole.parts[0], whole.parts.len(), names.iter().position(|name| name == whole.name))
    };
    wholes.sort_by_key(place);
    wholes.dedup_by(|b, a| a.parts == b.parts);
    let on_one_spot = |(at, first): (usize, &Whole)| {
        let is_other = |other: &&Whole| {
            let shares = other.parts.iter().any(|part| first.parts.binary_search(part).is_ok());
            !shares && over_ground(first.foot.middle_m, other.foot.middle_m) <= reach(first, other)
        };
        let others: Vec<&Whole> = wholes[at + 1..].iter().filter(is_other).collect();
        let names = std::iter::once(first.name).chain(others.iter().map(|other| other.name));
        let names = names.take(LISTED).map(str::to_owned).collect();
        (!others.is_empty()).then_some(Doubt::OneSpot { names })
    };
    wholes.iter().enumerate().find_map(on_one_spot)
}

/// The parts of a name as a plant, if they are one that stands on the ground.
fn whole<'m>(plant: &ClassedMesh, extents: &Extents, name: &'m str, parts: Vec<usize>) -> Option<Whole<'m>> {
    let uses = || parts.iter().flat_map(|&part| &plant.mesh.parts[part].uses);
    let bounds = |class: MaterialClass| {
        let of_class = uses().filter(|used| plant.classes[used.material as usize] == class);
        of_class.map(|used| used.bounds_m).reduce(around)
    };
    let bounds_m = around(bounds(MaterialClass::Leaf)?, bounds(MaterialClass::Wood)?);
    let foot = plan::foot(plant, uses())?;
    let (bottom_m, height_m) = (extents.bounds_m.min[1], extents.size_m()[1]);
    let is_high = bounds_m.max[1] - bounds_m.min[1] >= MIN_HEIGHT * height_m;
    let stands = foot.middle_m[1] - bottom_m <= MAX_FOOT * height_m;
    let is_centered = over_ground(middle(&bounds_m), foot.middle_m) <= CENTERED * width(&bounds_m);
    (is_high && stands && is_centered).then_some(Whole { name, parts, foot })
}

/// Distance of two feet up to which they go through each other.
fn reach(a: &Whole, b: &Whole) -> f64 {
    a.foot.spread_m.max(b.foot.spread_m)
}
