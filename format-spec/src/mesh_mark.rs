//! What marks a mesh, and whether the light of a species is of the mesh that a renderer draws (SPEC.md, section 9.2).
//!
//! The digest is of the triangles as a set: the order of vertices and triangles, indices, normals, texture coordinates,
//! names and the kind of file do not count. So a mesh keeps its digest through an exporter, a packer or a vertex cache
//! that moves no vertex, and light is the same for all of these. Classes and optics are no part of it: the file says
//! them beside it, and a renderer need not know them to ask.

use crate::SpeciesMeta;
use crate::meta::Bounds;

/// Largest distance of a side of a mesh's box from that of the file's for the light to fit, as a share of the longest
/// edge of the file's: levels of detail lose leaves and twigs at the rim. A wrong unit or up axis is off by more.
pub const FIT_SHARE: f64 = 0.1;

/// A mesh as a file remembers it.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshMark {
    /// Digest of the mesh by [`digest`].
    pub blake3: String,
    /// Bounds of leaves and wood, model space, metres. Triangles of neither class (a pot, the ground) do not count.
    pub bounds_m: Bounds,
}

impl MeshMark {
    /// Computes the mark of a mesh that is all leaf or wood, in model space, metres. `None` where there is no triangle,
    /// an index that no position has, or a coordinate that is not finite.
    pub fn of(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<MeshMark> {
        let blake3 = digest(positions, triangles)?;
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &index in triangles.as_flattened() {
            let point = positions[index as usize].map(f64::from);
            min = std::array::from_fn(|axis| min[axis].min(point[axis]));
            max = std::array::from_fn(|axis| max[axis].max(point[axis]));
        }
        Some(MeshMark { blake3, bounds_m: Bounds { min, max } })
    }
}

/// Digest of a mesh, 64 lower-case hexadecimal digits. `None` where there is no triangle, an index that no position
/// has, or a coordinate that is not finite.
pub fn digest(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<String> {
    let mut sums = [0u64; 4];
    for triangle in triangles {
        let mut corners = [[0u32; 3]; 3];
        for (corner, index) in corners.iter_mut().zip(triangle) {
            let point = positions.get(*index as usize).filter(|point| point.iter().all(|x| x.is_finite()))?;
            *corner = point.map(|x| (x + 0.0).to_bits()); // -0 becomes +0
        }
        corners.sort_unstable();
        let mut bytes = [0; 36];
        for (bytes, bits) in bytes.chunks_exact_mut(4).zip(corners.as_flattened()) {
            bytes.copy_from_slice(&bits.to_le_bytes());
        }
        let hash = blake3::hash(&bytes);
        for (sum, word) in sums.iter_mut().zip(hash.as_bytes().chunks_exact(8)) {
            *sum = sum.wrapping_add(u64::from_le_bytes(word.try_into().expect("eight bytes")));
        }
    }
    if triangles.is_empty() {
        return None;
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(triangles.len() as u64).to_le_bytes());
    sums.iter().for_each(|sum| _ = hasher.update(&sum.to_le_bytes()));
    Some(hasher.finalize().to_hex().to_string())
}

/// Relation of a mesh to the light of a species.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeshMatch {
    /// The light is of this mesh.
    Same,
    /// The light is of another mesh: where the fit is good, perhaps of another level of detail of one plant.
    Differs(MeshFit),
    /// The file does not say which mesh its light is of; the boxes can be compared all the same.
    Unknown(MeshFit),
}

impl MeshMatch {
    /// Compares the mesh that the light of a species was baked from with a mesh.
    pub fn of(meta: &SpeciesMeta, mesh: &MeshMark) -> MeshMatch {
        let fit = MeshFit::of(&meta.bounds_m, &mesh.bounds_m);
        match &meta.mesh_blake3 {
            Some(baked) if *baked == mesh.blake3 => MeshMatch::Same,
            Some(_) => MeshMatch::Differs(fit),
            None => MeshMatch::Unknown(fit),
        }
    }

    /// Whether points of the mesh lie where the light is: of the same mesh always.
    pub fn fits(&self) -> bool {
        match self {
            MeshMatch::Same => true,
            MeshMatch::Differs(fit) | MeshMatch::Unknown(fit) => fit.is_good(),
        }
    }

    /// The word of it in JSON.
    pub fn name(&self) -> &'static str {
        match self {
            MeshMatch::Same => "same",
            MeshMatch::Differs(_) => "differs",
            MeshMatch::Unknown(_) => "unknown",
        }
    }
}

/// Distance between two bounding boxes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshFit {
    /// Largest distance between a side of one and the same side of the other, metres.
    pub off_m: f64,
    /// Longest edge of the file's, metres.
    pub longest_m: f64,
}

impl MeshFit {
    fn of(baked: &Bounds, found: &Bounds) -> MeshFit {
        let sides = |a: [f64; 3], b: [f64; 3]| (0..3).map(|axis| (a[axis] - b[axis]).abs()).fold(0.0, larger);
        let off_m = larger(sides(baked.min, found.min), sides(baked.max, found.max));
        let longest_m = (0..3).map(|axis| baked.max[axis] - baked.min[axis]).fold(0.0, f64::max);
        MeshFit { off_m, longest_m }
    }

    /// Whether the distance is within [`FIT_SHARE`].
    pub fn is_good(&self) -> bool {
        self.off_m <= FIT_SHARE * self.longest_m
    }
}

/// As `max`, but what is no number stays none, and fits nothing.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

#[cfg(test)]
mod tests;
