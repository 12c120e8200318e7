//! What each part of a file uses: its triangles by material, with area, bounds and foot.

use flb_format::meta::Bounds;

use super::soup::{Lent, area};
use crate::mesh::{Foot, Mesh, Part, PartUse, around};

/// Height of a foot, as a share of the height of what stands on it.
const FOOT: f64 = 0.05;

/// Fills in the uses of all parts; `triangle_part` is the part of each triangle. Triangles that went because another
/// part has the same ones (`lent`) still count for where a part is.
pub(crate) fn fill(mesh: &Mesh, triangle_part: &[u32], lent: &[Lent], parts: &mut [Part]) {
    for (triangle, &part) in triangle_part.iter().enumerate() {
        let (material, corners) = (mesh.triangle_material[triangle], mesh.corners_m(triangle));
        let used = of_material(&mut parts[part as usize], material, corners);
        used.triangles += 1;
        used.area_m2 += area(corners);
    }
    for &Lent { part, triangle } in lent {
        let triangle = triangle as usize;
        of_material(&mut parts[part as usize], mesh.triangle_material[triangle], mesh.corners_m(triangle));
    }
    let stay = triangle_part.iter().enumerate().map(|(triangle, &part)| (triangle, part));
    fill_feet(mesh, stay.chain(lent.iter().map(|lent| (lent.triangle as usize, lent.part))), parts);
}

/// The use of a material, around a triangle.
fn of_material(part: &mut Part, material: u32, corners: [[f64; 3]; 3]) -> &mut PartUse {
    let bounds_m = bounds_of(corners);
    // Triangles of one material follow each other.
    match part.uses.iter().rposition(|used| used.material == material) {
        Some(at) => {
            let used = &mut part.uses[at];
            used.bounds_m = around(used.bounds_m, bounds_m);
            used
        }
        None => {
            let foot = Foot::default();
            part.uses.push(PartUse { material, triangles: 0, area_m2: 0.0, bounds_m, foot });
            part.uses.last_mut().expect("it was pushed")
        }
    }
}

/// Fills in the feet, once bounds are known, of (triangle, part).
fn fill_feet(mesh: &Mesh, all: impl Iterator<Item = (usize, u32)>, parts: &mut [Part]) {
    let mut count = 0;
    let first = |part: &Part| {
        count += part.uses.len();
        count - part.uses.len()
    };
    let firsts: Vec<usize> = parts.iter().map(first).collect();
    let mut feet = vec![FootSums::default(); count];
    for (triangle, part) in all {
        let material = mesh.triangle_material[triangle];
        let uses = &parts[part as usize].uses;
        let Some(at) = uses.iter().rposition(|used| used.material == material) else { continue };
        let Bounds { min, max } = uses[at].bounds_m;
        let end = min[1] + FOOT * (max[1] - min[1]);
        let sums = &mut feet[firsts[part as usize] + at];
        mesh.corners_m(triangle)
            .into_iter()
            .filter(|corner| corner[1] <= end)
            .for_each(|point| sums.add(point, min));
    }
    for (part, first) in parts.iter_mut().zip(firsts) {
        part.uses
            .iter_mut()
            .zip(&feet[first..])
            .for_each(|(used, sums)| used.foot = sums.foot(used.bounds_m.min));
    }
}

/// Sums over corners, from the lowest corner of their box: a sum of squares keeps its digits.
#[derive(Debug, Clone, Copy, Default)]
struct FootSums {
    corners: f64,
    first: [f64; 3],
    /// Of squares over the ground.
    second: f64,
}

impl FootSums {
    fn add(&mut self, point: [f64; 3], from: [f64; 3]) {
        let [x, y, z] = std::array::from_fn(|axis| point[axis] - from[axis]);
        self.corners += 1.0;
        self.first.iter_mut().zip([x, y, z]).for_each(|(sum, along)| *sum += along);
        self.second += x * x + z * z;
    }

    fn foot(&self, from: [f64; 3]) -> Foot {
        // The lowest corner is in its own foot.
        let count = self.corners.max(1.0);
        let [x, y, z] = self.first.map(|sum| sum / count);
        let spread_m = (self.second / count - x * x - z * z).max(0.0).sqrt();
        Foot { middle_m: [from[0] + x, from[1] + y, from[2] + z], spread_m }
    }
}

fn bounds_of(corners: [[f64; 3]; 3]) -> Bounds {
    let bounds_m = corners.map(|point| Bounds { min: point, max: point }).into_iter().reduce(around);
    bounds_m.expect("a triangle has three corners")
}
