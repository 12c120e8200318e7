//! A perspective camera that stands where the view says and frames the whole plant.

use flb_format::sun::towards_sun;
use glam::{DVec3, Vec3};

use crate::{
    RenderSettings,
    scene::{Ray, Scene},
};

/// Room left around the plant, as a share of the picture's half width and height.
const MARGIN: f64 = 0.07;

pub(crate) struct Camera {
    eye: DVec3,
    forward: DVec3,
    /// Half the picture's width and height at distance 1.
    right: DVec3,
    up: DVec3,
    size: [f64; 2],
}

impl Camera {
    /// The nearest place on the line of sight from which every vertex lies inside the margin.
    pub(crate) fn framing(scene: &Scene<'_>, settings: &RenderSettings) -> Self {
        // The camera stands where the sun would stand at its angles.
        let backward = DVec3::from(towards_sun(settings.view_azimuth_deg, settings.view_elevation_deg));
        let forward = -backward;
        let right = forward.cross(DVec3::Y).normalize();
        let up = right.cross(forward);
        let (width, height) = (f64::from(settings.width), f64::from(settings.height));
        let half_height = libm::tan(settings.field_of_view_deg.to_radians() / 2.0);
        let half_width = half_height * width / height;

        let target = (scene.min.as_dvec3() + scene.max.as_dvec3()) / 2.0;
        let mut distance = f64::from(scene.size()) * 1e-3;
        for vertex in scene.vertices() {
            let offset = vertex.as_dvec3() - target;
            let reach = (offset.dot(right).abs() / half_width).max(offset.dot(up).abs() / half_height);
            distance = distance.max(reach / (1.0 - MARGIN) - offset.dot(forward));
        }
        Camera {
            eye: target + backward * distance,
            forward,
            right: right * half_width,
            up: up * half_height,
            size: [width, height],
        }
    }

    /// The ray through a point of the picture, in pixels from the upper left corner.
    pub(crate) fn ray(&self, x: f32, y: f32) -> Ray {
        let across = f64::from(x) / self.size[0] * 2.0 - 1.0;
        let down = f64::from(y) / self.size[1] * 2.0 - 1.0;
        let direction = (self.forward + self.right * across - self.up * down).normalize();
        Ray { origin: self.eye.as_vec3(), direction: unit(direction) }
    }
}

fn unit(direction: DVec3) -> Vec3 {
    direction.as_vec3().normalize()
}
