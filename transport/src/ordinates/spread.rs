//! From values at the non-empty sites to a whole field.
//!
//! Surfaces lie at the borders of their sites, so samples between sites reach into empty ones. An empty site takes the
//! mean of the non-empty sites in the smallest cube of the pyramid over the lattice (2^3, 4^3, ... sites) that holds
//! any: next to matter that is the matter's light, and further away it changes little, which codes well.

use flb_format::Field;

/// Writes one band of a field.
pub fn spread(sites: &[u32], values: &[f32], field: &mut Field, band: u32) {
    let n = field.lattice as usize;
    let out = &mut field.values[band as usize * n * n * n..][..n * n * n];
    // [level][z][y][x]: sum and count.
    let mut level: Vec<(f32, f32)> = vec![(0.0, 0.0); n * n * n];
    for (&site, &value) in sites.iter().zip(values) {
        level[site as usize] = (value, 1.0);
    }
    let mut levels = vec![level];
    let mut edge = n;
    while edge > 1 {
        levels.push(halved(&levels[levels.len() - 1], edge));
        edge /= 2;
    }
    // From the top, each level hands its means to what is empty below.
    let mut means = vec![0.0_f32];
    for level in levels.iter().rev() {
        let edge = libm::cbrt(level.len() as f64).round() as usize;
        let parent_edge = (edge / 2).max(1);
        let mean = |i: usize| {
            let (sum, count) = level[i];
            let [x, y, z] = [i % edge, i / edge % edge, i / edge / edge].map(|c| c / 2);
            if count > 0.0 { sum / count } else { means[(z * parent_edge + y) * parent_edge + x] }
        };
        means = (0..level.len()).map(mean).collect();
    }
    out.copy_from_slice(&means);
}

/// Sums over 2x2x2.
fn halved(level: &[(f32, f32)], edge: usize) -> Vec<(f32, f32)> {
    let half = edge / 2;
    let sum = |i: usize| {
        let [x, y, z] = [i % half, i / half % half, i / half / half].map(|c| 2 * c);
        let mut sum = (0.0, 0.0);
        for (dz, dy, dx) in
            [(0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1), (1, 0, 0), (1, 0, 1), (1, 1, 0), (1, 1, 1)]
        {
            let (value, count) = level[((z + dz) * edge + y + dy) * edge + x + dx];
            sum.0 += value;
            sum.1 += count;
        }
        sum
    };
    (0..half * half * half).map(sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_sites_take_the_mean_of_the_nearest_cube_with_matter() {
        let mut field = Field::zeros(4, 2);
        // Sites (0, 0, 0) and (1, 0, 0) share a cube of 2^3; (3, 3, 3) has one of its own.
        spread(&[0, 1, 63], &[1.0, 3.0, 8.0], &mut field, 1);
        assert!(field.band(0).iter().all(|&v| v == 0.0));
        let band = field.band(1);
        assert_eq!([band[0], band[1], band[63]], [1.0, 3.0, 8.0]);
        assert_eq!(band[4], 2.0); // (0, 1, 0)
        assert_eq!(band[62], 8.0); // (2, 3, 3)
        assert_eq!(band[3], 4.0); // (3, 0, 0): the whole lattice
    }

    #[test]
    fn a_plant_without_sites_has_no_light() {
        let mut field = Field::zeros(4, 1);
        spread(&[], &[], &mut field, 0);
        assert!(field.values.iter().all(|&v| v == 0.0));
    }
}
