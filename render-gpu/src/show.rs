//! What a picture shows.

/// Content of a picture: light or false colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Show {
    /// Light.
    #[default]
    Picture = 0,
    /// A colour for each instance.
    Instances = 1,
    /// Normals of the model's frame, 0 to 1 for -1 to 1.
    Normals = 2,
}
