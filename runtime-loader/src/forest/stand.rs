//! How a plant is turned, and where that puts the sun in its own frame.

use flb_format::Transform;

/// How a plant is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stand {
    /// Yaw, 0 to below the number of yaws in a circle.
    Upright(f32),
    /// The rotation, world from model: x, y and z of its unit quaternion, whose w is not negative.
    Tilted([f32; 3]),
}

/// Share of a step that counts for none.
pub(super) const EXACT: f64 = 1e-3;

impl Stand {
    /// Of a placement; it stands upright where it is tilted by less than `least_deg`. What is no number is the first
    /// yaw.
    pub(super) fn of(stands: &Transform, yaws: u32, least_deg: f64) -> Stand {
        if !stands.rotation.as_flattened().iter().all(|entry| entry.is_finite()) {
            return Stand::Upright(0.0);
        }
        let least = libm::cos(least_deg.clamp(0.0, 180.0).to_radians());
        if stands.rotation[1][1] >= least || stands.is_upright() {
            return Stand::Upright(turn(stands.yaw_deg(), yaws) as f32);
        }
        Stand::Tilted(quaternion(&stands.rotation))
    }
}

/// Yaws in some degrees, 0 to below the number of them in a circle. It is a whole number where it nearly is one.
pub(super) fn turn(yaw_deg: f64, yaws: u32) -> f64 {
    let turn = yaw_deg / 360.0 * f64::from(yaws);
    let whole = libm::round(turn);
    let turn = if libm::fabs(turn - whole) < EXACT { whole } else { turn };
    let within = turn.rem_euclid(f64::from(yaws));
    if within < f64::from(yaws) { within } else { 0.0 }
}

/// x, y and z of a rotation's quaternion, whose w is not negative.
fn quaternion(rotation: &[[f64; 3]; 3]) -> [f32; 3] {
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = *rotation;
    // Four times the products of each two of x, y, z, w: each row is the quaternion times one of them.
    let products = [
        [1.0 + xx - yy - zz, xy + yx, xz + zx, zy - yz],
        [xy + yx, 1.0 - xx + yy - zz, yz + zy, xz - zx],
        [xz + zx, yz + zy, 1.0 - xx - yy + zz, yx - xy],
        [zy - yz, xz - zx, yx - xy, 1.0 + xx + yy + zz],
    ];
    let longest = (0..4).max_by(|a, b| products[*a][*a].total_cmp(&products[*b][*b]));
    let [x, y, z, w] = products[longest.unwrap_or(3)];
    let length = libm::sqrt(x * x + y * y + z * z + w * w);
    let signed = if w < 0.0 { -length } else { length };
    [x, y, z].map(|c| (c / signed) as f32)
}

/// A direction of the world in the frame of a model.
pub(super) fn model_from_world([x, y, z]: [f32; 3], direction: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = [x, y, z].map(f64::from);
    let w = libm::sqrt((1.0 - x * x - y * y - z * z).max(0.0));
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let once = cross([x, y, z], direction);
    let twice = cross([x, y, z], once);
    std::array::from_fn(|axis| direction[axis] + 2.0 * (twice[axis] - w * once[axis]))
}

/// Azimuth and elevation, degrees.
pub(super) fn angles([x, y, z]: [f64; 3]) -> [f64; 2] {
    [libm::atan2(x, -z).to_degrees(), libm::atan2(y, libm::hypot(x, z)).to_degrees()]
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::forest) fn rotation(quaternion: [f64; 4]) -> Transform {
        Transform::from_quaternion([0.0; 3], quaternion, 1.0).expect("a rotation")
    }

    pub(in crate::forest) fn apart_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
        let between = std::array::from_fn::<f64, 3, _>(|axis| a[axis] - b[axis]);
        2.0 * libm::asin((libm::sqrt(between.iter().map(|c| c * c).sum()) / 2.0).min(1.0)).to_degrees()
    }

    /// Rotations of all kinds, half turns among them.
    pub(in crate::forest) fn rotations() -> Vec<Transform> {
        let number = |seed: u32, axis| 2.0 * f64::from(crate::plants::noise(seed, axis)) - 1.0;
        let random = (0..200).map(|seed| rotation([1, 2, 3, 4].map(|axis| number(seed, axis))));
        let half = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.6, 0.8, 0.0, 0.0], [0.0, 1.0, 1e-9, 0.0]];
        random.chain(half.map(rotation)).collect()
    }

    #[test]
    fn a_quaternion_of_three_numbers_turns_as_its_rotation_does() {
        for stands in rotations() {
            for direction in [[0.36, 0.48, 0.8], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]] {
                let (found, expected) = (
                    model_from_world(quaternion(&stands.rotation), direction),
                    stands.model_from_world_direction(direction),
                );
                // w is what is left of 1.
                assert!(apart_deg(found, expected) < 0.04, "{stands:?}: {found:?}, {expected:?}");
            }
        }
    }

    #[test]
    fn a_turn_is_a_whole_number_where_it_nearly_is_one_and_always_within_the_circle() {
        for (yaw_deg, expected) in
            [(90.0, 2.0), (89.99, 2.0), (101.25, 2.25), (-1e-20, 0.0), (359.99, 0.0), (-45.0, 7.0)]
        {
            assert_eq!(turn(yaw_deg, 8), expected, "{yaw_deg}");
        }
        assert_eq!(turn(f64::NAN, 8), 0.0);
        let nothing = Transform { rotation: [[f64::NAN; 3]; 3], ..Transform::IDENTITY };
        assert_eq!(Stand::of(&nothing, 8, 1.0), Stand::Upright(0.0));
        // Hardly tilted.
        let hardly = rotation([0.004, 0.0, 0.0, 1.0]);
        assert!(matches!(Stand::of(&hardly, 8, 1.0), Stand::Upright(..)));
        assert!(matches!(Stand::of(&hardly, 8, 0.1), Stand::Tilted(..)));
    }
}
