//! From occupancy to the medium: voxels averaged 2x2x2, again and again, down to the lattice, as Steele and
//! Geist do; then one class per site by majority, and area per volume.
//!
//! The averages of halvings are dyadic fractions that f64 holds exactly, so the mean density is the same at
//! every level, to the bit. Where the voxels along a site are 2^a x q with q odd, one average over q^3
//! comes last.

use flb_format::Medium;
use flb_format::matter::{Class, rounded};

use crate::voxelise::{AREA_UNITS_PER_SITE_FACE, CLUSTER_EDGE, Cluster, Occupancy, VoxelError};

#[cfg(test)]
mod tests;

/// Halvings of a cluster until one place of the level is left of it.
const CLUSTER_HALVINGS: u32 = CLUSTER_EDGE.ilog2();

/// Shares of occupied voxels on a grid between voxels and lattice; sparse: only what is not 0.
#[derive(Debug, Clone, PartialEq)]
pub struct ShareGrid {
    /// Places per edge.
    pub edge: u32,
    /// Sorted by index, unique.
    pub shares: Vec<OccupiedShares>,
}

/// Shares of the voxels of one place that are occupied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OccupiedShares {
    /// `(z * edge + y) * edge + x`.
    pub index: u64,
    /// Share of the voxels that leaf touches.
    pub leaf: f64,
    /// Share of the voxels that wood touches.
    pub wood: f64,
    /// Share of the voxels that leaf or wood touches: a voxel with both counts once.
    pub either: f64,
}

impl ShareGrid {
    /// The voxels themselves, halved 0 to 3 times; memory goes with the places that are not 0.
    fn of_voxels(occupancy: &Occupancy, halvings: u32) -> ShareGrid {
        let edge = occupancy.voxels() >> halvings;
        let mut shares = Vec::new();
        for cluster in occupancy.clusters() {
            let [leaf, wood, either] = cluster_shares(cluster, halvings);
            let inner_edge = (CLUSTER_EDGE >> halvings) as usize;
            let start = cluster.position.map(|c| u64::from(c) * inner_edge as u64);
            for (inner, &either) in either.iter().enumerate().filter(|(_, either)| **either > 0.0) {
                let [x, y, z] =
                    [inner % inner_edge, inner / inner_edge % inner_edge, inner / inner_edge / inner_edge];
                let [x, y, z] = [start[0] + x as u64, start[1] + y as u64, start[2] + z as u64];
                let index = (z * u64::from(edge) + y) * u64::from(edge) + x;
                shares.push(OccupiedShares { index, leaf: leaf[inner], wood: wood[inner], either });
            }
        }
        shares.sort_unstable_by_key(|shares| shares.index);
        ShareGrid { edge, shares }
    }

    /// The next coarser level: averages over `factor`^3 places. `factor` divides the edge.
    fn averaged(&self, factor: u32) -> ShareGrid {
        let (from, factor) = (u64::from(self.edge), u64::from(factor));
        let edge = from / factor;
        let parent_of = |index: u64| {
            let [x, y, z] = [index % from, index / from % from, index / from / from].map(|c| c / factor);
            (z * edge + y) * edge + x
        };
        let mut parts: Vec<OccupiedShares> =
            self.shares.iter().map(|&part| OccupiedShares { index: parent_of(part.index), ..part }).collect();
        // Stable: the parts of a place keep their order, so their sum is the same on every machine.
        parts.sort_by_key(|part| part.index);
        let volume = (factor * factor * factor) as f64;
        let of_place = |parts: &[OccupiedShares]| {
            let mean = |pick: fn(&OccupiedShares) -> f64| parts.iter().map(pick).sum::<f64>() / volume;
            OccupiedShares {
                index: parts[0].index,
                leaf: mean(|p| p.leaf),
                wood: mean(|p| p.wood),
                either: mean(|p| p.either),
            }
        };
        ShareGrid {
            edge: edge as u32,
            shares: parts.chunk_by(|a, b| a.index == b.index).map(of_place).collect(),
        }
    }

    /// Mean density over the whole grid.
    pub fn mean_density(&self) -> f64 {
        self.shares.iter().map(|shares| shares.either).sum::<f64>() / (u64::from(self.edge).pow(3) as f64)
    }
}

/// A cluster's shares, `[leaf, wood, either][z][y][x]`, after 0 to 3 halvings.
fn cluster_shares(cluster: &Cluster, halvings: u32) -> [Vec<f64>; 3] {
    let either = std::array::from_fn(|z| cluster.leaf[z] | cluster.wood[z]);
    [cluster.leaf, cluster.wood, either].map(|words: [u64; 8]| {
        if halvings == CLUSTER_HALVINGS {
            // Three averages of bits are their count over 512, to the bit.
            return vec![f64::from(words.iter().map(|word| word.count_ones()).sum::<u32>()) / 512.0];
        }
        let mut shares: Vec<f64> = (0..512).map(|i| (words[i / 64] >> (i % 64) & 1) as f64).collect();
        let mut edge = CLUSTER_EDGE as usize;
        for _ in 0..halvings {
            shares = halved(&shares, edge);
            edge /= 2;
        }
        shares
    })
}

/// Averages of a dense cube of values over 2x2x2.
fn halved(values: &[f64], edge: usize) -> Vec<f64> {
    let half = edge / 2;
    let mean = |i: usize| {
        let [x, y, z] = [i % half, i / half % half, i / half / half].map(|c| 2 * c);
        let row = |y: usize, z: usize| {
            let at = (z * edge + y) * edge + x;
            values[at] + values[at + 1]
        };
        (row(y, z) + row(y + 1, z) + row(y, z + 1) + row(y + 1, z + 1)) / 8.0
    };
    (0..half * half * half).map(mean).collect()
}

/// The levels from `first` halvings of the voxels (0: the voxels themselves; at most 3 and at most what the
/// site allows) down to the lattice, which is the last.
pub fn levels(occupancy: &Occupancy, first: u32) -> impl Iterator<Item = ShareGrid> {
    let lattice = occupancy.grid().lattice;
    let first = first.min(CLUSTER_HALVINGS).min((occupancy.voxels() / lattice).trailing_zeros());
    std::iter::successors(Some(ShareGrid::of_voxels(occupancy, first)), move |level| {
        let per_site = level.edge / lattice;
        match per_site {
            1 => None,
            _ if per_site.is_multiple_of(2) => Some(level.averaged(2)),
            odd => Some(level.averaged(odd)),
        }
    })
}

/// Downsamples an occupancy to its lattice. Density is the share of a site's voxels that are occupied; the
/// class is wood where wood touches more voxels than leaf does; area densities are area / `spacing_m^3`, rounded
/// ([`flb_format::matter::rounded`]). A site is `Empty` exactly where its density is 0, and then has no area.
///
/// # Errors
/// None for an occupancy that [`crate::voxelise()`] made; the result leaves room for limits.
pub fn downsample(occupancy: &Occupancy) -> Result<Medium, VoxelError> {
    let grid = *occupancy.grid();
    let lattice = levels(occupancy, CLUSTER_HALVINGS).last().expect("the first level exists");
    let mut medium = Medium::empty(grid);
    for shares in &lattice.shares {
        let site = shares.index as usize;
        medium.density[site] = shares.either as f32;
        medium.class[site] = if shares.wood > shares.leaf { Class::Wood } else { Class::Leaf };
    }
    // units * spacing^2 / units per face / spacing^3
    let density_of = |units: u64| rounded((units as f64 / AREA_UNITS_PER_SITE_FACE / grid.spacing_m) as f32);
    for area in occupancy.areas() {
        let site = area.site as usize;
        // Rounding alone could leave area in a site that no voxel represents.
        if medium.density[site] > 0.0 {
            medium.leaf_area_density[site] = density_of(area.leaf);
            medium.wood_area_density[site] = density_of(area.wood);
        }
    }
    Ok(medium)
}
