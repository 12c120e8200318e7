//! Points on the surface of solids, and of leaves that walls enclose, even by area.

use flb_format::Grid;
use flb_scene::rays::{Ray, RayMesh};
use flb_scene::sampling::{cosine_hemisphere, hash, on_triangle, r2_sequence};
use flb_scene::{ClassedMesh, MaterialClass};
use glam::Vec3;
use rayon::prelude::*;

/// Points over the area of a site's face.
const PER_FACE: f64 = 3.0;

/// Fewest and most points.
const POINTS: [f64; 2] = [256.0, 262_144.0];

/// Rays from each side of a point: fewer where points are many, as those of one site share their noise.
const RAYS: [u32; 2] = [16, 48];

/// Points up to which each sends all of its rays.
const FEW: usize = 65_536;

/// Points that tell which way a mesh's solids face, and rays from each of their sides.
const JUDGES: [usize; 2] = [512, 8];

/// Share of the mesh's diagonal that keeps a ray off the surface which it leaves.
const LIFT: f32 = 1e-5;

/// A point of a solid or of a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidPoint {
    /// Model space, metres.
    pub at: Vec3,
    /// Unit; of a solid outwards, as the solids of the mesh face in the mean.
    pub normal: Vec3,
    /// Index of its triangle.
    pub triangle: u32,
}

/// Points on the solids of a mesh, or on its leaves.
pub(super) struct SolidPoints {
    pub points: Vec<SolidPoint>,
    /// Distance from its surface at which a ray starts, metres.
    pub lift: f32,
    /// Area that each stands for, in faces of a site.
    pub area: f64,
    /// Whether vertices run clockwise, seen from outside.
    pub inward: bool,
}

/// Rays from each side of each of so many points.
pub(super) fn rays_of(points: usize) -> u32 {
    ((RAYS[1] as usize * FEW / points.max(1)) as u32).clamp(RAYS[0], RAYS[1])
}

/// Points on all wood of a mesh.
pub(super) fn on_solids(classed: &ClassedMesh, rays: &RayMesh, grid: Grid) -> SolidPoints {
    let (points, area) = spread(classed, MaterialClass::Wood, rays, grid);
    let lift = rays.size() * LIFT;
    let inward = faces_inward(&points, rays, lift);
    let turned =
        |point: SolidPoint| SolidPoint { normal: if inward { -point.normal } else { point.normal }, ..point };
    SolidPoints { points: points.into_iter().map(turned).collect(), lift, area, inward }
}

/// Points on those leaves of a mesh that are `wanted`.
pub(super) fn on_leaves(
    classed: &ClassedMesh,
    rays: &RayMesh,
    grid: Grid,
    wanted: impl Fn(&SolidPoint) -> bool,
) -> SolidPoints {
    let (mut points, area) = spread(classed, MaterialClass::Leaf, rays, grid);
    points.retain(wanted);
    SolidPoints { points, lift: rays.size() * LIFT, area, inward: false }
}

/// Points on all surfaces of a class, and the area that each stands for, in faces of a site.
fn spread(classed: &ClassedMesh, class: MaterialClass, rays: &RayMesh, grid: Grid) -> (Vec<SolidPoint>, f64) {
    let ClassedMesh { mesh, classes } = classed;
    let mut ends = Vec::new();
    let mut area_m2 = 0.0;
    for (triangle, &material) in (0u32..).zip(&mesh.triangle_material) {
        if classes[material as usize] == class {
            let [a, b, c] = rays.points(triangle).map(Vec3::as_dvec3);
            area_m2 += (b - a).cross(c - a).length() / 2.0;
            ends.push((area_m2, triangle));
        }
    }
    let faces = area_m2 / (grid.spacing_m * grid.spacing_m);
    let count = if area_m2 > 0.0 { (faces * PER_FACE).clamp(POINTS[0], POINTS[1]) as u32 } else { 0 };
    let points: Vec<SolidPoint> = (0..count)
        .into_par_iter()
        .filter_map(|i| {
            let at = (f64::from(i) + 0.5) / f64::from(count) * area_m2;
            let &(_, triangle) = ends.get(ends.partition_point(|(end, _)| *end <= at))?;
            let weights = on_triangle(triangle, i);
            if !rays.is_present(triangle, weights) {
                return None;
            }
            let [a, b, c] = rays.points(triangle);
            let at = a + (b - a) * weights[0] + (c - a) * weights[1];
            Some(SolidPoint { at, normal: rays.front(triangle)?, triangle })
        })
        .collect();
    (points, if count > 0 { faces / f64::from(count) } else { 0.0 })
}

/// Whether more of the sky is seen from behind the triangles than from before them.
fn faces_inward(points: &[SolidPoint], rays: &RayMesh, lift: f32) -> bool {
    let [judges, directions] = JUDGES;
    let step = (points.len() / judges).max(1);
    let open = |point: &SolidPoint, normal: Vec3| -> u32 {
        let is_open = |i: &usize| {
            let [height, turn] = r2_sequence(hash(point.triangle), *i as u32);
            let ray =
                Ray { origin: point.at + normal * lift, direction: cosine_hemisphere(normal, height, turn) };
            !rays.is_blocked(ray, Some(point.triangle))
        };
        (0..directions).filter(is_open).count() as u32
    };
    let sums = points
        .par_iter()
        .step_by(step)
        .map(|point| [open(point, point.normal), open(point, -point.normal)])
        .reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    sums[1] > 2 * sums[0]
}
