//! Points of a plant's surface, even by area: where light is compared.

use crate::alpha::{AlphaError, Coverage};
use crate::{ClassedMesh, MaterialClass};

/// Candidates per point wanted, of which those on texels that are cut away are passed over.
const CANDIDATES: u64 = 256;

/// Steps of the R sequence in three dimensions (M. Roberts, 2018): powers of the root of g^4 = g + 1.
const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];

/// A point of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Index of its triangle.
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex.
    pub weights: [f32; 2],
    /// Model space, metres.
    pub position_m: [f32; 3],
}

/// Draws up to `count` points on leaf and wood triangles, even by the area that counts, on present texels only; none
/// where the mesh has no such surface. The same for the same mesh.
///
/// # Errors
/// Of [`Coverage::of`], for textures that cannot be cut.
pub fn surface_points(
    classed: &ClassedMesh,
    count: u32,
    ignore_alpha: bool,
) -> Result<Vec<SurfacePoint>, AlphaError> {
    let ClassedMesh { mesh, classes } = classed;
    let coverage = Coverage::of_all(mesh, ignore_alpha)?;
    let mut ends = Vec::with_capacity(mesh.triangles.len());
    let mut area_m2 = 0.0;
    for (number, (triangle, &material)) in mesh.triangles.iter().zip(&mesh.triangle_material).enumerate() {
        if classes[material as usize] != MaterialClass::Neither {
            area_m2 += mesh.sheets.side(number).share()
                * twice_area(triangle.map(|vertex| mesh.positions[vertex as usize].map(f64::from)));
        }
        ends.push(area_m2);
    }
    let mut found = Vec::new();
    for i in 0..u64::from(count) * CANDIDATES {
        let [place, u, v] = STEPS.map(|step| (0.5 + step * i as f64).fract());
        let triangle = ends.partition_point(|&end| end <= place * area_m2);
        if found.len() == count as usize || triangle == ends.len() {
            break;
        }
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let shares = [1.0 - u - v, u, v];
        let corners = mesh.triangles[triangle].map(|vertex| vertex as usize);
        let mix = |of: &dyn Fn(usize) -> f32| -> f32 {
            (0..3).map(|k| shares[k] * f64::from(of(corners[k]))).sum::<f64>() as f32
        };
        // Import gives every vertex its own; a mesh of another maker may have none, as for rays.
        let uv = [0, 1].map(|axis| mix(&|vertex| mesh.uvs.get(vertex).map_or(0.0, |uv| uv[axis])));
        if coverage[mesh.triangle_material[triangle] as usize].present_at(uv) {
            found.push(SurfacePoint {
                triangle: triangle as u32,
                weights: [u as f32, v as f32],
                position_m: [0, 1, 2].map(|axis| mix(&|vertex| mesh.positions[vertex][axis])),
            });
        }
    }
    Ok(found)
}

fn twice_area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let (p, q): ([f64; 3], [f64; 3]) =
        (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
    let cross: [f64; 3] = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        p[j] * q[k] - p[k] * q[j]
    });
    libm::sqrt(cross.iter().map(|c| c * c).sum())
}

#[cfg(test)]
mod tests;
