//! A triangle of the mesh on the voxel grid: snapped, in an order that does not depend on the file's,
//! and the lists that say which triangles meet which layer.

use flb_format::Grid;
use rayon::prelude::*;

use super::{Scene, Surface};
use flb_scene::Mesh;
use flb_scene::alpha::{Coverage, Cut, TexelBox};

/// Snapped units per voxel.
pub(super) const UNITS: i64 = 1 << 16;

/// A triangle with its vertices on the snapped grid, sorted, so that vertex order does not matter.
pub(super) struct Snapped<'a> {
    /// Vertices in units of 1/65536 voxel.
    pub vertices: [[i64; 3]; 3],
    pub wood: bool,
    /// Share of its area that counts.
    pub counted: f64,
    /// Where alpha cuts the surface.
    pub cut: Option<CutTriangle<'a>>,
}

/// A triangle's place on its cut.
pub(super) struct CutTriangle<'a> {
    pub cut: &'a Cut,
    /// Texels of the three vertices.
    pub texels: [[f64; 2]; 3],
    /// The texels that the triangle's box meets.
    pub within: TexelBox,
}

impl<'a> CutTriangle<'a> {
    fn new(cut: &'a Cut, texels: [[f64; 2]; 3]) -> CutTriangle<'a> {
        let end = |pick: fn(f64, f64) -> f64| {
            std::array::from_fn(|axis| pick(pick(texels[0][axis], texels[1][axis]), texels[2][axis]))
        };
        CutTriangle { cut, texels, within: TexelBox::of(end(f64::min), end(f64::max)) }
    }
}

/// The vertices of a mesh in units; those of triangles that count lie within the grid.
pub(super) fn snapped(mesh: &Mesh, grid: &Grid, voxels: u32) -> Vec<[i32; 3]> {
    let scale = f64::from(voxels / grid.lattice) * UNITS as f64;
    let snap = |position: &[f32; 3]| {
        grid.lattice_from_model(position.map(f64::from)).map(|c| libm::round(c * scale) as i32)
    };
    mesh.positions.par_iter().map(snap).collect()
}

impl Scene<'_> {
    /// A triangle of the mesh; `None` if its material does not count or nothing of it is there.
    pub(super) fn snapped(&self, triangle: usize) -> Option<Snapped<'_>> {
        let surface = self.surface_of(triangle)?;
        let counted = self.mesh.sheets.side(triangle).share();
        let mut corners = self.mesh.triangles[triangle].map(|vertex| (self.snap(vertex), vertex));
        let Coverage::Cut(cut) = &surface.coverage else {
            corners.sort_unstable_by_key(|&(at, _)| at);
            return Some(Snapped {
                vertices: corners.map(|(at, _)| at),
                wood: surface.wood,
                counted,
                cut: None,
            });
        };
        let uv_of = |vertex: u32| self.mesh.uvs[vertex as usize];
        corners.sort_unstable_by_key(|&(at, vertex)| (at, uv_of(vertex).map(f32::to_bits)));
        let mut texels = corners.map(|(_, vertex)| cut.texel_from_uv(uv_of(vertex)));
        cut.near_origin(&mut texels);
        let cut = Some(CutTriangle::new(cut, texels));
        Some(Snapped { vertices: corners.map(|(at, _)| at), wood: surface.wood, counted, cut })
    }

    fn surface_of(&self, triangle: usize) -> Option<&Surface> {
        let surface = self.surfaces[self.mesh.triangle_material[triangle] as usize].as_ref()?;
        (surface.coverage != Coverage::Nothing).then_some(surface)
    }

    fn snap(&self, vertex: u32) -> [i64; 3] {
        self.snapped[vertex as usize].map(i64::from)
    }

    /// Per layer of `thickness` units along z, the triangles that meet it (closed on both sides, so that
    /// one in the face between two layers is listed for both).
    pub(super) fn layers(&self, thickness: i64) -> Layers {
        let layer_count = ((i64::from(self.voxels) * UNITS + thickness - 1) / thickness) as usize;
        let spans: Vec<[u16; 2]> = (0..self.mesh.triangles.len())
            .into_par_iter()
            .map(|triangle| {
                if self.surface_of(triangle).is_none() {
                    return [1, 0];
                }
                let zs = self.mesh.triangles[triangle].map(|vertex| self.snap(vertex)[2]);
                let (low, high) = (zs[0].min(zs[1]).min(zs[2]), zs[0].max(zs[1]).max(zs[2]));
                [((low - 1).div_euclid(thickness)) as u16, high.div_euclid(thickness) as u16]
            })
            .collect();
        let mut starts = vec![0usize; layer_count + 1];
        for &[first, last] in &spans {
            for layer in first..=last {
                starts[layer as usize + 1] += 1;
            }
        }
        for layer in 0..layer_count {
            starts[layer + 1] += starts[layer];
        }
        let mut next = starts.clone();
        let mut triangles = vec![0u32; starts[layer_count]];
        for (triangle, &[first, last]) in spans.iter().enumerate() {
            for layer in first..=last {
                triangles[next[layer as usize]] = triangle as u32;
                next[layer as usize] += 1;
            }
        }
        Layers { starts, triangles }
    }
}

/// Lists of triangles per layer.
pub(super) struct Layers {
    /// Where a layer's list starts, and the end of the last.
    starts: Vec<usize>,
    triangles: Vec<u32>,
}

impl Layers {
    pub(super) fn count(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn of(&self, layer: usize) -> &[u32] {
        &self.triangles[self.starts[layer]..self.starts[layer + 1]]
    }
}
