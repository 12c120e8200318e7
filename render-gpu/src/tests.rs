//! The renderer on a GPU against its twin on the CPU. They need an adapter, and fail without one; lavapipe (`scripts/setup test` installs it)
//! will do.

mod among;
mod faults;
mod fleet;
mod lit;
pub mod scenes;
mod traced;
mod water;
mod ways;
mod wgsl;
