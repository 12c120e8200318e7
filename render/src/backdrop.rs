//! What stands around the plant: a ground that catches its shadow, and the sky behind it. Both are scenery,
//! and light nothing.

use std::f32::consts::{FRAC_1_PI, PI};

use flb_format::SkyPart;
use flb_scene::sky::Sky;
use glam::Vec3;

use crate::{
    Indirect, RenderSettings, Shading,
    scene::{Hit, Ray, Scene},
    sun::Sun,
};

/// Linear colour, and reflectance, of the ground: dry grass.
const GROUND: Vec3 = Vec3::new(0.23, 0.22, 0.15);
/// The ambient base of the `paper` model in empty space. The ground lies partly outside the lattice, where
/// the field says nothing, so it gets open sky and the sun's shadow.
pub(crate) const OPEN_SKY: f32 = 18.0;
/// Linear colours of the sky at the horizon and overhead.
pub(crate) const HORIZON: Vec3 = Vec3::new(0.60, 0.71, 0.84);
pub(crate) const ZENITH: Vec3 = Vec3::new(0.20, 0.36, 0.66);
/// Mean luminance (Rec. 709) of that gradient over the sky: a third of the horizon's, two thirds of the
/// zenith's.
pub(crate) const SKY_LUMINANCE: f32 = 0.4638;
/// Ambient weight at which the sky of the `paper` shading is drawn at full brightness.
const DAYLIGHT: f32 = 0.02;

/// What a ray from the camera meets first.
pub(crate) enum Seen {
    Plant(Hit),
    /// Linear colour of ground and sky.
    Backdrop(Vec3),
}

pub(crate) struct Backdrop<'a> {
    sun: Sun<'a>,
    indirect: Indirect,
    ground: Option<GroundDisc>,
    is_sky_drawn: bool,
    /// What a white ground sends out in a sun overhead, and under open sky.
    white_in_sun: Vec3,
    white_under_sky: Vec3,
    behind: Behind,
}

/// What is seen where there is nothing.
enum Behind {
    /// The gradient, times a factor.
    Gradient(f32),
    Dome(Sky),
}

/// A disc below the plant that fades into the background.
struct GroundDisc {
    center: Vec3,
    radius: f32,
}

impl<'a> Backdrop<'a> {
    pub(crate) fn new(scene: &Scene<'_>, settings: &RenderSettings, sun: Sun<'a>) -> Self {
        let center = (scene.min + scene.max) / 2.0;
        let in_sun = Vec3::splat(settings.sun_strength * FRAC_1_PI) * Vec3::from(settings.sun_color);
        let (white_in_sun, white_under_sky, behind) = match (&settings.dome, settings.shading) {
            (_, Shading::Paper) => (
                Vec3::splat(settings.sun_strength),
                Vec3::splat(OPEN_SKY * settings.ambient * settings.indirect_scale),
                Behind::Gradient(paper_sky_strength(settings.ambient)),
            ),
            (None, Shading::Physical(_)) => {
                // Irradiance of half a sky is pi times its radiance.
                let radiance = sky_radiance(settings);
                (in_sun, Vec3::splat(radiance), Behind::Gradient(radiance / SKY_LUMINANCE))
            }
            (Some(dome), Shading::Physical(_)) => {
                (in_sun, on_level_ground(dome) * FRAC_1_PI, Behind::Dome(dome.clone()))
            }
        };
        Backdrop {
            sun,
            indirect: settings.indirect,
            ground: settings.ground.then(|| GroundDisc {
                center: Vec3::new(center.x, scene.min.y, center.z),
                radius: scene.size() * 1.5,
            }),
            is_sky_drawn: settings.sky && settings.indirect != Indirect::Only,
            white_in_sun,
            white_under_sky,
            behind,
        }
    }

    /// The plant where it is the nearest thing along a ray from the camera, else what stands around it.
    pub(crate) fn seen(&self, ray: Ray) -> Seen {
        let hit = self.sun.scene.nearest(ray, None);
        let ground = self.ground.as_ref().and_then(|ground| ground.along(ray));
        match (hit, ground) {
            (Some(hit), Some(ground)) if hit.distance <= ground.0 => Seen::Plant(hit),
            (Some(hit), None) => Seen::Plant(hit),
            (_, Some((distance, cover))) => {
                let point = ray.origin + ray.direction * distance;
                Seen::Backdrop(self.ground_color(point) * cover + self.sky_color(ray) * (1.0 - cover))
            }
            (None, None) => Seen::Backdrop(self.sky_color(ray)),
        }
    }

    fn ground_color(&self, point: Vec3) -> Vec3 {
        let mut color = Vec3::ZERO;
        if self.indirect != Indirect::Only
            && self.sun.light.towards.y > 0.0
            && self.sun.sees(point, Vec3::Y, None)
        {
            color += GROUND * self.sun.light.towards.y * self.white_in_sun;
        }
        if self.indirect != Indirect::Off {
            color += GROUND * self.white_under_sky;
        }
        color
    }

    /// Sky, brightest at the horizon; below it there is haze, into which the ground fades.
    fn sky_color(&self, ray: Ray) -> Vec3 {
        if !self.is_sky_drawn {
            return Vec3::ZERO;
        }
        match &self.behind {
            Behind::Gradient(strength) => sky_gradient(ray.direction.y) * *strength,
            Behind::Dome(sky) => Vec3::from(sky.seen(ray.direction.to_array())),
        }
    }
}

/// Irradiance of a sky on level ground.
pub(crate) fn on_level_ground(sky: &Sky) -> Vec3 {
    let up = |patch: &SkyPart| patch.towards[1].max(0.0) as f32;
    sky.patches().iter().map(|patch| Vec3::from(patch.fluence) * up(patch)).sum()
}

/// The sky in a direction of unit length whose upward part is `up`, at full brightness.
pub(crate) fn sky_gradient(up: f32) -> Vec3 {
    HORIZON.lerp(ZENITH, up.clamp(0.0, 1.0).sqrt())
}

/// How bright the sky of the `paper` shading is drawn. Dusk is dimmer than noon, but a picture without ambient
/// light still has a sky.
pub(crate) fn paper_sky_strength(ambient: f32) -> f32 {
    0.35 + 0.65 * (ambient / DAYLIGHT).min(1.0)
}

/// Radiance of the isotropic sky that lights the plant in the `physical` shading: its fluence over the whole
/// sphere is `ambient`.
pub(crate) fn sky_radiance(settings: &RenderSettings) -> f32 {
    settings.ambient / (4.0 * PI)
}

impl GroundDisc {
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
