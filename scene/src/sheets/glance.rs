//! Whether a mesh has leaves that are worth a search, from some of them: most have none, and a search takes as long as
//! a good part of import.
//!
//! Of some thousand leaf triangles, spread over all of them, it is found out on how many all corners are shared by
//! three triangles or more, as in a closed shell, and on how many other triangles lie, as in a sheet of two. A plant
//! on whose leaves hardly any does has no such leaves, or so few that its light does not change.

use glam::DVec3;
use rayon::prelude::*;

use super::grid::Flat;
use crate::Mesh;

/// One leaf triangle of so many is looked at, but this many where there are as many.
const ONE_OF: usize = 16;
const LOOKED_AT: usize = 4096;

/// The search begins where more than one of so many is found.
const WORTH_ONE_OF: usize = 200;

/// Triangles at every corner of a triangle of a closed shell, at least, and at one of them: the foot of a spike may be
/// open.
const AROUND: [u8; 2] = [2, 3];

/// Points of a triangle at which others are looked for, as weights of the second and third vertex.
const POINTS: [[f64; 2]; 4] = [[1.0 / 3.0, 1.0 / 3.0], [0.1, 0.15], [0.75, 0.1], [0.1, 0.75]];

/// Cubes that a triangle may meet before it counts as on everything.
const MAX_CUBES: i64 = 4096;

/// Points that a triangle is tried on at most: more lie beside it only in a heap of leaves.
const MAX_TRIED: u32 = 1024;

/// What may be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Glance {
    pub shells: bool,
    pub pairs: bool,
}

/// Looks at some of the `leaves`; `hashes` are those of the vertices' positions.
pub(super) fn at(mesh: &Mesh, leaves: &[u32], longest_m: f64, hashes: &[u64]) -> Glance {
    let wanted = (leaves.len() / ONE_OF).max(LOOKED_AT);
    if leaves.len() <= wanted {
        return Glance { shells: true, pairs: true };
    }
    let some: Vec<u32> = (0..wanted).map(|at| leaves[at * leaves.len() / wanted]).collect();
    let worth = |found: usize| found * WORTH_ONE_OF > wanted;
    Glance {
        shells: worth(surrounded(mesh, leaves, &some, hashes)),
        pairs: worth(covered(mesh, leaves, &some, longest_m)),
    }
}

/// How many of `some` have enough triangles around each of their corners.
fn surrounded(mesh: &Mesh, leaves: &[u32], some: &[u32], hashes: &[u64]) -> usize {
    let places = (some.len() * 3 * 8).next_power_of_two();
    let place = |vertex: u32| (hashes[vertex as usize] >> 24) as usize & (places - 1);
    // What shares a place by chance only makes the search begin in vain.
    let mut around = vec![0u8; places];
    let corners = |triangle: u32| mesh.triangles[triangle as usize];
    let mut wanted = vec![0u64; places.div_ceil(64)];
    for vertex in some.iter().flat_map(|&triangle| corners(triangle)) {
        wanted[place(vertex) / 64] |= 1 << (place(vertex) % 64);
    }
    for vertex in leaves.iter().flat_map(|&triangle| corners(triangle)) {
        let place = place(vertex);
        if wanted[place / 64] >> (place % 64) & 1 == 1 {
            around[place] = around[place].saturating_add(1);
        }
    }
    let is_surrounded = |triangle: &&u32| {
        let counts = corners(**triangle).map(|vertex| around[place(vertex)]);
        let [every, one] = AROUND;
        counts.iter().all(|&count| count >= every) && counts.iter().any(|&count| count >= one)
    };
    some.iter().filter(is_surrounded).count()
}

/// How many of `some` have other triangles on all of their points.
fn covered(mesh: &Mesh, leaves: &[u32], some: &[u32], longest_m: f64) -> usize {
    let flats: Vec<Option<Flat>> = some.iter().map(|&triangle| Flat::new(mesh, triangle)).collect();
    let mean_m =
        flats.iter().flatten().map(|flat| libm::sqrt(flat.area_m2())).sum::<f64>() / some.len() as f64;
    let cube_m = mean_m.max(longest_m * 1e-6);
    let cube = |point: DVec3| (point / cube_m).floor().as_i64vec3();
    let places = (some.len() * POINTS.len() * 4).next_power_of_two();
    let place = |[x, y, z]: [i64; 3]| {
        let mixed = (x as u64)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add((y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
            .wrapping_add((z as u64).wrapping_mul(0x1656_67b1_9e37_79f9));
        ((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32) as usize & (places - 1)
    };
    // `(place, number of the point)`, sorted.
    let mut points: Vec<(u32, u32)> = Vec::new();
    for (flat, number) in flats.iter().zip(0u32..) {
        let Some(flat) = flat else { continue };
        points.extend((0u32..).zip(POINTS).map(|(of, weights)| {
            (place(cube(flat.point(weights)).to_array()) as u32, number * POINTS.len() as u32 + of)
        }));
    }
    points.sort_unstable();
    let mut starts = vec![0u32; places + 1];
    points.iter().for_each(|point| starts[point.0 as usize + 1] += 1);
    (0..places).for_each(|place| starts[place + 1] += starts[place]);
    let list = |cell: [i64; 3]| {
        let place = place(cell);
        &points[starts[place] as usize..starts[place + 1] as usize]
    };
    let met_by = |&triangle: &u32| {
        let mut met = Vec::new();
        let Some(flat) = Flat::new(mesh, triangle) else { return met };
        let [low, high] = flat.low_and_high(longest_m).map(cube);
        let cubes = high - low + 1;
        if cubes.x.saturating_mul(cubes.y).saturating_mul(cubes.z) > MAX_CUBES {
            return met;
        }
        let mut left = MAX_TRIED;
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    for &(_, point) in list([x, y, z]) {
                        if left == 0 {
                            return met;
                        }
                        left -= 1;
                        let this = point as usize / POINTS.len();
                        let Some(of_point) = &flats[this] else { continue };
                        let at = of_point.point(POINTS[point as usize % POINTS.len()]);
                        let is_on = some[this] != triangle && flat.before(at, longest_m).is_some();
                        if is_on && of_point.is_parallel(&flat) {
                            met.push(point);
                        }
                    }
                }
            }
        }
        met
    };
    let mut met: Vec<u32> = leaves.par_iter().with_min_len(1024).flat_map_iter(met_by).collect();
    met.sort_unstable();
    met.dedup();
    met.chunk_by(|a, b| *a as usize / POINTS.len() == *b as usize / POINTS.len())
        .filter(|points| points.len() == POINTS.len())
        .count()
}
