//! Doubts about a plant, in words.

use std::fmt::{self, Display};

use super::enclosed::{Enclosed, OPEN};
use super::foot::Side;
use super::painted::Painted;
use super::{USUAL_M, number};
use crate::MaterialClass;
use crate::import::{Up, quoted};

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
    /// Half of the leaf area is of leaves that are longer, or shorter, than those of plants.
    LeafSize {
        /// Length of these leaves, metres.
        length_m: f64,
        /// Shortest and longest leaves that are expected, metres.
        expected_m: [f64; 2],
        /// Units of the file under which they would be usual, and their length then, metres.
        units: Vec<(&'static str, f64)>,
    },
    /// The plant stands on another side than its bottom: it lies, or stands on its head.
    Foot {
        /// Side where the wood is thickest.
        at: Side,
        /// The up axis of the file under which that would be its bottom, if one would.
        up: Option<Up>,
    },
    /// Levels of detail beside each other, or seasons.
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
    /// Wood stands in wood, as that of a plant does that is there twice.
    WoodInWood {
        /// Share of the wood's area with other wood under it, 0..=1.
        share: f64,
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
    /// One sheet about the crown is much of the leaf area, as the hull of a crown is.
    Hull {
        /// Name of its material.
        material: String,
        /// Area of the sheet, square metres.
        hull_m2: f64,
        /// Area of all leaves, square metres.
        leaf_m2: f64,
    },
    /// A crown of a few cones or bowls about its trunk.
    Tiers {
        /// Number of them.
        count: u64,
        /// Share of the leaf area, 0..=1.
        share: f64,
    },
    /// Leaves and wood are of other scales.
    Scales {
        /// Longest edge of the leaves' box, metres.
        leaf_m: f64,
        /// Longest edge of the wood's box, metres.
        wood_m: f64,
    },
    /// Air between the wood and the leaves.
    Air {
        /// Length of it, metres.
        gap_m: f64,
    },
    /// Two edges of the box are far shorter than the longest one.
    Thin {
        /// Width along x, height along y, depth along z, metres.
        size_m: [f64; 3],
    },
    /// A scrap far off makes the plant's box long.
    Scrap {
        /// Part that it is of, if there are parts.
        part: Option<String>,
        /// Place of the scrap, model space, metres.
        at_m: [f64; 3],
        /// Longest edge of the plant's box, metres.
        longest_m: f64,
        /// Longest edge of the box around all but scraps, metres.
        rest_m: f64,
    },
    /// Leaves are opaque to their edges, and much of them shows the flat background of their image.
    Background {
        /// Name of the material.
        material: String,
        /// Name of its image.
        image: String,
        /// Share of the material that shows it, 0..=1.
        share: f64,
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
            Doubt::LeafSize { .. } => "leaf-size",
            Doubt::Foot { .. } => "foot",
            Doubt::HighWood { .. } => "high-wood",
            Doubt::Shells { .. } => "shells",
            Doubt::SecondSheets { .. } => "second-sheets",
            Doubt::Enclosed(_) => "enclosed",
            Doubt::Levels { .. } => "levels",
            Doubt::Apart { .. } => "apart",
            Doubt::OneSpot { .. } => "one-spot",
            Doubt::WoodInWood { .. } => "wood-in-wood",
            Doubt::NoWood => "no-wood",
            Doubt::NoLeaf => "no-leaf",
            Doubt::CutAway { .. } => "cut-away",
            Doubt::WoodCut { .. } => "wood-cut",
            Doubt::Uncut { .. } => "uncut",
            Doubt::VertexColors { .. } => "vertex-colours",
            Doubt::Card { .. } => "card",
            Doubt::Names { .. } => "names",
            Doubt::Hull { .. } => "hull",
            Doubt::Tiers { .. } => "tiers",
            Doubt::Scales { .. } => "scales",
            Doubt::Air { .. } => "air",
            Doubt::Thin { .. } => "thin",
            Doubt::Scrap { .. } => "scrap",
            Doubt::Background { .. } => "background",
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
            Doubt::LeafSize { length_m, expected_m: [least, most], .. } => {
                let [length, least, longest] = [*length_m, *least, *most].map(number);
                let (found, or) = match length_m > most {
                    true => (format!("{length} m long or longer"), ", or cards stand for much of the plant"),
                    false => (format!("{length} m long or shorter"), ""),
                };
                write!(
                    f,
                    "half of the leaf area is leaves {found}, expected {least} to {longest} m: the unit may be another one{or}"
                )
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
                    "levels of detail, or seasons, of one plant are all there: {}; expected one of them",
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
            Doubt::WoodInWood { share } => write!(
                f,
                "{:.0} % of the wood has other wood right under it, expected solid wood: the plant may be there twice, \
                 two levels of detail may be joined, or an inner wall may face outwards",
                100.0 * share
            ),
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
                one(image),
                100.0 * cut
            ),
            Doubt::Uncut { material, image, outside } => write!(
                f,
                "{:.0} % of the leaves {material:?} lie outside of the outline in the alpha of {}, and the material is \
                 opaque there (alphaMode OPAQUE, or none), expected MASK: whole cards count as leaf",
                100.0 * outside,
                one(image),
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
            Doubt::Hull { material, hull_m2, leaf_m2 } => write!(
                f,
                "one sheet about the crown (material {}) is {} of {} m2 of leaf, as the hull of a crown is; expected \
                 single leaves",
                one(material),
                number(*hull_m2),
                number(*leaf_m2)
            ),
            Doubt::Tiers { count, share } => write!(
                f,
                "{count} {} {:.0} % of the leaf area, as in trees of games, expected single leaves: no \
                 light is found between leaves that are not there",
                if *count == 1 {
                    "cone or bowl about the trunk is"
                } else {
                    "cones or bowls about the trunk are"
                },
                100.0 * share
            ),
            Doubt::Scales { leaf_m, wood_m } => write!(
                f,
                "the leaves span {} m and the wood {} m, expected parts of one scale",
                number(*leaf_m),
                number(*wood_m)
            ),
            Doubt::Air { gap_m } => write!(
                f,
                "{} m of air lie between the wood and the leaves, expected leaves on the wood",
                number(*gap_m)
            ),
            Doubt::Thin { size_m } => write!(
                f,
                "the plant is {} m, two edges of which are under a thousandth of the third; expected metres along each \
                 axis: degrees of a map may be among them",
                size_m.map(number).join(" x ")
            ),
            Doubt::Scrap { part, at_m, longest_m, rest_m } => {
                let part = part.as_ref().map_or(String::new(), |part| format!("{} ", one(part)));
                let [at, longest, rest] = [at_m.map(number).join(" "), number(*longest_m), number(*rest_m)];
                write!(
                    f,
                    "a scrap {part}at {at} m makes the plant's box {longest} m long, expected {rest} m, where nearly all of \
                     its area is: sites would be as much too large"
                )
            }
            Doubt::Background { material, image, share } => write!(
                f,
                "{:.0} % of the leaves {material:?} show the flat background of {}, and the material is opaque, expected \
                 MASK and alpha: whole cards count as leaf",
                100.0 * share,
                one(image),
            ),
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
                    percent(OPEN)
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
    names.iter().map(|name| one(name)).collect::<Vec<_>>().join(", ")
}

/// A name in quotes.
fn one(name: &str) -> String {
    format!("'{}'", quoted(name))
}
