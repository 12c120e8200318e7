//! Digests that tell two lattices of a scene apart.

use flb_format::matter::TurbidMedium;

use super::Stand;

/// BLAKE3 of a medium.
pub fn matter_digest(turbid: &TurbidMedium) -> [u8; 32] {
    *fed_with(turbid).finalize().as_bytes()
}

/// BLAKE3 of all that a stand's light depends on, beside the settings of its solve and its mean surfaces.
pub fn stand_digest(stand: &Stand) -> [u8; 32] {
    let mut hasher = fed_with(&stand.turbid);
    for value in stand.albedos.as_flattened().iter().chain([&stand.below]) {
        hasher.update(&value.to_le_bytes());
    }
    *hasher.finalize().as_bytes()
}

fn fed_with(turbid: &TurbidMedium) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    turbid.feed(|bytes| {
        hasher.update(bytes);
    });
    hasher
}
