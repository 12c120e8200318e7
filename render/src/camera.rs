//! A perspective camera that stands where the view says and frames the whole plant.

use flb_format::sun::towards_sun;
use glam::{DVec3, Vec3};

use crate::{
    RenderSettings,
    lens::{self, Lens},
    scene::{Ray, Scene},
};

/// Room left around the plant, as a share of the picture's half width and height.
const MARGIN: f64 = 0.07;

pub(crate) struct Camera(Lens);

impl Camera {
    /// The nearest place on the line of sight from which every vertex lies inside the margin.
    pub(crate) fn framing(scene: &Scene<'_>, settings: &RenderSettings) -> Self {
        // The camera stands where the sun would stand at its angles.
        let backward = DVec3::from(towards_sun(settings.view_azimuth_deg, settings.view_elevation_deg));
        let (forward, fov_deg) = (-backward, settings.field_of_view_deg);
        let size = [settings.width, settings.height];
        let ([right, up], [half_width, half_height]) = (lens::upright(forward), lens::half(fov_deg, size));

        let target = (scene.min.as_dvec3() + scene.max.as_dvec3()) / 2.0;
        let mut distance = f64::from(scene.size()) * 1e-3;
        for vertex in scene.vertices() {
            let offset = vertex.as_dvec3() - target;
            let reach = (offset.dot(right).abs() / half_width).max(offset.dot(up).abs() / half_height);
            distance = distance.max(reach / (1.0 - MARGIN) - offset.dot(forward));
        }
        Camera(Lens::along(target + backward * distance, forward, fov_deg, size))
    }

    /// The ray through a point of the picture, in pixels from the upper left corner.
    pub(crate) fn ray(&self, x: f32, y: f32) -> Ray {
        let direction = self.0.direction(f64::from(x), f64::from(y));
        Ray { origin: self.0.position.as_vec3(), direction: unit(direction) }
    }
}

fn unit(direction: DVec3) -> Vec3 {
    direction.as_vec3().normalize()
}
