//! How large a plant is, and what about that is to be doubted: a mesh says neither its unit nor which way is up.
//!
//! ```text
//! ClassedMesh -Extents::of-> width, height and depth in metres -doubts-> what to ask its maker
//! ```
//!
//! A doubt is no error: a giant sequoia and a moss are plants. It says what was found and what was expected. [`Mend`]
//! says what mends it, in the words of the place where a reader can say it.

mod alpha;
mod blades;
mod card;
mod doubt;
mod enclosed;
mod foot;
mod hull;
mod leaves;
mod mend;
mod names;
mod nested;
mod painted;
mod plan;
mod seconds;
mod shape;
mod spot;
#[cfg(test)]
mod tests;
mod tiers;
mod whole;

use std::fmt::{self, Display};

use flb_format::meta::Bounds;

pub use doubt::Doubt;
pub use enclosed::{Enclosed, Walls};
pub use foot::Side;
pub use mend::Mend;
pub use painted::Painted;

use crate::classify::SpeciesRules;
use crate::import::Up;
use crate::unit::UNITS;
use crate::{ClassedMesh, ImportSettings, MaterialClass, PlantReader};

/// Longest edges of plants, metres, that are not doubted: from a moss to the tallest trees.
pub const USUAL_M: [f64; 2] = [0.05, 100.0];

/// Longest edges, metres, that are not doubted where the unit is stated: from a seedling to the tallest tree.
const STATED_M: std::ops::Range<f64> = 0.03..130.0;

/// Wood is expected to begin below this share of the plant's height: leaves may hang lower than the trunk stands.
const LOWEST_WOOD: f64 = 1.0 / 3.0;

/// Share of the leaf area that may be closed shells: fruit, and buds.
const SHELLS: f64 = 0.25;

/// Bounding box of a plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extents {
    /// Bounds of leaves and wood, model space, metres.
    pub bounds_m: Bounds,
}

impl Extents {
    /// Measures a plant; `None` where it has no triangle, or a coordinate that is not finite.
    pub fn of(plant: &ClassedMesh) -> Option<Extents> {
        Extents::of_bounds(plant.bounds()?)
    }

    /// Checks a box; `None` where a side of it is not finite.
    pub fn of_bounds(bounds_m: Bounds) -> Option<Extents> {
        let sides = [bounds_m.min, bounds_m.max];
        sides.as_flattened().iter().all(|side| side.is_finite()).then_some(Extents { bounds_m })
    }

    /// Width along x, height along y, depth along z.
    pub fn size_m(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.bounds_m.max[axis] - self.bounds_m.min[axis])
    }

    /// The longest of the three.
    pub fn longest_m(&self) -> f64 {
        self.size_m().into_iter().fold(0.0, f64::max)
    }

    /// Returns a doubt where the size is not one that plants have. `read_as` is how the mesh was read.
    pub fn doubt(&self, read_as: &ImportSettings) -> Option<Doubt> {
        let longest_m = self.longest_m();
        let [low, high] = USUAL_M;
        if (low..=high).contains(&longest_m) {
            return None;
        }
        let per_m = longest_m / read_as.unit_m.unwrap_or(1.0);
        let would_be = UNITS.map(|(unit, unit_m)| (unit, per_m * unit_m));
        let units = would_be.into_iter().filter(|(_, longest_m)| (low..=high).contains(longest_m)).collect();
        Some(Doubt::Size { longest_m, units })
    }
}

impl Display for Extents {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [width, height, depth] = self.size_m().map(number);
        write!(f, "{width} x {height} x {depth} m")
    }
}

/// All doubts about a plant. `read_as` is how its mesh was read.
pub fn doubts(plant: &ClassedMesh, read_as: &ImportSettings) -> Vec<Doubt> {
    let Some(extents) = Extents::of(plant) else { return Vec::new() };
    let of_size = extents.doubt(read_as);
    let of_wood = doubt_of_wood(plant, &extents, read_as.up.unwrap_or(Up::Y));
    let of_parts = whole::doubts(plant, &extents);
    // Of several plants no one is the foot.
    let are_several = of_parts.iter().any(|doubt| matches!(doubt, Doubt::Apart { .. }));
    let are_told = of_parts.iter().any(|doubt| matches!(doubt, Doubt::Levels { .. }));
    let on_one_spot = spot::doubt(plant, &extents).filter(|_| !are_told);
    // Of a plant that is there twice each leaf is.
    let is_single = !are_told && on_one_spot.is_none();
    let leaves = leaves::Leaves::of(plant);
    let of_walls = doubt_of_walls(plant, &extents);
    // Of a plant in a box the box is told.
    let of_twins = (is_single && !are_several && of_walls.is_none())
        .then(|| nested::doubt(plant, extents.longest_m()))
        .flatten();
    let second_sheets = is_single.then(|| seconds::doubt(plant, &leaves, extents.longest_m())).flatten();
    let of_shape = shape::doubt(plant, &extents).filter(|_| !are_several);
    let of_shells = doubt_of_shells(plant);
    let of_hull =
        hull::doubt(plant, &leaves, &extents).filter(|_| of_shells.is_none() && !has_card(&of_parts));
    let of_tiers = tiers::doubt(plant, &leaves).filter(|_| of_hull.is_none() && of_shells.is_none());
    let of_leaves = blades::doubt(plant, &leaves, &extents, read_as.unit_m)
        .filter(|_| of_size.is_none() && of_hull.is_none() && of_tiers.is_none() && !has_card(&of_parts));
    // Large triangles of a tier are no cards.
    let is_tiered = of_tiers.is_some();
    let is_other = |doubt: &Doubt| !is_tiered || !matches!(doubt, Doubt::Card { .. });
    of_size
        .into_iter()
        .chain(of_leaves)
        .chain(of_shape)
        .chain(of_wood.filter(|_| !are_several))
        .chain(of_shells)
        .chain(second_sheets)
        .chain(of_walls)
        .chain(of_parts.into_iter().filter(is_other))
        .chain(of_hull)
        .chain(of_tiers)
        .chain(on_one_spot)
        .chain(of_twins)
        .chain(names::doubt(plant))
        .collect()
}

/// All doubts about a plant that a reader read. Who says which materials are leaves, or which are wood, knows that
/// there is no wood, or no leaf; and who says the unit knows of a size just beyond those of plants.
pub fn doubts_of(plant: &ClassedMesh, reader: &PlantReader) -> Vec<Doubt> {
    let rules = &reader.rules;
    let says = |flag: &[String], file: fn(&SpeciesRules) -> &[String]| {
        !flag.is_empty() || rules.species.as_ref().is_some_and(|species| !file(species).is_empty())
    };
    let says_leaf = says(&rules.leaf, |species| &species.leaf);
    let says_wood = says(&rules.wood, |species| &species.wood);
    let is_open = |doubt: &Doubt| match doubt {
        Doubt::NoWood => !says_leaf,
        Doubt::NoLeaf => !says_wood,
        Doubt::LeafSize { .. } => reader.settings.unit_m.is_none(),
        Doubt::Size { longest_m, .. } => reader.settings.unit_m.is_none() || !STATED_M.contains(longest_m),
        _ => true,
    };
    doubts(plant, &reader.settings).into_iter().filter(is_open).collect()
}

fn has_card(doubts: &[Doubt]) -> bool {
    doubts.iter().any(|doubt| matches!(doubt, Doubt::Card { .. }))
}

/// Whether the wood stands where plants do. A plant without wood stands as it likes.
fn doubt_of_wood(plant: &ClassedMesh, extents: &Extents, up: Up) -> Option<Doubt> {
    let [wood, leaves] = [MaterialClass::Wood, MaterialClass::Leaf].map(|class| triangles_of(plant, class));
    if wood.is_empty() {
        return None;
    }
    if let Some(at) = foot::foot_elsewhere(&wood, foot::middle(&leaves), extents.longest_m()) {
        return Some(Doubt::Foot { at, up: upright(at, up) });
    }
    let lowest_m = wood.as_flattened().iter().map(|corner| corner[1]).fold(f64::INFINITY, f64::min);
    let (above_m, height_m) = (lowest_m - extents.bounds_m.min[1], extents.size_m()[1]);
    (above_m > LOWEST_WOOD * height_m).then_some(Doubt::HighWood { above_m, height_m })
}

/// The walls of a plant.
pub fn walls(plant: &ClassedMesh) -> Walls {
    Extents::of(plant).map_or(Walls::None, |extents| enclosed::walls(plant, &extents))
}

/// Whether leaves stand behind walls.
fn doubt_of_walls(plant: &ClassedMesh, extents: &Extents) -> Option<Doubt> {
    match enclosed::walls(plant, extents) {
        Walls::Enclosing(enclosed) => Some(Doubt::Enclosed(enclosed)),
        Walls::None | Walls::Beside => None,
    }
}

/// Whether leaves are thick closed shells ([`crate::sheets`]).
fn doubt_of_shells(plant: &ClassedMesh) -> Option<Doubt> {
    let thick = plant.mesh.sheets.thick;
    if thick.area_m2 == 0.0 {
        return None;
    }
    let leaf_m2 = plant.area_m2(MaterialClass::Leaf);
    let shells_m2 = thick.area_m2;
    (shells_m2 > SHELLS * leaf_m2).then_some(Doubt::Shells {
        shells_m2,
        leaf_m2,
        thickness_m: thick.thickness_m,
    })
}

/// The up axis that turns a foot to the bottom, where the mesh was read with `up`. With +Z up, (x, y, z) of the file is
/// (x, z, -y) of the model: what lies at -y of the file is at +z of the model.
fn upright(at: Side, up: Up) -> Option<Up> {
    match (up, at) {
        (Up::Y, Side { axis: 2, is_upper: false }) => Some(Up::Z),
        (Up::Z, Side { axis: 2, is_upper: true }) => Some(Up::Y),
        _ => None,
    }
}

/// Those of a class.
fn triangles_of(plant: &ClassedMesh, class: MaterialClass) -> Vec<foot::Triangle> {
    let mesh = &plant.mesh;
    let is_of_class = |triangle: &usize| plant.classes[mesh.triangle_material[*triangle] as usize] == class;
    (0..mesh.triangles.len()).filter(is_of_class).map(|triangle| mesh.corners_m(triangle)).collect()
}

/// A number of metres, to three digits: "12.5", "0.0312", "1530".
pub fn number(metres: f64) -> String {
    if metres == 0.0 || !(1e-6..1e7).contains(&metres.abs()) {
        return format!("{metres:.2e}").replace("0.00e0", "0");
    }
    let digits = 2 - libm::floor(libm::log10(metres.abs())) as i32;
    let text = format!("{metres:.*}", digits.max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
