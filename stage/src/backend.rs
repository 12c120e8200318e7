//! Where frames are made.

/// How many GPUs draw a frame together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GpuCount {
    /// All that there are.
    All,
    /// The best so many.
    Exactly(usize),
}

/// Where frames are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Backend {
    /// On the CPU.
    Cpu,
    /// On GPUs, or not at all.
    Gpu(GpuCount),
    /// On GPUs where there is one that is no software and it can show the scene; else on the CPU.
    Auto(GpuCount),
}
