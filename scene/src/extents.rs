//! How large a plant is, and what about that is to be doubted: a mesh says neither its unit nor which way is up.
//!
//! ```text
//! ClassedMesh -Extents::of-> width, height and depth in metres -doubts-> what to ask its maker
//! ```
//!
//! A doubt is no error: a giant sequoia and a moss are plants. It says what was found and what was expected. [`Mend`]
//! says what mends it, in the words of the place where a reader can say it.

mod alpha;
mod card;
mod enclosed;
mod foot;
mod mend;
mod names;
mod painted;
mod seconds;
mod spot;
#[cfg(test)]
mod tests;
mod whole;

use std::fmt::{self, Display};

use flb_format::meta::Bounds;

pub use enclosed::{Enclosed, Walls};
pub use foot::Side;
pub use mend::Mend;
pub use painted::Painted;

use crate::import::{Up, quoted};
use crate::unit::UNITS;
use crate::{ClassedMesh, ImportSettings, MaterialClass};

/// Longest edges of plants, metres, that are not doubted: from a moss to the tallest trees.
pub const USUAL_M: [f64; 2] = [0.05, 100.0];

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

/// Doubt about a plant's box or matter.
#[derive(Debug, Clone, PartialEq)]
pub enum Doubt {
    /// The longest edge is outside [`USUAL_M`].
    Size {
        /// Longest edge as it was read, metres.
        longest_m: f64,
        /// Units of the file under which it would be usual, and its longest edge then, metres.
        units: Vec<(&'static str, f64)>,
    },
    /// The plant stands on another side than its bottom: it lies, or stands on its head.
    Foot {
        /// Side where the wood is thickest.
        at: Side,
        /// The up axis of the file under which that would be its bottom, if one would.
        up: Option<Up>,
    },
    /// Levels of detail beside each other.
    Levels {
        /// Labels of the parts, or names of the materials.
        names: Vec<String>,
    },
    /// Parts of the plant stand apart, as several plants do.
    Apart {
        /// Plants that stand apart: labels of parts, or where each is.
        stands: Vec<String>,
    },
    /// Whole plants, each with its trunk, stand on one spot.
    OneSpot {
        /// Names of the parts that are a plant each.
        names: Vec<String>,
    },
    /// The plant has leaves and no wood.
    NoWood,
    /// The plant has wood and no leaf.
    NoLeaf,
    /// Alpha leaves nothing of a material, or next to nothing.
    CutAway {
        /// Name of the material.
        material: String,
        /// Area of the material's triangles, square metres.
        area_m2: f64,
        /// Share of it that alpha leaves, 0..=1.
        left: f64,
    },
    /// Alpha that is no outline cuts wood, as a map of gloss does that an exporter took for alpha.
    WoodCut {
        /// Name of the material.
        material: String,
        /// Name of its image.
        image: String,
        /// Share of the material that it cuts away, 0..=1.
        cut: f64,
    },
    /// Leaves are opaque to their edges, though their image has an outline.
    Uncut {
        /// Name of the material.
        material: String,
        /// Name of its image.
        image: String,
        /// Share of the material outside of that outline, 0..=1.
        outside: f64,
    },
    /// Colours of vertices that multiply a texture look like data.
    VertexColors {
        /// Name of the material.
        material: String,
        /// Kind of data that they look like.
        look: Painted,
    },
    /// A few triangles as large as the plant are much of its leaf area, as the ground is, or cards that stand for a
    /// plant from afar.
    Card {
        /// Number of these triangles.
        triangles: u64,
        /// Share of the leaf area, 0..=1.
        share: f64,
        /// Names of their materials.
        materials: Vec<String>,
    },
    /// Parts that are called a trunk and are leaf alone, or are called leaves and are wood alone.
    Names {
        /// `MATERIAL@PART` of some of them.
        parts: Vec<String>,
        /// Area of all of them, square metres.
        area_m2: f64,
        /// Class that they have; `None` where some are leaf and some wood.
        class: Option<MaterialClass>,
    },
    /// The wood begins high above the lowest leaf.
    HighWood {
        /// Height of the lowest wood above the lowest leaf, metres.
        above_m: f64,
        /// Height of the plant, metres.
        height_m: f64,
    },
    /// Much of the leaf is closed shells that are too thick to be leaves: their insides are leaf that no light reaches.
    Shells {
        /// Area of these shells, square metres.
        shells_m2: f64,
        /// Area of all leaves, square metres.
        leaf_m2: f64,
        /// Mean thickness of the thickest, metres.
        thickness_m: f64,
    },
    /// Much of the leaf has a second sheet behind it, too far off to be taken for its other side.
    SecondSheets {
        /// Area of leaves that have one, both sheets of each, square metres.
        sheets_m2: f64,
        /// Area of all leaves, square metres.
        leaf_m2: f64,
        /// Mean gap between two sheets, metres; 0 where they lie on each other.
        gap_m: f64,
    },
    /// Leaves stand behind walls of wood: in a closed box, or deep in a pot.
    Enclosed(Enclosed),
}

impl Doubt {
    /// A word for it, which keeps its meaning.
    pub fn name(&self) -> &'static str {
        match self {
            Doubt::Size { .. } => "size",
            Doubt::Foot { .. } => "foot",
            Doubt::HighWood { .. } => "high-wood",
            Doubt::Shells { .. } => "shells",
            Doubt::SecondSheets { .. } => "second-sheets",
            Doubt::Enclosed(_) => "enclosed",
            Doubt::Levels { .. } => "levels",
            Doubt::Apart { .. } => "apart",
            Doubt::OneSpot { .. } => "one-spot",
            Doubt::NoWood => "no-wood",
            Doubt::NoLeaf => "no-leaf",
            Doubt::CutAway { .. } => "cut-away",
            Doubt::WoodCut { .. } => "wood-cut",
            Doubt::Uncut { .. } => "uncut",
            Doubt::VertexColors { .. } => "vertex-colours",
            Doubt::Card { .. } => "card",
            Doubt::Names { .. } => "names",
        }
    }
}

impl Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Doubt::Size { longest_m, .. } => {
                let [low, high] = USUAL_M.map(number);
                write!(f, "the plant's longest edge is {} m, expected {low} to {high} m", number(*longest_m))
            }
            Doubt::Foot { at, .. } => {
                let (at, bottom) = (at.name(), Side::BOTTOM.name());
                write!(
                    f,
                    "the plant's foot (its thickest wood) is on its side {at}, expected at its bottom, {bottom}"
                )
            }
            Doubt::Levels { names } => {
                write!(
                    f,
                    "levels of detail of one plant are all there: {}; expected one of them",
                    list(names)
                )
            }
            Doubt::Apart { stands } => {
                let count = stands.len();
                write!(
                    f,
                    "{count} parts stand apart, as {count} plants do: {}; expected one plant",
                    list(stands)
                )
            }
            Doubt::OneSpot { names } => {
                let (count, names) = (names.len(), list(names));
                write!(f, "{count} plants with a trunk each stand on one spot: {names}; expected one plant")
            }
            Doubt::NoWood => write!(f, "the plant has leaves and no wood: no material is taken for wood"),
            Doubt::NoLeaf => write!(f, "the plant has wood and no leaf: no material is taken for leaf"),
            Doubt::CutAway { material, area_m2, left } => {
                let left = match *left > 0.0 {
                    true => format!("{} %", number(100.0 * left)),
                    false => "nothing".to_owned(),
                };
                let area = number(*area_m2);
                write!(f, "alpha leaves {left} of {area} m^2 of the material {material:?}")
            }
            Doubt::WoodCut { material, image, cut } => write!(
                f,
                "the alpha of {} cuts {:.0} % of the wood {material:?} away and is no outline, expected whole wood: it \
                 looks like a map of gloss or height",
                list(std::slice::from_ref(image)),
                100.0 * cut
            ),
            Doubt::Uncut { material, image, outside } => write!(
                f,
                "{:.0} % of the leaves {material:?} lie outside of the outline in the alpha of {}, and the material is \
                 opaque there (alphaMode OPAQUE, or none), expected MASK: whole cards count as leaf",
                100.0 * outside,
                list(std::slice::from_ref(image)),
            ),
            Doubt::VertexColors { material, look } => write!(
                f,
                "the colours of the vertices of material {material:?} {look} and multiply its texture or base colour, \
                 expected a tint: data of wind may lie there, or the colour a second time"
            ),
            Doubt::Card { triangles, share, materials } => write!(
                f,
                "{triangles} triangles as large as the plant are {:.0} % of its leaf area (material {}), as the ground is, \
                 or a card that stands for a plant from afar; expected leaves alone",
                100.0 * share,
                list(materials)
            ),
            Doubt::Names { parts, area_m2, class } => {
                let [found, expected] = match class {
                    Some(MaterialClass::Leaf) => ["leaf", "wood"],
                    Some(_) => ["wood", "leaf"],
                    None => ["of one class", "of the other"],
                };
                let (area, parts) = (number(*area_m2), list(parts));
                write!(
                    f,
                    "{area} m2 are {found} by material, expected {expected} by the names of their parts: {parts}"
                )
            }
            Doubt::HighWood { above_m, height_m } => {
                let [above, height] = [*above_m, *height_m].map(number);
                write!(
                    f,
                    "the wood begins {above} m above the lowest leaf of a plant {height} m high, expected at its bottom"
                )
            }
            Doubt::Enclosed(Enclosed { share, open }) => {
                let percent = |share: f64| format!("{:.0} %", 100.0 * share);
                write!(
                    f,
                    "{} of the leaf area sees {} of the sky past wood, expected over {}: it stays dark, and the light \
                     of suns there, a hundredth of open light, may be off by a third",
                    percent(*share),
                    percent(*open),
                    percent(enclosed::OPEN)
                )
            }
            Doubt::SecondSheets { sheets_m2, leaf_m2, gap_m } => {
                let [sheets, leaf, gap] = [*sheets_m2, *leaf_m2, *gap_m].map(number);
                let place = match *gap_m > 0.0 {
                    true => format!("{gap} m behind or before"),
                    false => "on".to_owned(),
                };
                write!(
                    f,
                    "{sheets} of {leaf} m2 of leaf have a second sheet {place} them, expected single leaves: either \
                     sheet counts as a leaf"
                )
            }
            Doubt::Shells { shells_m2, leaf_m2, thickness_m } => {
                let [shells, leaf, thick] = [*shells_m2, *leaf_m2, *thickness_m].map(number);
                write!(
                    f,
                    "{shells} of {leaf} m2 of leaf are closed shells up to {thick} m thick, expected single leaves: their \
                     insides count as leaf, too"
                )
            }
        }
    }
}

/// Names in quotes.
fn list(names: &[String]) -> String {
    names.iter().map(|name| format!("'{}'", quoted(name))).collect::<Vec<_>>().join(", ")
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
    let second_sheets = is_single.then(|| seconds::doubt(plant, extents.longest_m())).flatten();
    of_size
        .into_iter()
        .chain(of_wood.filter(|_| !are_several))
        .chain(doubt_of_shells(plant))
        .chain(second_sheets)
        .chain(doubt_of_walls(plant, &extents))
        .chain(of_parts)
        .chain(on_one_spot)
        .chain(names::doubt(plant))
        .collect()
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
    let materials = mesh.triangles.iter().zip(&mesh.triangle_material);
    let of_class = materials.filter(|(_, material)| plant.classes[**material as usize] == class);
    of_class
        .map(|(corners, _)| corners.map(|vertex| mesh.positions[vertex as usize].map(f64::from)))
        .collect()
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
