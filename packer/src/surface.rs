//! Where the error of a coding is measured: points inside non-empty sites, as a renderer samples at surfaces.

use flb_format::Medium;
use flb_format::matter::Class;
use flb_format::sample::site_of;

/// Sample points in every non-empty site.
pub const POINTS_PER_SITE: u32 = 2;

/// Indices of the non-empty sites, ascending.
pub(crate) fn surface_sites(medium: &Medium) -> Vec<u32> {
    (0u32..).zip(&medium.class).filter(|(_, class)| **class != Class::Empty).map(|(i, _)| i).collect()
}

/// The `k`-th sample point of a site, in lattice coordinates (site i covers i..i+1). The offsets come
/// from a hash of the site, 20 bits an axis (SplitMix64's finaliser: Steele, Lea and Flood 2014).
pub fn surface_point(site: u32, k: u32, lattice: u32) -> [f64; 3] {
    let mut h =
        (u64::from(site) * u64::from(POINTS_PER_SITE) + u64::from(k) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    h = (h ^ (h >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    h ^= h >> 31;
    let at = site_of(site as usize, lattice);
    std::array::from_fn(|axis| f64::from(at[axis]) + ((h >> (20 * axis)) & 0xF_FFFF) as f64 / 1_048_576.0)
}
