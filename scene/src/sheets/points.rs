//! Corners of leaves at one position have one number, and what shares such numbers is one blade.

use std::collections::HashMap;

use super::union::Union;
use crate::Mesh;

/// No number.
const NONE: u32 = u32::MAX;

/// Numbers the blades of leaves: triangles that hold together by their corners are of one. Returns a number for each
/// of `leaves`, below three times their count.
pub(crate) fn blades(mesh: &Mesh, leaves: &[u32]) -> Vec<u32> {
    let (points, count) = points(mesh, leaves);
    let mut union = Union::new(count);
    for &[a, b, c] in &points {
        union.join(a, b);
        union.join(b, c);
    }
    points.iter().map(|corners| union.root(corners[0])).collect()
}

/// Numbers the pieces of triangles: those that hold together by edges are of one. Returns a number for each of
/// `triangles`, below their count.
pub(crate) fn pieces(mesh: &Mesh, triangles: &[u32]) -> Vec<u32> {
    let (points, _) = points(mesh, triangles);
    let mut union = Union::new(triangles.len());
    let mut first: HashMap<[u32; 2], u32> = HashMap::with_capacity(2 * triangles.len());
    for (at, &[a, b, c]) in (0u32..).zip(&points) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let other = *first.entry([from.min(to), from.max(to)]).or_insert(at);
            union.join(at, other);
        }
    }
    (0..triangles.len() as u32).map(|at| union.root(at)).collect()
}

/// Returns per leaf the numbers of its corners, and how many numbers there are. Corners at one position have one
/// number.
pub(super) fn points(mesh: &Mesh, leaves: &[u32]) -> (Vec<[u32; 3]>, usize) {
    let mut number_of_vertex = vec![NONE; mesh.positions.len()];
    let places = (leaves.len() * 3).min(mesh.positions.len()).next_power_of_two() * 2;
    let mut table = vec![NONE; places];
    let mut count = 0u32;
    let bits = |vertex: u32| mesh.positions[vertex as usize].map(|coordinate| (coordinate + 0.0).to_bits());
    // `[number]`: a vertex at it.
    let mut vertex_of: Vec<u32> = Vec::new();
    let mut number = |vertex: u32| {
        if number_of_vertex[vertex as usize] != NONE {
            return number_of_vertex[vertex as usize];
        }
        let key = bits(vertex);
        let mixed = key.iter().fold(0x9e37_79b9_7f4a_7c15u64, |hash, &word| {
            let mixed = (hash ^ u64::from(word)).wrapping_mul(0xff51_afd7_ed55_8ccd);
            mixed ^ (mixed >> 32)
        });
        let mut place = mixed as usize & (places - 1);
        while table[place] != NONE && bits(vertex_of[table[place] as usize]) != key {
            place = (place + 1) & (places - 1);
        }
        if table[place] == NONE {
            table[place] = count;
            vertex_of.push(vertex);
            count += 1;
        }
        number_of_vertex[vertex as usize] = table[place];
        table[place]
    };
    let points = leaves.iter().map(|&triangle| mesh.triangles[triangle as usize].map(&mut number)).collect();
    (points, count as usize)
}
