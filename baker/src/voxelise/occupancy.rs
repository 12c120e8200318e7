//! What voxelising makes: sparse masks of voxels and areas of sites.

use flb_format::Grid;
use flb_format::sample::site_of;

use super::{LATTICES, MAX_VOXELS, VoxelError};

/// Voxels along an edge of a [`Cluster`].
pub const CLUSTER_EDGE: u32 = 8;

/// Units of [`SiteArea`] in one face of a site, `spacing_m^2`.
pub const AREA_UNITS_PER_SITE_FACE: f64 = (1u64 << 36) as f64;

/// 8^3 voxels, some of them occupied. Bit `y * 8 + x` of word `z` is voxel (x, y, z) of the cluster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cluster {
    /// Position in clusters, x, y, z; voxel (0, 0, 0) of the cluster is voxel `8 * position` of the grid.
    pub position: [u16; 3],
    /// Voxels that leaf touches.
    pub leaf: [u64; 8],
    /// Voxels that wood touches.
    pub wood: [u64; 8],
}

impl Cluster {
    /// A cluster without occupied voxels.
    pub(crate) fn empty(position: [u16; 3]) -> Cluster {
        Cluster { position, leaf: [0; 8], wood: [0; 8] }
    }

    /// Order of storage: z, then y, then x.
    pub(crate) fn rank(&self) -> [u16; 3] {
        let [x, y, z] = self.position;
        [z, y, x]
    }
}

/// Surface inside one site, in units of `spacing_m^2 / 2^36`; sums saturate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SiteArea {
    /// Index of the site in `[z][y][x]` order, x fastest.
    pub site: u32,
    /// One-sided area of leaf, absent texels left out.
    pub leaf: u64,
    /// One-sided area of wood, absent texels left out.
    pub wood: u64,
}

/// A voxelised plant. Invariants, kept by its makers: `voxels` is a multiple of the lattice and of 8,
/// at most 4096; clusters are sorted by z, y, x, unique, inside the grid and not empty; areas are sorted
/// by site, unique, inside the lattice and not both 0; the outer two layers of sites hold nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Occupancy {
    grid: Grid,
    voxels: u32,
    clusters: Vec<Cluster>,
    areas: Vec<SiteArea>,
}

impl Occupancy {
    /// From stages that keep the invariants by construction.
    pub(crate) fn from_stages(
        grid: Grid,
        voxels: u32,
        clusters: Vec<Cluster>,
        areas: Vec<SiteArea>,
    ) -> Occupancy {
        let occupancy = Occupancy { grid, voxels, clusters, areas };
        debug_assert_eq!(occupancy.check(), Ok(()));
        occupancy
    }

    /// Makes an occupancy from parts of unknown origin.
    ///
    /// # Errors
    /// The first invariant that does not hold.
    pub fn from_parts(
        grid: Grid,
        voxels: u32,
        clusters: Vec<Cluster>,
        areas: Vec<SiteArea>,
    ) -> Result<Occupancy, VoxelError> {
        let occupancy = Occupancy { grid, voxels, clusters, areas };
        occupancy.check()?;
        Ok(occupancy)
    }

    /// The lattice in model space.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Voxels per edge of the grid; the voxel grid covers exactly the lattice.
    pub fn voxels(&self) -> u32 {
        self.voxels
    }

    /// Sorted by z, y, x.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// Sorted by site.
    pub fn areas(&self) -> &[SiteArea] {
        &self.areas
    }

    /// Voxels that leaf, wood and either touch.
    pub fn counts(&self) -> [u64; 3] {
        let count = |words: &[u64; 8]| words.iter().map(|word| u64::from(word.count_ones())).sum::<u64>();
        self.clusters.iter().fold([0; 3], |[leaf, wood, either], cluster| {
            let both = std::array::from_fn(|z| cluster.leaf[z] | cluster.wood[z]);
            [leaf + count(&cluster.leaf), wood + count(&cluster.wood), either + count(&both)]
        })
    }

    /// Leaf and wood area in m^2.
    pub fn area_m2(&self) -> [f64; 2] {
        let unit = self.grid.spacing_m * self.grid.spacing_m / AREA_UNITS_PER_SITE_FACE;
        let sums = self.areas.iter().fold([0u128; 2], |[leaf, wood], area| {
            [leaf + u128::from(area.leaf), wood + u128::from(area.wood)]
        });
        sums.map(|sum| sum as f64 * unit)
    }

    fn check(&self) -> Result<(), VoxelError> {
        let fault =
            |place: &str, fault: String| Err(VoxelError::Occupancy { place: place.to_owned(), fault });
        let Grid { lattice, origin_m, spacing_m } = self.grid;
        if !lattice.is_power_of_two() || !(LATTICES[0]..=LATTICES[1]).contains(&lattice) {
            return Err(VoxelError::Lattice { found: lattice });
        }
        if self.voxels == 0
            || self.voxels > MAX_VOXELS
            || !self.voxels.is_multiple_of(lattice)
            || !self.voxels.is_multiple_of(CLUSTER_EDGE)
        {
            return Err(VoxelError::Voxels { found: self.voxels, lattice, limit: MAX_VOXELS });
        }
        let finite = spacing_m.is_finite() && origin_m.iter().all(|c| c.is_finite());
        if !finite || spacing_m <= 0.0 {
            return fault(
                "grid",
                format!("origin {origin_m:?}, spacing {spacing_m}: expected finite, spacing above 0"),
            );
        }
        if let Some(pair) = self.clusters.windows(2).find(|pair| pair[0].rank() >= pair[1].rank()) {
            return fault(
                "clusters",
                format!("{:?} is stored before {:?}", pair[0].position, pair[1].position),
            );
        }
        let edge = self.voxels / lattice;
        let inside = 2 * edge..self.voxels - 2 * edge;
        for cluster in &self.clusters {
            let either: [u64; 8] = std::array::from_fn(|z| cluster.leaf[z] | cluster.wood[z]);
            let Some([low, high]) = bounds_of(&either) else {
                return fault("clusters", format!("{:?} is empty", cluster.position));
            };
            for axis in 0..3 {
                let first = u32::from(cluster.position[axis]) * CLUSTER_EDGE;
                if !inside.contains(&(first + low[axis])) || !inside.contains(&(first + high[axis])) {
                    let expected = format!("voxels {} to {} only", inside.start, inside.end - 1);
                    return fault(
                        "clusters",
                        format!("{:?}: expected occupied {expected}", cluster.position),
                    );
                }
            }
        }
        if let Some(pair) = self.areas.windows(2).find(|pair| pair[0].site >= pair[1].site) {
            return fault("areas", format!("site {} is stored before site {}", pair[0].site, pair[1].site));
        }
        for area in &self.areas {
            let [x, y, z] = site_of(area.site as usize, lattice);
            if (area.leaf == 0 && area.wood == 0) || [x, y, z].iter().any(|c| !(2..lattice - 2).contains(c)) {
                let found =
                    format!("site {} ({x}, {y}, {z}) with areas {} and {}", area.site, area.leaf, area.wood);
                return fault(
                    "areas",
                    format!("{found}: expected an area, and none in the outer two layers"),
                );
            }
        }
        Ok(())
    }
}

/// Smallest and largest x, y, z of the set bits.
fn bounds_of(words: &[u64; 8]) -> Option<[[u32; 3]; 2]> {
    let plane = words.iter().fold(0, |plane, word| plane | word);
    if plane == 0 {
        return None;
    }
    let row = (0..8).fold(0u64, |row, y| row | (plane >> (8 * y) & 0xff));
    let first = words.iter().position(|&word| word != 0)? as u32;
    let last = words.iter().rposition(|&word| word != 0)? as u32;
    let low = [row.trailing_zeros(), plane.trailing_zeros() / 8, first];
    Some([low, [63 - row.leading_zeros(), (63 - plane.leading_zeros()) / 8, last]])
}
