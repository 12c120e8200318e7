//! Leaves behind walls: in a closed box, or deep in a pot.
//!
//! From points of the leaves rays go in all directions, through the wood alone. A hull of a crown that was read as wood
//! makes a dark plant, and the doubt tells why.

use glam::Vec3;
use rayon::prelude::*;

use super::{Extents, triangles_of};
use crate::import::area;
use crate::mesh::Material;
use crate::rays::{Ray, RayMesh};
use crate::sampling::{cosine_hemisphere, r2_sequence};
use crate::surface_points::surface_points;
use crate::{ClassedMesh, MaterialClass, Mesh};

/// Wood can enclose leaves if its area is more than this share of the surface of the plant's box: that of most trees
/// is not, and need not be asked.
const MIN_WALLS: f64 = 0.25;

/// Points of leaf and wood, and rays from each.
const POINTS: u32 = 1024;
const RAYS: u32 = 48;

/// Share of all directions that a leaf sees past wood, up to which it is enclosed.
pub(super) const OPEN: f64 = 0.15;

/// Share of the leaves that may be.
pub(super) const ENCLOSED: f64 = 0.15;

/// Share of the plant's longest edge that keeps a ray off a wall on which its leaf lies.
const LIFT: f32 = 1e-5;

/// Leaves that are enclosed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Enclosed {
    /// Share of the leaf area that is enclosed, 0..=1.
    pub share: f64,
    /// Share of all directions in which the enclosed leaves see past wood, in the mean.
    pub open: f64,
}

/// Whether a plant with these extents has wood that can enclose leaves.
pub(super) fn has_walls(plant: &ClassedMesh, extents: &Extents) -> bool {
    let wood = triangles_of(plant, MaterialClass::Wood);
    let walls_m2: f64 = wood.iter().map(|&corners| area(corners)).sum();
    let [x, y, z] = extents.size_m();
    walls_m2 > MIN_WALLS * 2.0 * (x * y + y * z + z * x)
}

/// Where more than [`ENCLOSED`] of the leaves of a plant in a box see less than [`OPEN`] past its wood.
pub(super) fn enclosed(plant: &ClassedMesh, extents: &Extents) -> Option<Enclosed> {
    if !has_walls(plant, extents) {
        return None;
    }
    let class_of = |triangle: u32| plant.classes[plant.mesh.triangle_material[triangle as usize] as usize];
    let points = surface_points(plant, POINTS, false).ok()?;
    let leaves: Vec<_> =
        points.into_iter().filter(|point| class_of(point.triangle) == MaterialClass::Leaf).collect();
    let is_wood = |&triangle: &u32| class_of(triangle) == MaterialClass::Wood;
    let walls: Vec<[u32; 3]> = (0..plant.mesh.triangles.len() as u32)
        .filter(is_wood)
        .map(|triangle| plant.mesh.triangles[triangle as usize])
        .collect();
    let walls = Mesh {
        positions: plant.mesh.positions.clone(),
        triangle_material: vec![0; walls.len()],
        triangles: walls,
        materials: vec![Material::opaque("walls")],
        ..Mesh::default()
    };
    let rays = RayMesh::new(&walls, true).ok()?;
    let lift = extents.longest_m() as f32 * LIFT;
    let open = |(seed, at): (usize, &[f32; 3])| {
        let is_open = |&ray: &u32| {
            let [height, turn] = r2_sequence(seed as u32, ray);
            let direction = cosine_hemisphere(Vec3::ZERO, height, turn);
            !rays.is_blocked(Ray { origin: Vec3::from(*at) + lift * direction, direction }, None)
        };
        f64::from((0..RAYS).filter(is_open).count() as u32) / f64::from(RAYS)
    };
    let leaves: Vec<[f32; 3]> = leaves.into_iter().map(|point| point.position_m).collect();
    let all: Vec<f64> = leaves.par_iter().enumerate().map(open).collect();
    let hidden: Vec<f64> = all.iter().copied().filter(|open| *open < OPEN).collect();
    let share = hidden.len() as f64 / all.len().max(1) as f64;
    let open = hidden.iter().sum::<f64>() / hidden.len().max(1) as f64;
    (share > ENCLOSED).then_some(Enclosed { share, open })
}
