//! The leaf triangles of a plant, and the blades that they are part of.

use crate::sheets::blades;
use crate::{ClassedMesh, MaterialClass};

/// Leaf triangles.
pub(super) struct Leaves {
    /// Indices of the triangles, ascending.
    pub triangles: Vec<u32>,
    /// Number of the blade of each: triangles that hold together by their corners are of one.
    pub blades: Vec<u32>,
}

impl Leaves {
    /// All of a plant.
    pub(super) fn of(plant: &ClassedMesh) -> Leaves {
        let mesh = &plant.mesh;
        let is_leaf = |&triangle: &u32| {
            plant.classes[mesh.triangle_material[triangle as usize] as usize] == MaterialClass::Leaf
        };
        let triangles: Vec<u32> = (0..mesh.triangles.len() as u32).filter(is_leaf).collect();
        Leaves { blades: blades(mesh, &triangles), triangles }
    }
}
