//! What a material's triangles are to the light.

/// The class of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MaterialClass {
    /// Lets light through and scatters it.
    Leaf,
    /// Opaque, scatters back.
    Wood,
    /// Left out of the medium.
    Neither,
}
