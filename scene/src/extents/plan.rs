//! The plan of a plant's parts over the ground: where they stand, and where their middles are.

use flb_format::meta::Bounds;

use crate::mesh::{Foot, PartUse};
use crate::{ClassedMesh, MaterialClass};

/// A plant stands where its foot is no more than this above the lowest of all, as a share of the height of all.
pub(super) const MAX_FOOT: f64 = 0.1;

/// The foot of the wood among these uses that begins lowest.
pub(super) fn foot<'u>(plant: &ClassedMesh, uses: impl Iterator<Item = &'u PartUse>) -> Option<Foot> {
    let wood = uses.filter(|used| plant.classes[used.material as usize] == MaterialClass::Wood);
    wood.min_by(|a, b| a.bounds_m.min[1].total_cmp(&b.bounds_m.min[1])).map(|used| used.foot)
}

/// Middle of a box.
pub(super) fn middle(bounds: &Bounds) -> [f64; 3] {
    std::array::from_fn(|axis| bounds.min[axis].midpoint(bounds.max[axis]))
}

/// Longer edge of a box over the ground.
pub(super) fn width(bounds: &Bounds) -> f64 {
    (bounds.max[0] - bounds.min[0]).max(bounds.max[2] - bounds.min[2])
}

/// Distance over the ground.
pub(super) fn over_ground(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::hypot(a[0] - b[0], a[2] - b[2])
}
