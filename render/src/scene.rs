//! A mesh made ready for rays, with what they see of its surfaces.

use std::ops::Deref;

use flb_scene::color::mean_colors;
pub(crate) use flb_scene::rays::{PaddedBox, Ray, TriangleHit};
use flb_scene::rays::{RayMesh, points};
use flb_scene::texture::{self, SrgbTable};
use flb_scene::{MaterialClass, Mesh};
use glam::Vec3;

use crate::RenderError;

/// The nearest present surface along a ray.
#[derive(Clone)]
pub(crate) struct Hit {
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

/// A mesh, what its materials are, and the rays in it.
pub(crate) struct Scene<'a> {
    pub classes: &'a [MaterialClass],
    rays: RayMesh<'a>,
    table: SrgbTable,
}

impl<'a> Deref for Scene<'a> {
    type Target = RayMesh<'a>;

    fn deref(&self) -> &RayMesh<'a> {
        &self.rays
    }
}

impl<'a> Scene<'a> {
    pub(crate) fn prepare(mesh: &'a Mesh, classes: &'a [MaterialClass]) -> Result<Self, RenderError> {
        if classes.len() != mesh.materials.len() {
            return Err(RenderError::Classes { found: classes.len(), expected: mesh.materials.len() });
        }
        Ok(Scene { classes, rays: RayMesh::new(mesh, false)?, table: SrgbTable::new() })
    }

    /// The nearest present surface. Triangle `except` is not seen.
    pub(crate) fn nearest(&self, ray: Ray, except: Option<u32>) -> Option<Hit> {
        self.find(ray, f32::INFINITY, except).map(|found| self.surface(ray.direction, &found))
    }

    /// What a ray that goes in a direction sees of the surface that it met.
    pub(crate) fn surface(&self, looking: Vec3, found: &TriangleHit) -> Hit {
        let &TriangleHit { triangle, weights, .. } = found;
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
            point: a + (b - a) * weights[0] + (c - a) * weights[1],
            flat_normal,
            normal,
            color: self.color(triangle, weights),
            class: self.classes[material],
            material,
            triangle,
        }
    }

    /// Linear texture colour x base colour x the vertices' colours at the weights of a triangle's second and third
    /// vertex.
    fn color(&self, triangle: u32, weights: [f32; 2]) -> Vec3 {
        let material = self.mesh.triangle_material[triangle as usize] as usize;
        let uv = self.uv(triangle, weights);
        let color = texture::color(&self.mesh.materials[material], &self.mesh.images, &self.table, uv);
        color * self.mesh.vertex_color(triangle as usize, weights)
    }

    /// Per material, the mean of its linear colour over the surface of the mesh that alpha leaves.
    pub(crate) fn mean_colors(&self) -> Vec<Vec3> {
        mean_colors(self.mesh, &self.coverage)
    }
}
