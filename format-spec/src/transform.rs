//! Where a model stands in the world, and the ways between both frames.

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
