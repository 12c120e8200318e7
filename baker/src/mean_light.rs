//! The mean light of a plant over its matter, of fields as they will be coded.

use flb_format::light::SunBasis;
use flb_format::mean_light::MeanLight;
use flb_format::sample::site_of;
use flb_format::sun::harmonics;
use flb_format::{Field, SpeciesMeta, mean_light};
use flb_transport::cholesky;
use rayon::prelude::*;

/// Highest degree for light of single suns, which are few.
const MAX_STORED_DEGREE: u8 = 2;
/// Suns for each harmonic that is fitted to them, at least.
const SUNS_A_HARMONIC: usize = 2;
/// Added to the squares of harmonics, so that suns of one half of the sky do not leave the other half open.
const RIDGE: f64 = 1e-3;

/// Sites along a block's edge.
const BLOCK_EDGE: usize = 4;

const MAX_HARMONICS: usize = harmonics::count(harmonics::MAX_DEGREE);

/// Means of fields over matter: sites, and how much each counts. `near` is the projection of each mean of the near beam
/// on each harmonic, `[harmonic][mean][place]`, of fields of harmonics.
fn mean_light(
    fields: &[(u8, Field)],
    suns: &SunBasis,
    matter: &[(u32, f64)],
    near: &[Vec<Vec<f32>>],
) -> MeanLight {
    let all: f64 = matter.iter().map(|(_, weight)| weight).sum();
    let mean = |field: &Field, factor: Option<&[f32]>| -> Vec<f64> {
        let of_band = |band: u32| {
            let part = |(place, (site, weight)): (usize, &(u32, f64))| {
                weight
                    * f64::from(field.value(band, *site as usize))
                    * factor.map_or(1.0, |f| f64::from(f[place]))
            };
            let sum: f64 = matter.iter().enumerate().map(part).sum();
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
            (0..count).into_par_iter().map(of_harmonic).collect::<Option<_>>().unwrap_or_default()
        }
        _ => {
            let single = |(item, field): &(u8, Field)| Some((suns.sun_of(*item)?, mean(field, None)));
            fit(&fields.iter().filter_map(single).collect::<Vec<_>>())
        }
    };
    MeanLight { sky, sun }.rounded()
}

/// Means of a species: of its light, and of its sky where there are averages alone.
pub(crate) fn set_means(
    meta: &mut SpeciesMeta,
    fields: &[(u8, Field)],
    suns: &SunBasis,
    matter: &[(u32, f64)],
    near: &[Vec<Vec<f32>>],
) {
    meta.mean_light = Some(mean_light(fields, suns, matter, near));
    let sky = fields.iter().find(|(item, _)| *item == 0);
    meta.sky_averages = sky.map(|(_, field)| mean_of_averages(field, matter));
}

/// Mean light of a field over matter by band, where each block of 4^3 sites is its average: what a reader has before
/// detail. Dense sites are darker than the rest of their blocks.
fn mean_of_averages(field: &Field, matter: &[(u32, f64)]) -> Vec<f64> {
    let edge = field.lattice as usize / BLOCK_EDGE;
    let block_of = |site: usize| {
        let [x, y, z] = site_of(site, field.lattice).map(|c| c as usize / BLOCK_EDGE);
        (z * edge + y) * edge + x
    };
    let mut weights = vec![0.0; edge * edge * edge];
    matter.iter().for_each(|(site, weight)| weights[block_of(*site as usize)] += weight);
    let all: f64 = weights.iter().sum();
    let of_band = |band: u32| {
        let of_site = |(site, value): (usize, &f32)| weights[block_of(site)] * f64::from(*value);
        let sum: f64 = field.band(band).iter().enumerate().map(of_site).sum();
        if all > 0.0 { sum / (all * BLOCK_EDGE.pow(3) as f64) } else { 0.0 }
    };
    (0..field.bands).map(of_band).map(mean_light::rounded).collect()
}

/// Harmonics of the light of single suns by least squares, `[harmonic][band]`, as many as the suns tell.
fn fit(suns: &[([f64; 3], Vec<f64>)]) -> Vec<Vec<f64>> {
    let Some((_, first)) = suns.first() else { return Vec::new() };
    let is_told = |degree: &u8| SUNS_A_HARMONIC * harmonics::count(*degree) <= suns.len();
    let count = harmonics::count((0..=MAX_STORED_DEGREE).rev().find(is_told).unwrap_or(0));
    let rows: Vec<_> = suns.iter().map(|(towards, _)| harmonics::evaluate(*towards)).collect();
    let of_band = |band: usize| {
        let (mut matrix, mut right) = ([[0.0; MAX_HARMONICS]; MAX_HARMONICS], [0.0; MAX_HARMONICS]);
        for (row, (_, light)) in rows.iter().zip(suns) {
            for a in 0..count {
                (0..count).for_each(|b| matrix[a][b] += row[a] * row[b]);
                right[a] += row[a] * light[band];
            }
        }
        // Not of the mean, which any sun tells of.
        (1..count).for_each(|k| matrix[k][k] += RIDGE * suns.len() as f64);
        cholesky::solve(&mut matrix, &mut right, count);
        right
    };
    let bands: Vec<_> = (0..first.len()).map(of_band).collect();
    (0..count).map(|k| bands.iter().map(|of_band| of_band[k]).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_counts_as_its_average_by_the_matter_that_it_holds() {
        let mut field = Field::zeros(16, 1);
        let at = |x: usize, y: usize, z: usize| (z * 16 + y) * 16 + x;
        // The dark site of the first block holds all of its matter; the second block is even.
        let first = (0..4).flat_map(|z| (0..4).flat_map(move |y| (0..4).map(move |x| at(x, y, z))));
        first.for_each(|site| field.values_mut()[site] = 2.0);
        field.values_mut()[at(1, 2, 3)] = 0.0;
        for site in (0..4).flat_map(|z| (0..4).flat_map(move |y| (12..16).map(move |x| at(x, y, z)))) {
            field.values_mut()[site] = 1.0;
        }
        let matter = [(at(1, 2, 3) as u32, 3.0), (at(13, 0, 0) as u32, 1.0)];
        let expected = (3.0 * 2.0 * 63.0 / 64.0 + 1.0) / 4.0;
        assert!((mean_of_averages(&field, &matter)[0] - expected).abs() < 1e-4);
        assert_eq!(mean_of_averages(&field, &[]), [0.0]);
        assert_eq!(mean_light(&[(0, field)], &SunBasis::Lattice18, &matter, &[]).sky, [0.25]);
    }

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
                    field.values_mut()[at] = value * share * (1.0 + band as f32);
                }
            }
            (item, field)
        };
        let fields: Vec<_> = (0..=18).map(field).collect();
        let matter = [(sites[0], 1.0), (sites[1], 2.0), (sites[2], 1.0)];
        let found = mean_light(&fields, &suns, &matter, &[]);
        assert_eq!(found.sky, [3.0, 6.0]);
        assert_eq!(found.sun.len(), 9);
        for towards in [[0.0, 1.0, 0.0], [0.6, 0.0, -0.8], [-0.48, -0.6, 0.64]] {
            for band in 0..2 {
                let (found, expected) = (found.of_sun(towards)(band), (1.0 + band as f64) * light(towards));
                assert!(
                    (found / expected.max(0.0) - 1.0).abs() < 0.02 || expected < 0.0,
                    "{found}, {expected}"
                );
            }
        }
        // Of few suns the mean alone is told, and of none nothing.
        let few = mean_light(&fields[..3], &suns, &matter, &[]);
        assert_eq!(few.sun.len(), 1);
        assert_eq!(mean_light(&fields[..1], &suns, &matter, &[]).sun, Vec::<Vec<f64>>::new());
    }
}
