//! From triangles to clusters: in layers of clusters along z, each by one thread.

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_format::progress::{Cancelled, Progress};
use rayon::prelude::*;

use super::Scene;
use super::clips::Clips;
use super::cutter::Cutter;
use super::occupancy::{CLUSTER_EDGE, Cluster};
use super::overlap::Overlap;
use super::triangle::UNITS;

/// Clusters that a layer is thick: most triangles then lie in one layer, and there still are enough for many threads.
const THICKNESS: usize = 4;

/// All clusters that leaf or wood touches, sorted by z, y, x.
pub(super) fn occupy(scene: &Scene, progress: &Progress<'_>) -> Result<Vec<Cluster>, Cancelled> {
    let layers = scene.layers(THICKNESS as i64 * i64::from(CLUSTER_EDGE) * UNITS);
    let done = AtomicUsize::new(0);
    let edge = (scene.voxels / CLUSTER_EDGE) as usize;
    let clusters = (0..layers.count())
        .into_par_iter()
        .with_max_len(1)
        .map_init(
            || vec![0u32; THICKNESS * edge * edge],
            |places, layer| {
                let clusters = Layer { z: layer * THICKNESS, edge, places, clusters: Vec::new() }
                    .fill(scene, layers.of(layer));
                progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / layers.count() as f64)?;
                Ok(clusters)
            },
        )
        .collect::<Result<Vec<Vec<Cluster>>, Cancelled>>()?;
    Ok(clusters.concat())
}

/// One layer while it fills.
struct Layer<'s> {
    /// First position along z, in clusters.
    z: usize,
    /// Clusters along x and y.
    edge: usize,
    /// `[z][y][x]`: 1 + the index of the cluster there, 0 for none. All 0 between layers.
    places: &'s mut Vec<u32>,
    clusters: Vec<Cluster>,
}

impl Layer<'_> {
    fn fill(mut self, scene: &Scene, triangles: &[u32]) -> Vec<Cluster> {
        let first = self.z as i64 * i64::from(CLUSTER_EDGE);
        let zs = [first, first + THICKNESS as i64 * i64::from(CLUSTER_EDGE) - 1];
        let mut clips = Clips::new();
        for triangle in triangles.iter().filter_map(|&triangle| scene.snapped(triangle as usize)) {
            let overlap = Overlap::new(&triangle.vertices);
            let wood = triangle.wood;
            match &triangle.cut {
                None => overlap.for_each(
                    zs,
                    |_| false,
                    |voxel, candidate| {
                        if self.peek(voxel, wood) & bit(voxel) == 0 && candidate.touched() {
                            *self.word(voxel, wood) |= bit(voxel);
                        }
                    },
                ),
                Some(cut) => {
                    let cutter = Cutter::new(&triangle, cut, overlap.along(), &mut clips);
                    let absent = |square| cutter.absent_in(square);
                    overlap.for_each(zs, absent, |voxel, candidate| {
                        let set = self.peek(voxel, wood) & bit(voxel) != 0;
                        if !set && candidate.touched() && cutter.present_in(voxel) {
                            *self.word(voxel, wood) |= bit(voxel);
                        }
                    });
                }
            }
        }
        for cluster in &self.clusters {
            let [x, y, z] = cluster.position.map(usize::from);
            self.places[((z - self.z) * self.edge + y) * self.edge + x] = 0;
        }
        self.clusters.sort_unstable_by_key(Cluster::rank);
        self.clusters
    }

    fn place(&self, voxel: [i64; 3]) -> usize {
        let [x, y, z] = voxel.map(|at| (at >> 3) as usize);
        ((z - self.z) * self.edge + y) * self.edge + x
    }

    fn peek(&self, voxel: [i64; 3], wood: bool) -> u64 {
        let index = self.places[self.place(voxel)];
        let Some(cluster) = self.clusters.get((index as usize).wrapping_sub(1)) else { return 0 };
        if wood { cluster.wood[voxel[2] as usize & 7] } else { cluster.leaf[voxel[2] as usize & 7] }
    }

    fn word(&mut self, voxel: [i64; 3], wood: bool) -> &mut u64 {
        let place = self.place(voxel);
        if self.places[place] == 0 {
            self.clusters.push(Cluster::empty(voxel.map(|at| (at >> 3) as u16)));
            self.places[place] = self.clusters.len() as u32;
        }
        let cluster = &mut self.clusters[self.places[place] as usize - 1];
        if wood { &mut cluster.wood[voxel[2] as usize & 7] } else { &mut cluster.leaf[voxel[2] as usize & 7] }
    }
}

fn bit(voxel: [i64; 3]) -> u64 {
    1 << ((voxel[1] & 7) * 8 + (voxel[0] & 7))
}
