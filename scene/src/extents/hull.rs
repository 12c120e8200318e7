//! Whether few large sheets are much of a plant's leaf area: ground below it, however finely it is cut, or a hull of
//! the crown that is open below.

use glam::DVec3;

use super::leaves::Leaves;
use super::{Doubt, Extents};
use crate::sheets::{corners, pieces};
use crate::{ClassedMesh, Mesh};

/// A sheet of ground spans this share of the plant's width and depth..
const SPAN: f64 = 0.7;
/// ..it is so level, as a mean cosine, lies so low, as a share of the plant's height, and is so much of the leaf area,
/// but not all of it.
const LEVEL: f64 = 0.9;
const LOW: f64 = 0.1;
const OF_LEAVES: [f64; 2] = [0.2, 0.98];
/// Ground of fewer triangles is a card.
const MIN_OF_GROUND: usize = 4;
/// A hull spans this share of the leaves' width and depth, and this of their height..
const HULL_SPAN: [f64; 2] = [0.8, 0.25];
/// ..and has this share of their area. Its triangles look away from its middle, as a mean cosine: leaves that hold
/// together look anywhere, 0.5.
const HULL_AREA: f64 = 0.25;
const OUTWARDS: f64 = 0.65;
/// It has more triangles than a card or a leaf, and is so deep, as a share of its longest edge.
const MIN_OF_HULL: usize = 12;
const DEEP: f64 = 0.2;

/// Leaf triangles that hold together.
struct Sheet<'m> {
    mesh: &'m Mesh,
    triangles: Vec<u32>,
    area_m2: f64,
    low: DVec3,
    high: DVec3,
}

impl<'m> Sheet<'m> {
    fn of(mesh: &'m Mesh, triangles: Vec<u32>) -> Sheet<'m> {
        let mut sheet =
            Sheet { mesh, triangles, area_m2: 0.0, low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        for at in 0..sheet.triangles.len() {
            let [a, b, c] = sheet.corners(sheet.triangles[at]);
            sheet.area_m2 += sheet.normal_m2(sheet.triangles[at]).length();
            (sheet.low, sheet.high) = (sheet.low.min(a).min(b).min(c), sheet.high.max(a).max(b).max(c));
        }
        sheet
    }

    /// The largest by area of those that have one number each; of two as large, the one with the lower number.
    fn largest(mesh: &'m Mesh, triangles: &[u32], numbers: &[u32]) -> Option<Sheet<'m>> {
        let count = numbers.iter().max().map_or(0, |most| *most as usize + 1);
        let mut areas_m2 = vec![0.0; count];
        for (&triangle, &number) in triangles.iter().zip(numbers) {
            areas_m2[number as usize] += normal_m2(mesh, triangle).length();
        }
        let (largest, _) = (0u32..)
            .zip(&areas_m2)
            .max_by(|(a, of_a): &(u32, &f64), (b, of_b)| of_a.total_cmp(of_b).then_with(|| b.cmp(a)))?;
        let of_it = triangles.iter().zip(numbers).filter(|(_, number)| **number == largest);
        Some(Sheet::of(mesh, of_it.map(|(triangle, _)| *triangle).collect()))
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        corners(self.mesh, triangle)
    }

    fn normal_m2(&self, triangle: u32) -> DVec3 {
        normal_m2(self.mesh, triangle)
    }

    fn size(&self) -> DVec3 {
        self.high - self.low
    }

    fn is_ground(&self, extents: &Extents) -> bool {
        let plant_m = DVec3::from_array(extents.size_m());
        let is_wide = self.size().x >= SPAN * plant_m.x && self.size().z >= SPAN * plant_m.z;
        let is_low = self.high.y - extents.bounds_m.min[1] <= LOW * plant_m.y;
        let level_m2 =
            || self.triangles.iter().map(|&triangle| self.normal_m2(triangle).y.abs()).sum::<f64>();
        is_wide && is_low && self.triangles.len() >= MIN_OF_GROUND && level_m2() >= LEVEL * self.area_m2
    }

    /// Whether it is as large as the crown, whose box has this size.
    fn spans(&self, crown: DVec3) -> bool {
        let size = self.size();
        let is_wide = size.x >= HULL_SPAN[0] * crown.x && size.z >= HULL_SPAN[0] * crown.z;
        let is_high = size.y >= HULL_SPAN[1] * crown.y;
        is_wide
            && is_high
            && size.min_element() >= DEEP * size.max_element()
            && self.triangles.len() >= MIN_OF_HULL
    }

    /// Whether its triangles look away from its middle.
    fn looks_outwards(&self) -> bool {
        let (middle, size) = (self.low.midpoint(self.high), self.size());
        let outwards_m2 = |&triangle: &u32| {
            let ([a, b, c], normal_m2) = (self.corners(triangle), self.normal_m2(triangle));
            // In shares of the sheet's box, so that a slender hull is a ball.
            let (out, normal) = (((a + b + c) / 3.0 - middle) / size, normal_m2 * size);
            let both = out.length() * normal.length();
            if both > 0.0 { (out.dot(normal) / both).abs() * normal_m2.length() } else { 0.0 }
        };
        self.triangles.iter().map(outwards_m2).sum::<f64>() >= OUTWARDS * self.area_m2
    }

    fn material(&self) -> String {
        let material = self.mesh.triangle_material[self.triangles[0] as usize];
        self.mesh.materials[material as usize].name.clone()
    }
}

/// The normal of a triangle, as long as its area; of one side of a leaf, half of it.
pub(super) fn normal_m2(mesh: &Mesh, triangle: u32) -> DVec3 {
    let [a, b, c] = corners(mesh, triangle);
    0.5 * mesh.sheets.side(triangle as usize).share() * (b - a).cross(c - a)
}

/// The doubt, if there is such a sheet.
pub(super) fn doubt(plant: &ClassedMesh, of_plant: &Leaves, extents: &Extents) -> Option<Doubt> {
    let mesh = &plant.mesh;
    let sheet = Sheet::largest(mesh, &of_plant.triangles, &of_plant.blades)?;
    let leaves = Sheet::of(mesh, of_plant.triangles.clone());
    let share = |sheet: &Sheet| sheet.area_m2 / leaves.area_m2;
    if (OF_LEAVES[0]..OF_LEAVES[1]).contains(&share(&sheet)) && sheet.is_ground(extents) {
        let materials = vec![sheet.material()];
        return Some(Doubt::Card {
            triangles: sheet.triangles.len() as u64,
            share: share(&sheet),
            materials,
        });
    }
    let is_hull = |sheet: &Sheet| share(sheet) >= HULL_AREA && sheet.spans(leaves.size());
    if !is_hull(&sheet) {
        return None;
    }
    // The leaves of a rosette hold together in one point; a hull does by its edges.
    let piece = Sheet::largest(mesh, &sheet.triangles, &pieces(mesh, &sheet.triangles))?;
    (is_hull(&piece) && piece.looks_outwards()).then(|| Doubt::Hull {
        material: piece.material(),
        hull_m2: piece.area_m2,
        leaf_m2: leaves.area_m2,
    })
}
