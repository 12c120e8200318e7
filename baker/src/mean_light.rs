//! The mean light of a plant over its matter, of fields as they will be coded.

use flb_format::sun::harmonics;
use flb_format::{Field, MeanLight, SunBasis};

/// Highest degree for light of single suns, which are few.
const MOST_DEGREE: u8 = 2;
/// Suns for each harmonic that is fitted to them, at least.
const SUNS_A_HARMONIC: usize = 2;
/// Added to the squares of harmonics, so that suns of one half of the sky do not leave the other half open.
const RIDGE: f64 = 1e-3;

const MOST: usize = harmonics::count(harmonics::MAX_DEGREE);

/// Where matter is.
pub(crate) struct Weights<'a> {
    /// Sites with matter, ascending.
    pub sites: &'a [u32],
    /// How much each counts, `[place]`.
    pub of_sites: Vec<f64>,
}

/// Means of fields over matter. `near` is the projection of each mean of the near beam on each harmonic,
/// `[harmonic][mean][place]`, of fields of harmonics.
pub(crate) fn mean_light(
    fields: &[(u8, Field)],
    suns: &SunBasis,
    weights: &Weights,
    near: &[Vec<Vec<f32>>],
) -> MeanLight {
    let all: f64 = weights.of_sites.iter().sum();
    let mean = |field: &Field, factor: Option<&[f32]>| -> Vec<f64> {
        let of_band = |band: u32| {
            let values = field.band(band);
            let part = |(place, (site, weight)): (usize, (&u32, &f64))| {
                weight * f64::from(values[*site as usize]) * factor.map_or(1.0, |f| f64::from(f[place]))
            };
            let sum: f64 = weights.sites.iter().zip(&weights.of_sites).enumerate().map(part).sum();
            if all > 0.0 { sum / all } else { 0.0 }
        };
        (0..field.bands).map(of_band).collect()
    };
    let of = |item: u8| fields.iter().find(|(found, _)| *found == item).map(|(_, field)| field);
    let sky = of(0).map_or(Vec::new(), |field| mean(field, None));
    let sun = match suns {
        SunBasis::Harmonics { degree, .. } => {
            let count = harmonics::count(*degree);
            let of_harmonic = |k: usize| {
                let mut sum = mean(of(1 + k as u8)?, None);
                for (j, near) in near[k].iter().enumerate() {
                    let part = mean(of((1 + count + j) as u8)?, Some(near));
                    sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
                }
                Some(sum)
            };
            (0..count).map(of_harmonic).collect::<Option<_>>().unwrap_or_default()
        }
        _ => {
            let single = |(item, field): &(u8, Field)| Some((suns.sun_of(*item)?, mean(field, None)));
            fit(&fields.iter().filter_map(single).collect::<Vec<_>>())
        }
    };
    MeanLight { sky, sun }.rounded()
}

/// Harmonics of the light of single suns by least squares, as many as the suns tell.
fn fit(suns: &[([f64; 3], Vec<f64>)]) -> Vec<Vec<f64>> {
    let Some((_, first)) = suns.first() else { return Vec::new() };
    let is_told = |degree: &u8| SUNS_A_HARMONIC * harmonics::count(*degree) <= suns.len();
    let count = harmonics::count((0..=MOST_DEGREE).rev().find(is_told).unwrap_or(0));
    let mut matrix = [[0.0; MOST]; MOST];
    let mut right = vec![vec![0.0; first.len()]; count];
    for (towards, light) in suns {
        let values = harmonics::evaluate(*towards);
        for a in 0..count {
            (0..count).for_each(|b| matrix[a][b] += values[a] * values[b]);
            right[a].iter_mut().zip(light).for_each(|(sum, light)| *sum += values[a] * light);
        }
    }
    // Not of the mean, which any sun tells of.
    (1..count).for_each(|k| matrix[k][k] += RIDGE * suns.len() as f64);
    solve(&mut matrix, &mut right);
    right
}

/// Gauss's elimination of a positive definite system, for all bands at once.
fn solve(matrix: &mut [[f64; MOST]; MOST], right: &mut [Vec<f64>]) {
    let count = right.len();
    let less = |right: &mut [Vec<f64>], row: usize, other: usize, factor: f64| {
        let taken = right[other].clone();
        right[row].iter_mut().zip(taken).for_each(|(value, taken)| *value -= factor * taken);
    };
    for pivot in 0..count {
        for row in pivot + 1..count {
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            (pivot..count).for_each(|column| matrix[row][column] -= factor * matrix[pivot][column]);
            less(right, row, pivot, factor);
        }
    }
    for row in (0..count).rev() {
        let factors = matrix[row];
        (row + 1..count).for_each(|column| less(right, row, column, factors[column]));
        right[row].iter_mut().for_each(|value| *value /= matrix[row][row]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_that_is_a_sum_of_harmonics_is_found_from_the_lattice_s_suns() {
        let truth = [1.0, 0.5, -0.2, 0.1, 0.0, 0.3, -0.1, 0.0, 0.2];
        let light = |towards: [f64; 3]| -> f64 {
            harmonics::evaluate(towards).iter().zip(truth).map(|(y, c)| y * c).sum()
        };
        let suns = SunBasis::Lattice18;
        let lattice = 16;
        let sites = [5, 70, 4095];
        let field = |item: u8| {
            let mut field = Field::zeros(lattice, 2);
            let value = suns.sun_of(item).map_or(3.0, light) as f32;
            // The mean over weights 1, 2, 1 is the value; the second band has twice that.
            for band in 0..2 {
                for (site, share) in sites.iter().zip([0.5, 1.0, 1.5]) {
                    let at = band as usize * 4096 + *site as usize;
                    field.values[at] = value * share * (1.0 + band as f32);
                }
            }
            (item, field)
        };
        let fields: Vec<_> = (0..=18).map(field).collect();
        let weights = Weights { sites: &sites, of_sites: vec![1.0, 2.0, 1.0] };
        let found = mean_light(&fields, &suns, &weights, &[]);
        assert_eq!(found.sky, [3.0, 6.0]);
        assert_eq!(found.sun.len(), 9);
        for towards in [[0.0, 1.0, 0.0], [0.6, 0.0, -0.8], [-0.48, -0.6, 0.64]] {
            for band in 0..2 {
                let (found, expected) = (found.of_sun(towards, band), (1.0 + band as f64) * light(towards));
                assert!(
                    (found / expected.max(0.0) - 1.0).abs() < 0.02 || expected < 0.0,
                    "{found}, {expected}"
                );
            }
        }
        // Of few suns the mean alone is told, and of none nothing.
        let few = mean_light(&fields[..3], &suns, &weights, &[]);
        assert_eq!(few.sun.len(), 1);
        assert_eq!(mean_light(&fields[..1], &suns, &weights, &[]).sun, Vec::<Vec<f64>>::new());
    }
}
