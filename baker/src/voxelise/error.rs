//! What can be wrong with a mesh or with settings, seen from voxelising and downsampling.

use flb_format::progress::Cancelled;
use flb_scene::alpha::AlphaError;

/// A mesh, occupancy or settings that cannot be voxelised or downsampled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VoxelError {
    /// The lattice is not allowed.
    #[error("lattice {found}: expected a power of two from 16 to 256")]
    Lattice {
        /// Sites per edge asked for.
        found: u32,
    },
    /// The voxel grid is not allowed.
    #[error(
        "voxels {found}: expected a multiple of 8 and of the lattice ({lattice}), from {lattice} to {limit}"
    )]
    Voxels {
        /// Voxels per edge asked for.
        found: u32,
        /// The lattice beside it.
        lattice: u32,
        /// Largest number of voxels per edge.
        limit: u32,
    },
    /// Number of material classes that is not that of the materials.
    #[error("{found} material classes for a mesh of {expected} materials")]
    Classes {
        /// Classes given.
        found: usize,
        /// Materials of the mesh.
        expected: usize,
    },
    /// Mesh without a triangle of leaf or wood.
    #[error("no triangle is leaf or wood: there is nothing to voxelise")]
    NothingToVoxelise,
    /// A vertex lies nowhere.
    #[error("vertex {vertex} lies at {position:?}: expected finite coordinates")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Position of the vertex.
        position: [f32; 3],
    },
    /// The plant has no size, or no usable one.
    #[error(
        "the leaf and wood triangles span {min:?} to {max:?} m: expected finite bounds with an extent above 0"
    )]
    Extent {
        /// Smallest coordinates, metres.
        min: [f64; 3],
        /// Largest coordinates, metres.
        max: [f64; 3],
    },
    /// A material's texture cannot be read for its coverage.
    #[error(transparent)]
    Alpha(#[from] AlphaError),
    /// An occupancy's parts contradict each other.
    #[error("occupancy: {place}: {fault}")]
    Occupancy {
        /// Part of the occupancy.
        place: String,
        /// Value that was found, and what was expected.
        fault: String,
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
