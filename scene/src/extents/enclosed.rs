//! Leaves behind walls: in a closed box, or deep in a pot.
//!
//! From points of the leaves rays go in all directions, past the wood alone. A hull of a crown that was read as wood
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

/// A side of wood is bare if it sees past all other wood in more than this share of directions, and is inside of a
/// solid if it does in less than the other.
const BARE: f64 = 0.95;
const INSIDE: f64 = 0.02;

/// Share of bare sides among those that are not inside of a solid, from which on wood is walls: half of a pot's are
/// bare, and hardly one of a crown of thick branches.
const MIN_BARE: f64 = 0.2;

/// Points of leaf and wood, and rays from each.
const POINTS: u32 = 1024;
const RAYS: u32 = 48;

/// Points of leaf among those of leaf and wood that tell enough of the leaves.
const MIN_POINTS: usize = 64;

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

/// Walls of wood: of a pot, a box, a hull. Their area is over a quarter of the surface of the plant's box, and many of
/// their sides see no other wood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Walls {
    /// No walls, as of trees.
    None,
    /// Walls, past which most leaves see the sky.
    Beside,
    /// Walls that enclose more than 15 % of the leaf area.
    Enclosing(Enclosed),
}

/// A plant's wood by itself, which may be walls.
struct Wood {
    mesh: Mesh,
    leaves: Vec<Vec3>,
    /// Points with the normals of their triangles.
    woods: Vec<(Vec3, Vec3)>,
    lift: f32,
}

impl Wood {
    /// `None` where there is too little for walls.
    fn of(plant: &ClassedMesh, extents: &Extents) -> Option<Wood> {
        let wood_m2: f64 =
            triangles_of(plant, MaterialClass::Wood).iter().map(|&corners| area(corners)).sum();
        let [x, y, z] = extents.size_m();
        if wood_m2 <= MIN_WALLS * 2.0 * (x * y + y * z + z * x) {
            return None;
        }
        let ClassedMesh { mesh, classes } = plant;
        let class_of = |triangle: u32| classes[mesh.triangle_material[triangle as usize] as usize];
        let (mut leaves, mut woods) = (Vec::new(), Vec::new());
        for point in surface_points(plant, POINTS, false).ok()? {
            let at = Vec3::from(point.position_m);
            match class_of(point.triangle) {
                MaterialClass::Leaf => leaves.push(at),
                MaterialClass::Wood => {
                    let corner = |vertex: u32| Vec3::from(mesh.positions[vertex as usize]);
                    let [a, b, c] = mesh.triangles[point.triangle as usize].map(corner);
                    woods.push((at, (b - a).cross(c - a).normalize_or_zero()));
                }
                MaterialClass::Neither => {}
            }
        }
        if leaves.len() < MIN_POINTS {
            // Beside large walls leaves have hardly a point: they get their own.
            let class = |of: &MaterialClass| match of {
                MaterialClass::Wood => MaterialClass::Neither,
                other => *other,
            };
            let alone = ClassedMesh { mesh: mesh.clone(), classes: classes.iter().map(class).collect() };
            let points = surface_points(&alone, POINTS, false).ok()?;
            leaves = points.iter().map(|point| Vec3::from(point.position_m)).collect();
        }
        let triangles: Vec<[u32; 3]> = (0..mesh.triangles.len() as u32)
            .filter(|&triangle| class_of(triangle) == MaterialClass::Wood)
            .map(|triangle| mesh.triangles[triangle as usize])
            .collect();
        let mesh = Mesh {
            positions: mesh.positions.clone(),
            triangle_material: vec![0; triangles.len()],
            triangles,
            materials: vec![Material::opaque("walls")],
            ..Mesh::default()
        };
        Some(Wood { mesh, leaves, woods, lift: extents.longest_m() as f32 * LIFT })
    }

    /// Share of the directions around a normal, or of all, in which a point sees past the wood.
    fn open(&self, rays: &RayMesh, seed: usize, at: Vec3, normal: Vec3) -> f64 {
        let is_open = |&ray: &u32| {
            let [height, turn] = r2_sequence(seed as u32, ray);
            let direction = cosine_hemisphere(normal, height, turn);
            !rays.is_blocked(Ray { origin: at + self.lift * (direction + normal), direction }, None)
        };
        f64::from((0..RAYS).filter(is_open).count() as u32) / f64::from(RAYS)
    }

    /// Whether it is walls.
    fn is_walls(&self, rays: &RayMesh) -> bool {
        let of_point = |(seed, &(at, normal)): (usize, &(Vec3, Vec3))| {
            [normal, -normal].map(|normal| self.open(rays, seed, at, normal))
        };
        let sides: Vec<[f64; 2]> = self.woods.par_iter().enumerate().map(of_point).collect();
        let outside = sides.as_flattened().iter().filter(|open| **open > INSIDE).count();
        let bare = sides.as_flattened().iter().filter(|open| **open > BARE).count();
        bare as f64 > MIN_BARE * outside as f64
    }
}

/// The walls of a plant in a box.
pub(super) fn walls(plant: &ClassedMesh, extents: &Extents) -> Walls {
    let Some(wood) = Wood::of(plant, extents) else { return Walls::None };
    let Ok(rays) = RayMesh::new(&wood.mesh, true) else { return Walls::None };
    if !wood.is_walls(&rays) {
        return Walls::None;
    }
    let of_leaf = |(seed, &at): (usize, &Vec3)| wood.open(&rays, seed, at, Vec3::ZERO);
    let all: Vec<f64> = wood.leaves.par_iter().enumerate().map(of_leaf).collect();
    let hidden: Vec<f64> = all.iter().copied().filter(|open| *open < OPEN).collect();
    let share = hidden.len() as f64 / all.len().max(1) as f64;
    let open = hidden.iter().sum::<f64>() / hidden.len().max(1) as f64;
    if share > ENCLOSED { Walls::Enclosing(Enclosed { share, open }) } else { Walls::Beside }
}
