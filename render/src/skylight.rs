//! The sky that paths end in: most of it is met by chance, what is small and bright is looked for.
//!
//! Radiance is cut at a few times its mean. Paths that leave the plant see what lies below the cut. What lies above it,
//! in the pixels of an image, is drawn by its light and looked at through a shadow ray, as a sun is.

use flb_scene::sky::{Sky, luminance};
use glam::Vec3;

use crate::{Lighting, backdrop::sky_radiance, paths::Draw};

/// Times its mean luminance at which a sky is cut.
const CUT: f64 = 8.0;

/// A sky made ready for paths.
pub(crate) struct Skylight {
    source: Source,
    /// Luminance at which radiance is cut.
    cut: f32,
    bright: Vec<BrightPixel>,
}

enum Source {
    Even(Vec3),
    Dome(Sky),
}

struct BrightPixel {
    towards: Vec3,
    /// Irradiance beyond the cut on a plane that faces it, over the chance that the pixel is drawn.
    irradiance: Vec3,
    /// Sum of the chances up to this pixel.
    up_to: f64,
}

impl Skylight {
    pub(crate) fn of(lighting: &Lighting) -> Skylight {
        let Some(sky) = &lighting.dome else {
            let source = Source::Even(Vec3::splat(sky_radiance(lighting.daylight.sky)));
            return Skylight { source, cut: f32::INFINITY, bright: Vec::new() };
        };
        let Some((image, scale)) = sky.image() else {
            return Skylight { source: Source::Dome(sky.clone()), cut: f32::INFINITY, bright: Vec::new() };
        };
        let cut = (CUT * image.mean_luminance()) as f32 * scale;
        let [width, height] = image.size();
        let (mut bright, mut sum) = (Vec::new(), 0.0);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let light = image.pixel(x, y).map(|band| band * scale);
            let over = 1.0 - cut / luminance(light);
            if over > 0.0 {
                let irradiance = Vec3::from(light) * (over * image.solid_angle(y) as f32);
                sum += f64::from(luminance(irradiance.to_array()));
                let towards = Vec3::from(image.towards(x as f64 + 0.5, y as f64 + 0.5));
                bright.push(BrightPixel { towards, irradiance, up_to: sum });
            }
        }
        for pixel in &mut bright {
            let chance = f64::from(luminance(pixel.irradiance.to_array())) / sum;
            pixel.irradiance /= chance as f32;
            pixel.up_to /= sum;
        }
        Skylight { source: Source::Dome(sky.clone()), cut, bright }
    }

    /// Whether some of it has to be looked for.
    pub(crate) fn has_bright_parts(&self) -> bool {
        !self.bright.is_empty()
    }

    /// Radiance below the cut.
    pub(crate) fn even_part(&self, towards: Vec3) -> Vec3 {
        match &self.source {
            Source::Even(radiance) => *radiance,
            Source::Dome(sky) => {
                let light = sky.radiance(towards.to_array());
                Vec3::from(light) * (self.cut / luminance(light)).min(1.0)
            }
        }
    }

    /// A direction drawn by the light beyond the cut, and the irradiance that stands for all of that.
    pub(crate) fn bright_part(&self, draw: &mut Draw) -> Option<(Vec3, Vec3)> {
        let chosen = f64::from(draw.unit());
        let at = self.bright.partition_point(|pixel| pixel.up_to <= chosen);
        let pixel = self.bright.get(at.min(self.bright.len().checked_sub(1)?))?;
        Some((pixel.towards, pixel.irradiance))
    }
}

#[cfg(test)]
mod tests;
