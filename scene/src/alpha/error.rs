//! What can be wrong with a texture that says where a surface is.

/// A material whose coverage cannot be told.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AlphaError {
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
        /// Largest number of texels per edge.
        limit: u32,
    },
}
