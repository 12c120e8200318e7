//! Whether cards that stand for the whole plant from afar, or the ground under it, are among its leaves.

use super::{Doubt, Extents};
use crate::import::area;
use crate::{ClassedMesh, MaterialClass};

/// A triangle that spans this share of the plant's height and of its width, or of its width both ways, is no leaf.
const SPAN: f64 = 0.4;
/// Such triangles are cards beside leaves where they are no more than this share of all leaf triangles..
const MAX_COUNT: f64 = 0.05;
/// ..and this share of the leaf area at least.
const MIN_AREA: f64 = 0.2;
/// Of a plant higher than this, metres, such triangles are cards, too, where they are this share of the leaf area and
/// no more in number: a tree of whole-tree cards. Leaves of small plants are that large.
const MIN_HIGH_M: f64 = 2.0;
const MIN_OF_TREE: f64 = 0.5;
const MAX_CARDS: u64 = 64;
/// Names that a doubt lists.
const LISTED: usize = 4;

/// The doubt, if there are such cards.
pub(super) fn doubt(plant: &ClassedMesh, extents: &Extents) -> Option<Doubt> {
    let mesh = &plant.mesh;
    let [width, height, depth] = extents.size_m();
    let widest = width.max(depth);
    let (mut triangles, mut of_cards) = (0u64, 0u64);
    let (mut leaf_m2, mut cards_m2) = (0.0, 0.0);
    let mut materials: Vec<u32> = Vec::new();
    for (triangle, &material) in mesh.triangle_material.iter().enumerate() {
        if plant.classes[material as usize] != MaterialClass::Leaf {
            continue;
        }
        let points = mesh.corners_m(triangle);
        let span = |axis: usize| {
            let along = points.map(|point| point[axis]);
            along.iter().copied().fold(f64::MIN, f64::max) - along.iter().copied().fold(f64::MAX, f64::min)
        };
        let area_m2 = area(points) * mesh.sheets.side(triangle).share();
        (triangles, leaf_m2) = (triangles + 1, leaf_m2 + area_m2);
        let is_upright = span(1) >= SPAN * height && libm::hypot(span(0), span(2)) >= SPAN * widest;
        if is_upright || span(0) >= SPAN * width && span(2) >= SPAN * depth {
            (of_cards, cards_m2) = (of_cards + 1, cards_m2 + area_m2);
            if !materials.contains(&material) && materials.len() < LISTED {
                materials.push(material);
            }
        }
    }
    let is_few = of_cards > 0 && of_cards as f64 <= MAX_COUNT * triangles as f64;
    let is_all = height > MIN_HIGH_M && of_cards <= MAX_CARDS && cards_m2 >= MIN_OF_TREE * leaf_m2;
    (of_cards > 0 && (is_few && cards_m2 >= MIN_AREA * leaf_m2 || is_all)).then(|| Doubt::Card {
        triangles: of_cards,
        share: cards_m2 / leaf_m2,
        materials: materials.iter().map(|&at| mesh.materials[at as usize].name.clone()).collect(),
    })
}
