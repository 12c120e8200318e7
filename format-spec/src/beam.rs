//! The beam of a sun inside a turbid medium, before any scattering, and its means around each site: what a reader needs
//! to follow for each sun, besides the stored fields (SPEC.md, section 10.4).
//!
//! ```text
//! Turbid + sun -tracks-> uncollided fluence per site -near-> means around each site
//! ```

mod near;
pub mod single;
mod tracks;
mod uncollided;

pub use near::{BEAM_RAYS, MAX_MEANS, Near, NearBeam, means, reaches};
pub use tracks::{Sites, Step};
pub use uncollided::{Beam, Passing, depth_per_edge, uncollided};
