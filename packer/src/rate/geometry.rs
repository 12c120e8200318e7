//! Which blocks are stored, where errors count, and how much: everything that all bases of a species share.
//!
//! Points spread evenly over the non-empty sites sample trilinearly; the mean square error of those samples is `e^T G
//! e` summed over blocks, with `e` the error of a block's coefficients. `G` depends on geometry alone. It is worked out
//! anew for each pass over a block, since all of them together would not fit in memory at 256^3.

use flb_format::blocks::transform::Rows;
use flb_format::blocks::{BlockMap, EDGE, TEXELS};

use super::SampledSites;
use crate::surface::{POINTS_PER_SITE, surface_point};

/// Keeps the descent from moving a coefficient that no sample sees.
const RIDGE: f32 = 1e-4;

/// Of sites without points: those that count, and those that do not.
const OTHER: u32 = u32::MAX - 1;
const NOT_COUNTED: u32 = u32::MAX;

/// A block's Gram matrix.
pub(super) struct Gram {
    /// `[coefficient][coefficient]`
    entries: [f32; TEXELS * TEXELS],
    /// `[coefficient]`: 1 over the entry on the diagonal and a little.
    pub inverse: [f32; TEXELS],
}

/// Expected products of the linear weights of the texels i-1, i, i+1 over a uniform point of site i.
const SITE: [[f32; 3]; 3] =
    [[1.0 / 24.0, 1.0 / 12.0, 0.0], [1.0 / 12.0, 7.0 / 12.0, 1.0 / 12.0], [0.0, 1.0 / 12.0, 1.0 / 24.0]];

/// Pairs of rows of an axis whose order does not matter.
const PAIRS: usize = EDGE * (EDGE + 1) / 2;
/// `[row][row]`: which pair they are.
const PAIR: [usize; EDGE * EDGE] = [0, 1, 2, 3, 1, 4, 5, 6, 2, 5, 7, 8, 3, 6, 8, 9];

/// What all bases of a species share.
pub(super) struct Geometry {
    /// The stored blocks.
    pub map: BlockMap,
    /// Rows of the transform.
    pub rows: &'static Rows,
    /// Points at which errors are measured.
    pub points: Points,
    /// `[z][y][x]`: which of the sites with points it is, if it counts in `G`; [`OTHER`] of a site that counts but has
    /// none.
    counted: Vec<u32>,
    /// `[site -1..=4][row][row]`: expected products of two rows along an axis.
    products: [[f32; EDGE * EDGE]; EDGE + 2],
    /// The same by pair.
    pairs: [[f32; PAIRS]; EDGE + 2],
}

/// The surface points of [`crate::surface`].
pub(super) struct Points {
    /// Index of the texel with the smallest coordinates, of eight.
    pub first: Vec<u32>,
    /// `[x, y, z]` way to the next texel, 0..=1.
    pub part: Vec<[f32; 3]>,
    /// Whether each point lies in a site of leaves.
    pub on_leaves: Vec<bool>,
}

impl Geometry {
    /// Of a lattice with these sites.
    pub(super) fn new(lattice: u32, sites: SampledSites, all_blocks: bool, rows: &'static Rows) -> Geometry {
        let non_empty = sites.all;
        let map = if all_blocks { BlockMap::all(lattice) } else { BlockMap::near(lattice, non_empty) };
        // Away from geometry no sample counts; where such blocks are wanted all sites count alike.
        let other = if map.is_full() { OTHER } else { NOT_COUNTED };
        let mut with_points = 0u32..;
        let counted = non_empty
            .iter()
            .map(|is| if *is { with_points.next().expect("fewer than 2^32 sites") } else { other })
            .collect();
        let products = products(rows);
        let mut pairs = [[0.0; PAIRS]; EDGE + 2];
        for (pairs, products) in pairs.iter_mut().zip(&products) {
            // Of a pair's two orders, whose sums may differ by rounding, the first one counts.
            PAIR.iter().zip(products).rev().for_each(|(pair, product)| pairs[*pair] = *product);
        }
        let points = Points::new(lattice, sites);
        Geometry { map, rows, points, counted, products, pairs }
    }

    /// Sites that count in `G`.
    pub(super) fn counted_sites(&self) -> usize {
        self.counted.iter().filter(|c| **c != NOT_COUNTED).count()
    }

    /// `G` of a stored block, for coefficients in steps; of sites with points as heavy as `weights` says, if it does.
    #[inline(always)]
    pub(super) fn gram(&self, rank: usize, weights: Option<&[f32]>) -> Box<Gram> {
        let n = self.map.lattice() as i32;
        let [x0, y0, z0] = self.map.first_texel(rank).map(|t| t as i32 - 1);
        // An axis at a time, pairs of rows side by side: [z pair][y pair][x row][x row].
        let mut pairs = [[0.0f32; PAIRS * 16]; PAIRS];
        for (z, z_pairs) in (z0..).zip(&self.pairs).filter(|(z, _)| (0..n).contains(z)) {
            let mut plane = [[0.0f32; 16]; PAIRS];
            for (y, y_pairs) in (y0..).zip(&self.pairs).filter(|(y, _)| (0..n).contains(y)) {
                let mut row = [0.0f32; 16];
                for (x, x_pairs) in (x0..).zip(&self.products).filter(|(x, _)| (0..n).contains(x)) {
                    let weight = match (self.counted[((z * n + y) * n + x) as usize], weights) {
                        (NOT_COUNTED, _) => continue,
                        (OTHER, _) | (_, None) => 1.0,
                        (site, Some(weights)) => weights[site as usize],
                    };
                    (0..16).for_each(|i| row[i] += weight * x_pairs[i]);
                }
                if row[0] > 0.0 {
                    for (plane, y) in plane.iter_mut().zip(y_pairs) {
                        (0..16).for_each(|i| plane[i] += y * row[i]);
                    }
                }
            }
            if plane[0][0] > 0.0 {
                let plane = plane.as_flattened();
                for (pairs, z) in pairs.iter_mut().zip(z_pairs) {
                    (0..PAIRS * 16).for_each(|i| pairs[i] += z * plane[i]);
                }
            }
        }
        let mut gram = Box::new(Gram { entries: [0.0; TEXELS * TEXELS], inverse: [0.0; TEXELS] });
        for (z, pair) in PAIR.iter().enumerate() {
            let pairs = pairs[*pair].as_chunks::<16>().0;
            for (y, pair) in PAIR.iter().enumerate() {
                for (x, pairs) in pairs[*pair].as_chunks::<4>().0.iter().enumerate() {
                    let row = (z / 4 * 4 + y / 4) * 4 + x;
                    gram.entries[row * TEXELS + (z % 4 * 4 + y % 4) * 4..][..4].copy_from_slice(pairs);
                }
            }
        }
        for i in 0..TEXELS {
            gram.inverse[i] = 1.0 / (gram.row(i)[i] + RIDGE);
        }
        gram
    }
}

impl Gram {
    /// Entries of coefficient `i`.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> &[f32; TEXELS] {
        &self.entries.as_chunks::<TEXELS>().0[i % TEXELS]
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
    fn new(lattice: u32, sites: SampledSites) -> Points {
        let mut points = Points { first: Vec::new(), part: Vec::new(), on_leaves: Vec::new() };
        for site in (0u32..).zip(sites.all).filter(|(_, is)| **is).map(|(site, _)| site) {
            for k in 0..POINTS_PER_SITE {
                let p =
                    surface_point(site, k, lattice).map(|x| (x - 0.5).max(0.0).min(f64::from(lattice - 1)));
                let at = p.map(|x| (x as u32).min(lattice - 2));
                points.on_leaves.push(sites.leaves[site as usize]);
                points.first.push((at[2] * lattice + at[1]) * lattice + at[0]);
                points.part.push(std::array::from_fn(|axis| (p[axis] - f64::from(at[axis])) as f32));
            }
        }
        points
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.first.len()
    }

    /// Trilinear sample of `[z][y][x]` values at a point.
    #[inline]
    pub(super) fn sample(&self, point: usize, lattice: usize, values: &[f32]) -> f32 {
        let (first, [x, y, z]) = (self.first[point] as usize, self.part[point]);
        let mix = |a: f32, b: f32, t: f32| a * (1.0 - t) + b * t;
        let row = |i: usize| mix(values[i], values[i + 1], x);
        let plane = |i: usize| mix(row(i), row(i + lattice), y);
        mix(plane(first), plane(first + lattice * lattice), z)
    }
}
