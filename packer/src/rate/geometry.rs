//! Which blocks are stored, where errors count, and how much: everything that all bases of a species share.
//!
//! Points spread evenly over the non-empty sites sample trilinearly; the mean square error of those samples is
//! `e^T G e` summed over blocks, with `e` the error of a block's coefficients. `G` depends on geometry alone. It is worked
//! out anew for each pass over a block, since all of them together would not fit in memory at 256^3.

use flb_format::blocks::transform::Rows;
use flb_format::blocks::{BlockMap, EDGE, TEXELS};

use crate::quality::{POINTS_PER_SITE, surface_point};

/// Entries of a block's Gram matrix.
pub const GRAM: usize = TEXELS * TEXELS;

/// Expected products of the linear weights of the texels i-1, i, i+1 over a uniform point of site i.
const SITE: [[f32; 3]; 3] =
    [[1.0 / 24.0, 1.0 / 12.0, 0.0], [1.0 / 12.0, 7.0 / 12.0, 1.0 / 12.0], [0.0, 1.0 / 12.0, 1.0 / 24.0]];

/// What all bases of a species share.
pub struct Geometry {
    /// The stored blocks.
    pub map: BlockMap,
    /// Rows of the transform.
    pub rows: &'static Rows,
    /// Where errors are measured.
    pub points: Points,
    /// `[z][y][x]` sites whose points count in `G`.
    counted: Vec<bool>,
    /// `[site -1..=4][row][row]`: expected products of two rows along an axis.
    products: [[f32; EDGE * EDGE]; EDGE + 2],
}

/// The surface points of [`crate::quality`].
pub struct Points {
    /// Index of the texel with the smallest coordinates, of eight.
    pub first: Vec<u32>,
    /// `[x, y, z]` way to the next texel, 0..=1.
    pub part: Vec<[f32; 3]>,
}

impl Geometry {
    /// Of a lattice whose `non_empty` sites, `[z][y][x]`, hold surfaces.
    pub fn new(lattice: u32, non_empty: &[bool], all_blocks: bool, rows: &'static Rows) -> Geometry {
        let map = if all_blocks { BlockMap::all(lattice) } else { BlockMap::near(lattice, non_empty) };
        // Away from geometry no sample counts; where such blocks are wanted all sites count alike.
        let counted = if map.is_full() { vec![true; non_empty.len()] } else { non_empty.to_vec() };
        Geometry { map, rows, points: Points::new(lattice, non_empty), counted, products: products(rows) }
    }

    /// Sites that count in `G`.
    pub fn counted_sites(&self) -> usize {
        self.counted.iter().filter(|c| **c).count()
    }

    /// `G` of a stored block, `[64][64]`, for coefficients in steps.
    pub fn gram(&self, rank: usize) -> Box<[f32; GRAM]> {
        let n = self.map.lattice() as i32;
        let at = self.map.first_texel(rank).map(|t| t as i32 - 1);
        let mut gram = vec![0.0f32; GRAM];
        for (sz, z_pairs) in self.products.iter().enumerate() {
            let mut plane = [0.0f32; 256];
            for (sy, y_pairs) in self.products.iter().enumerate() {
                let mut row = [0.0f32; 16];
                for (sx, pairs) in self.products.iter().enumerate() {
                    let p = [at[0] + sx as i32, at[1] + sy as i32, at[2] + sz as i32];
                    let inside = p.iter().all(|c| (0..n).contains(c));
                    if inside && self.counted[((p[2] * n + p[1]) * n + p[0]) as usize] {
                        (0..16).for_each(|i| row[i] += pairs[i]);
                    }
                }
                if row[0] > 0.0 {
                    for (y, py) in y_pairs.iter().enumerate() {
                        for (x, px) in row.iter().enumerate() {
                            // [ky][kx][ky'][kx']
                            plane[((y / 4 * 4 + x / 4) * 4 + y % 4) * 4 + x % 4] += py * px;
                        }
                    }
                }
            }
            if plane[0] > 0.0 {
                for (z, pz) in z_pairs.iter().enumerate() {
                    for i in 0..16 {
                        let from = &plane[i * 16..][..16];
                        let to = &mut gram[(z / 4 * 16 + i) * TEXELS + z % 4 * 16..][..16];
                        (0..16).for_each(|j| to[j] += pz * from[j]);
                    }
                }
            }
        }
        gram.into_boxed_slice().try_into().expect("64 x 64 entries")
    }
}

/// For each site -1..=4 along an axis of a block, the expected products of two rows; 1/6 an axis makes a step of row 0
/// orthonormal.
fn products(rows: &Rows) -> [[f32; EDGE * EDGE]; EDGE + 2] {
    std::array::from_fn(|site| {
        std::array::from_fn(|pair| {
            let (j, k) = (pair / EDGE, pair % EDGE);
            let mut sum = 0.0;
            for (a, weights) in SITE.iter().enumerate() {
                for (b, weight) in weights.iter().enumerate() {
                    // Texels from -2: of those in the block, 0..4.
                    let (Some(t), Some(u)) = ((site + a).checked_sub(2), (site + b).checked_sub(2)) else {
                        continue;
                    };
                    if t < EDGE && u < EDGE {
                        sum += weight * (rows[j][t] * rows[k][u]) as f32;
                    }
                }
            }
            sum / 36.0
        })
    })
}

impl Points {
    fn new(lattice: u32, non_empty: &[bool]) -> Points {
        let mut points = Points { first: Vec::new(), part: Vec::new() };
        for site in (0u32..).zip(non_empty).filter(|(_, is)| **is).map(|(site, _)| site) {
            for k in 0..POINTS_PER_SITE {
                let p =
                    surface_point(site, k, lattice).map(|x| (x - 0.5).max(0.0).min(f64::from(lattice - 1)));
                let at = p.map(|x| (x as u32).min(lattice - 2));
                points.first.push((at[2] * lattice + at[1]) * lattice + at[0]);
                points.part.push(std::array::from_fn(|axis| (p[axis] - f64::from(at[axis])) as f32));
            }
        }
        points
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.first.len()
    }

    /// Trilinear sample of `[z][y][x]` values at a point.
    #[inline]
    pub fn sample(&self, point: usize, lattice: usize, values: &[f32]) -> f32 {
        let (first, [x, y, z]) = (self.first[point] as usize, self.part[point]);
        let mix = |a: f32, b: f32, t: f32| a * (1.0 - t) + b * t;
        let row = |i: usize| mix(values[i], values[i + 1], x);
        let plane = |i: usize| mix(row(i), row(i + lattice), y);
        mix(plane(first), plane(first + lattice * lattice), z)
    }
}
