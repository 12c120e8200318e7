//! Why there is no such sky.

use std::path::PathBuf;

use super::clear::TURBIDITIES;

/// Everything that is refused of skies.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SkyError {
    /// A sun that stands nowhere.
    #[error("towards the sun: {found:?}, expected a direction: finite and not zero")]
    NoDirection {
        /// Direction as given.
        found: [f64; 3],
    },
    /// Air that the model knows nothing of.
    #[error("turbidity {found}, expected {} (very clear) to {} (thick haze)", TURBIDITIES.start(), TURBIDITIES.end())]
    Turbidity {
        /// Turbidity as given.
        found: f64,
    },
    /// A file that cannot be read.
    #[error("{}: cannot be read: {why}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        why: String,
    },
    /// An image that ends too soon, or holds what its format does not allow.
    #[error("{}: is no whole image: {why}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The decoder's reason.
        why: String,
    },
    /// A file of another kind.
    #[error("{}: begins with {found}, expected an OpenEXR (76 2f 31 01) or a Radiance HDR (#?) image", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
        /// First bytes of the file.
        found: String,
    },
    /// An image that is no sky by its size.
    #[error("{}: {found} pixels, expected {expected}", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// Width x height.
        found: String,
        /// Sizes that are allowed.
        expected: String,
    },
    /// A pixel that is no light.
    #[error("{}: pixel ({x}, {y}) band {band} is {found}, expected {expected}", path.display())]
    Pixel {
        /// The file.
        path: PathBuf,
        /// Column.
        x: usize,
        /// Row, from the top.
        y: usize,
        /// R, G or B.
        band: &'static str,
        /// Value of the pixel.
        found: f32,
        /// Values that are allowed.
        expected: &'static str,
    },
    /// Primaries that tell no colours.
    #[error("{}: {name} {found}: expected x and y of red, green and blue that are no line, and of a white", path.display())]
    Primaries {
        /// The file.
        path: PathBuf,
        /// Name of the primaries in the file.
        name: &'static str,
        /// x and y of red, green, blue and white.
        found: String,
    },
    /// A line of a Radiance header that cannot be followed.
    #[error("{}: found {found:?} in its header, expected {expected}", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// The line.
        found: String,
        /// Lines that would do.
        expected: &'static str,
    },
    /// Image above a limit of reading.
    #[error("{}: {what}: {found} is over the limit of {limit}", path.display())]
    Limit {
        /// The file.
        path: PathBuf,
        /// Name of what is counted.
        what: &'static str,
        /// Number or size that was found.
        found: u64,
        /// Largest number or size.
        limit: u64,
    },
    /// Image so dark that numbers have no room for a sky of fluence 1.
    #[error("{}: mean luminance {found:e}, expected {least:e} or more", path.display())]
    Dark {
        /// The file.
        path: PathBuf,
        /// Mean over the sphere.
        found: f64,
        /// Least mean luminance that would do.
        least: f64,
    },
    /// Image without light.
    #[error("{}: all pixels are black, expected light", path.display())]
    Black {
        /// The file.
        path: PathBuf,
    },
}
