//! Where a model stands in the world, and the ways between both frames.

/// Share by which the axes of a matrix may differ in length and from right angles.
const TURNED: f64 = 0.01;

/// Places a model in the world: turned, scaled, moved. All of a scene's instances are placed by it.
///
/// ```text
/// world point = position_m + (rotation . model point) * scale
/// ```
///
/// A point of the light API is one of the model at rest; [`Transform`] brings directions such as the sun's there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// World from model: the rows of a rotation, `[row][column]`.
    pub rotation: [[f64; 3]; 3],
    /// Position of the model's origin in the world, metres.
    pub position_m: [f64; 3],
    /// Length in the world of a length 1 in the model; above 0.
    pub scale: f64,
}

/// A plant of a species that stands somewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Index of its species, in a list that the context names.
    pub species: usize,
    /// Position, scale and rotation of the model.
    pub transform: Transform,
}

impl Default for Transform {
    fn default() -> Transform {
        Transform::IDENTITY
    }
}

impl Transform {
    /// The model's frame is the world's.
    pub const IDENTITY: Transform = Transform {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        position_m: [0.0; 3],
        scale: 1.0,
    };

    /// A model turned about the vertical by an angle in degrees, clockwise seen from above as azimuths are: north, -z,
    /// turns towards east, +x.
    pub fn from_yaw(position_m: [f64; 3], yaw_deg: f64, scale: f64) -> Transform {
        let [sin, _, minus_cos] = crate::sun::towards_sun(yaw_deg, 0.0);
        let cos = -minus_cos;
        Transform { rotation: [[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]], position_m, scale }
    }

    /// The angle in degrees by which a model is turned about the vertical, clockwise, from 0 to 360; of a tilted one
    /// that of its x axis.
    pub fn yaw_deg(&self) -> f64 {
        let [[x, ..], _, [z, ..]] = self.rotation;
        let turned = libm::atan2(z, x).to_degrees();
        if turned < 0.0 { turned + 360.0 } else { turned }
    }

    /// A model turned by a quaternion `[x, y, z, w]` of any length; `None` for one of length 0, and for what is not
    /// finite or a scale that is not above 0. About the vertical alone it keeps y exactly.
    pub fn from_quaternion(position_m: [f64; 3], quaternion: [f64; 4], scale: f64) -> Option<Transform> {
        let length = libm::sqrt(quaternion.iter().map(|c| c * c).sum());
        let [x, y, z, w] = quaternion.map(|c| c / length);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Transform { rotation, position_m, scale }.checked()
    }

    /// A model placed by a matrix, as its columns: the images of x, y and z, then the position. `None` unless it turns,
    /// scales all axes alike to a hundredth, and moves: a mirrored, sheared or flattened plant has another light.
    pub fn from_matrix(columns: [[f64; 4]; 4]) -> Option<Transform> {
        let [x, y, z, position] = columns;
        let axes = [x, y, z].map(|[a, b, c, _]| [a, b, c]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let lengths = axes.map(|axis| libm::sqrt(dot(axis, axis)));
        let scale = libm::cbrt(lengths[0] * lengths[1] * lengths[2]);
        let [x, y, z] = axes.map(|axis| axis.map(|c| c / scale));
        let turned = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
        let near = |found: f64, expected: f64| (found - expected).abs() < TURNED;
        let is_turn = lengths.iter().all(|length| near(length / scale, 1.0))
            && [dot(x, y), dot(y, z), dot(z, x)].iter().all(|cos| near(*cos, 0.0))
            && near(dot(turned, z), 1.0);
        let is_affine = columns.map(|column| column[3]) == [0.0, 0.0, 0.0, 1.0];
        let rotation = std::array::from_fn(|row| [x[row], y[row], z[row]]);
        let placed = Transform { rotation, position_m: [position[0], position[1], position[2]], scale };
        placed.checked().filter(|_| is_turn && is_affine)
    }

    /// `None` for what is not finite, and for a scale that is not above 0.
    fn checked(self) -> Option<Transform> {
        let numbers = self.rotation.iter().flatten().chain(&self.position_m).chain([&self.scale]);
        (numbers.into_iter().all(|c| c.is_finite()) && self.scale > 0.0).then_some(self)
    }

    /// Whether the model is turned about the vertical alone.
    #[inline]
    pub fn is_upright(&self) -> bool {
        self.rotation[1] == [0.0, 1.0, 0.0]
    }

    /// A point of the model, metres, in the world.
    #[inline]
    pub fn world_from_model_point(&self, point_m: [f64; 3]) -> [f64; 3] {
        let turned = self.world_from_model_direction(point_m);
        std::array::from_fn(|axis| self.position_m[axis] + turned[axis] * self.scale)
    }

    /// A direction of the model in the world; its length stays.
    #[inline]
    pub fn world_from_model_direction(&self, direction: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = direction;
        self.rotation.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }

    /// A point of the world, metres, in the model.
    #[inline]
    pub fn model_from_world_point(&self, point_m: [f64; 3]) -> [f64; 3] {
        let from_origin = std::array::from_fn(|axis| point_m[axis] - self.position_m[axis]);
        self.model_from_world_direction(from_origin).map(|c| c / self.scale)
    }

    /// A direction of the world in the model; its length stays.
    #[inline]
    pub fn model_from_world_direction(&self, direction: [f64; 3]) -> [f64; 3] {
        let ([x, y, z], [a, b, c]) = (direction, self.rotation);
        std::array::from_fn(|axis| a[axis] * x + b[axis] * y + c[axis] * z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// About the vertical, then about an axis of the level.
    fn tilted() -> Transform {
        let ([a, b], [c, d]) = ([0.6, 0.8], [0.28, 0.96]);
        Transform {
            rotation: [[a, -b * c, b * d], [0.0, d, c], [-b, -a * c, a * d]],
            position_m: [3.0, -1.0, 200.0],
            scale: 2.5,
        }
    }

    #[test]
    fn the_ways_back_undo_the_ways_there() {
        let (stands, point) = (tilted(), [0.3, 4.0, -1.5]);
        let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-12);
        assert!(near(stands.model_from_world_point(stands.world_from_model_point(point)), point));
        assert!(near(stands.model_from_world_direction(stands.world_from_model_direction(point)), point));
        let squared = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>();
        assert!((squared(stands.model_from_world_direction(point)) - squared(point)).abs() < 1e-12);
        assert_eq!(Transform::IDENTITY.world_from_model_point(point), point);
    }

    #[test]
    fn a_yaw_a_quaternion_and_a_matrix_say_the_same() {
        let yaw = Transform::from_yaw([1.0, 2.0, 3.0], 40.0, 2.0);
        let (sin, cos) = libm::sincos((-20.0_f64).to_radians());
        let quaternion = Transform::from_quaternion([1.0, 2.0, 3.0], [0.0, 3.0 * sin, 0.0, 3.0 * cos], 2.0);
        let close = |a: Transform, b: Transform| {
            let ends = [a, b].map(|stands| stands.world_from_model_point([0.3, 4.0, -1.5]));
            (0..3).all(|axis| (ends[0][axis] - ends[1][axis]).abs() < 1e-12)
        };
        assert!(close(yaw, quaternion.expect("a turn")) && yaw.is_upright());
        for yaw_deg in [0.0, 40.0, 179.0, 181.0, 300.0] {
            assert!((Transform::from_yaw([0.0; 3], yaw_deg, 1.0).yaw_deg() - yaw_deg).abs() < 1e-9);
        }
        let east = Transform::from_yaw([0.0; 3], 90.0, 1.0).world_from_model_direction([0.0, 0.0, -1.0]);
        assert!(east[0] > 0.999, "{east:?}");
        let stands = tilted();
        let column = |axis: usize| {
            let [a, b, c] = [0, 1, 2].map(|row| stands.scale * stands.rotation[row][axis]);
            [a, b, c, 0.0]
        };
        let [x, y, z] = stands.position_m;
        let columns = [column(0), column(1), column(2), [x, y, z, 1.0]];
        assert!(close(Transform::from_matrix(columns).expect("a placement"), stands));
        type Matrix = [[f64; 4]; 4];
        let faults: [fn(&mut Matrix); 6] = [
            |m| m[0] = m[0].map(|c| -c),
            |m| m[1] = m[1].map(|c| 1.05 * c),
            |m| m[2][0] += 0.3,
            |m| m[3][1] = f64::NAN,
            |m| m[0][3] = 0.1,
            |m| m[..3].fill([0.0; 4]),
        ];
        for (number, fault) in faults.iter().enumerate() {
            let mut columns = columns;
            fault(&mut columns);
            assert_eq!(Transform::from_matrix(columns), None, "{number}");
        }
        assert_eq!(Transform::from_quaternion([0.0; 3], [0.0; 4], 1.0), None);
        assert_eq!(Transform::from_quaternion([0.0; 3], [0.0, 0.0, 0.0, 1.0], 0.0), None);
    }

    #[test]
    fn a_model_is_turned_then_scaled_then_moved() {
        let quarter = Transform {
            rotation: [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
            position_m: [10.0, 20.0, 30.0],
            scale: 2.0,
        };
        assert_eq!(quarter.world_from_model_point([1.0, 2.0, 3.0]), [16.0, 24.0, 28.0]);
        assert_eq!(quarter.world_from_model_direction([1.0, 0.0, 0.0]), [0.0, 0.0, -1.0]);
        assert_eq!(quarter.model_from_world_direction([0.0, 0.0, -1.0]), [1.0, 0.0, 0.0]);
        assert_eq!(quarter.model_from_world_point([16.0, 24.0, 28.0]), [1.0, 2.0, 3.0]);
    }
}
