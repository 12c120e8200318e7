//! Fragments in the light of a sun: shadow rays and baked light, and nothing that the camera has found before.

use std::f32::consts::FRAC_1_PI;
use std::sync::atomic::{AtomicUsize, Ordering};

use flb_scene::sky::Sky;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{
    Forest, Fragments, InstanceSearch,
    fragments::{Fragment, Square},
    ground::GroundSurface,
    placed::WorldRay,
    scenery::Scenery,
    sun_grid::{self, SunGrid},
    trace::SunWay,
    water::{INTO_FROM_SKY, Water, reflectance},
};
use crate::{
    Asked, Indirect, Picture, RenderError,
    backdrop::{on_level_ground, sky_gradient},
    paper::Paper,
    physical::Physical,
    picture::{if_finite, not_below_0},
    scene::TriangleHit,
    settings::{dome_over_paper, range, sun_direction},
    sun::Sunlight,
};

/// Where phi comes from: takes an instance and what is asked of its model (metres), and writes phi per band, R, G, B,
/// as [`crate::FacingLight`] does: sun and sky applied, their directions turned into the instance's own frame.
pub type ForestLight<'a> = dyn Fn(u32, Asked, &mut [f32; 3]) + Sync + 'a;

/// The light on a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Daylight {
    /// Towards the sun, world, any length but zero. Where there is a ground or water, a sun at or below the horizon
    /// sends nothing by itself; `light` has to leave it out as well.
    pub sun: [f64; 3],
    /// As [`crate::RenderSettings::sun_strength`].
    pub sun_strength: f32,
    /// As [`crate::RenderSettings::sun_color`].
    pub sun_color: [f32; 3],
    /// As [`crate::RenderSettings::ambient`].
    pub ambient: f32,
    /// As [`crate::RenderSettings::dome`], in the frame of the world.
    pub dome: Option<Sky>,
    /// Which part of the light is shown.
    pub indirect: Indirect,
    /// Scale of indirect light in the `paper` shading.
    pub indirect_scale: f32,
    /// Strength of the leaves' highlight in the `paper` shading.
    pub specular: f32,
    /// Whether the sky is drawn.
    pub sky: bool,
}

impl Default for Daylight {
    fn default() -> Daylight {
        let plant = crate::RenderSettings::default();
        Daylight {
            sun: plant.sun,
            sun_strength: plant.sun_strength,
            sun_color: plant.sun_color,
            ambient: plant.ambient,
            dome: plant.dome,
            indirect: plant.indirect,
            indirect_scale: plant.indirect_scale,
            specular: plant.specular,
            sky: plant.sky,
        }
    }
}

impl Daylight {
    /// Checks every setting and gives back the unit vector towards the sun.
    pub(super) fn validated(&self) -> Result<DVec3, RenderError> {
        range("sun_strength", self.sun_strength.into(), 0.0, 1e6)?;
        for band in self.sun_color {
            range("sun_color", band.into(), 0.0, 1e6)?;
        }
        range("ambient", self.ambient.into(), 0.0, 1e6)?;
        range("indirect_scale", self.indirect_scale.into(), 0.0, 1e6)?;
        range("specular", self.specular.into(), 0.0, 1e3)?;
        sun_direction(self.sun)
    }
}

/// A scene under one sun.
struct Lit<'a> {
    forest: &'a Forest<'a>,
    daylight: &'a Daylight,
    light: &'a ForestLight<'a>,
    sun: SunWay,
    scenery: Scenery,
    /// What a white ground sends out under open sky.
    white_under_sky: Vec3,
}

impl Forest<'_> {
    /// A picture of fragments that this forest has traced, in the light of a sun and of `light`. `progress` is called
    /// with the share done, 0..=1, from any thread.
    ///
    /// # Errors
    /// [`RenderError`] for settings outside their limits, and for light that is not finite.
    pub fn relight(
        &self,
        fragments: &Fragments,
        daylight: &Daylight,
        light: &ForestLight<'_>,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Picture, RenderError> {
        let lit = Lit::new(self, fragments, daylight, light)?;
        let (count, done) = (fragments.squares.len(), AtomicUsize::new(0));
        progress(0.0);
        let colors: Vec<Vec<[f32; 3]>> = fragments
            .squares
            .par_iter()
            .map(|square| {
                let colors = lit.square(fragments, square);
                progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count as f64);
                colors
            })
            .collect();
        let (width, height) = (fragments.view.width, fragments.view.height);
        let mut pixels = vec![[0.0f32; 3]; width as usize * height as usize];
        for (square, colors) in fragments.squares.iter().zip(colors) {
            for (row, colors) in colors.chunks_exact(square.width as usize).enumerate() {
                let first = (square.top as usize + row) * width as usize + square.left as usize;
                pixels[first..first + colors.len()].copy_from_slice(colors);
            }
        }
        if_finite(Picture { width, height, rgb: pixels.into_flattened() })
    }
}

impl<'a> Lit<'a> {
    fn new(
        forest: &'a Forest<'a>,
        fragments: &Fragments,
        daylight: &'a Daylight,
        light: &'a ForestLight<'a>,
    ) -> Result<Lit<'a>, RenderError> {
        let towards = daylight.validated()?;
        let scenery = forest.around().under(daylight, towards, fragments.lens.position);
        let white_under_sky = match &daylight.dome {
            None => Vec3::splat(scenery.white_under_sky),
            Some(_) if !forest.is_physical => return Err(dome_over_paper()),
            Some(dome) => on_level_ground(dome) * FRAC_1_PI,
        };
        let grid = match forest.search.shadow {
            InstanceSearch::Tree => None,
            InstanceSearch::Grid => {
                let extents = forest.instances.iter().map(|placed| placed.extent);
                Some(SunGrid::new(extents, towards, sun_grid::PAD))
            }
        };
        Ok(Lit { forest, daylight, light, sun: SunWay { towards, grid }, scenery, white_under_sky })
    }

    /// The means of a square's pixels, `[y][x]`, not below 0.
    fn square(&self, fragments: &Fragments, square: &Square) -> Vec<[f32; 3]> {
        let samples = fragments.view.samples;
        let pixels = square.fragments.chunks_exact(samples as usize);
        let places =
            (0..).map(|pixel| (square.left + pixel % square.width, square.top + pixel / square.width));
        let color = |(pixel, (x, y)): (&[Fragment], (u32, u32))| {
            let mut sum = Vec3::ZERO;
            for (sample, fragment) in (0..).zip(pixel) {
                sum += self.seen(fragment, square, &fragments.ray(x, y, sample));
            }
            not_below_0((sum / samples as f32).to_array())
        };
        pixels.zip(places).map(color).collect()
    }

    /// Linear colour that a ray from the camera sees.
    fn seen(&self, fragment: &Fragment, square: &Square, ray: &WorldRay) -> Vec3 {
        match (fragment, &self.forest.water) {
            (Fragment::Water { distance_m, sky, mirrored }, Some(water)) => {
                let back = water.mirrored(ray, *distance_m);
                let share = reflectance(back.direction.y as f32);
                let image = square.mirrored.get(*mirrored as usize).unwrap_or(&Fragment::Sky);
                self.color(image, &back) * share + self.body(water, back.origin, *sky) * (1.0 - share)
            }
            _ => self.color(fragment, ray),
        }
    }

    /// What comes out of the water at a point of it.
    fn body(&self, water: &Water, point: DVec3, sky: f32) -> Vec3 {
        let cosine = self.sun.towards.y as f32;
        let sun = self.sun_on(point, cosine) * (1.0 - reflectance(cosine));
        water.color() * (sun + self.sky_on(sky) * INTO_FROM_SKY)
    }

    /// Linear colour of anything but water along a ray.
    fn color(&self, fragment: &Fragment, ray: &WorldRay) -> Vec3 {
        match (fragment, &self.forest.soil) {
            (Fragment::Plant { instance, found }, _) => self.plant(*instance, found, ray),
            (Fragment::Ground { distance_m, sky }, Some(soil)) => {
                let point = ray.origin + ray.direction * *distance_m;
                let cover = self.cover(point);
                self.ground(soil, point, *sky) * cover + self.sky_color(ray) * (1.0 - cover)
            }
            _ => self.sky_color(ray),
        }
    }

    fn plant(&self, instance: u32, found: &TriangleHit, ray: &WorldRay) -> Vec3 {
        let placed = &self.forest.instances[instance as usize];
        let model = &self.forest.models[placed.species];
        let looking = placed.model_direction(ray.direction).as_vec3();
        let hit = model.surface(looking, found);
        let towards = placed.model_direction(self.sun.towards).as_vec3();
        let color = Vec3::from(self.daylight.sun_color);
        let sun = Sunlight { towards, strength: self.scenery.sun_strength, color };
        let sees = |side: Vec3| !self.forest.is_shaded(&self.sun, instance, &hit, side);
        let has_direct = self.daylight.indirect != Indirect::Only && self.scenery.sun_strength > 0.0;
        let has_indirect = self.daylight.indirect != Indirect::Off;
        let phi = |asked: Asked| {
            let mut phi = [0.0; 3];
            (self.light)(instance, asked, &mut phi);
            Vec3::from(phi)
        };
        let mut color = Vec3::ZERO;
        match &model.finish {
            None => {
                let Daylight { specular, indirect_scale, .. } = *self.daylight;
                let paper = Paper { sun, specular, indirect_scale };
                if has_direct {
                    color += paper.direct(&hit, looking, sees);
                }
                if has_indirect {
                    color += paper.indirect(&hit, phi(Asked::of(hit.point, &hit)));
                }
            }
            Some(finish) => {
                let (physical, matt) = (Physical { sun }, finish.at(&hit));
                if has_direct {
                    color += physical.direct(&hit, &matt, sees);
                }
                if has_indirect {
                    color += physical.indirect(&matt, phi(finish.asks(&hit)));
                }
            }
        }
        color
    }

    fn ground(&self, soil: &GroundSurface, point: DVec3, sky: f32) -> Vec3 {
        let cosine = soil.normal(point).dot(self.sun.towards.as_vec3());
        soil.color() * (self.sun_on(soil.off(point), cosine) + self.sky_on(sky))
    }

    /// What a white ground sends out at a point because of the sun. `cosine` is of its angle to the ground's normal.
    fn sun_on(&self, origin: DVec3, cosine: f32) -> Vec3 {
        if self.daylight.indirect == Indirect::Only || cosine <= 0.0 || self.scenery.white_in_sun <= 0.0 {
            return Vec3::ZERO;
        }
        let ray = WorldRay { origin, direction: self.sun.towards };
        match self.forest.is_blocked(&self.sun, &ray, None) {
            true => Vec3::ZERO,
            false => Vec3::from(self.daylight.sun_color) * (cosine * self.scenery.white_in_sun),
        }
    }

    /// What it sends out because of the sky, of which it sees a share.
    fn sky_on(&self, share: f32) -> Vec3 {
        match self.daylight.indirect {
            Indirect::Off => Vec3::ZERO,
            _ => self.white_under_sky * share,
        }
    }

    /// How much of the ground is left of the haze.
    fn cover(&self, point: DVec3) -> f32 {
        let offset = point - DVec3::from(self.scenery.center_m);
        let reach = (offset.x * offset.x + offset.z * offset.z).sqrt() / self.scenery.haze_m;
        let inward = (1.0 - reach).clamp(0.0, 1.0) as f32;
        (inward * inward * (3.0 - 2.0 * inward)).min(1.0)
    }

    fn sky_color(&self, ray: &WorldRay) -> Vec3 {
        match (&self.daylight.dome, self.daylight.sky && self.daylight.indirect != Indirect::Only) {
            (_, false) => Vec3::ZERO,
            (None, true) => sky_gradient(ray.direction.y as f32) * self.scenery.sky_strength,
            (Some(dome), true) => Vec3::from(dome.seen(ray.direction.as_vec3().to_array())),
        }
    }
}
