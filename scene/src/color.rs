//! What the texels of a plant's materials mean, and what its leaves and wood reflect in the mean.
//!
//! A texture is either a *tint*, which says where a surface of measured reflectance is brighter or darker than its
//! mean, or an *albedo*, which is the reflectance itself. Green leaves are a tint: their spectra are known better than
//! any picture tells, as cameras, drawings and exporters all change colours a little. Red leaves are no green leaf of
//! another brightness. Where it is not said which it is, a texture near the measured colour is a tint, and any other
//! an albedo (`evidence.rs`).
//!
//! ```text
//! ClassedMesh, Surfaces, ColorRules -resolve-> Colors: a surface per material, the mean of leaf and of wood
//! Material -law-> Law (flb_format::surface); texel -Law-> reflectance and transmittance
//! ```

mod evidence;
mod law;
mod points;
mod resolve;
mod rules;
#[cfg(test)]
mod tests;
pub mod words;

pub use evidence::{Difference, Evidence, MAX_APART, apart};
pub use law::law;
pub use points::{mean_colors, on_surface};
pub use resolve::{Colors, MaterialColor, MeanShares, resolve};
pub use rules::{ColorRule, ColorRules, ColorSource, SurfaceSet};
