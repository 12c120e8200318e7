//! A window on a scene: a camera to move, a sun to turn, and how the light is coming along.
//!
//! ```text
//! keys, mouse -Controls-> Shot -Painter (a thread of its own)-> Painted -Screen-> window, or a file
//! ```
//!
//! [`Controls`] is state and nothing else. The [`Painter`](paint::Painter) streams the light of the scene's libraries
//! and draws with what has come so far, so that the picture gets finer by itself; on the CPU, or on a GPU that follows
//! it. The [`Screen`](screen::Screen) puts the picture and the panel into a texture: that of a window, or one that is
//! read back, which is how tests and `flb view --screenshot` see what a user would. Only `window.rs` knows windows.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod controls;
mod error;
mod marks;
mod on_gpu;
pub mod paint;
mod panel;
pub mod screen;
pub mod window;

pub use controls::{Controls, Shot, Show};
pub use error::ViewError;

#[cfg(test)]
mod tests;
