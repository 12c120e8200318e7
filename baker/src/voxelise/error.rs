//! What can be wrong with a mesh or with settings, seen from voxelising and downsampling.

/// A mesh, occupancy or settings that cannot be voxelised or downsampled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
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
        /// Most voxels per edge.
        limit: u32,
    },
    /// One class per material is needed.
    #[error("{found} material classes for a mesh of {expected} materials")]
    Classes {
        /// Classes given.
        found: usize,
        /// Materials of the mesh.
        expected: usize,
    },
    /// No triangle has a leaf or wood material.
    #[error("no triangle is leaf or wood: there is nothing to voxelise")]
    NothingToVoxelise,
    /// A vertex lies nowhere.
    #[error("vertex {vertex} lies at {position:?}: expected finite coordinates")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Its position.
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
    /// A material's texture names no image.
    #[error("material {material:?} uses image {image} of a mesh with {images} images")]
    NoSuchImage {
        /// Name of the material.
        material: String,
        /// Index of the image.
        image: u32,
        /// Images of the mesh.
        images: usize,
    },
    /// An image's bytes do not match its size, or it is too large.
    #[error(
        "image {image:?}: {width} x {height} texels with {bytes} bytes of RGBA: expected 1 to {limit} texels each way and 4 bytes each"
    )]
    ImageSize {
        /// Name of the image.
        image: String,
        /// Texels per row.
        width: u32,
        /// Rows.
        height: u32,
        /// Bytes found.
        bytes: usize,
        /// Most texels per edge.
        limit: u32,
    },
    /// An occupancy's parts contradict each other.
    #[error("occupancy: {place}: {fault}")]
    Occupancy {
        /// Which part.
        place: String,
        /// What was found, and what was expected.
        fault: String,
    },
}
