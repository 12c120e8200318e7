//! The same picture without a lattice: paths traced on the mesh itself, to judge baked light by.
//!
//! Camera, ground, sky, surfaces and the sun's first hit are those of the `physical` shading, to the last
//! bit. What the shading takes from the file, the light that was scattered or came from the sky, is found
//! here by following paths from leaf to leaf: at each hit the sun by a shadow ray, then on from a side
//! drawn by its share, in a direction drawn by the cosine, until a path leaves (and sees the sky) or is
//! ended by Russian roulette (Kajiya 1986, "The rendering equation"; Arvo and Kirk 1990, "Particle
//! transport and image synthesis"). The sky is isotropic over the whole sphere, or the one of the settings; the
//! ground sends the plant no light, as in the lattice, which has no ground. Small bright parts of a sky are
//! looked for by rays of their own (`skylight.rs`).

use flb_format::progress::Progress;
use glam::Vec3;

use crate::{
    Lighting, Look, Picture, Portrait, RenderError,
    forest::{
        Fragment, Species,
        fragments::{self, Camera},
        relight::{Lit, picture},
        squares,
    },
    paths::{Draw, Paths},
    physical::Physical,
    scene::Hit,
    skylight::Skylight,
    sun::{Sun, Sunlight, lift},
    surfaces::{Finish, Matt},
};

/// A path-traced picture and how sure it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Linear, in the units of [`crate::Shading::Physical`].
    pub picture: Picture,
    /// Standard error of each value of the picture, estimated from its samples, in the same order. Samples
    /// are spread more evenly over a pixel than chance would, so it is high rather than low at edges.
    pub standard_error: Vec<f32>,
}

impl Reference {
    /// Mean of the standard errors over the pixels, R, G, B.
    pub fn mean_standard_error(&self) -> [f64; 3] {
        let pixels = self.standard_error.len() / 3;
        [0, 1, 2].map(|band| {
            let errors = self.standard_error.iter().skip(band).step_by(3);
            errors.map(|&error| f64::from(error)).sum::<f64>() / pixels as f64
        })
    }
}

/// Traces paths over a plant under a sun and a sky, `samples` of them for each pixel. [`Look::indirect`] chooses the
/// sun's first hit, everything else, or both. The same settings give the same bytes for any number of threads.
///
/// `progress` is that of [`crate::render_plant`].
///
/// # Errors
/// As [`crate::render_plant`], and for a plant without [`crate::Shading::Physical`] or with fewer than 2 samples, from
/// which no error can be told.
pub fn render_reference(
    plant: &Species<'_>,
    portrait: &Portrait,
    lighting: &Lighting,
    look: &Look,
    progress: &Progress<'_>,
) -> Result<Reference, RenderError> {
    if portrait.samples < 2 {
        return Err(RenderError::Setting {
            name: "samples",
            found: portrait.samples.to_string(),
            expected: "2 or more, to estimate an error from".into(),
        });
    }
    let (forest, view) = portrait.prepare(plant, lighting, look)?;
    let camera = Camera::new(&forest, &view)?;
    let no_light = |_, _: &mut [f32; 3]| ();
    let lit = Lit::new(&forest, &camera, lighting, look, &no_light)?;
    let (scene, Some(finish)) = forest.first_model() else {
        return Err(RenderError::Setting {
            name: "shading",
            found: "paper".into(),
            expected: "physical: a path-traced picture needs surfaces".into(),
        });
    };
    let sky = Skylight::of(lighting);
    let sun = Sun { scene, light: lit.sunlight() };
    let tracer = Tracer {
        rays: fragments::Tracer::new(&forest, camera),
        camera,
        lit: &lit,
        sun,
        finish,
        look,
        sky,
        lift: lift(scene),
    };
    let pixels = squares::pixels(&view, progress, |_, area| {
        area.pixels().map(|(x, y)| tracer.pixel(x, y, view.samples)).collect()
    })?;
    let (colors, errors): (Vec<[f32; 3]>, Vec<[f32; 3]>) = pixels.into_iter().unzip();
    Ok(Reference { picture: picture(&view, colors)?, standard_error: errors.into_flattened() })
}

struct Tracer<'a> {
    rays: fragments::Tracer<'a>,
    camera: Camera,
    lit: &'a Lit<'a>,
    sun: Sun<'a>,
    finish: &'a Finish,
    look: &'a Look,
    sky: Skylight,
    lift: f32,
}

impl Tracer<'_> {
    /// Mean of a pixel's samples, and the standard error of that mean.
    fn pixel(&self, x: u32, y: u32, samples: u32) -> ([f32; 3], [f32; 3]) {
        let mut sum = [0.0f32; 3];
        let mut squares = [0.0f64; 3];
        for sample in 0..samples {
            let color = self.color(x, y, sample);
            for band in 0..3 {
                sum[band] += color[band];
                squares[band] += f64::from(color[band]) * f64::from(color[band]);
            }
        }
        let mean = sum.map(|value| value / samples as f32);
        let count = f64::from(samples);
        let error = [0, 1, 2].map(|band| {
            let mean = f64::from(sum[band]) / count;
            let variance = (squares[band] / count - mean * mean).max(0.0) * count / (count - 1.0);
            (variance / count).sqrt() as f32
        });
        (mean, error)
    }

    fn color(&self, x: u32, y: u32, sample: u32) -> [f32; 3] {
        let ray = self.camera.ray(x, y, sample);
        let fragment = self.rays.fragment(x, y, sample, &mut Vec::new());
        let Fragment::Plant { found, .. } = &fragment else {
            return self.lit.color(&fragment, &ray).to_array();
        };
        let hit = self.sun.scene.surface(ray.direction.as_vec3(), found);
        let mut color = Vec3::ZERO;
        if self.look.has_direct() {
            color += self.direct(&hit, &self.finish.at(&hit));
        }
        if self.look.has_indirect() {
            color += self.scattered(hit, &mut Draw::new(x, y, sample));
        }
        color.to_array()
    }

    fn direct(&self, hit: &Hit, matt: &Matt) -> Vec3 {
        Physical { sun: self.sun.light }.direct(hit, matt, |side| self.sun.sees_hit(hit, side))
    }

    /// Radiance that a hit sends to where its ray came from, without the sun on the hit itself.
    fn scattered(&self, hit: Hit, draw: &mut Draw) -> Vec3 {
        let mut radiance = Vec3::ZERO;
        let mut lookouts = Vec::new();
        if self.sky.has_bright_parts() {
            lookouts.push((Vec3::ONE, hit.clone()));
        }
        let paths = Paths { scene: self.sun.scene, finish: self.finish, lift: self.lift };
        let leaves = paths.follow(hit, draw, |throughput, hit, matt| {
            radiance += throughput * self.direct(hit, matt);
            if self.sky.has_bright_parts() {
                lookouts.push((throughput, hit.clone()));
            }
        });
        for (throughput, hit) in &lookouts {
            radiance += *throughput * self.bright_parts(hit, draw);
        }
        match leaves {
            Some((towards, throughput)) => radiance + throughput * self.sky.even_part(towards),
            None => radiance,
        }
    }

    /// Radiance that the small bright parts of the sky cause at a hit.
    fn bright_parts(&self, hit: &Hit, draw: &mut Draw) -> Vec3 {
        let Some((towards, irradiance)) = self.sky.bright_part(draw) else { return Vec3::ZERO };
        let sun = Sun { light: Sunlight { towards, strength: 1.0, color: irradiance }, ..self.sun };
        Physical { sun: sun.light }.direct(hit, &self.finish.at(hit), |side| sun.sees_hit(hit, side))
    }
}

#[cfg(test)]
mod tests;
