//! Leaves that a mesh states twice: a sheet for either side, or a closed shell around it.
//!
//! ```text
//! Mesh, classes -Sheets::find-> which side of its leaf each triangle stands for, and what is there twice
//! ```
//!
//! Everything downstream takes a leaf triangle for a whole leaf: light falls on both of its sides and passes through
//! it. A mesh that has a second triangle for the back of every leaf, or a needle that is a closed tube, would have each
//! leaf twice. So such a triangle *stands for one side*, the outer one: a ray meets it from that side alone, and half
//! of its area counts. A ray through the leaf then meets it once, from whichever side it comes.
//!
//! - Triangles over the same three points, of several materials (`coincident.rs`): wood is there once and goes before
//!   leaf, what is neither leaf nor wood goes last. Two leaves are two sides.
//! - Closed shells of leaf that are thin against the plant and against themselves (`shells.rs`).
//! - Leaf sheets that lie on each other, or nearly (`pairs.rs`).
//!
//! All of it is a pure function of the triangles, their alpha and the classes: a renderer finds what the bake found.

mod coincident;
mod glance;
mod grid;
mod pairs;
mod points;
mod shells;
#[cfg(test)]
mod tests;
mod union;

use crate::mesh::sides::{Sheets, Side};
use crate::{MaterialClass, Mesh};
pub(crate) use points::{blades, pieces};

/// Finds what is there twice, and tells it in `mesh.sheets`. Triangles that lie exactly on those of another material
/// and are no other side of them are dropped, as are third sheets of a leaf. `classes` has one entry per material;
/// where it has not, or where an index or coordinate of the mesh is not valid, nothing is found: the stages that read
/// the mesh say what is wrong with it.
pub fn find(mesh: &mut Mesh, classes: &[MaterialClass]) {
    mesh.sheets = Sheets::default();
    if !is_sound(mesh, classes) {
        return;
    }
    let hashes = coincident::hashes(mesh);
    let dropped = coincident::drop(mesh, classes, &hashes);
    let is_leaf =
        |&triangle: &u32| classes[mesh.triangle_material[triangle as usize] as usize] == MaterialClass::Leaf;
    let leaves: Vec<u32> = (0..mesh.triangles.len() as u32).filter(is_leaf).collect();
    let mut found = Sheets { dropped, ..Sheets::default() };
    let Some(longest_m) = longest_m(mesh, classes).filter(|_| !leaves.is_empty()) else {
        mesh.sheets = found;
        return;
    };
    let glance = glance::at(mesh, &leaves, longest_m, &hashes);
    if glance.shells {
        shells::find(mesh, &leaves, longest_m, &mut found);
    }
    let hidden = if glance.pairs { pairs::find(mesh, &leaves, longest_m, &mut found) } else { Vec::new() };
    if !hidden.is_empty() {
        let mut keep = vec![true; mesh.triangles.len()];
        hidden.iter().for_each(|&triangle| keep[triangle as usize] = false);
        found.further = hidden.len() as u64;
        let mut kept = keep.iter();
        found.sides.retain(|_| *kept.next().expect("one flag per triangle"));
        retain(mesh, &keep);
    }
    mesh.sheets = found;
}

/// Gives a triangle a side.
fn set(found: &mut Sheets, mesh: &Mesh, triangle: u32, side: Side) {
    if found.sides.is_empty() {
        found.sides = vec![Side::Both; mesh.triangles.len()];
    }
    found.sides[triangle as usize] = side;
}

/// Keeps triangles; vertices that none uses any more stay.
fn retain(mesh: &mut Mesh, keep: &[bool]) {
    let mut kept = keep.iter();
    mesh.triangles.retain(|_| *kept.next().expect("one flag per triangle"));
    let mut kept = keep.iter();
    mesh.triangle_material.retain(|_| *kept.next().expect("one flag per triangle"));
}

fn is_sound(mesh: &Mesh, classes: &[MaterialClass]) -> bool {
    let vertices = mesh.positions.len() as u32;
    classes.len() == mesh.materials.len()
        && mesh.triangle_material.len() == mesh.triangles.len()
        && mesh.triangle_material.iter().all(|&material| (material as usize) < classes.len())
        && mesh.triangles.as_flattened().iter().all(|&vertex| vertex < vertices)
        && mesh.positions.as_flattened().iter().all(|coordinate| coordinate.is_finite())
}

/// The longest edge of the box around leaves and wood, metres.
fn longest_m(mesh: &Mesh, classes: &[MaterialClass]) -> Option<f64> {
    let materials = mesh.triangles.iter().zip(&mesh.triangle_material);
    let counts = materials.filter(|(_, material)| classes[**material as usize] != MaterialClass::Neither);
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for &vertex in counts.flat_map(|(corners, _)| corners) {
        let at = mesh.positions[vertex as usize];
        low = std::array::from_fn(|axis| low[axis].min(at[axis]));
        high = std::array::from_fn(|axis| high[axis].max(at[axis]));
    }
    let longest = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis])).fold(0.0, f64::max);
    (longest > 0.0).then_some(longest)
}

/// Corners of a triangle, metres.
pub(crate) fn corners(mesh: &Mesh, triangle: u32) -> [glam::DVec3; 3] {
    mesh.corners_m(triangle as usize).map(glam::DVec3::from_array)
}
