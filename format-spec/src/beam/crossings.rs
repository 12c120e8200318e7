//! Rays along one direction as runs of the sites that they cross.

use super::sites::Sites;
use super::sweep::Sweep;

/// Rays on an edge of a bundle. Neighbouring rays, one after the other, meet the same sites while these are in the
/// cache.
const BUNDLE: usize = 8;

/// Crossing of a site by a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Crossing {
    /// Place of the site in the list of non-empty sites.
    pub place: u32,
    /// Whether the ray ends with this crossing.
    pub is_last: bool,
    /// Length, in site edges.
    pub length: f32,
    /// Middle of the crossing, in site edges from the middle of the site.
    pub middle: [f32; 3],
}

/// Finds every crossing of a non-empty site by rays along `direction` (a unit vector), `rays` of them per site edge:
/// ray after ray, each in the order of travel.
pub fn crossings(sites: &Sites, direction: [f64; 3], rays: u32) -> Vec<Crossing> {
    let Some(sweep) = Sweep::new(sites, direction, rays) else { return Vec::new() };
    let [rows, columns] = sweep.picture();
    let bundles = columns.div_ceil(BUNDLE);
    let number = |row: usize, column: usize| {
        let bundle = (row / BUNDLE) * bundles + column / BUNDLE;
        bundle * BUNDLE * BUNDLE + (row % BUNDLE) * BUNDLE + column % BUNDLE
    };
    let way = sweep.way();
    let mut found: Vec<(u32, Crossing)> = Vec::new();
    // Crossings of each ray.
    let mut counts = vec![0u32; rows.div_ceil(BUNDLE) * bundles * BUNDLE * BUNDLE];
    sweep.visit(|place, across, along| {
        for (row, [enter, leave, start]) in across.rays() {
            for (column, [enters, leaves, starts]) in along.rays() {
                let (from, to) = (enters.max(enter), leaves.min(leave));
                let length = way.length(from, to);
                if length == 0.0 {
                    continue;
                }
                let mut middle = [0.0; 3];
                let offset = way.middle(from, to, [start, starts]);
                sweep.axes.into_iter().zip(offset).for_each(|(axis, offset)| middle[axis] = offset);
                let ray = number(row, column);
                counts[ray] += 1;
                found.push((ray as u32, Crossing { place, is_last: false, length, middle }));
            }
        }
    });
    // By ray; stable, so that each keeps the order of travel.
    let mut next = 0;
    for count in &mut counts {
        (*count, next) = (next, next + *count);
    }
    let mut sorted = vec![Crossing::default(); found.len()];
    for (ray, crossing) in found {
        let at = &mut counts[ray as usize];
        sorted[*at as usize] = crossing;
        *at += 1;
    }
    // Each count is now the end of its ray.
    let mut begins = 0;
    for end in counts {
        if end > begins {
            sorted[end as usize - 1].is_last = true;
        }
        begins = end;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::super::uncollided::tests::{DIRECTIONS, media, unit};
    use super::super::walk::{Step, Walker};
    use super::*;
    use crate::turbid::TurbidMedium;

    #[test]
    fn crossings_are_those_of_rays_that_are_walked() {
        for medium in media() {
            are_those_that_are_walked(&medium);
        }
    }

    fn are_those_that_are_walked(medium: &TurbidMedium) {
        let sites = medium.sites();
        let places = Sites::new(&medium.grid, &sites);
        for direction in DIRECTIONS.map(unit) {
            for rays in [1, 2, 4] {
                let mut walked: Vec<Vec<Crossing>> = vec![Vec::new()];
                Walker::new(&medium.grid, &sites).walk(direction, rays, |step| match step {
                    Step::Cross { place, length, middle } => {
                        let (length, middle) = (length as f32, middle.map(|c| c as f32));
                        let crossing = Crossing { place, is_last: false, length, middle };
                        walked.last_mut().expect("one is begun").push(crossing);
                    }
                    Step::End => walked.push(Vec::new()),
                });
                walked.retain(|ray| !ray.is_empty());
                let found = crossings(&places, direction, rays);
                let mut found: Vec<Vec<Crossing>> =
                    found.split_inclusive(|crossing| crossing.is_last).map(<[Crossing]>::to_vec).collect();
                assert_eq!(found.len(), walked.len(), "{direction:?}, {rays}");
                // Rays in any order: by the places that they cross, and by where.
                let key = |ray: &Vec<Crossing>| {
                    let places: Vec<u32> = ray.iter().map(|crossing| crossing.place).collect();
                    let first = ray[0].middle.map(|c| (1000.0 * c).round() as i32);
                    (places, first)
                };
                found.sort_by_cached_key(key);
                walked.sort_by_cached_key(key);
                assert!(found.iter().zip(&walked).all(|(found, walked)| found.len() == walked.len()));
                for (found, walked) in found.iter().flatten().zip(walked.iter().flatten()) {
                    assert_eq!(found.place, walked.place, "{direction:?}, {rays}");
                    assert!((found.length - walked.length).abs() < 1e-5, "{found:?}, {walked:?}");
                    let apart = (0..3).map(|axis| (found.middle[axis] - walked.middle[axis]).abs());
                    assert!(apart.fold(0.0, f32::max) < 1e-5, "{found:?}, {walked:?}");
                }
            }
        }
    }
}
