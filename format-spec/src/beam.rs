//! The beam of a sun inside a turbid medium, before any scattering, and its means around each site: what a reader needs
//! to follow for each sun, besides the stored fields (SPEC.md, section 10.4).
//!
//! ```text
//! TurbidMedium + sun -sweep-> uncollided fluence per site -near-> means around each site
//! ```

mod crossings;
mod near;
mod passing;
pub mod single;
mod sites;
mod sweep;
mod uncollided;
#[cfg(any(test, feature = "testing"))]
pub mod walk;

pub use crossings::{Crossing, crossings};
pub use near::{BEAM_RAYS, MAX_MEANS, Near, NearBeam, means, reaches};
pub use passing::Passing;
pub use sites::Sites;
pub use uncollided::{Beam, depth_per_edge, uncollided};
