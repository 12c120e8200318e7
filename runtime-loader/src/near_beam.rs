//! The near beam of a sun (SPEC.md, section 10.4) in a medium: at all sites at once, or by marches from points.

pub(crate) mod dense;
mod march;
pub(crate) mod ring;
mod sites;

use flb_format::beam::MAX_MEANS;

#[cfg(all(test, feature = "gpu"))]
pub(crate) use march::CANDIDATES;
pub(crate) use march::everywhere;
pub use march::{Marcher, RayOffsets, offset, seed_of};
pub use ring::SunRing;
pub(crate) use sites::MediumSites;

use crate::sun_terms::SunTerms;

/// A sun made ready: its terms, and its near beam in every non-empty site where the species needs one.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedSun {
    /// Factors that the sun's direction gives each field.
    pub terms: SunTerms,
    /// `[place]`
    pub(crate) near: Vec<[f32; MAX_MEANS]>,
}

impl PreparedSun {
    /// Memory of the prepared sun, bytes.
    pub fn size_bytes(&self) -> usize {
        size_of_val(&self.near[..])
    }
}
