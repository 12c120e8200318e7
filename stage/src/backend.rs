//! Where frames are made.

/// Number of GPUs that draw a frame together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GpuCount {
    /// All that there are.
    All,
    /// The best so many.
    Exactly(usize),
}

impl GpuCount {
    /// Largest number that is opened.
    pub fn most(self) -> usize {
        match self {
            GpuCount::All => usize::MAX,
            GpuCount::Exactly(count) => count,
        }
    }

    /// The number that was asked for, where so many are fewer.
    pub fn missed_by(self, found: usize) -> Option<usize> {
        match self {
            GpuCount::Exactly(count) if found < count => Some(count),
            _ => None,
        }
    }
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
