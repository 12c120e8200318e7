//! Light transport through the matter of a lattice. Nothing here knows a mesh, a file or a scene.
//!
//! - [`ordinates`]: discrete ordinates through a turbid medium, the solver of the `physical` model, the default.
//! - [`lattice`]: Steele and Geist's lattice-Boltzmann solver of the `paper` model.
//! - [`monte_carlo`]: photons traced in the same turbid medium; what the fields of [`ordinates`] are judged by.
//! - [`cholesky`]: small systems of least squares.
//! - [`extremes`]: the two solvers at the ends of their ranges.
//! - [`gpu`]: the GPU that the first two may solve on.
//! - [`turbid`]: the medium's optics, which the first and the last share.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

pub mod cholesky;
mod ends;
pub mod extremes;
pub mod gpu;
pub mod lattice;
pub mod monte_carlo;
pub mod ordinates;
pub mod turbid;
