//! From values at the non-empty sites to a whole field.
//!
//! Surfaces lie at the borders of their sites, so samples between sites reach into empty ones. An empty site takes the
//! mean of the non-empty sites in the smallest cube of the pyramid over the lattice (2^3, 4^3, ... sites) that holds
//! any: next to matter that is the matter's light, and further away it changes little, which codes well.

use flb_format::field::{CellBand, Cells};

/// The pyramid over the non-empty sites of a lattice: what each site of a field takes its value from.
pub struct Spread {
    /// `[level]`: for each cube that holds matter, ascending, the place of its cube among those of the next level. The
    /// first level's cubes are the sites.
    parents: Vec<Vec<u32>>,
    /// Sites that each cube holds, those of all levels one after the other.
    counts: Vec<f32>,
    /// `[z][y][x]`: number of the cube, among those of all levels, whose mean a site takes.
    cubes: Cells,
}

impl Spread {
    /// Prepares for the non-empty sites of a lattice, ascending.
    pub fn new(sites: &[u32], lattice: u32) -> Spread {
        let mut edge = lattice as usize;
        if sites.is_empty() {
            let cubes = Cells::new(vec![0; edge * edge * edge]);
            return Spread { parents: Vec::new(), counts: Vec::new(), cubes };
        }
        // Cubes of a level by their place in it, and all of them.
        let mut cubes: Vec<u32> = sites.to_vec();
        let mut levels = Vec::new();
        let (mut parents, mut counts) = (Vec::new(), vec![1.0; sites.len()]);
        let mut first = 0;
        while edge > 1 {
            let half = edge / 2;
            let above = |&cube: &u32| {
                let cube = cube as usize;
                let [x, y, z] = [cube % edge, cube / edge % edge, cube / edge / edge].map(|c| c / 2);
                ((z * half + y) * half + x) as u32
            };
            let mut next: Vec<u32> = cubes.iter().map(above).collect();
            next.sort_unstable();
            next.dedup();
            let place = |cube: &u32| next.binary_search(&above(cube)).expect("it is there") as u32;
            let of_level: Vec<u32> = cubes.iter().map(place).collect();
            let mut sums = vec![0.0; next.len()];
            of_level.iter().zip(&counts[first..]).for_each(|(&parent, count)| sums[parent as usize] += count);
            first = counts.len();
            counts.extend(sums);
            parents.push(of_level);
            levels.push((std::mem::replace(&mut cubes, next), edge));
            edge = half;
        }
        // From the top, each level tells those below that are empty.
        let mut numbers = vec![counts.len() as u32 - 1];
        let mut end = first;
        for (cubes, edge) in levels.into_iter().rev() {
            let half = edge / 2;
            let mut below = Vec::with_capacity(edge * edge * edge);
            for z in 0..edge {
                for y in 0..edge {
                    let row = &numbers[(z / 2 * half + y / 2) * half..][..half];
                    below.extend(row.iter().flat_map(|&number| [number; 2]));
                }
            }
            let start = end - cubes.len();
            (start..end).zip(cubes).for_each(|(number, cube)| below[cube as usize] = number as u32);
            (numbers, end) = (below, start);
        }
        Spread { parents, counts, cubes: Cells::new(numbers) }
    }

    /// Makes a band of a field from the values at the sites; without sites, one of zeros.
    pub fn band(&self, values: &[f32]) -> CellBand {
        if values.is_empty() {
            return CellBand::new(self.cubes.clone(), vec![0.0]);
        }
        let mut means = Vec::with_capacity(self.counts.len());
        means.extend_from_slice(values);
        let mut first = 0;
        for (level, parents) in self.parents.iter().enumerate() {
            let end = means.len();
            means.resize(end + self.parents.get(level + 1).map_or(1, Vec::len), 0.0);
            let (level, next) = means[first..].split_at_mut(end - first);
            parents.iter().zip(level).for_each(|(&parent, sum)| next[parent as usize] += *sum);
            first = end;
        }
        means.iter_mut().zip(&self.counts).for_each(|(mean, count)| *mean /= count);
        CellBand::new(self.cubes.clone(), means)
    }
}

#[cfg(test)]
mod tests {
    use flb_format::Field;

    use super::*;

    #[test]
    fn empty_sites_take_the_mean_of_the_nearest_cube_with_matter() {
        // Sites (0, 0, 0) and (1, 0, 0) share a cube of 2^3; (3, 3, 3) has one of its own.
        let field = Field::of_cells(4, vec![Spread::new(&[0, 1, 63], 4).band(&[1.0, 3.0, 8.0])]);
        let band = field.band(0);
        assert_eq!([band[0], band[1], band[63]], [1.0, 3.0, 8.0]);
        assert_eq!(band[4], 2.0); // (0, 1, 0)
        assert_eq!(band[62], 8.0); // (2, 3, 3)
        assert_eq!(band[3], 4.0); // (3, 0, 0): the whole lattice
    }

    /// Sums over the whole lattice, level by level.
    fn by_sums_over_all(sites: &[u32], values: &[f32], lattice: usize) -> Vec<f32> {
        let mut levels = vec![vec![(0.0_f32, 0.0_f32); lattice * lattice * lattice]];
        sites.iter().zip(values).for_each(|(&site, &value)| levels[0][site as usize] = (value, 1.0));
        let mut edge = lattice;
        while edge > 1 {
            let half = edge / 2;
            let mut above = vec![(0.0, 0.0); half * half * half];
            for (cube, (value, count)) in levels[levels.len() - 1].iter().enumerate() {
                let [x, y, z] = [cube % edge, cube / edge % edge, cube / edge / edge].map(|c| c / 2);
                let sum = &mut above[(z * half + y) * half + x];
                *sum = (sum.0 + value, sum.1 + count);
            }
            levels.push(above);
            edge = half;
        }
        let of_site = |site: usize| {
            let mut at = [site % lattice, site / lattice % lattice, site / lattice / lattice];
            let mut edge = lattice;
            for level in &levels {
                let (sum, count) = level[(at[2] * edge + at[1]) * edge + at[0]];
                if count > 0.0 {
                    return sum / count;
                }
                (at, edge) = (at.map(|c| c / 2), edge / 2);
            }
            unreachable!("the last cube holds all sites")
        };
        (0..lattice * lattice * lattice).map(of_site).collect()
    }

    #[test]
    fn a_pyramid_that_is_made_once_gives_what_sums_over_the_lattice_give() {
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        for share in [1, 40, 900] {
            let sites: Vec<u32> = (0..16 * 16 * 16).filter(|_| random() % 1000 < share).collect();
            let spread = Spread::new(&sites, 16);
            for _ in 0..2 {
                let values: Vec<f32> = sites.iter().map(|_| random() as f32 / 1e5).collect();
                let field = Field::of_cells(16, vec![spread.band(&values)]);
                assert_eq!(field.band(0), by_sums_over_all(&sites, &values, 16));
            }
        }
    }

    #[test]
    fn a_plant_without_sites_has_no_light() {
        let field = Field::of_cells(4, vec![Spread::new(&[], 4).band(&[])]);
        assert!(field.values().iter().all(|&v| v == 0.0));
    }
}
