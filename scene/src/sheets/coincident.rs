//! Triangles over the same three points, of several materials.

use rayon::prelude::*;

use crate::{MaterialClass, Mesh};

/// Drops, of triangles over the same three points in any order, all but the first wood; without wood all but leaves;
/// without either all but the first. Leaves of several materials stay: [`super::pairs`] finds out which are two sides
/// of one leaf. `hashes` are those of [`hashes`]. Returns how many were dropped.
pub(super) fn drop(mesh: &mut Mesh, classes: &[MaterialClass], hashes: &[u64]) -> u64 {
    let Some(first) = mesh.triangle_material.first() else { return 0 };
    // Import has dropped those of one material.
    if mesh.triangle_material.iter().all(|material| material == first) {
        return 0;
    }
    let of = |triangle: u32| {
        let corners = mesh.triangles[triangle as usize];
        corners.iter().fold(0u64, |sum, &vertex| sum.wrapping_add(hashes[vertex as usize]))
    };
    // Those whose hash comes once more, by a bit a hash: nearly all have none.
    let bits = (mesh.triangles.len() * 16).next_power_of_two();
    let mut seen = vec![0u64; bits.div_ceil(64)];
    let mut again = vec![0u64; bits.div_ceil(64)];
    let place = |hash: u64| ((hash >> 20) as usize & (bits - 1), 1u64 << ((hash >> 20) & 63));
    for triangle in 0..mesh.triangles.len() as u32 {
        let (at, bit) = place(of(triangle));
        again[at / 64] |= seen[at / 64] & bit;
        seen[at / 64] |= bit;
    }
    if again.iter().all(|word| *word == 0) {
        return 0;
    }
    let comes_again = |&triangle: &u32| {
        let (at, bit) = place(of(triangle));
        again[at / 64] & bit != 0
    };
    let mut hashed: Vec<(u64, u32)> = (0..mesh.triangles.len() as u32)
        .filter(comes_again)
        .map(|triangle| (of(triangle), triangle))
        .collect();
    hashed.par_sort_unstable();
    let mut gone: Vec<u32> = Vec::new();
    for run in hashed.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
        let mut same: Vec<([[u32; 3]; 3], u32)> =
            run.iter().map(|&(_, triangle)| (points(mesh, triangle), triangle)).collect();
        same.sort_unstable();
        for group in same.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
            let class = |&(_, triangle): &([[u32; 3]; 3], u32)| {
                classes[mesh.triangle_material[triangle as usize] as usize]
            };
            let first_of = |wanted| group.iter().find(|one| class(one) == wanted);
            let keeps_leaves =
                first_of(MaterialClass::Wood).is_none() && first_of(MaterialClass::Leaf).is_some();
            let kept = first_of(MaterialClass::Wood).unwrap_or(&group[0]);
            let goes = |one: &&([[u32; 3]; 3], u32)| match keeps_leaves {
                true => class(one) != MaterialClass::Leaf,
                false => one.1 != kept.1,
            };
            gone.extend(group.iter().filter(goes).map(|one| one.1));
        }
    }
    if gone.is_empty() {
        return 0;
    }
    let mut keep = vec![true; mesh.triangles.len()];
    gone.iter().for_each(|&triangle| keep[triangle as usize] = false);
    super::retain(mesh, &keep);
    gone.len() as u64
}

/// The bits of a triangle's corners, sorted; -0 counts as 0.
fn points(mesh: &Mesh, triangle: u32) -> [[u32; 3]; 3] {
    let mut points = mesh.triangles[triangle as usize]
        .map(|vertex| mesh.positions[vertex as usize].map(|coordinate| (coordinate + 0.0).to_bits()));
    points.sort_unstable();
    points
}

/// A hash of the position of each vertex; -0 counts as 0.
pub(super) fn hashes(mesh: &Mesh) -> Vec<u64> {
    let of = |position: &[f32; 3]| {
        position.iter().fold(0x9e37_79b9_7f4a_7c15, |hash: u64, &coordinate| {
            let mixed = (hash ^ u64::from((coordinate + 0.0).to_bits())).wrapping_mul(0xff51_afd7_ed55_8ccd);
            mixed ^ (mixed >> 32)
        })
    };
    mesh.positions.par_iter().with_min_len(4096).map(of).collect()
}
