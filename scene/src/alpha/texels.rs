//! Boxes of texels, by whole numbers that have not been wrapped into an image.

/// Texels `min..=max` along u and v, not yet wrapped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TexelBox {
    /// First texel.
    pub min: [i64; 2],
    /// Last texel.
    pub max: [i64; 2],
}

/// A coordinate rounded down, as an index; beyond 2^52, where whole numbers end, the sign is all that counts.
#[inline]
pub fn index(coordinate: f64) -> i64 {
    const LIMIT: f64 = (1u64 << 52) as f64;
    let clamped = coordinate.clamp(-LIMIT, LIMIT);
    let whole = clamped as i64;
    whole - i64::from(whole as f64 > clamped)
}

impl TexelBox {
    /// The texels whose inside the box of real coordinates meets; a box without extent along an axis that
    /// lies on the border of two texels counts for the upper one.
    #[inline]
    pub fn of(min: [f64; 2], max: [f64; 2]) -> TexelBox {
        let low = min.map(index);
        let high = std::array::from_fn(|axis| (-index(-max[axis]) - 1).max(low[axis]));
        TexelBox { min: low, max: high }
    }

    /// Returns the box moved into `outer` along each axis.
    #[inline]
    pub fn clamped(self, outer: &TexelBox) -> TexelBox {
        let clamp = |c: [i64; 2]| std::array::from_fn(|axis| c[axis].clamp(outer.min[axis], outer.max[axis]));
        TexelBox { min: clamp(self.min), max: clamp(self.max) }
    }
}
