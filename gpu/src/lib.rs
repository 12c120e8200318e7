//! A GPU, opened and watched: everything that goes wrong on it becomes an error that names it.
//!
//! ```text
//! adapters -find-> Found -Gpu::open-> Gpu -check, wait, read-> bytes, or a DeviceError
//! ```
//!
//! wgpu tells of faults by callbacks, some time after the call that caused them, and panics where no handler is set. A
//! [`Gpu`] listens, keeps the first fault, since the others follow from it, and tells it wherever results are taken:
//! nothing that a device computed after a fault can be trusted. Waiting ends after a while, so that a driver that hangs
//! is an error as well.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod adapter;
mod device;
mod error;
mod wait;

pub use adapter::{Found, find, find_alike};
pub use device::Gpu;
pub use error::DeviceError;

#[cfg(test)]
mod tests;
