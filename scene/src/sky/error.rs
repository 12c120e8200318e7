//! Why there is no such sky.

use std::path::PathBuf;

use super::clear::TURBIDITIES;

/// Everything that is refused of skies.
#[derive(Debug, thiserror::Error)]
pub enum SkyError {
    /// A sun that stands nowhere.
    #[error("towards the sun: {found:?}, expected a direction: finite and not zero")]
    NoDirection {
        /// As given.
        found: [f64; 3],
    },
    /// Air that the model knows nothing of.
    #[error("turbidity {found}, expected {} (very clear) to {} (thick haze)", TURBIDITIES.start(), TURBIDITIES.end())]
    Turbidity {
        /// As given.
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
        /// Its first bytes.
        found: String,
    },
    /// An image that is no sky by its size.
    #[error("{}: {found} pixels, expected {expected}", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// Width x height.
        found: String,
        /// What is allowed.
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
        /// Its value.
        found: f32,
        /// What is allowed.
        expected: &'static str,
    },
    /// No light at all.
    #[error("{}: all pixels are black, expected light", path.display())]
    Black {
        /// The file.
        path: PathBuf,
    },
}
