//! A mesh made ready for rays: triangles in a bounding volume hierarchy, alpha cuts honoured at each hit.

use std::time::Duration;

use flb_scene::{MaterialClass, Mesh, alpha::Coverage};
use glam::{DVec3, Vec2, Vec3, Vec3A};
use obvhs::{
    Boundable, BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ray::{Ray as BoxRay, RayHit},
};

use crate::{
    RenderError,
    texture::{self, SrgbTable},
};

/// A half line. `direction` is of unit length.
#[derive(Clone, Copy)]
pub(crate) struct Ray {
    pub origin: Vec3,
    pub direction: Vec3,
}

/// The nearest present surface along a ray.
pub(crate) struct Hit {
    pub distance: f32,
    pub point: Vec3,
    /// Unit, of the flat triangle, towards the ray's origin.
    pub flat_normal: Vec3,
    /// Unit, interpolated, on the side of `flat_normal`.
    pub normal: Vec3,
    /// Linear texture colour x base colour.
    pub color: Vec3,
    pub class: MaterialClass,
    /// Index into the mesh's materials.
    pub material: usize,
    /// Index of the triangle, which no ray that leaves the surface may hit.
    pub triangle: u32,
}

/// Where a ray met the nearest present triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// In the model's frame, from where the ray enters the model's box.
    pub distance: f32,
    /// Index into the mesh.
    pub triangle: u32,
    /// Of its second and third vertex.
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
}

pub(crate) struct Scene<'a> {
    pub mesh: &'a Mesh,
    pub classes: &'a [MaterialClass],
    pub hierarchy: Bvh2,
    corners: Vec<Corner>,
    /// Per material, what alpha leaves of it.
    pub coverage: Vec<Coverage>,
    table: SrgbTable,
    pub min: Vec3,
    pub max: Vec3,
}

/// A triangle's or an instance's box, padded: box tests round, and a flat box must not be lost.
pub(crate) struct PaddedBox(Aabb);

/// Coordinates from which products of three lengths would near the end of f32, metres.
const COORDINATE_LIMIT_M: f32 = 1e9;
/// Padding, as a share of the largest coordinate: some tens of the last place of an f32.
const PAD: f32 = 4e-6;

/// Points at which a material's mean colour is taken, at least, over all of its triangles and on each.
const MEAN_POINTS: u32 = 1 << 14;
const FEWEST_MEAN_POINTS: u32 = 4;

impl PaddedBox {
    /// Pads by `pad` at least, shifted by a hash of the index: thousands of equal boxes would make
    /// the hierarchy's builder pair them into a list as deep as they are many, and overflow its stack.
    pub(crate) fn around(corners: [Vec3; 3], triangle: u32, pad: f32) -> Self {
        let mut aabb = Aabb::from_points(&corners.map(Vec3A::from));
        let mut seed = triangle;
        let shift = Vec3A::from_array([0; 3].map(|_: i32| {
            seed = crate::hash(seed);
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

impl<'a> Scene<'a> {
    pub(crate) fn prepare(mesh: &'a Mesh, classes: &'a [MaterialClass]) -> Result<Self, RenderError> {
        if classes.len() != mesh.materials.len() {
            return Err(RenderError::Classes { found: classes.len(), expected: mesh.materials.len() });
        }
        check_triangles(mesh)?;
        let bounds = mesh.bounds().ok_or(RenderError::NoTriangles)?;
        let (min, max) = (Vec3::from(bounds.min.map(|v| v as f32)), Vec3::from(bounds.max.map(|v| v as f32)));
        let reach = max.abs().max(min.abs()).max_element().max(f32::MIN_POSITIVE);
        let boxes: Vec<PaddedBox> = (0..mesh.triangles.len())
            .map(|triangle| PaddedBox::around(points(mesh, triangle), triangle as u32, reach * PAD))
            .collect();
        // A binary tree, not a wide one: its stack grows with its depth, so no mesh can overflow it.
        let hierarchy = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let coverage = (0..mesh.materials.len())
            .map(|material| Coverage::of(mesh, material))
            .collect::<Result<Vec<_>, _>>()?;
        let corners = hierarchy
            .primitive_indices
            .iter()
            .map(|&triangle| {
                let [a, b, c] = points(mesh, triangle as usize);
                Corner {
                    origin: a,
                    edges: [b - a, c - a],
                    triangle,
                    is_cut: coverage[mesh.triangle_material[triangle as usize] as usize] != Coverage::Full,
                }
            })
            .collect();
        Ok(Scene { mesh, classes, hierarchy, corners, coverage, table: SrgbTable::new(), min, max })
    }

    /// Vertices that a triangle uses (some of them more than once).
    pub(crate) fn vertices(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.mesh.triangles.iter().flatten().map(|&v| Vec3::from(self.mesh.positions[v as usize]))
    }

    /// Length from which tolerances are taken: the diagonal of the bounds.
    pub(crate) fn size(&self) -> f32 {
        (self.max - self.min).length().max(1e-6)
    }

    /// The nearest present surface. Triangle `except` is not seen.
    pub(crate) fn nearest(&self, ray: Ray, except: Option<u32>) -> Option<Hit> {
        self.find(ray, f32::INFINITY, except).map(|found| self.surface(ray.direction, &found))
    }

    /// The same up to the distance `far`, before anything is known of the surface but where it is.
    pub(crate) fn find(&self, ray: Ray, far: f32, except: Option<u32>) -> Option<TriangleHit> {
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
    pub(crate) fn meet(
        &self,
        at: usize,
        ray: Ray,
        except: Option<u32>,
        best: &mut Option<TriangleHit>,
    ) -> bool {
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
    pub(crate) fn meets(&self, at: usize, ray: Ray, except: Option<u32>) -> bool {
        let corner = &self.corners[at];
        intersect(corner, ray).is_some_and(|(_, weights)| self.counts(corner, weights, except))
    }

    fn counts(&self, corner: &Corner, weights: [f32; 2], except: Option<u32>) -> bool {
        Some(corner.triangle) != except && (!corner.is_cut || self.is_present(corner.triangle, weights))
    }

    /// Whether anything present other than triangle `except` stands in the way.
    pub(crate) fn is_blocked(&self, ray: Ray, except: Option<u32>) -> bool {
        !self.hierarchy.ray_traverse_miss(box_ray(ray, f32::MAX), |_, at| match self.meets(at, ray, except) {
            true => 0.0,
            false => f32::INFINITY,
        })
    }

    /// Corners of each triangle, in the hierarchy's order.
    pub(crate) fn triangles(&self) -> impl ExactSizeIterator<Item = [Vec3; 3]> + '_ {
        self.corners.iter().map(|corner| {
            let [b, c] = corner.edges.map(|edge| corner.origin + edge);
            [corner.origin, b, c]
        })
    }

    /// What a ray that goes in a direction sees of the surface that it met.
    pub(crate) fn surface(&self, looking: Vec3, found: &TriangleHit) -> Hit {
        let &TriangleHit { distance, triangle, weights } = found;
        let corners = self.mesh.triangles[triangle as usize];
        let [a, b, c] = points(self.mesh, triangle as usize);
        let mut flat_normal = (b - a).cross(c - a).normalize_or(-looking);
        if flat_normal.dot(looking) > 0.0 {
            flat_normal = -flat_normal;
        }
        let normals =
            corners.map(|v| self.mesh.normals.get(v as usize).copied().map_or(flat_normal, Vec3::from));
        let mixed =
            normals[0] * (1.0 - weights[0] - weights[1]) + normals[1] * weights[0] + normals[2] * weights[1];
        let mut normal = mixed.normalize_or(flat_normal);
        if normal.dot(flat_normal) < 0.0 {
            normal = -normal;
        }
        let material = self.mesh.triangle_material[triangle as usize] as usize;
        Hit {
            distance,
            point: a + (b - a) * weights[0] + (c - a) * weights[1],
            flat_normal,
            normal,
            color: self.color(triangle, weights),
            class: self.classes[material],
            material,
            triangle,
        }
    }

    /// Linear texture colour x base colour at the weights of a triangle's second and third vertex.
    fn color(&self, triangle: u32, weights: [f32; 2]) -> Vec3 {
        let material = self.mesh.triangle_material[triangle as usize] as usize;
        let uv = self.uv(triangle, weights);
        texture::color(&self.mesh.materials[material], &self.mesh.images, &self.table, uv)
    }

    fn is_present(&self, triangle: u32, weights: [f32; 2]) -> bool {
        let material = self.mesh.triangle_material[triangle as usize] as usize;
        self.coverage[material].present_at(self.uv(triangle, weights))
    }

    /// Per material, the mean of its linear colour over the surface of the mesh that alpha leaves; white for
    /// materials without any. By area of the mesh, not by texels: a part of an image that no leaf shows,
    /// such as the bark's half of an atlas, has no say in the leaves' mean.
    pub(crate) fn mean_colors(&self) -> Vec<Vec3> {
        let mut uses = vec![0u32; self.mesh.materials.len()];
        for &material in &self.mesh.triangle_material {
            uses[material as usize] += 1;
        }
        let mut sums = vec![(DVec3::ZERO, 0.0f64); uses.len()];
        for (triangle, &material) in self.mesh.triangle_material.iter().enumerate() {
            let [a, b, c] = points(self.mesh, triangle);
            let area = f64::from((b - a).cross(c - a).length()) / 2.0;
            let count = (MEAN_POINTS / uses[material as usize]).max(FEWEST_MEAN_POINTS);
            let (sum, weight) = &mut sums[material as usize];
            for point in 0..count {
                let [u, v] = crate::sequence(triangle as u32, point);
                // The half of the square beyond the diagonal, turned onto the triangle.
                let weights = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
                if self.is_present(triangle as u32, weights) {
                    let share = area / f64::from(count);
                    *sum += self.color(triangle as u32, weights).as_dvec3() * share;
                    *weight += share;
                }
            }
        }
        let mean =
            |(sum, weight): (DVec3, f64)| if weight > 0.0 { (sum / weight).as_vec3() } else { Vec3::ONE };
        sums.into_iter().map(mean).collect()
    }

    fn uv(&self, triangle: u32, weights: [f32; 2]) -> [f32; 2] {
        let [a, b, c] = self.mesh.triangles[triangle as usize]
            .map(|v| self.mesh.uvs.get(v as usize).map_or(Vec2::ZERO, |&uv| Vec2::from(uv)));
        (a * (1.0 - weights[0] - weights[1]) + b * weights[0] + c * weights[1]).to_array()
    }
}

/// Distance along the ray and the weights of the second and third vertex (Moeller and Trumbore 1997), in
/// scalar arithmetic of one fixed order, so that every machine finds the same hit.
fn intersect(corner: &Corner, ray: Ray) -> Option<(f32, [f32; 2])> {
    let [e1, e2] = corner.edges;
    let p = ray.direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
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

fn points(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
    mesh.triangles[triangle].map(|v| Vec3::from(mesh.positions[v as usize]))
}

/// Every index in range and every coordinate finite, for meshes that did not come from import.
fn check_triangles(mesh: &Mesh) -> Result<(), RenderError> {
    let refuse = |triangle: usize, what: String| Err(RenderError::Triangle { triangle, what });
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
