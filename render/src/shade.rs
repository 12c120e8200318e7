//! What a ray sees: the `paper` shading of lighting-model, section 10, before sky and ground.

use flb_baker::MaterialClass;
use glam::{DVec3, Vec3};

use crate::{
    Indirect, Light, RenderSettings,
    scene::{Hit, Ray, Scene},
};

/// Linear colour of the ground: dry grass.
const GROUND: Vec3 = Vec3::new(0.23, 0.22, 0.15);
/// The ambient base in empty space. The ground is a backdrop: it lies partly outside the lattice, where the
/// field says nothing, so it gets open sky and the sun's shadow.
const OPEN_SKY: f32 = 18.0;
/// Linear colours of the sky at the horizon and overhead.
const HORIZON: Vec3 = Vec3::new(0.60, 0.71, 0.84);
const ZENITH: Vec3 = Vec3::new(0.20, 0.36, 0.66);
/// Exponent of the leaves' highlight (Blinn and Phong).
const SHININESS: f32 = 24.0;
/// Ambient weight at which the sky is drawn at full brightness.
const DAYLIGHT: f32 = 0.02;

pub(crate) struct Shader<'a> {
    scene: &'a Scene<'a>,
    settings: &'a RenderSettings,
    towards_sun: Vec3,
    light: &'a Light<'a>,
    /// How far a shadow ray starts above its surface.
    lift: f32,
    ground: Option<Ground>,
    sky_strength: f32,
}

/// A disc below the plant that fades into the background.
struct Ground {
    center: Vec3,
    radius: f32,
}

impl<'a> Shader<'a> {
    pub(crate) fn new(
        scene: &'a Scene<'a>,
        settings: &'a RenderSettings,
        towards_sun: DVec3,
        light: &'a Light<'a>,
    ) -> Self {
        let center = (scene.min + scene.max) / 2.0;
        Shader {
            scene,
            settings,
            towards_sun: towards_sun.as_vec3(),
            light,
            lift: scene.size() * 1e-5,
            ground: settings.ground.then(|| Ground {
                center: Vec3::new(center.x, scene.min.y, center.z),
                radius: scene.size() * 1.5,
            }),
            // Dusk is dimmer than noon, but a picture without ambient light still has a sky.
            sky_strength: 0.35 + 0.65 * (settings.ambient / DAYLIGHT).min(1.0),
        }
    }

    /// Linear colour seen along a ray.
    pub(crate) fn color(&self, ray: Ray) -> [f32; 3] {
        let hit = self.scene.nearest(ray);
        let ground = self.ground.as_ref().and_then(|ground| ground.along(ray));
        match (hit, ground) {
            (Some(hit), Some(ground)) if hit.distance <= ground.0 => self.plant(&hit, ray),
            (Some(hit), None) => self.plant(&hit, ray),
            (_, Some((distance, cover))) => {
                let point = ray.origin + ray.direction * distance;
                self.ground_color(point) * cover + self.background(ray) * (1.0 - cover)
            }
            (None, None) => self.background(ray),
        }
        .to_array()
    }

    fn plant(&self, hit: &Hit, ray: Ray) -> Vec3 {
        let mut color = Vec3::ZERO;
        if self.settings.indirect != Indirect::Only {
            color += self.direct(hit, ray);
        }
        if self.settings.indirect != Indirect::Off {
            color += self.indirect(hit.color, hit.point);
        }
        color
    }

    /// Lambert and a highlight, where the sun stands on the side that is looked at and sees the point.
    fn direct(&self, hit: &Hit, ray: Ray) -> Vec3 {
        let cosine = hit.normal.dot(self.towards_sun);
        if cosine <= 0.0 || hit.flat_normal.dot(self.towards_sun) <= 0.0 {
            return Vec3::ZERO;
        }
        let shadow = Ray { origin: hit.point + hit.flat_normal * self.lift, direction: self.towards_sun };
        if self.scene.is_blocked(shadow, Some(hit.triangle)) {
            return Vec3::ZERO;
        }
        let mut color = hit.color * cosine;
        if hit.class == MaterialClass::Leaf && self.settings.specular > 0.0 {
            let half = (self.towards_sun - ray.direction).normalize_or_zero();
            let highlight = libm::powf(hit.normal.dot(half).max(0.0), SHININESS);
            color += Vec3::splat(self.settings.specular * highlight);
        }
        color * self.settings.sun_strength
    }

    /// Texture colour x phi x scale.
    fn indirect(&self, color: Vec3, point: Vec3) -> Vec3 {
        let mut phi = [0.0; 3];
        (self.light)(point.to_array(), &mut phi);
        color * Vec3::from(phi) * self.settings.indirect_scale
    }

    fn ground_color(&self, point: Vec3) -> Vec3 {
        let mut color = Vec3::ZERO;
        let lifted = point + Vec3::Y * self.lift;
        if self.settings.indirect != Indirect::Only
            && self.towards_sun.y > 0.0
            && !self.scene.is_blocked(Ray { origin: lifted, direction: self.towards_sun }, None)
        {
            color += GROUND * self.towards_sun.y * self.settings.sun_strength;
        }
        if self.settings.indirect != Indirect::Off {
            color += GROUND * (OPEN_SKY * self.settings.ambient * self.settings.indirect_scale);
        }
        color
    }

    /// Sky, brightest at the horizon; below it there is haze, into which the ground fades.
    fn background(&self, ray: Ray) -> Vec3 {
        if !self.settings.sky || self.settings.indirect == Indirect::Only {
            return Vec3::ZERO;
        }
        let height = ray.direction.y.clamp(0.0, 1.0).sqrt();
        HORIZON.lerp(ZENITH, height) * self.sky_strength
    }
}

impl Ground {
    /// Distance to the disc along a ray that comes from above, and how much of the background it covers.
    fn along(&self, ray: Ray) -> Option<(f32, f32)> {
        let above = ray.origin.y - self.center.y;
        if above <= 0.0 || ray.direction.y >= 0.0 {
            return None;
        }
        let distance = above / -ray.direction.y;
        let offset = ray.origin + ray.direction * distance - self.center;
        let reach = Vec3::new(offset.x, 0.0, offset.z).length() / self.radius;
        if reach >= 1.0 {
            return None;
        }
        let inward = 1.0 - reach;
        Some((distance, (inward * inward * (3.0 - 2.0 * inward)).min(1.0)))
    }
}
