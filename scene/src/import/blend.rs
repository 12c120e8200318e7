//! Texture coordinates for surfaces that are there in part, the same part everywhere, and have no image: a dither asks
//! where on the surface it is.

use std::collections::HashMap;

use crate::mesh::{AlphaMode, Mesh};

/// From a point to texture coordinates, in turns over the longest edge of the mesh: two directions that lie along no
/// axis, so that neither a wall nor a level leaf falls on a line.
const TURNS: [[f32; 3]; 2] = [[16.0, 5.07, 8.49], [4.33, 15.7, -9.79]];

/// Gives their vertices texture coordinates by where they stand; those that another material shares are doubled.
pub(super) fn place_blends(mut mesh: Mesh) -> Mesh {
    let is_placed: Vec<bool> = mesh
        .materials
        .iter()
        .map(|m| m.alpha_mode == AlphaMode::Blend && m.color_texture.is_none() && m.alpha_texture.is_none())
        .collect();
    if !is_placed.contains(&true) {
        return mesh;
    }
    let Some(bounds) = mesh.bounds() else { return mesh };
    let longest =
        (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(f64::MIN_POSITIVE, f64::max) as f32;
    let is_of = |triangle: usize| is_placed[mesh.triangle_material[triangle] as usize];
    let mut is_shared = vec![false; mesh.positions.len()];
    for triangle in (0..mesh.triangles.len()).filter(|&triangle| !is_of(triangle)) {
        mesh.triangles[triangle].iter().for_each(|&vertex| is_shared[vertex as usize] = true);
    }
    let mut doubles: HashMap<u32, u32> = HashMap::new();
    for triangle in
        (0..mesh.triangles.len()).filter(|&triangle| is_placed[mesh.triangle_material[triangle] as usize])
    {
        for corner in 0..3 {
            let vertex = mesh.triangles[triangle][corner];
            let vertex = match is_shared[vertex as usize] {
                true => *doubles.entry(vertex).or_insert_with(|| {
                    mesh.positions.push(mesh.positions[vertex as usize]);
                    mesh.normals.push(mesh.normals[vertex as usize]);
                    mesh.uvs.push([0.0; 2]);
                    if !mesh.colors.is_empty() {
                        mesh.colors.push(mesh.colors[vertex as usize]);
                    }
                    is_shared.push(false);
                    mesh.positions.len() as u32 - 1
                }),
                false => vertex,
            };
            mesh.triangles[triangle][corner] = vertex;
            let point = mesh.positions[vertex as usize];
            mesh.uvs[vertex as usize] =
                TURNS.map(|row| (0..3).map(|axis| row[axis] * (point[axis] / longest)).sum());
        }
    }
    mesh
}
