//! One collision for four bases at once: arriving light of a site -> outgoing light, f32.
//!
//! The 18x18 gain matrix depends only on the angle between two directions, so it splits by opposite
//! pairs into an even part (acting on f_m + f_opp) and an odd part (acting on f_m - f_opp), and
//! inside each part only five (three) different angles occur. Sums shared between rows then leave about 145
//! operations of the 324 multiply-adds. The plain matrix product is the oracle.

use std::ops::{Add, Mul, Sub};

use super::collision::Matrix;

/// Bases that one solve carries side by side.
pub const LANES: usize = 4;

/// One number per base; plain element-wise arithmetic that LLVM turns into vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(align(16))]
pub struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(value: f32) -> Lanes {
        Lanes([value; LANES])
    }
}

impl Add for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn add(self, other: Lanes) -> Lanes {
        let (a, b) = (self.0, other.0);
        Lanes([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
    }
}

impl Sub for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn sub(self, other: Lanes) -> Lanes {
        let (a, b) = (self.0, other.0);
        Lanes([a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]])
    }
}

impl Mul for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn mul(self, other: Lanes) -> Lanes {
        let (a, b) = (self.0, other.0);
        Lanes([a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]])
    }
}

/// The distinct entries of a gain matrix. "Axis" and "diagonal" name receiver, then giver; the number
/// is the cosine between them; `_excess` is what an entry has beyond the one that its shared sum covers.
#[derive(Debug, Clone, Copy)]
pub struct Gain {
    even: Even,
    odd: Odd,
}

/// Acts on sums of opposite directions.
#[derive(Debug, Clone, Copy)]
struct Even {
    axis_axis: Lanes,
    axis_axis_excess: Lanes,
    axis_diagonal: Lanes,
    axis_plane_excess: Lanes,
    diagonal_axis: Lanes,
    diagonal_axis_excess: Lanes,
    diagonal_diagonal: Lanes,
    diagonal_plane_excess: Lanes,
    diagonal_self_excess: Lanes,
}

/// Acts on differences of opposite directions.
#[derive(Debug, Clone, Copy)]
struct Odd {
    axis_self: Lanes,
    axis_diagonal: Lanes,
    diagonal_axis: Lanes,
    diagonal_diagonal: Lanes,
    diagonal_self_excess: Lanes,
}

impl Gain {
    /// From a matrix with the symmetry of the direction set, as [`collision::gain`](super::collision::gain)
    /// makes them.
    pub fn new(matrix: &Matrix) -> Gain {
        let splat = |value: f64| Lanes::splat(value as f32);
        let even = |i: usize, j: usize| matrix[i][j] + matrix[i][j + 1];
        let odd = |i: usize, j: usize| matrix[i][j] - matrix[i][j + 1];
        // Directions 1 +x, 3 +y, 7 +x+y, 9 +x-y, 11 +x+z, 15 +y+z, 5 +z; j + 1 is opposite to odd j.
        Gain {
            even: Even {
                axis_axis: splat(even(1, 3)),
                axis_axis_excess: splat(even(1, 1) - even(1, 3)),
                axis_diagonal: splat(even(1, 7)),
                axis_plane_excess: splat(even(1, 15) - even(1, 7)),
                diagonal_axis: splat(even(7, 1)),
                diagonal_axis_excess: splat(even(7, 5) - even(7, 1)),
                diagonal_diagonal: splat(even(7, 11)),
                diagonal_plane_excess: splat(even(7, 9) - even(7, 11)),
                diagonal_self_excess: splat(even(7, 7) - even(7, 9)),
            },
            odd: Odd {
                axis_self: splat(odd(1, 1)),
                axis_diagonal: splat(odd(1, 7)),
                diagonal_axis: splat(odd(7, 1)),
                diagonal_diagonal: splat(odd(7, 11)),
                diagonal_self_excess: splat(odd(7, 7) - 2.0 * odd(7, 11)),
            },
        }
    }

    /// `(1 - rho) f + rho gain f` of the arriving light f, `[m - 1]`, and phi = sum of f.
    #[inline(always)]
    pub fn collide(&self, rho: f32, f: &[Lanes; 18]) -> ([Lanes; 18], Lanes) {
        let mut e = [Lanes::default(); 9];
        let mut o = [Lanes::default(); 9];
        for p in 0..9 {
            e[p] = f[2 * p] + f[2 * p + 1];
            o[p] = f[2 * p] - f[2 * p + 1];
        }
        // Halves, because f_m = (even + odd) / 2.
        let scattered = Lanes::splat(0.5 * rho);
        let straight = Lanes::splat(0.5 * (1.0 - rho));

        let even = &self.even;
        // plane[a]: the two diagonal pairs perpendicular to axis a.
        let plane = [e[7] + e[8], e[5] + e[6], e[3] + e[4]];
        let axes = e[0] + e[1] + e[2];
        let diagonals = plane[0] + plane[1] + plane[2];
        let to_axis = even.axis_axis * axes + even.axis_diagonal * diagonals;
        let to_diagonal = even.diagonal_axis * axes + even.diagonal_diagonal * diagonals;
        let axis_even = |a: usize| {
            let sum = to_axis + even.axis_axis_excess * e[a] + even.axis_plane_excess * plane[a];
            straight * e[a] + scattered * sum
        };
        let of_plane =
            |a: usize| to_diagonal + even.diagonal_plane_excess * plane[a] + even.diagonal_axis_excess * e[a];
        let to_plane = [of_plane(0), of_plane(1), of_plane(2)];
        let diagonal_even = |p: usize, a: usize| {
            straight * e[p] + scattered * (to_plane[a] + even.diagonal_self_excess * e[p])
        };

        let odd = &self.odd;
        let (xy, x_y) = (o[3], o[4]);
        let (xz, x_z) = (o[5], o[6]);
        let (yz, y_z) = (o[7], o[8]);
        // along[a]: flux of the diagonals along axis a.
        let along = [(xy + x_y) + (xz + x_z), (xy - x_y) + (yz + y_z), (xz - x_z) + (yz - y_z)];
        let axis_odd =
            |a: usize| straight * o[a] + scattered * (odd.axis_self * o[a] + odd.axis_diagonal * along[a]);
        let drift = |a: usize| odd.diagonal_diagonal * along[a] + odd.diagonal_axis * o[a];
        let u = [drift(0), drift(1), drift(2)];
        let diagonal_odd =
            |p: usize, drift: Lanes| straight * o[p] + scattered * (odd.diagonal_self_excess * o[p] + drift);

        let even_out = [
            axis_even(0),
            axis_even(1),
            axis_even(2),
            diagonal_even(3, 2),
            diagonal_even(4, 2),
            diagonal_even(5, 1),
            diagonal_even(6, 1),
            diagonal_even(7, 0),
            diagonal_even(8, 0),
        ];
        let odd_out = [
            axis_odd(0),
            axis_odd(1),
            axis_odd(2),
            diagonal_odd(3, u[0] + u[1]),
            diagonal_odd(4, u[0] - u[1]),
            diagonal_odd(5, u[0] + u[2]),
            diagonal_odd(6, u[0] - u[2]),
            diagonal_odd(7, u[1] + u[2]),
            diagonal_odd(8, u[1] - u[2]),
        ];
        let mut out = [Lanes::default(); 18];
        for p in 0..9 {
            out[2 * p] = even_out[p] + odd_out[p];
            out[2 * p + 1] = even_out[p] - odd_out[p];
        }
        (out, axes + diagonals)
    }
}

#[cfg(test)]
mod tests {
    use flb_format::{ClassOptics, Optics};

    use super::*;
    use crate::lattice::collision;

    #[test]
    fn structured_collision_equals_the_matrix_product() {
        let mut cases: Vec<(ClassOptics, bool)> = Vec::new();
        for band in Optics::paper().bands {
            cases.extend([(band.leaf, false), (band.wood, true)]);
        }
        cases.extend([1.0, 0.7, 0.0, -1.0].map(|g| (ClassOptics { sigma_a: 0.25, g }, g < 0.0)));
        for (optics, keeps_rest) in cases {
            let matrix = collision::gain(optics, keeps_rest);
            let gain = Gain::new(&matrix);
            for rho in [0.0_f32, 0.3, 1.0] {
                for seed in 0..18 {
                    let f: [Lanes; 18] = std::array::from_fn(|m| {
                        Lanes([0, 1, 2, 3].map(|l| ((m * 7 + l * 5 + seed * 11) % 18) as f32 / 18.0))
                    });
                    let (out, phi) = gain.collide(rho, &f);
                    for l in 0..LANES {
                        let sum: f32 = f.iter().map(|f| f.0[l]).sum();
                        assert!((phi.0[l] - sum).abs() < 1e-5);
                        for m in 1..19 {
                            let product: f64 = (1..19).map(|j| matrix[m][j] * f64::from(f[j - 1].0[l])).sum();
                            let r = f64::from(rho);
                            let expected = (1.0 - r) * f64::from(f[m - 1].0[l]) + r * product;
                            let found = f64::from(out[m - 1].0[l]);
                            // Rounding of sums of up to 9 in f32.
                            assert!(
                                (found - expected).abs() < 2e-6,
                                "{optics:?} {rho} {m}: {found} {expected}"
                            );
                        }
                    }
                }
            }
        }
    }
}
