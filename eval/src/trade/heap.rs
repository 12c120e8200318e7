//! Memory in use, which only a program knows that chose its allocator.

/// Count of the heap.
pub trait Heap: Sync {
    /// Returns the bytes that are in use.
    fn used_bytes(&self) -> u64;

    /// Returns the most bytes that were in use since the last [`Heap::reset_peak`].
    fn peak_bytes(&self) -> u64;

    /// Begins to measure the peak anew.
    fn reset_peak(&self);
}

/// Stand-in of a program that does not count its heap: rows have a peak of 0 bytes.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoHeap;

impl Heap for NoHeap {
    fn used_bytes(&self) -> u64 {
        0
    }

    fn peak_bytes(&self) -> u64 {
        0
    }

    fn reset_peak(&self) {}
}
