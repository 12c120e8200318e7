//! What a frame shows: placed plants and a camera. Plain numbers in `f32`, as renderers have them.

use flb_format::Placement;
use flb_format::eye::Eye;

/// A placement in `f32`, of which there are many.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Instance {
    /// Index of its species in the library.
    pub species: u32,
    /// Position of the model's origin, metres.
    pub position_m: [f32; 3],
    /// World from model: rows of a rotation.
    pub rotation: [[f32; 3]; 3],
    /// Scale of the model, above 0.
    pub scale: f32,
}

impl Instance {
    pub(crate) fn of(Placement { species, transform }: &Placement) -> Instance {
        Instance {
            species: *species as u32,
            position_m: transform.position_m.map(|c| c as f32),
            rotation: transform.rotation.map(|row| row.map(|c| c as f32)),
            scale: transform.scale as f32,
        }
    }

    /// A point of the model in the world.
    #[inline]
    pub(crate) fn world_from_model(&self, point_m: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|axis| self.position_m[axis] + self.scale * dot(self.rotation[axis], point_m))
    }

    /// A direction of the world in the model's frame; its length stays.
    #[inline]
    pub(crate) fn model_from_world_direction(&self, d: [f32; 3]) -> [f32; 3] {
        let r = &self.rotation;
        std::array::from_fn(|axis| r[0][axis] * d[0] + r[1][axis] * d[1] + r[2][axis] * d[2])
    }

    /// A point of the world in the model's frame.
    #[inline]
    pub(crate) fn model_from_world(&self, point_m: [f32; 3]) -> [f32; 3] {
        let from_origin = std::array::from_fn(|axis| (point_m[axis] - self.position_m[axis]) / self.scale);
        self.model_from_world_direction(from_origin)
    }
}

/// A pinhole camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position of the camera, metres.
    pub position_m: [f32; 3],
    /// Direction of view; any length but 0.
    pub forward: [f32; 3],
    /// Upward direction in the picture, about; not along `forward`.
    pub up: [f32; 3],
    /// Vertical field of view, degrees, above 0, below 180.
    pub fov_deg: f32,
    /// Width of the picture.
    pub width_px: u32,
    /// Height of the picture.
    pub height_px: u32,
}

/// Water that may mirror what a frame shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaterPlane {
    /// Height of the water (y), metres.
    pub height_m: f32,
    /// Largest angle by which waves turn what is mirrored that still counts, degrees, 0 to 90; 0 of level water.
    pub spread_deg: f32,
}

/// A plane: `normal . point >= offset` inside. The normal is of unit length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Normal of the plane, unit length; points inwards.
    pub normal: [f32; 3],
    /// Along the normal.
    pub offset: f32,
}

/// Space that a camera sees, directly or in water: the space between five planes, and how large things look there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    /// Tip of the frustum, metres.
    pub position_m: [f32; 3],
    /// Left, right, lower and upper side, then the plane through the camera across its view, or the water.
    pub planes: [Plane; 5],
    /// Pixels of a length of one metre at a distance of one.
    pub focal_px: f32,
    /// Pixels of the picture.
    pub picture_px: f32,
}

impl Camera {
    /// Makes the camera of an eye and the pixels of its picture; straight up and down, the top of its picture is north.
    pub fn of(eye: &Eye, [width_px, height_px]: [u32; 2]) -> Camera {
        let forward: [f64; 3] = std::array::from_fn(|axis| eye.look_at_m[axis] - eye.position_m[axis]);
        let is_steep = forward[0] == 0.0 && forward[2] == 0.0;
        Camera {
            position_m: eye.position_m.map(|c| c as f32),
            forward: forward.map(|c| c as f32),
            up: if is_steep { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] },
            fov_deg: eye.fov_deg as f32,
            width_px,
            height_px,
        }
    }

    /// Frustum that the camera sees.
    pub fn frustum(&self) -> Frustum {
        self.wider_frustum(0.0)
    }

    /// Frustum that is wider by an angle on each side.
    fn wider_frustum(&self, by_deg: f32) -> Frustum {
        let Axes { forward, right, up, half, aspect } = self.axes();
        let wider = |tangent: f32| match by_deg > 0.0 {
            true => libm::tanf((libm::atanf(tangent) + by_deg.to_radians()).min(WIDEST_DEG.to_radians())),
            false => tangent,
        };
        let [across, upwards] = [half * aspect, half].map(wider);
        let side = |along: [f32; 3], tangent: f32| {
            let normal = unit(std::array::from_fn(|i| forward[i] * tangent + along[i]));
            Plane { normal, offset: dot(normal, self.position_m) }
        };
        let minus = |v: [f32; 3]| v.map(|c| -c);
        let planes = [
            side(right, across),
            side(minus(right), across),
            side(up, upwards),
            side(minus(up), upwards),
            Plane { normal: forward, offset: dot(forward, self.position_m) },
        ];
        let (width, height) = (self.width_px as f32, self.height_px as f32);
        Frustum {
            position_m: self.position_m,
            planes,
            focal_px: height / (2.0 * half),
            picture_px: width * height,
        }
    }

    /// Frustum that the camera may see in water: what lies above that, from the camera's image below; wider where waves
    /// turn it. `None` from the surface or below it, and where no ray of the picture goes down. Ground that hides water
    /// is not known here.
    pub fn frustum_in_water(&self, water: WaterPlane) -> Option<Frustum> {
        let WaterPlane { height_m: water_m, spread_deg } = water;
        let Axes { forward, right, up, half, aspect } = self.axes();
        // Of the steepest ray downwards.
        let lowest = forward[1] - half * (right[1].abs() * aspect + up[1].abs());
        let [x, y, z] = self.position_m;
        if lowest >= 0.0 || y <= water_m {
            return None;
        }
        let below = |[x, y, z]: [f32; 3]| [x, -y, z];
        let position_m = [x, 2.0 * water_m - y, z];
        let image = Camera { position_m, forward: below(self.forward), up: below(self.up), ..*self };
        let mut frustum = image.wider_frustum(spread_deg);
        frustum.planes[4] = Plane { normal: [0.0, 1.0, 0.0], offset: water_m };
        Some(frustum)
    }

    fn axes(&self) -> Axes {
        let forward = unit(self.forward);
        let right = unit(cross(forward, self.up));
        Axes {
            forward,
            right,
            up: cross(right, forward),
            half: libm::tanf(self.fov_deg.to_radians() / 2.0),
            aspect: self.width_px as f32 / self.height_px as f32,
        }
    }
}

/// Half of the widest frustum's angle, degrees.
const WIDEST_DEG: f32 = 89.0;

/// A picture's axes, unit vectors; half of its height at a distance of one, and its width over its height.
struct Axes {
    forward: [f32; 3],
    right: [f32; 3],
    up: [f32; 3],
    half: f32,
    aspect: f32,
}

impl Frustum {
    /// Whether part of a sphere may be seen; spheres near an edge of the frustum may count though they are not.
    #[inline]
    pub fn sees_sphere(&self, center_m: [f32; 3], radius_m: f32) -> bool {
        self.planes.iter().all(|plane| dot(plane.normal, center_m) - plane.offset >= -radius_m)
    }

    /// Whether part of an axis-aligned box may be seen, of a model that the frustum was turned to.
    pub fn sees_box(&self, min_m: [f32; 3], max_m: [f32; 3]) -> bool {
        self.planes.iter().all(|plane| {
            let farthest = std::array::from_fn(|i| if plane.normal[i] > 0.0 { max_m[i] } else { min_m[i] });
            dot(plane.normal, farthest) >= plane.offset
        })
    }

    /// The same in the frame of an instance's model.
    pub(crate) fn in_model(&self, instance: &Instance) -> Frustum {
        let plane = |plane: Plane| Plane {
            normal: instance.model_from_world_direction(plane.normal),
            offset: (plane.offset - dot(plane.normal, instance.position_m)) / instance.scale,
        };
        Frustum {
            position_m: instance.model_from_world(self.position_m),
            planes: self.planes.map(plane),
            ..*self
        }
    }
}

#[inline]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = libm::sqrtf(dot(v, v));
    v.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            position_m: [1.0, 2.0, 3.0],
            forward: [0.0, 0.0, -2.0],
            up: [0.0, 1.0, 0.0],
            fov_deg: 90.0,
            width_px: 200,
            height_px: 100,
        }
    }

    #[test]
    fn a_frustum_sees_what_lies_between_its_sides() {
        let frustum = camera().frustum();
        assert!((frustum.focal_px - 50.0).abs() < 1e-4 && frustum.picture_px == 20_000.0);
        // At a distance of 4 the picture is 16 wide and 8 high. Point, seen as such, as a sphere of radius 1.
        let table = [
            ([1.0, 2.0, -1.0], true, true),
            ([8.9, 2.0, -1.0], true, true),
            ([9.1, 2.0, -1.0], false, true),
            ([11.0, 2.0, -1.0], false, true), // the side is aslant: 0.9 m away
            ([12.0, 2.0, -1.0], false, false),
            ([1.0, 5.9, -1.0], true, true),
            ([1.0, -2.1, -1.0], false, true),
            ([1.0, 2.0, 3.5], false, true),
            ([1.0, 2.0, 4.5], false, false),
        ];
        for (point, alone, as_sphere) in table {
            assert_eq!(frustum.sees_sphere(point, 0.0), alone, "{point:?}");
            assert_eq!(frustum.sees_sphere(point, 1.0), as_sphere, "a sphere at {point:?}");
            assert_eq!(frustum.sees_box(point, point), alone, "{point:?} as a box");
        }
        assert!(
            frustum.sees_box([-100.0, -100.0, -2.0], [100.0, 100.0, -1.0]),
            "a wall that fills the picture"
        );
        assert!(!frustum.sees_box([-100.0, -100.0, 3.5], [100.0, 100.0, 9.0]), "all of it behind the camera");
    }

    #[test]
    fn water_is_looked_into_from_above_and_shows_what_stands_over_it() {
        let water_m = 0.5;
        let level = |height_m: f32| WaterPlane { height_m, spread_deg: 0.0 };
        let image =
            camera().frustum_in_water(level(water_m)).expect("the lower half of the picture is water");
        let frustum = camera().frustum();
        assert_eq!(image.position_m, [1.0, -1.0, 3.0]);
        let mut seen = 0;
        for i in 0..1000 {
            let [x, y, z] = [i % 10, i / 10 % 10, i / 100].map(|c| c as f32 * 1.3 - 6.0);
            let mirrored = [x, 2.0 * water_m - y, z];
            let is_seen = y >= water_m && frustum.sees_sphere(mirrored, 0.0);
            assert_eq!(image.sees_sphere([x, y, z], 0.0), is_seen, "{x} {y} {z}");
            seen += usize::from(is_seen);
        }
        assert!(seen > 50, "{seen} of 1000 points");
        assert_eq!(camera().frustum_in_water(level(2.0)), None, "not from its surface");
        // 45 degrees up, half of the picture's 90 degrees: as good as level.
        for (up, sees) in [(1.9, true), (2.1, false)] {
            let camera = Camera { forward: [0.0, up, -2.0], ..camera() };
            assert_eq!(camera.frustum_in_water(level(water_m)).is_some(), sees, "{up}");
        }
    }

    #[test]
    fn waves_show_what_level_water_does_and_what_lies_beside_it() {
        let wavy = |spread_deg| WaterPlane { height_m: 0.5, spread_deg };
        let [level, breeze, storm] = [0.0, 20.0, 90.0].map(|spread_deg| {
            camera().frustum_in_water(wavy(spread_deg)).expect("the lower half of the picture is water")
        });
        let mut counts = [0; 3];
        for i in 0..1000 {
            let point = [i % 10, i / 10 % 10, i / 100].map(|c| c as f32 * 2.3 - 10.0);
            let seen = [level, breeze, storm].map(|frustum| frustum.sees_sphere(point, 0.0));
            assert!(seen[0] <= seen[1] && seen[1] <= seen[2] && (!seen[2] || point[1] >= 0.5), "{point:?}");
            (0..3).for_each(|at| counts[at] += usize::from(seen[at]));
        }
        assert!(counts[0] + 20 < counts[1] && counts[1] + 20 < counts[2], "{counts:?}");
        assert_eq!((breeze.position_m, breeze.focal_px), (level.position_m, level.focal_px));
    }

    #[test]
    fn a_frustum_in_a_model_sees_the_same_points() {
        let (sin, cos) = libm::sincosf(0.7);
        let rotation = [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]];
        let instance = Instance { species: 0, position_m: [2.0, -1.0, -4.0], rotation, scale: 2.5 };
        let frustum = camera().frustum();
        let in_model = frustum.in_model(&instance);
        let mut seen = 0;
        for i in 0..1000 {
            let point = [i % 10, i / 10 % 10, i / 100].map(|c| c as f32 * 1.3 - 6.0);
            let world = instance.world_from_model(point);
            assert_eq!(in_model.sees_box(point, point), frustum.sees_sphere(world, 0.0), "{point:?}");
            seen += usize::from(frustum.sees_sphere(world, 0.0));
            let back = instance.model_from_world(world);
            assert!((0..3).all(|i| (back[i] - point[i]).abs() < 1e-5));
        }
        assert!((100..900).contains(&seen), "{seen} of 1000 points");
    }
}
