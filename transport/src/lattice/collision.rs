//! What a site does to light: optics of a class -> the 19x19 collision matrix Omega, f64.
//!
//! Steele 2009, eq. 2.15 to 2.19; the limits at g = +-1 and the scaled Henyey-Greenstein form are the
//! project lighting model's, section 3. Column j of Omega says where the light that travels along c_j goes.

use flb_format::direction::{DIRECTIONS, WEIGHTS};
use flb_format::matter::{BandOptics, ClassOptics};

/// `[i][j]`, rows receive, columns give; index 0 is rest.
pub type Matrix = [[f64; 19]; 19];

/// Omega of one class in one band: `f(r + c) = f(r) + rho Omega f(r)`. Every column sums to 0.
///
/// `optics` must have sigma_a in 0..=1 and g in -1..=1.
pub fn omega(optics: ClassOptics) -> Matrix {
    let ClassOptics { sigma_a, g } = optics;
    let scatter = phase(g);
    let mut omega = [[0.0; 19]; 19];
    omega[0][0] = -1.0;
    for i in 1..19 {
        omega[0][i] = sigma_a;
        omega[i][0] = WEIGHTS[i];
        for j in 1..19 {
            let lost = if i == j { 1.0 } else { 0.0 };
            omega[i][j] = (1.0 - sigma_a) * scatter[i][j] - lost;
        }
    }
    omega
}

/// Returns the matrix of one collision: light given to direction i of the light along j, `Omega_ij + [i = j]`, i and j
/// above 0; row and column 0 are zero. With `keeps_rest` (wood) the rest density is eliminated exactly: at steady state
/// `f_0 = sigma_a sum_j f_j`, of which w_i goes to direction i (lighting model, section 4). Columns then sum to 1, else
/// to sigma_s. No entry is negative.
pub fn gain(optics: ClassOptics, keeps_rest: bool) -> Matrix {
    let mut gain = phase(optics.g);
    for (i, row) in gain.iter_mut().enumerate().skip(1) {
        for entry in &mut row[1..] {
            *entry *= 1.0 - optics.sigma_a;
            if keeps_rest {
                *entry += optics.sigma_a * WEIGHTS[i];
            }
        }
    }
    gain
}

/// [`gain`] of leaf and of wood in one band; wood keeps its rest.
pub fn gains(band: &BandOptics) -> [Matrix; 2] {
    [gain(band.leaf, false), gain(band.wood, true)]
}

/// `w_i pn_ij(g)`: the share of the light scattered out of direction j that goes to i. Columns 1..=18 sum
/// to 1 (eq. 2.18). g = 1 gives `[i = j]`, g = -1 gives `[i = opposite(j)]`, exactly.
pub fn phase(g: f64) -> Matrix {
    let mut phase = [[0.0; 19]; 19];
    for j in 1..19 {
        let mut sum = 0.0;
        for (i, row) in phase.iter_mut().enumerate().skip(1) {
            row[j] = WEIGHTS[i] * henyey_greenstein(g, cosine(i, j));
            sum += row[j];
        }
        for row in &mut phase[1..] {
            row[j] /= sum;
        }
    }
    phase
}

/// Henyey-Greenstein (eq. 2.19) scaled to 1 at its peak; the scale cancels in [`phase`]. Unlike the plain
/// form it is neither 0/0 nor huge near g = +-1. x^(3/2) is x sqrt(x), which is rounded alike everywhere.
fn henyey_greenstein(g: f64, cosine: f64) -> f64 {
    let a = g.abs();
    let c = if g < 0.0 { -cosine } else { cosine };
    if c == 1.0 {
        return 1.0;
    }
    let x = (1.0 - a) * (1.0 - a);
    let ratio = x / (x + 2.0 * a * (1.0 - c));
    ratio * ratio.sqrt()
}

/// n_i . n_j of the unit directions, i and j > 0: 0, +-1/2, +-1/sqrt(2) or +-1, without rounding errors of a
/// normalisation.
fn cosine(i: usize, j: usize) -> f64 {
    let dot: i32 = (0..3).map(|axis| DIRECTIONS[i][axis] * DIRECTIONS[j][axis]).sum();
    f64::from(dot)
        * match (i <= 6, j <= 6) {
            (true, true) => 1.0,
            (false, false) => 0.5,
            _ => std::f64::consts::FRAC_1_SQRT_2,
        }
}

#[cfg(test)]
mod tests;
