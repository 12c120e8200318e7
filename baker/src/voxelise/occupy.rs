//! From triangles to clusters: layer by layer of clusters along z, each by one thread.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::Scene;
use super::occupancy::{CLUSTER_EDGE, Cluster};
use super::overlap::Overlap;
use super::piece::{MAX_POINTS, Piece, Point, cross};
use super::triangle::{CutTriangle, Snapped, UNITS};
use crate::alpha::{TexelBox, Verdict};

/// How far a voxel is grown, in voxels, before a triangle is clipped to it.
pub(super) const GROWN: f64 = 1.0 / (1u64 << 20) as f64;

/// All clusters that leaf or wood touches, sorted by z, y, x.
pub(super) fn occupy(scene: &Scene, progress: &(dyn Fn(f64) + Sync)) -> Vec<Cluster> {
    let layers = scene.layers(i64::from(CLUSTER_EDGE) * UNITS);
    let done = AtomicUsize::new(0);
    let edge = (scene.voxels / CLUSTER_EDGE) as usize;
    let clusters: Vec<Vec<Cluster>> = (0..layers.count())
        .into_par_iter()
        .with_max_len(1)
        .map_init(
            || vec![0u32; edge * edge],
            |places, layer| {
                let clusters = Layer { z: layer as u16, edge, places, clusters: Vec::new() }
                    .fill(scene, layers.of(layer));
                progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / layers.count() as f64);
                clusters
            },
        )
        .collect();
    clusters.concat()
}

/// One layer of clusters while it fills.
struct Layer<'s> {
    /// Position along z, in clusters.
    z: u16,
    /// Clusters along x and y.
    edge: usize,
    /// `[y][x]`: 1 + the index of the cluster there, 0 for none. All 0 between layers.
    places: &'s mut Vec<u32>,
    clusters: Vec<Cluster>,
}

impl Layer<'_> {
    fn fill(mut self, scene: &Scene, triangles: &[u32]) -> Vec<Cluster> {
        let first = i64::from(self.z) * i64::from(CLUSTER_EDGE);
        let zs = [first, first + i64::from(CLUSTER_EDGE) - 1];
        for triangle in triangles.iter().filter_map(|&triangle| scene.snapped(triangle as usize)) {
            let overlap = Overlap::new(&triangle.vertices);
            match &triangle.cut {
                None => overlap.for_each(zs, |voxel| *self.word(voxel, triangle.wood) |= bit(voxel)),
                Some(cut) => {
                    let cutter = Cutter::new(&triangle, cut);
                    overlap.for_each(zs, |voxel| {
                        let set = self.peek(voxel, triangle.wood) & bit(voxel) != 0;
                        if !set && cutter.present_in(voxel) {
                            *self.word(voxel, triangle.wood) |= bit(voxel);
                        }
                    });
                }
            }
        }
        for cluster in &self.clusters {
            self.places[usize::from(cluster.position[1]) * self.edge + usize::from(cluster.position[0])] = 0;
        }
        self.clusters.sort_unstable_by_key(Cluster::rank);
        self.clusters
    }

    fn place(&self, voxel: [i64; 3]) -> usize {
        (voxel[1] >> 3) as usize * self.edge + (voxel[0] >> 3) as usize
    }

    fn peek(&self, voxel: [i64; 3], wood: bool) -> u64 {
        let index = self.places[self.place(voxel)];
        let Some(cluster) = self.clusters.get((index as usize).wrapping_sub(1)) else { return 0 };
        if wood { cluster.wood[voxel[2] as usize & 7] } else { cluster.leaf[voxel[2] as usize & 7] }
    }

    fn word(&mut self, voxel: [i64; 3], wood: bool) -> &mut u64 {
        let place = self.place(voxel);
        if self.places[place] == 0 {
            self.clusters.push(Cluster::empty([(voxel[0] >> 3) as u16, (voxel[1] >> 3) as u16, self.z]));
            self.places[place] = self.clusters.len() as u32;
        }
        let cluster = &mut self.clusters[self.places[place] as usize - 1];
        if wood { &mut cluster.wood[voxel[2] as usize & 7] } else { &mut cluster.leaf[voxel[2] as usize & 7] }
    }
}

fn bit(voxel: [i64; 3]) -> u64 {
    1 << ((voxel[1] & 7) * 8 + (voxel[0] & 7))
}

/// Decides whether the part of a cut triangle inside a voxel is there.
pub(super) struct Cutter<'a> {
    triangle: &'a CutTriangle<'a>,
    piece: Piece,
    /// Texels per voxel of movement in the triangle's plane, for u and v; `None` for a triangle without area.
    gradients: Option<[[f64; 3]; 2]>,
    /// Position and texel of a vertex, and what a voxel's half edges add to the texel.
    anchor: Point,
    reach: [f64; 2],
    /// Smallest and largest texel coordinates of the triangle.
    ends: [[f64; 2]; 2],
}

impl<'a> Cutter<'a> {
    pub fn new(snapped: &Snapped, triangle: &'a CutTriangle<'a>) -> Cutter<'a> {
        let points: [Point; 3] = std::array::from_fn(|i| Point {
            at: snapped.vertices[i].map(|c| c as f64 / UNITS as f64),
            texel: triangle.texels[i],
        });
        let gradients = gradients(&points);
        // A share of the reach and a part of a texel on top: far more than the rounding of both sides.
        let reach = gradients.map_or([0.0; 2], |gradients| {
            gradients.map(|g| (0.5 + 2.0 * GROWN + 1e-9) * (g[0].abs() + g[1].abs() + g[2].abs()) + 1e-3)
        });
        let end = |pick: fn(f64, f64) -> f64| -> [f64; 2] {
            std::array::from_fn(|axis| {
                points.iter().map(|p| p.texel[axis]).reduce(pick).expect("three points")
            })
        };
        let ends = [end(f64::min), end(f64::max)];
        Cutter { triangle, piece: Piece::triangle(points), gradients, anchor: points[0], reach, ends }
    }

    /// The rule itself: the triangle clipped to the grown voxel touches a present texel.
    pub fn touches(&self, voxel: [i64; 3], touches: impl Fn(&[[f64; 2]], &TexelBox) -> bool) -> bool {
        let piece = self.piece.within_unit_box(voxel.map(|c| c as f64), GROWN);
        touches(piece.texels(&mut [[0.0; 2]; MAX_POINTS]), &self.triangle.within)
    }

    /// The same, without clipping where the texels around the voxel agree.
    pub fn present_in(&self, voxel: [i64; 3]) -> bool {
        let cut = self.triangle.cut;
        match self.texels_around(voxel).map_or(Verdict::Mixed, |texels| cut.verdict(&texels)) {
            Verdict::Absent => false,
            Verdict::Present => true,
            Verdict::Mixed => self.touches(voxel, |piece, within| cut.touches(piece, within)),
        }
    }

    /// A box of texels that holds those of the triangle's part in the voxel.
    fn texels_around(&self, voxel: [i64; 3]) -> Option<TexelBox> {
        let gradients = self.gradients?;
        let from_anchor: [f64; 3] =
            std::array::from_fn(|axis| voxel[axis] as f64 + 0.5 - self.anchor.at[axis]);
        let (mut min, mut max) = ([0.0; 2], [0.0; 2]);
        for axis in 0..2 {
            let g = gradients[axis];
            let centre = self.anchor.texel[axis]
                + (g[0] * from_anchor[0] + g[1] * from_anchor[1] + g[2] * from_anchor[2]);
            min[axis] = (centre - self.reach[axis]).max(self.ends[0][axis]);
            max[axis] = (centre + self.reach[axis]).min(self.ends[1][axis]);
        }
        Some(TexelBox::of(min, max).clamped(&self.triangle.within))
    }
}

/// The gradients of u and v within the triangle's plane.
fn gradients(points: &[Point; 3]) -> Option<[[f64; 3]; 2]> {
    let edge =
        |to: usize| -> [f64; 3] { std::array::from_fn(|axis| points[to].at[axis] - points[0].at[axis]) };
    let (e, f) = (edge(1), edge(2));
    let normal = cross(e, f);
    let square = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    if square == 0.0 {
        return None;
    }
    let (along_e, along_f) = (cross(f, normal), cross(normal, e));
    Some(std::array::from_fn(|axis| {
        let (du, dv) =
            (points[1].texel[axis] - points[0].texel[axis], points[2].texel[axis] - points[0].texel[axis]);
        std::array::from_fn(|i| (du * along_e[i] + dv * along_f[i]) / square)
    }))
}
