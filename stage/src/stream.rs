//! Pictures of a stage in the light of what has come of its libraries so far, within a budget: what a viewer shows.

mod marks;
#[cfg(not(feature = "gpu"))]
#[path = "stream/no_gpu.rs"]
mod on_gpu;
#[cfg(feature = "gpu")]
mod on_gpu;
mod painter;
mod shot;

pub use painter::{Painted, Painter, Progress};
pub use shot::{Shot, Show};

#[cfg(all(test, feature = "gpu"))]
mod tests;
