//! From the sun's direction to the three bases and weights that make its light.
//!
//! The 18 unit directions span a polyhedron of 32 triangles, four per octant: one at each axis and one
//! between the three diagonals (lighting model, section 6). The ray along the direction in which the
//! light TRAVELS, `d = -s`, meets one triangle; its corners are the bases, and the barycentric coordinates
//! of the hit the weights. Neighbouring triangles share corners, so the blend is continuous.
//!
//! With `a, b, c` the magnitudes of d's components: at axis a (`a >= b + c`) the weights are in proportion
//! to `a - b - c` for the axis and `sqrt 2 b`, `sqrt 2 c` for its diagonals; in the middle triangle to
//! `a + b - c` and its permutations for the diagonals ab, ac and bc. Both follow from solving
//! `d = sum of weight * unit direction` in the octant.

pub mod directions;
pub mod harmonics;
pub mod reach;

use crate::direction::DIRECTIONS;

/// Three bases and their weights; a zero weight means that its base is not needed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunBlend {
    /// Base numbers from 1, all different.
    pub bases: [u8; 3],
    /// Weights of the bases, each in 0..=1; they sum to 1 up to rounding.
    pub weights: [f32; 3],
}

/// The blend for a sun that stands in direction `towards_sun_model` (model space, any length).
/// `None` if the vector is zero or not finite.
pub fn blend(towards_sun_model: [f64; 3]) -> Option<SunBlend> {
    let longest = towards_sun_model.iter().fold(0.0f64, |l, c| l.max(c.abs()));
    if longest == 0.0 || !towards_sun_model.iter().all(|c| c.is_finite()) {
        return None;
    }
    // Light travels along -s. A zero of either sign counts as positive: its bases get no weight.
    let sign = towards_sun_model.map(|c| if c > 0.0 { -1 } else { 1 });
    let m = towards_sun_model.map(|c| c.abs() / longest);

    let axis_corner = (0..3).find(|&axis| m[axis] >= m[(axis + 1) % 3] + m[(axis + 2) % 3]);
    let (bases, weights) = if let Some(a) = axis_corner {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        let weights =
            [m[a] - (m[b] + m[c]), std::f64::consts::SQRT_2 * m[b], std::f64::consts::SQRT_2 * m[c]];
        ([base_along(sign, &[a]), base_along(sign, &[a, b]), base_along(sign, &[a, c])], weights)
    } else {
        let [x, y, z] = m;
        // Positive, because no magnitude reaches the sum of the other two.
        let weights = [(x + y) - z, (z + x) - y, (y + z) - x];
        ([base_along(sign, &[0, 1]), base_along(sign, &[0, 2]), base_along(sign, &[1, 2])], weights)
    };
    let sum = weights[0] + weights[1] + weights[2];
    Some(SunBlend { bases, weights: weights.map(|w| (w.max(0.0) / sum) as f32) })
}

/// Unit vector towards the sun in model space: +Y up, north = -Z, east = +X; azimuth clockwise from north
/// as seen from above, both angles in degrees. Multiples of 90 degrees are exact.
pub fn towards_sun(azimuth_deg: f64, elevation_deg: f64) -> [f64; 3] {
    let (sin_azimuth, cos_azimuth) = sin_cos_deg(azimuth_deg);
    let (sin_elevation, cos_elevation) = sin_cos_deg(elevation_deg);
    [cos_elevation * sin_azimuth, sin_elevation, -cos_elevation * cos_azimuth]
}

/// The direction whose components are `sign` along `axes` and 0 elsewhere.
fn base_along(sign: [i32; 3], axes: &[usize]) -> u8 {
    let wanted: [i32; 3] = std::array::from_fn(|axis| if axes.contains(&axis) { sign[axis] } else { 0 });
    let m =
        DIRECTIONS.iter().position(|c| *c == wanted).expect("every sum of one or two axes is a direction");
    m as u8
}

/// Sine and cosine of an angle in degrees, reduced to -45..=45 degrees without rounding first.
fn sin_cos_deg(degrees: f64) -> (f64, f64) {
    let turned = degrees % 360.0;
    let quarter = libm::round(turned / 90.0);
    let (sin, cos) = libm::sincos((turned - 90.0 * quarter).to_radians());
    match (quarter as i64).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests;
