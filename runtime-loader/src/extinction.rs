//! A species' extinction, kept where there is some, for rays that ask how much light comes through.
//!
//! ```text
//! TurbidMedium (dense) -of-> Extinction: blocks of 4^3 sites that hold matter, optical depth per site edge
//! ```
//!
//! Two of three sites of a block are air. So a block is a mask of 64 bits, and the depths of the sites whose bits are
//! set: the default oak takes 1.2 MB, where 64 pairs a block took 3.4.
//!
//! A ray goes from face to face, through empty blocks in one step (3D DDA over two sizes of cells; Amanatides and Woo
//! 1987). All is in binary32, in the order in which `gpu/near.wgsl` does it, so that both agree but for rounding.

use flb_format::Grid;
use flb_format::blocks::BlockMap;
use flb_format::matter::{LeafAngles, TurbidMedium};

/// Sites along an edge of a block.
const EDGE: u32 = 4;
/// Sites of a block.
const BLOCK_SITES: usize = 64;
/// Memory of a block besides the depths of its sites.
pub const BLOCK_BYTES: u64 = size_of::<Block>() as u64;
/// Memory of the depths of a site.
pub const DEPTHS_BYTES: u64 = size_of::<[f32; 2]>() as u64;
/// A component of a direction that is nearer to 0 is taken for this, so that nothing is divided by 0.
const STEEP: f32 = 1e-12;

/// The extinction of a species.
#[derive(Debug, Clone)]
pub struct Extinction {
    grid: Grid,
    angles: LeafAngles,
    map: BlockMap,
    /// `[rank]`
    blocks: Vec<Block>,
    /// Of the sites of all blocks: by leaves and by wood, in the mean over all directions.
    depths: Vec<[f32; 2]>,
}

/// The sites of a block that hold matter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// Bit `[z][y][x]`: the site holds matter.
    pub mask: u64,
    /// First of its depths, which are in the order of the bits.
    pub first: u32,
}

/// End of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Travel {
    /// Outside the lattice, behind this optical depth.
    Out {
        /// Optical depth from the ray's start.
        depth: f32,
    },
    /// The optical depth reached the limit, so many site edges from the ray's start.
    Stopped {
        /// Distance from the ray's start, site edges.
        t: f32,
    },
}

/// A ray that is followed, in lattice coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Start of the ray, in lattice coordinates.
    pub point: [f32; 3],
    /// Direction of travel, unit length.
    pub direction: [f32; 3],
    /// Extinction of leaves for this direction, relative to its mean over directions.
    pub relative: f32,
}

impl Extinction {
    /// Packs a dense turbid medium: only blocks with matter are kept.
    pub fn of(turbid: &TurbidMedium) -> Extinction {
        let grid = turbid.grid;
        let edge = grid.lattice / EDGE;
        let mut bits = vec![0u8; (edge as usize).pow(3).div_ceil(8)];
        let all = || (0..).zip(turbid.leaf_per_m.iter().zip(&turbid.wood_per_m));
        let block_of = |site: usize| grid.site(site).map(|c| c / EDGE);
        for (site, _) in all().filter(|(_, (leaf, wood))| **leaf + **wood > 0.0) {
            let code = morton(block_of(site));
            bits[code / 8] |= 1 << (code % 8);
        }
        // A map has a block; where no matter is, it is one without.
        if bits.iter().all(|byte| *byte == 0) {
            bits[0] = 1;
        }
        let map = BlockMap::from_bytes(&bits, grid.lattice).expect("a bit for each block, one of them set");
        let depth = |per_m: f32| (f64::from(per_m) * grid.spacing_m) as f32;
        let (mut blocks, mut depths) = (Vec::with_capacity(map.len()), Vec::new());
        for rank in 0..map.len() {
            let corner = map.block(rank).map(|c| c * EDGE);
            let mut block = Block { mask: 0, first: depths.len() as u32 }; // a lattice has up to 2^24 sites
            for place in 0..BLOCK_SITES as u32 {
                let site = site_of_block(&grid, corner, place);
                let both = [turbid.leaf_per_m[site], turbid.wood_per_m[site]].map(depth);
                if both != [0.0; 2] {
                    block.mask |= 1 << place;
                    depths.push(both);
                }
            }
            blocks.push(block);
        }
        depths.shrink_to_fit();
        Extinction { grid, angles: turbid.angles.clone(), map, blocks, depths }
    }

    /// Returns the dense medium, per metre, equal to the packed one but for the last bit.
    pub fn to_dense(&self) -> TurbidMedium {
        let sites = self.grid.sites();
        let (mut leaf_per_m, mut wood_per_m) = (vec![0.0; sites], vec![0.0; sites]);
        let per_m = |depth: f32| (f64::from(depth) / self.grid.spacing_m) as f32;
        for (site, depths) in self.sites().zip(&self.depths) {
            [leaf_per_m[site], wood_per_m[site]] = depths.map(per_m);
        }
        TurbidMedium { grid: self.grid, leaf_per_m, wood_per_m, angles: self.angles.clone() }
    }

    /// Sites that hold matter, in the order of [`Extinction::depths`].
    pub fn sites(&self) -> impl Iterator<Item = usize> {
        self.blocks.iter().enumerate().flat_map(move |(rank, block)| {
            let corner = self.map.block(rank).map(|c| c * EDGE);
            let places = (0..BLOCK_SITES as u32).filter(|place| block.mask >> place & 1 == 1);
            places.map(move |place| site_of_block(&self.grid, corner, place))
        })
    }

    /// Grid of the lattice in model space.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Distribution of leaf inclinations.
    pub fn angles(&self) -> &LeafAngles {
        &self.angles
    }

    /// Map of the blocks that hold matter.
    pub fn map(&self) -> &BlockMap {
        &self.map
    }

    /// The blocks of the map, by rank.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Optical depths along the edge of a site by leaves and by wood, as the blocks point to them.
    pub fn depths(&self) -> &[[f32; 2]] {
        &self.depths
    }

    /// Memory that it takes.
    pub fn size_bytes(&self) -> usize {
        size_of_val(&self.blocks[..]) + size_of_val(&self.depths[..]) + self.map.size_bytes()
    }

    /// A point of model space in lattice coordinates.
    pub fn lattice_from_model(&self, point_model_m: [f32; 3]) -> [f32; 3] {
        self.grid.lattice_from_model(point_model_m.map(f64::from)).map(|c| c as f32)
    }

    /// A ray from a point, in lattice coordinates, along a unit vector.
    pub fn ray(&self, point: [f32; 3], direction: [f32; 3]) -> Ray {
        Ray { point, direction, relative: self.angles.relative(f64::from(direction[1])) as f32 }
    }

    /// Optical depth along a site's edge in the mean over all directions; the site lies in the lattice.
    pub fn depth(&self, site: [u32; 3]) -> f32 {
        match self.map.rank(site.map(|c| c / EDGE)) {
            Some(rank) => {
                let [leaf, wood] = self.of_block(rank, site);
                leaf + wood
            }
            None => 0.0,
        }
    }

    /// Optical depths of a site by leaves and by wood, in the block of a rank.
    #[inline(always)]
    fn of_block(&self, rank: u32, site: [u32; 3]) -> [f32; 2] {
        let (Block { mask, first }, bit) = (self.blocks[rank as usize], 1_u64 << place(site));
        match mask & bit {
            0 => [0.0; 2],
            _ => self.depths[first as usize + (mask & (bit - 1)).count_ones() as usize],
        }
    }

    /// Follows a ray until it leaves the lattice or has crossed an optical depth.
    pub fn travel(&self, ray: &Ray, most_depth: f32) -> Travel {
        let n = self.grid.lattice as i32;
        let direction = ray.direction.map(|d| if d.abs() < STEEP { STEEP.copysign(d) } else { d });
        let inverse = direction.map(|d| 1.0 / d);
        let (mut enter, mut leave) = (0.0_f32, f32::INFINITY);
        for (point, inverse) in ray.point.iter().zip(&inverse) {
            let ends = [-point * inverse, (n as f32 - point) * inverse];
            enter = enter.max(ends[0].min(ends[1]));
            leave = leave.min(ends[0].max(ends[1]));
        }
        if enter >= leave || !ray.point.iter().all(|c| c.is_finite()) {
            return Travel::Out { depth: 0.0 };
        }
        let at = |axis: usize, t: f32| libm::floorf(ray.point[axis] + direction[axis] * t) as i32;
        let mut site: [i32; 3] = std::array::from_fn(|axis| at(axis, enter).clamp(0, n - 1));
        let (mut t, mut depth) = (enter, 0.0_f32);
        loop {
            let rank = self.map.rank(site.map(|c| c as u32 / EDGE));
            let (size, per_edge) = match rank {
                Some(rank) => {
                    let [leaf, wood] = self.of_block(rank, site.map(|c| c as u32));
                    (1, leaf * ray.relative + wood)
                }
                None => (EDGE as i32, 0.0),
            };
            let low = site.map(|c| c & -size);
            let face = |axis: usize| low[axis] + if direction[axis] > 0.0 { size } else { 0 };
            let ends: [f32; 3] =
                std::array::from_fn(|axis| (face(axis) as f32 - ray.point[axis]) * inverse[axis]);
            let axis = match ends {
                [x, y, z] if x <= y && x <= z => 0,
                [_, y, z] if y <= z => 1,
                _ => 2,
            };
            let end = ends[axis].max(t);
            depth += per_edge * (end - t);
            if depth > most_depth {
                return Travel::Stopped { t: end - (depth - most_depth) / per_edge };
            }
            t = end;
            for other in 0..3 {
                // Onwards only, and in the cell that is left, whatever was rounded.
                let [first, last] = match direction[other] > 0.0 {
                    true => [site[other], low[other] + size - 1],
                    false => [low[other], site[other]],
                };
                site[other] = at(other, t).clamp(first, last);
            }
            site[axis] = if direction[axis] > 0.0 { low[axis] + size } else { low[axis] - 1 };
            if !(0..n).contains(&site[axis]) {
                return Travel::Out { depth };
            }
        }
    }
}

/// Place of a site in its block.
fn place([x, y, z]: [u32; 3]) -> usize {
    (((z % EDGE) * EDGE + y % EDGE) * EDGE + x % EDGE) as usize
}

fn morton(block: [u32; 3]) -> usize {
    flb_format::blocks::map::encode(block) as usize
}

/// A site of a block, by its bit.
fn site_of_block(grid: &Grid, [x, y, z]: [u32; 3], place: u32) -> usize {
    grid.index(x + place % EDGE, y + place / EDGE % EDGE, z + place / (EDGE * EDGE))
}

#[cfg(test)]
mod tests;
