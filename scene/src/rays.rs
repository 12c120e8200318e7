//! A mesh made ready for rays: triangles in a bounding volume hierarchy, alpha cuts honoured at each hit. A triangle
//! that stands for one side of a leaf ([`crate::sheets`]) is met from that side alone.

use std::time::Duration;

use glam::{Vec2, Vec3, Vec3A};
use obvhs::{
    Boundable, BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ray::{Ray as BoxRay, RayHit},
};
use thiserror::Error;

use crate::Mesh;
use crate::alpha::{AlphaError, Coverage};
use crate::mesh::sides::Side;
use crate::sampling::hash;

/// Reason why no ray can be traced.
#[derive(Debug, Error)]
pub enum RayMeshError {
    /// Mesh without triangles.
    #[error("the mesh has no triangles")]
    NoTriangles,
    /// A mesh whose indices or coordinates cannot be used.
    #[error("triangle {triangle}: {what}")]
    Triangle {
        /// Index of the triangle.
        triangle: usize,
        /// Fault of the triangle, and what was expected.
        what: String,
    },
    /// A material's alpha cannot be read.
    #[error(transparent)]
    Alpha(#[from] AlphaError),
}

/// A half line. `direction` is of unit length.
#[derive(Clone, Copy)]
pub struct Ray {
    /// Start of the ray, metres.
    pub origin: Vec3,
    /// Direction of the ray.
    pub direction: Vec3,
}

/// Hit of a ray on the nearest present triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// Distance in the model's frame, from where the ray enters the model's box.
    pub distance: f32,
    /// Index of the triangle in the mesh.
    pub triangle: u32,
    /// Barycentric weights of the triangle's second and third vertex.
    pub weights: [f32; 2],
}

/// A triangle in the order of the hierarchy's leaves.
struct Corner {
    origin: Vec3,
    edges: [Vec3; 2],
    /// Index into the mesh.
    triangle: u32,
    /// Whether alpha has to be looked up.
    is_cut: bool,
    /// From where it is met.
    side: Side,
}

/// A mesh that rays are traced in.
pub struct RayMesh<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Hierarchy of boxes over the triangles.
    pub hierarchy: Bvh2,
    corners: Vec<Corner>,
    /// Presence of each material's surface by alpha.
    pub coverage: Vec<Coverage>,
    /// Lowest coordinates.
    pub min: Vec3,
    /// Highest coordinates.
    pub max: Vec3,
}

/// A triangle's or an instance's box, padded: box tests round, and a flat box must not be lost.
pub struct PaddedBox(Aabb);

/// Coordinates from which products of three lengths would near the end of f32, metres.
const COORDINATE_LIMIT_M: f32 = 1e9;
/// Padding, as a share of the largest coordinate: some tens of the last place of an f32.
const PAD: f32 = 4e-6;

impl PaddedBox {
    /// Pads by `pad` at least, shifted by a hash of the index: thousands of equal boxes would make
    /// the hierarchy's builder pair them into a list as deep as they are many, and overflow its stack.
    pub fn around(corners: [Vec3; 3], triangle: u32, pad: f32) -> Self {
        let mut aabb = Aabb::from_points(&corners.map(Vec3A::from));
        let mut seed = triangle;
        let shift = Vec3A::from_array([0; 3].map(|_: i32| {
            seed = hash(seed);
            pad * ((seed >> 8) as f32 / (1u32 << 23) as f32 - 1.0)
        }));
        aabb.min += shift - pad * 2.0;
        aabb.max += shift + pad * 2.0;
        PaddedBox(aabb)
    }
}

impl Boundable for PaddedBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl<'a> RayMesh<'a> {
    /// Sorts the triangles of a mesh; with `ignore_alpha`, every texel is present.
    ///
    /// # Errors
    /// A mesh without triangles, indices out of range, coordinates that are not finite or too large, and alpha that
    /// cannot be read.
    pub fn new(mesh: &'a Mesh, ignore_alpha: bool) -> Result<Self, RayMeshError> {
        check_triangles(mesh)?;
        let bounds = mesh.bounds().ok_or(RayMeshError::NoTriangles)?;
        let (min, max) = (Vec3::from(bounds.min.map(|v| v as f32)), Vec3::from(bounds.max.map(|v| v as f32)));
        let reach = max.abs().max(min.abs()).max_element().max(f32::MIN_POSITIVE);
        let boxes: Vec<PaddedBox> = (0..mesh.triangles.len())
            .map(|triangle| PaddedBox::around(points(mesh, triangle), triangle as u32, reach * PAD))
            .collect();
        // A binary tree, not a wide one: its stack grows with its depth, so no mesh can overflow it.
        let hierarchy = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let coverage = Coverage::of_all(mesh, ignore_alpha)?;
        let corners = hierarchy
            .primitive_indices
            .iter()
            .map(|&triangle| {
                let [a, b, c] = points(mesh, triangle as usize);
                Corner {
                    origin: a,
                    edges: [b - a, c - a],
                    triangle,
                    side: mesh.sheets.side(triangle as usize),
                    is_cut: coverage[mesh.triangle_material[triangle as usize] as usize] != Coverage::Full,
                }
            })
            .collect();
        Ok(RayMesh { mesh, hierarchy, corners, coverage, min, max })
    }

    /// Vertices that a triangle uses (some of them more than once).
    pub fn vertices(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.mesh.triangles.iter().flatten().map(|&v| Vec3::from(self.mesh.positions[v as usize]))
    }

    /// Length from which tolerances are taken: the diagonal of the bounds.
    pub fn size(&self) -> f32 {
        (self.max - self.min).length().max(1e-6)
    }

    /// Finds the nearest hit up to the distance `far`, before anything is known of the surface but where it is.
    pub fn find(&self, ray: Ray, far: f32, except: Option<u32>) -> Option<TriangleHit> {
        let mut best = None;
        self.hierarchy.ray_traverse(box_ray(ray, far), &mut RayHit::none(), |_, at| {
            match self.meet(at, ray, except, &mut best) {
                true => best.as_ref().map_or(f32::INFINITY, |found: &TriangleHit| found.distance),
                false => f32::INFINITY,
            }
        });
        best.filter(|found| found.distance <= far)
    }

    /// Puts the triangle number `at` of the hierarchy's order into `best` if the ray meets it nearer, and says so. Of
    /// two at the same distance the one with the lower index is taken, so that the order of a search cannot show.
    pub fn meet(&self, at: usize, ray: Ray, except: Option<u32>, best: &mut Option<TriangleHit>) -> bool {
        let corner = &self.corners[at];
        let Some((distance, weights)) = intersect(corner, ray) else { return false };
        let is_nearer = best.as_ref().is_none_or(|found| {
            distance < found.distance || (distance == found.distance && corner.triangle < found.triangle)
        });
        let is_met = is_nearer && self.counts(corner, weights, except);
        if is_met {
            *best = Some(TriangleHit { distance, triangle: corner.triangle, weights });
        }
        is_met
    }

    /// Whether the ray meets the triangle number `at` of the hierarchy's order.
    pub fn meets(&self, at: usize, ray: Ray, except: Option<u32>) -> bool {
        let corner = &self.corners[at];
        intersect(corner, ray).is_some_and(|(_, weights)| self.counts(corner, weights, except))
    }

    fn counts(&self, corner: &Corner, weights: [f32; 2], except: Option<u32>) -> bool {
        Some(corner.triangle) != except && (!corner.is_cut || self.is_present(corner.triangle, weights))
    }

    /// Whether anything present other than triangle `except` stands in the way.
    pub fn is_blocked(&self, ray: Ray, except: Option<u32>) -> bool {
        !self.hierarchy.ray_traverse_miss(box_ray(ray, f32::MAX), |_, at| match self.meets(at, ray, except) {
            true => 0.0,
            false => f32::INFINITY,
        })
    }

    /// Corners of each triangle, in the hierarchy's order.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [Vec3; 3]> + '_ {
        self.corners.iter().map(|corner| {
            let [b, c] = corner.edges.map(|edge| corner.origin + edge);
            [corner.origin, b, c]
        })
    }

    /// Corners of a triangle.
    pub fn points(&self, triangle: u32) -> [Vec3; 3] {
        points(self.mesh, triangle as usize)
    }

    /// Unit normal of a flat triangle, to the side from which its vertices run counter-clockwise; `None` where it has
    /// no area.
    pub fn front(&self, triangle: u32) -> Option<Vec3> {
        let [a, b, c] = points(self.mesh, triangle as usize);
        (b - a).cross(c - a).try_normalize()
    }

    /// Whether alpha leaves the point of a triangle at the weights of its second and third vertex.
    pub fn is_present(&self, triangle: u32, weights: [f32; 2]) -> bool {
        let material = self.mesh.triangle_material[triangle as usize] as usize;
        self.coverage[material].present_at(self.uv(triangle, weights))
    }

    /// Texture coordinates at the weights of a triangle's second and third vertex; (0, 0) without any.
    pub fn uv(&self, triangle: u32, weights: [f32; 2]) -> [f32; 2] {
        uv(self.mesh, triangle as usize, weights)
    }
}

/// Distance along the ray and the weights of the second and third vertex (Moeller and Trumbore 1997), in
/// scalar arithmetic of one fixed order, so that every machine finds the same hit.
fn intersect(corner: &Corner, ray: Ray) -> Option<(f32, [f32; 2])> {
    let [e1, e2] = corner.edges;
    let p = ray.direction.cross(e2);
    let determinant = e1.dot(p);
    // Above 0 where the ray comes from the side from which the vertices run counter-clockwise.
    if determinant == 0.0 || !corner.side.is_met(determinant > 0.0) {
        return None;
    }
    let inverse = 1.0 / determinant;
    let s = ray.origin - corner.origin;
    let u = s.dot(p) * inverse;
    let q = s.cross(e1);
    let v = ray.direction.dot(q) * inverse;
    let distance = e2.dot(q) * inverse;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0 && distance.is_finite())
        .then_some((distance, [u, v]))
}

fn box_ray(ray: Ray, far: f32) -> BoxRay {
    BoxRay::new(ray.origin.into(), ray.direction.into(), 0.0, far)
}

/// Corners of a triangle.
pub fn points(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
    mesh.triangles[triangle].map(|v| Vec3::from(mesh.positions[v as usize]))
}

/// Texture coordinates at the weights of a triangle's second and third vertex; (0, 0) without any.
pub fn uv(mesh: &Mesh, triangle: usize, weights: [f32; 2]) -> [f32; 2] {
    let [a, b, c] =
        mesh.triangles[triangle].map(|v| mesh.uvs.get(v as usize).map_or(Vec2::ZERO, |&uv| Vec2::from(uv)));
    (a * (1.0 - weights[0] - weights[1]) + b * weights[0] + c * weights[1]).to_array()
}

/// Every index in range and every coordinate finite, for meshes that did not come from import.
fn check_triangles(mesh: &Mesh) -> Result<(), RayMeshError> {
    let refuse = |triangle: usize, what: String| Err(RayMeshError::Triangle { triangle, what });
    if mesh.triangle_material.len() != mesh.triangles.len() {
        let what = format!(
            "the mesh has {} triangles but {} material indices",
            mesh.triangles.len(),
            mesh.triangle_material.len()
        );
        return refuse(mesh.triangles.len().min(mesh.triangle_material.len()), what);
    }
    for (triangle, (corners, &material)) in mesh.triangles.iter().zip(&mesh.triangle_material).enumerate() {
        if material as usize >= mesh.materials.len() {
            return refuse(triangle, format!("material {material} of {}", mesh.materials.len()));
        }
        for &vertex in corners {
            match mesh.positions.get(vertex as usize) {
                Some(point) if point.iter().all(|v| v.abs() < COORDINATE_LIMIT_M) => {}
                Some(point) => {
                    return refuse(
                        triangle,
                        format!("vertex {vertex} lies at {point:?}, expected finite coordinates below 1e9 m"),
                    );
                }
                None => return refuse(triangle, format!("vertex {vertex} of {}", mesh.positions.len())),
            }
        }
    }
    Ok(())
}
