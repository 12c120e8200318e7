//! What tells two lattices of a scene apart.

use super::Stand;

/// BLAKE3 of all that a stand's light depends on, beside the settings of its solve and its mean surfaces.
pub fn stand_digest(stand: &Stand) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    stand.turbid.feed(|bytes| {
        hasher.update(bytes);
    });
    for value in stand.albedos.as_flattened().iter().chain([&stand.below]) {
        hasher.update(&value.to_le_bytes());
    }
    *hasher.finalize().as_bytes()
}
