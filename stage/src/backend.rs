//! Where frames are made.

/// Number of GPUs that draw a frame together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GpuCount {
    /// All that there are.
    All,
    /// The best so many.
    Exactly(usize),
}

/// Device on which frames are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Backend {
    /// Frames on the CPU.
    Cpu,
    /// Frames on GPUs, or not at all.
    Gpu(GpuCount),
    /// Frames on GPUs where there is one that is no software and it can show the scene; else on the CPU.
    Auto(GpuCount),
}
