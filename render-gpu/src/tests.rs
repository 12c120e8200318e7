//! The renderer on a GPU against its twin on the CPU. They need an adapter, and fail without one; lavapipe
//! (`scripts/setup test` installs it) will do.

mod among;
mod faults;
mod fleet;
mod lit;
mod sky;
mod traced;
mod water;
mod ways;
mod wgsl;

use flb_gpu::Gpu;

fn gpu() -> Gpu {
    // The message says what to install.
    Gpu::open(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}"))
}
