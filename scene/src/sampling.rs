//! Points and numbers that fill their range evenly, without chance.

use std::f32::consts::TAU;

use glam::Vec3;

/// Points that fill the unit square evenly, however many are taken: the additive sequence of the plastic
/// number (R2, M. Roberts 2018), turned by a hash of the seed.
pub fn r2_sequence(seed: u32, point: u32) -> [f32; 2] {
    const STEP: [u32; 2] = [3_242_174_889, 2_447_445_414]; // 1/p and 1/p^2 as fractions of 2^32
    let turn = hash(seed);
    let turns = [turn, hash(turn)];
    [0, 1].map(|axis| {
        let fraction = turns[axis].wrapping_add(point.wrapping_mul(STEP[axis]));
        (fraction >> 8) as f32 / (1u32 << 24) as f32
    })
}

/// A point of a triangle by the [`r2_sequence`], even by area: weights of its second and third vertex.
pub fn on_triangle(seed: u32, point: u32) -> [f32; 2] {
    let [u, v] = r2_sequence(seed, point);
    // The half of the square beyond the diagonal, turned onto the triangle.
    if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] }
}

/// A bijective 32-bit mix (two rounds of xorshift-multiply).
pub fn hash(value: u32) -> u32 {
    let mut v = value.wrapping_add(0x9e37_79b9);
    v = (v ^ (v >> 16)).wrapping_mul(0x21f0_aaad);
    v = (v ^ (v >> 15)).wrapping_mul(0x735a_2d97);
    v ^ (v >> 15)
}

/// A unit vector on the side of `normal`, by its cosine where `height` and `turn` are even in 0..1: a point of the unit
/// sphere that touches the surface from above, seen from where it touches.
pub fn cosine_hemisphere(normal: Vec3, height: f32, turn: f32) -> Vec3 {
    let y = 2.0 * height - 1.0;
    let (sin, cos) = libm::sincosf(TAU * turn);
    let level = (1.0 - y * y).max(0.0).sqrt();
    (normal + Vec3::new(level * cos, y, level * sin)).normalize_or(normal)
}
