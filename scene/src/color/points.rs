//! Colours of a mesh's surface, even by area: by area of the mesh, not by texels, so that a part of an image that no
//! leaf shows, such as the bark's half of an atlas, has no say.

use glam::{DVec3, Vec3};

use crate::Mesh;
use crate::alpha::Coverage;
use crate::rays::{points, uv};
use crate::sampling::on_triangle;
use crate::texture::{self, SrgbTable};

/// Points at which a material's colour is taken, at least, over all of its triangles and on each.
const POINTS: u32 = 1 << 14;
const MIN_POINTS: u32 = 4;

/// Visits points of the surface that alpha leaves, with their material, linear colour and the area each stands for.
/// `coverage` has an entry per material.
pub fn on_surface(mesh: &Mesh, coverage: &[Coverage], mut visit: impl FnMut(usize, Vec3, f64)) {
    let table = SrgbTable::new();
    let mut uses = vec![0u32; mesh.materials.len()];
    for &material in &mesh.triangle_material {
        uses[material as usize] += 1;
    }
    for (triangle, &material) in mesh.triangle_material.iter().enumerate() {
        let material = material as usize;
        let [a, b, c] = points(mesh, triangle);
        let area = f64::from((b - a).cross(c - a).length()) / 2.0 * mesh.sheets.side(triangle).share();
        let count = (POINTS / uses[material]).max(MIN_POINTS);
        let share = area / f64::from(count);
        for point in 0..count {
            let weights = on_triangle(triangle as u32, point);
            let uv = uv(mesh, triangle, weights);
            if coverage[material].present_at(uv) {
                let color = texture::color(&mesh.materials[material], &mesh.images, &table, uv);
                visit(material, color * mesh.vertex_color(triangle, weights), share);
            }
        }
    }
}

/// Returns the mean linear colour of each material over the surface that alpha leaves; white for materials without any.
pub fn mean_colors(mesh: &Mesh, coverage: &[Coverage]) -> Vec<Vec3> {
    let mut sums = vec![(DVec3::ZERO, 0.0f64); mesh.materials.len()];
    on_surface(mesh, coverage, |material, color, share| {
        let (sum, weight) = &mut sums[material];
        *sum += color.as_dvec3() * share;
        *weight += share;
    });
    let mean = |(sum, weight): (DVec3, f64)| if weight > 0.0 { (sum / weight).as_vec3() } else { Vec3::ONE };
    sums.into_iter().map(mean).collect()
}
