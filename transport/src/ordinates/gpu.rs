//! The `physical` solver's marches on a GPU, for many suns side by side.
//!
//! The host lays the rays, follows the beams, and fits; the GPU scatters. Along each axis one dispatch marches: an
//! invocation takes a ray there and back for one lane, and writes what each segment adds to a slot of its own. A second
//! dispatch adds the slots of each site up, in the order of the axis. No two invocations write the same number, so one
//! GPU and driver give the same bytes every time. The light of an iteration stays on the GPU; after each pass the host
//! reads sums over the sites, and says how the lanes go on.
//!
//! ```text
//! March -rays-> buffers -first, gather-> x_1 -(send, march, gather, step, remember, measure, mix) x n-> light
//! ```
//!
//! The twin is the CPU's: [`super::scatter`], [`super::first`], [`super::source_iteration`].

mod bands;
mod device;
mod layout;
mod rays;
mod relax;
mod stages;
#[cfg(test)]
mod tests;
mod work;

pub(super) use bands::scatter;
pub(super) use device::{Gpu, open};
