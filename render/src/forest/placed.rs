//! A plant that stands somewhere: rays of the world to rays of its model and back, and the boxes that it stays within.
//!
//! All in f64, and a ray starts where it enters the model's box: in its own frame a plant has the precision that it has
//! alone, wherever in the world it stands and however far away the camera is.

use flb_format::{Placement, Transform};
use glam::{DMat3, DVec3};

use crate::scene::Ray;

/// A half line in the world. `direction` is of unit length.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorldRay {
    pub origin: DVec3,
    pub direction: DVec3,
}

/// An axis-aligned box of a frame that the context names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extent {
    pub min: DVec3,
    pub max: DVec3,
}

/// Where an instance of a species stands.
pub(crate) struct Placed {
    pub placement: Placement,
    /// Box around the instance in the world.
    pub extent: Extent,
}

/// A world's ray in a model's frame, from where it enters the model's box.
#[derive(Clone, Copy)]
pub(crate) struct ModelRay {
    pub ray: Ray,
    /// Distance in the model's frame from the world ray's origin to this one's.
    start: f64,
}

/// What a model stays within.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hull {
    pub extent: Extent,
    /// Radius of the upright cylinder through the middle of the extent that all vertices lie in.
    pub radius: f64,
}

impl Extent {
    /// Holds nothing.
    pub(crate) const EMPTY: Extent = Extent { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    pub(crate) fn center(&self) -> DVec3 {
        (self.min + self.max) / 2.0
    }

    pub(crate) fn union(&self, other: &Extent) -> Extent {
        Extent { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    pub(crate) fn padded(&self, pad: f64) -> Extent {
        Extent { min: self.min - pad, max: self.max + pad }
    }

    /// Its eight corners.
    pub(crate) fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|corner| {
            let of = |axis: usize| if corner >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            DVec3::new(of(0), of(1), of(2))
        })
    }

    /// Distance from a point to the nearest point of it; 0 inside.
    pub(crate) fn distance(&self, point: DVec3) -> f64 {
        (self.min - point).max(point - self.max).max(DVec3::ZERO).length()
    }

    /// Where a ray enters and leaves, the first not before the origin.
    pub(crate) fn along(&self, ray: &WorldRay) -> Option<[f64; 2]> {
        let mut inside = [0.0f64, f64::INFINITY];
        for axis in 0..3 {
            let inverse = 1.0 / ray.direction[axis];
            let a = (self.min[axis] - ray.origin[axis]) * inverse;
            let b = (self.max[axis] - ray.origin[axis]) * inverse;
            // A ray within a face gives 0 x infinity, which min and max pass over.
            inside = [inside[0].max(a.min(b)), inside[1].min(a.max(b))];
        }
        (inside[0] <= inside[1]).then_some(inside)
    }
}

impl Placed {
    pub(super) fn new(instance: &Placement, hull: &Hull) -> Placed {
        let Transform { rotation, scale, .. } = instance.transform;
        let rows = DMat3::from_cols_array_2d(&rotation);
        let mut placed = Placed { placement: *instance, extent: Extent::EMPTY };
        let place = |point: DVec3| placed.world_point(point);
        // A turned box is larger than a turned plant, so that the box of its turned cylinder is looked at too.
        let mut of_box = Extent::EMPTY;
        for corner in hull.extent.corners().map(place) {
            of_box = of_box.union(&Extent { min: corner, max: corner });
        }
        let center = place(hull.extent.center());
        let half_height = (hull.extent.max.y - hull.extent.min.y) / 2.0;
        let reach = DVec3::from_array([0, 1, 2].map(|axis| {
            let row = rows.col(axis);
            let level = (row.x * row.x + row.z * row.z).sqrt();
            scale * (hull.radius * level + half_height * row.y.abs())
        }));
        placed.extent = Extent { min: of_box.min.max(center - reach), max: of_box.max.min(center + reach) };
        placed
    }

    /// Orthonormal.
    fn model_from_world(&self) -> DMat3 {
        DMat3::from_cols_array_2d(&self.placement.transform.rotation)
    }

    fn position(&self) -> DVec3 {
        DVec3::from(self.placement.transform.position_m)
    }

    fn scale(&self) -> f64 {
        self.placement.transform.scale
    }

    /// The part of a ray within the model's box.
    pub(super) fn enter(&self, ray: &WorldRay, hull: &Hull) -> Option<ModelRay> {
        let model_from_world = self.model_from_world();
        let inside = WorldRay {
            origin: model_from_world * (ray.origin - self.position()) / self.scale(),
            direction: model_from_world * ray.direction,
        };
        let [start, _] = hull.extent.along(&inside)?;
        let origin = (inside.origin + inside.direction * start).as_vec3();
        let ray = Ray { origin, direction: inside.direction.as_vec3() };
        Some(ModelRay { ray, start })
    }

    /// A direction of the world in the model's frame, of the same length.
    pub(super) fn model_direction(&self, direction: DVec3) -> DVec3 {
        self.model_from_world() * direction
    }

    /// A point of the model in the world.
    pub(super) fn world_point(&self, point: DVec3) -> DVec3 {
        self.position() + self.model_from_world().transpose() * point * self.scale()
    }

    /// Distance from the world ray's origin, in metres, of a distance along its model ray.
    pub(super) fn world_distance(&self, ray: &ModelRay, distance: f32) -> f64 {
        (ray.start + f64::from(distance)) * self.scale()
    }

    /// The other way round, not below the true value.
    pub(super) fn model_distance(&self, ray: &ModelRay, distance_m: f64) -> f32 {
        above(distance_m / self.scale() - ray.start)
    }
}

/// As f32, a little larger.
fn above(value: f64) -> f32 {
    (value + value.abs() * 1e-6 + 1e-30) as f32
}
