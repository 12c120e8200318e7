//! A window on a scene: a camera to move, a sun to turn, and how the light is coming along.
//!
//! ```text
//! keys, mouse -Controls-> Shot -flb_stage's Painter (a thread of its own)-> Painted -Screen-> window, or a file
//! ```
//!
//! [`Controls`] is state and nothing else. The [`Painter`](flb_stage::stream::Painter) streams the light of the
//! scene's libraries and draws with what has come so far, so that the picture gets finer by itself; on the CPU, or on
//! a GPU that follows it. The [`Screen`](screen::Screen) puts the picture and the panel into a texture: that of a
//! window, or one that is read back, which is how tests and `flb view --screenshot` see what a user would. Only
//! `window.rs` knows windows.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod controls;
mod error;
mod panel;
pub mod screen;
pub mod window;

pub use controls::Controls;
pub use error::ViewError;
pub use flb_stage::stream::{Shot, Show};

#[cfg(test)]
mod tests;
