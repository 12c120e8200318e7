//! Whether wood stands in wood, as it does where a plant is there twice: two levels of detail joined into one part, a
//! copy a hand away, a variant on the same trunk.

use glam::Vec3;
use rayon::prelude::*;

use super::Doubt;
use crate::mesh::Material;
use crate::rays::{Ray, RayMesh};
use crate::surface_points::surface_points;
use crate::{ClassedMesh, MaterialClass, Mesh};

/// Share of the wood's area with other wood right under it: where a twig leaves its branch some always is.
const MAX_NESTED: f64 = 0.25;
/// Points on wood.
const POINTS: u32 = 1024;
/// Walls that a ray counts before it is given up.
const MAX_WALLS: usize = 64;
/// Share of the plant's longest edge that keeps a ray off the wall it starts from or has met.
const LIFT: f32 = 2e-6;

/// The doubt, if so much wood has other wood under it.
pub(super) fn doubt(plant: &ClassedMesh, longest_m: f64) -> Option<Doubt> {
    let share = share(plant, longest_m as f32)?;
    (share > MAX_NESTED).then_some(Doubt::WoodInWood { share })
}

fn share(plant: &ClassedMesh, longest_m: f32) -> Option<f64> {
    let wood = wood(plant);
    let alone = ClassedMesh { mesh: wood, classes: vec![MaterialClass::Wood] };
    let points = surface_points(&alone, POINTS, true).ok()?;
    let rays = RayMesh::new(&alone.mesh, true).ok()?;
    let is_nested = |triangle: u32, at: [f32; 3]| {
        let inward = -rays.front(triangle)?;
        Some(has_wood_under(&rays, Vec3::from(at), inward, triangle, LIFT * longest_m))
    };
    let found = points.par_iter().filter(|point| is_nested(point.triangle, point.position_m) == Some(true));
    Some(found.count() as f64 / points.len().max(1) as f64)
}

/// All wood, as one material.
fn wood(plant: &ClassedMesh) -> Mesh {
    let mesh = &plant.mesh;
    let is_wood =
        |triangle: &usize| plant.classes[mesh.triangle_material[*triangle] as usize] == MaterialClass::Wood;
    let triangles: Vec<[u32; 3]> =
        (0..mesh.triangles.len()).filter(is_wood).map(|triangle| mesh.triangles[triangle]).collect();
    Mesh {
        positions: mesh.positions.clone(),
        triangle_material: vec![0; triangles.len()],
        triangles,
        materials: vec![Material::opaque("wood")],
        ..Mesh::default()
    }
}

/// Whether a ray from a wall of a solid into it enters another solid before it leaves the first. Walls that are thin
/// and have two sides, and those that are inside out, tell nothing: the ray leaves one solid more than it enters.
fn has_wood_under(rays: &RayMesh, start: Vec3, inward: Vec3, from: u32, lift: f32) -> bool {
    let (mut origin, mut except) = (start + lift * inward, from);
    let (mut first, mut depth) = (None, 1i32);
    for _ in 0..MAX_WALLS {
        let ray = Ray { origin, direction: inward };
        let Some(hit) = rays.find(ray, f32::MAX, Some(except)) else { break };
        let enters = rays.front(hit.triangle).is_some_and(|front| front.dot(inward) < 0.0);
        first = first.or(Some(enters));
        if first == Some(false) {
            return false;
        }
        depth += if enters { 1 } else { -1 };
        (origin, except) = (origin + (hit.distance + lift) * inward, hit.triangle);
    }
    first == Some(true) && depth == 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::soup;

    /// A tube of `sides` walls along y, closed nowhere.
    fn tube(middle: [f32; 2], radius: f32, sides: usize, inside_out: bool) -> Vec<[[f32; 3]; 3]> {
        let corner = |at: usize, y: f32| {
            let turn = std::f64::consts::TAU * at as f64 / sides as f64;
            let [x, z] = [libm::sin(turn) as f32, libm::cos(turn) as f32];
            [middle[0] + radius * x, y, middle[1] + radius * z]
        };
        let wall = |at: usize| {
            let [a, b, c, d] = [corner(at, 0.0), corner(at + 1, 0.0), corner(at + 1, 4.0), corner(at, 4.0)];
            if inside_out { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] }
        };
        (0..sides).flat_map(wall).collect()
    }

    fn found(tubes: &[Vec<[[f32; 3]; 3]>]) -> f64 {
        let mesh = soup(&tubes.concat());
        let plant = ClassedMesh { mesh, classes: vec![MaterialClass::Wood; 2] };
        share(&plant, 4.0).expect("wood")
    }

    #[test]
    fn a_trunk_in_a_trunk_is_found_and_a_hollow_one_is_not() {
        let outer = || tube([0.0; 2], 0.2, 16, false);
        assert_eq!(found(&[outer()]), 0.0);
        let coarse = found(&[outer(), tube([0.0; 2], 0.2, 6, false)]);
        assert!((0.4..0.65).contains(&coarse), "two levels: {coarse}");
        let beside = found(&[outer(), tube([0.1, 0.0], 0.2, 16, false)]);
        assert!((0.4..0.8).contains(&beside), "a copy beside it: {beside}");
        assert_eq!(found(&[outer(), tube([1.0, 0.0], 0.2, 16, false)]), 0.0, "two trunks");
        assert_eq!(found(&[outer(), tube([0.0; 2], 0.19, 16, true)]), 0.0, "a wall with two sides");
        assert_eq!(
            found(&[tube([0.0; 2], 0.2, 16, true), tube([1.0, 0.0], 0.2, 16, true)]),
            0.0,
            "inside out"
        );
    }
}
