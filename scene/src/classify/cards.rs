//! Materials that are called wood and look like leaves: green cards of whole twigs, which exporters call branches.

use glam::DVec3;

use crate::alpha::Coverage;
use crate::mesh::{AlphaMode, Mesh};
use crate::rays::{points, uv};
use crate::sampling::on_triangle;
use crate::texture::{SrgbTable, color};

/// Share of the area that alpha cuts away of such cards, at least.
const MIN_CUT: f64 = 1.0 / 3.0;
/// Green over red and over blue, at least, in the mean of what is left.
const MIN_GREEN: f64 = 1.2;
/// Triangles that are looked at, and points of each.
const LOOKED_AT: usize = 1024;
const POINTS: u32 = 16;

/// The share that alpha cuts away of a material, where it is much and the rest is green.
pub(super) fn cut_of_green(mesh: &Mesh, material: usize) -> Option<f64> {
    let of = &mesh.materials[material];
    if of.alpha_mode == AlphaMode::Opaque {
        return None;
    }
    let coverage = Coverage::of(mesh, material).ok().filter(|coverage| *coverage != Coverage::Full)?;
    let is_its = |triangle: &usize| mesh.triangle_material[*triangle] as usize == material;
    let triangles: Vec<usize> = (0..mesh.triangles.len()).filter(is_its).collect();
    let table = SrgbTable::new();
    let (mut all, mut left, mut sum) = (0.0, 0.0, DVec3::ZERO);
    for &triangle in triangles.iter().step_by(triangles.len().div_ceil(LOOKED_AT).max(1)) {
        let [a, b, c] = points(mesh, triangle).map(|point| point.as_dvec3());
        let share = (b - a).cross(c - a).length();
        for point in 0..POINTS {
            let weights = on_triangle(triangle as u32, point);
            let uv = uv(mesh, triangle, weights);
            all += share;
            if coverage.present_at(uv) {
                left += share;
                let color = color(of, &mesh.images, &table, uv) * mesh.vertex_color(triangle, weights);
                sum += color.as_dvec3() * share;
            }
        }
    }
    let is_green = sum.y >= MIN_GREEN * sum.x.max(sum.z) && sum.y > 0.0;
    (is_green && left < (1.0 - MIN_CUT) * all).then(|| 1.0 - left / all)
}
