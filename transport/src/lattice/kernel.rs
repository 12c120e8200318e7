//! One collision for eight solves at once: arriving light of a site -> outgoing light, f32.
//!
//! The 18x18 gain matrix depends only on the angle between two directions, so it splits by opposite
//! pairs into an even part (acting on f_m + f_opp) and an odd part (acting on f_m - f_opp), and
//! inside each part only five (three) different angles occur. Sums shared between rows then leave about 145
//! operations of the 324 multiply-adds. The plain matrix product is the oracle.
//!
//! Every function here is one loop over the lanes around scalar arithmetic: LLVM vectorises such a loop
//! whole. Arithmetic on whole arrays of lanes is left to its guess which lanes to pair, and cost twice the time.

use super::collision::Matrix;

/// Solves that are carried side by side.
pub(super) const LANES: usize = 8;

/// One number per solve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(align(32))]
pub(super) struct Lanes(pub [f32; LANES]);

/// The distinct entries of a gain matrix. "Axis" and "diagonal" name receiver, then giver; the number
/// is the cosine between them; `_excess` is what an entry has beyond the one that its shared sum covers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gain {
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
    /// From one matrix per lane, with the symmetry of the direction set, as
    /// [`collision::gain`](super::collision::gain) makes them.
    pub(super) fn new(matrices: &[Matrix; LANES]) -> Gain {
        let lanes =
            |entry: &dyn Fn(&Matrix) -> f64| Lanes(std::array::from_fn(|lane| entry(&matrices[lane]) as f32));
        let even = |m: &Matrix, i: usize, j: usize| m[i][j] + m[i][j + 1];
        let odd = |m: &Matrix, i: usize, j: usize| m[i][j] - m[i][j + 1];
        // Directions 1 +x, 3 +y, 7 +x+y, 9 +x-y, 11 +x+z, 15 +y+z, 5 +z; j + 1 is opposite to odd j.
        Gain {
            even: Even {
                axis_axis: lanes(&|m| even(m, 1, 3)),
                axis_axis_excess: lanes(&|m| even(m, 1, 1) - even(m, 1, 3)),
                axis_diagonal: lanes(&|m| even(m, 1, 7)),
                axis_plane_excess: lanes(&|m| even(m, 1, 15) - even(m, 1, 7)),
                diagonal_axis: lanes(&|m| even(m, 7, 1)),
                diagonal_axis_excess: lanes(&|m| even(m, 7, 5) - even(m, 7, 1)),
                diagonal_diagonal: lanes(&|m| even(m, 7, 11)),
                diagonal_plane_excess: lanes(&|m| even(m, 7, 9) - even(m, 7, 11)),
                diagonal_self_excess: lanes(&|m| even(m, 7, 7) - even(m, 7, 9)),
            },
            odd: Odd {
                axis_self: lanes(&|m| odd(m, 1, 1)),
                axis_diagonal: lanes(&|m| odd(m, 1, 7)),
                diagonal_axis: lanes(&|m| odd(m, 7, 1)),
                diagonal_diagonal: lanes(&|m| odd(m, 7, 11)),
                diagonal_self_excess: lanes(&|m| odd(m, 7, 7) - 2.0 * odd(m, 7, 11)),
            },
        }
    }

    /// One lane's entries by the names that types.wgsl gives them, in its order.
    #[cfg(feature = "gpu")]
    pub(super) fn fields(&self, lane: usize) -> [(&'static str, f32); 14] {
        let Gain { even, odd } = self;
        [
            ("even_axis_axis", even.axis_axis),
            ("even_axis_axis_excess", even.axis_axis_excess),
            ("even_axis_diagonal", even.axis_diagonal),
            ("even_axis_plane_excess", even.axis_plane_excess),
            ("even_diagonal_axis", even.diagonal_axis),
            ("even_diagonal_axis_excess", even.diagonal_axis_excess),
            ("even_diagonal_diagonal", even.diagonal_diagonal),
            ("even_diagonal_plane_excess", even.diagonal_plane_excess),
            ("even_diagonal_self_excess", even.diagonal_self_excess),
            ("odd_axis_self", odd.axis_self),
            ("odd_axis_diagonal", odd.axis_diagonal),
            ("odd_diagonal_axis", odd.diagonal_axis),
            ("odd_diagonal_diagonal", odd.diagonal_diagonal),
            ("odd_diagonal_self_excess", odd.diagonal_self_excess),
        ]
        .map(|(name, lanes)| (name, lanes.0[lane]))
    }

    /// Puts `(1 - rho) f + rho gain f` of the arriving light f, `[m - 1]`, into `out`, and phi = sum of f into `phi`.
    ///
    /// Never inlined: as arguments the four places are known not to overlap, without which LLVM gives up the lanes.
    #[inline(never)]
    pub(super) fn collide(&self, rho: &Lanes, f: &[Lanes; 18], out: &mut [Lanes; 18], phi: &mut Lanes) {
        for l in 0..LANES {
            // Halves, because f_m = (even + odd) / 2.
            let scattered = 0.5 * rho.0[l];
            let straight = 0.5 * (1.0 - rho.0[l]);
            let pair_sum = |p: usize| f[2 * p].0[l] + f[2 * p + 1].0[l];
            let pair_difference = |p: usize| f[2 * p].0[l] - f[2 * p + 1].0[l];
            let e: [f32; 9] = std::array::from_fn(pair_sum);
            let o: [f32; 9] = std::array::from_fn(pair_difference);

            let even = &self.even;
            // plane[a]: the two diagonal pairs perpendicular to axis a.
            let plane = [e[7] + e[8], e[5] + e[6], e[3] + e[4]];
            let axes = e[0] + e[1] + e[2];
            let diagonals = plane[0] + plane[1] + plane[2];
            let to_axis = even.axis_axis.0[l] * axes + even.axis_diagonal.0[l] * diagonals;
            let to_diagonal = even.diagonal_axis.0[l] * axes + even.diagonal_diagonal.0[l] * diagonals;
            let axis_even = |a: usize| {
                let excess = even.axis_axis_excess.0[l] * e[a] + even.axis_plane_excess.0[l] * plane[a];
                straight * e[a] + scattered * (to_axis + excess)
            };
            let of_plane = |a: usize| {
                let excess =
                    even.diagonal_plane_excess.0[l] * plane[a] + even.diagonal_axis_excess.0[l] * e[a];
                to_diagonal + excess
            };
            let to_plane = [of_plane(0), of_plane(1), of_plane(2)];
            let diagonal_even = |p: usize, a: usize| {
                straight * e[p] + scattered * (to_plane[a] + even.diagonal_self_excess.0[l] * e[p])
            };

            let odd = &self.odd;
            let (xy, x_y) = (o[3], o[4]);
            let (xz, x_z) = (o[5], o[6]);
            let (yz, y_z) = (o[7], o[8]);
            // along[a]: flux of the diagonals along axis a.
            let along = [(xy + x_y) + (xz + x_z), (xy - x_y) + (yz + y_z), (xz - x_z) + (yz - y_z)];
            let axis_odd = |a: usize| {
                let sum = odd.axis_self.0[l] * o[a] + odd.axis_diagonal.0[l] * along[a];
                straight * o[a] + scattered * sum
            };
            let drift = |a: usize| odd.diagonal_diagonal.0[l] * along[a] + odd.diagonal_axis.0[l] * o[a];
            let u = [drift(0), drift(1), drift(2)];
            let diagonal_odd = |p: usize, drift: f32| {
                straight * o[p] + scattered * (odd.diagonal_self_excess.0[l] * o[p] + drift)
            };

            let mut put = |p: usize, even: f32, odd: f32| {
                out[2 * p].0[l] = even + odd;
                out[2 * p + 1].0[l] = even - odd;
            };
            put(0, axis_even(0), axis_odd(0));
            put(1, axis_even(1), axis_odd(1));
            put(2, axis_even(2), axis_odd(2));
            put(3, diagonal_even(3, 2), diagonal_odd(3, u[0] + u[1]));
            put(4, diagonal_even(4, 2), diagonal_odd(4, u[0] - u[1]));
            put(5, diagonal_even(5, 1), diagonal_odd(5, u[0] + u[2]));
            put(6, diagonal_even(6, 1), diagonal_odd(6, u[0] - u[2]));
            put(7, diagonal_even(7, 0), diagonal_odd(7, u[1] + u[2]));
            put(8, diagonal_even(8, 0), diagonal_odd(8, u[1] - u[2]));
            phi.0[l] = axes + diagonals;
        }
    }
}

#[cfg(test)]
mod tests {
    use flb_format::matter::{ClassOptics, Optics};

    use super::*;
    use crate::lattice::collision;

    #[test]
    fn structured_collision_equals_the_matrix_product() {
        let mut cases: Vec<(ClassOptics, bool)> = Vec::new();
        for band in Optics::paper().bands {
            cases.extend([(band.leaf, false), (band.wood, true)]);
        }
        cases.extend([1.0, 0.7, 0.0, -1.0].map(|g| (ClassOptics { sigma_a: 0.25, g }, g < 0.0)));
        let other = collision::gain(ClassOptics { sigma_a: 0.6, g: 0.5 }, false);
        for (optics, keeps_rest) in cases {
            let matrix = collision::gain(optics, keeps_rest);
            // Lanes with other matrices must not disturb each other.
            let matrices = std::array::from_fn(|l| if l % 3 == 1 { other } else { matrix });
            let gain = Gain::new(&matrices);
            for rho in [0.0_f32, 0.3, 1.0] {
                for seed in 0..18 {
                    let f: [Lanes; 18] = std::array::from_fn(|m| {
                        Lanes(std::array::from_fn(|l| ((m * 7 + l * 5 + seed * 11) % 18) as f32 / 18.0))
                    });
                    let (mut out, mut phi) = ([Lanes::default(); 18], Lanes::default());
                    gain.collide(&Lanes([rho; LANES]), &f, &mut out, &mut phi);
                    for (l, matrix) in matrices.iter().enumerate() {
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
