//! The sky over a plant: how much light comes from every side.
//!
//! ```text
//! sun + turbidity -clear-> Sky      image -read-> Sky
//! Sky -radiance(direction)-> linear sRGB      Sky -patches-> a few directions, each with its share of the light
//! ```
//!
//! World space is that of scenes: +Y up, north is -Z, east +X. Colours are linear sRGB (Rec. 709 primaries, white
//! D65). The unit of irradiance is that of the sun overhead in clear air ([`clear`]), by luminance.

pub mod clear;
pub mod error;
pub mod image;
pub mod patches;
mod primaries;
mod spectrum;

use std::f64::consts::PI;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use flb_format::sky_part::SkyPart;

pub use clear::ClearSky;
pub use error::SkyError;
pub use image::SkyImage;

/// Reflectance of the ground around, where a sky has ground below its horizon: dry grass, linear.
pub const GROUND_REFLECTANCE: [f32; 3] = [0.23, 0.22, 0.15];

/// Radiance from every side.
#[derive(Debug, Clone)]
pub struct Sky {
    source: Source,
    /// Factor on the source.
    scale: f32,
    /// Parts of it, once they were asked for; clones have the same.
    patches: Arc<OnceLock<Vec<SkyPart>>>,
}

#[derive(Debug, Clone)]
enum Source {
    Clear(Arc<ClearSky>),
    Image(Arc<SkyImage>),
}

impl PartialEq for Sky {
    fn eq(&self, other: &Sky) -> bool {
        let is_same_source = match (&self.source, &other.source) {
            (Source::Clear(a), Source::Clear(b)) => a == b,
            // Millions of pixels.
            (Source::Image(a), Source::Image(b)) => Arc::ptr_eq(a, b) || a == b,
            _ => false,
        };
        is_same_source && self.scale == other.scale
    }
}

impl Sky {
    /// A clear sky under a sun that stands in a direction of the world, of any length.
    ///
    /// # Errors
    /// [`SkyError::NoDirection`], [`SkyError::Turbidity`].
    pub fn clear(towards_sun: [f64; 3], turbidity: f64) -> Result<Sky, SkyError> {
        let clear = ClearSky::new(towards_sun, turbidity)?;
        Ok(Sky::new(Source::Clear(Arc::new(clear)), 1.0))
    }

    /// The sky of an image, of fluence 1 by luminance: images say nothing of their unit.
    pub fn of_image(image: Arc<SkyImage>) -> Sky {
        let scale = (1.0 / (4.0 * PI * image.mean_luminance())) as f32;
        Sky::new(Source::Image(image), scale)
    }

    /// Reads the sky of an image file, as of [`Sky::of_image`].
    ///
    /// # Errors
    /// [`SkyError`] for a file that cannot be used.
    pub fn read(file: &Path) -> Result<Sky, SkyError> {
        Ok(Sky::of_image(Arc::new(SkyImage::read(file)?)))
    }

    fn new(source: Source, scale: f32) -> Sky {
        Sky { source, scale, patches: Arc::default() }
    }

    /// Returns the sky made so many times as bright.
    #[must_use]
    pub fn times(&self, factor: f32) -> Sky {
        Sky::new(self.source.clone(), self.scale * factor)
    }

    /// Radiance from a direction of unit length.
    pub fn radiance(&self, towards: [f32; 3]) -> [f32; 3] {
        match &self.source {
            Source::Clear(clear) => clear.radiance(towards),
            Source::Image(image) => image.radiance(towards),
        }
        .map(|band| band * self.scale)
    }

    /// Radiance that a camera sees in a direction of unit length: smooth between texels; below the horizon of a clear
    /// sky its haze, into which a ground fades.
    pub fn seen(&self, towards: [f32; 3]) -> [f32; 3] {
        match &self.source {
            Source::Clear(clear) => clear.above([towards[0], towards[1].max(0.0), towards[2]]),
            Source::Image(image) => image.smooth(towards),
        }
        .map(|band| band * self.scale)
    }

    /// Irradiance of the sun that belongs to a clear sky on a plane that faces it. It is no part of the radiance.
    pub fn sun(&self) -> Option<[f32; 3]> {
        match &self.source {
            Source::Clear(clear) => Some(clear.sun),
            Source::Image(_) => None,
        }
    }

    /// Image of the sky and the factor on it, where the sky is of one.
    pub fn image(&self) -> Option<(&SkyImage, f32)> {
        match &self.source {
            Source::Clear(_) => None,
            Source::Image(image) => Some((image, self.scale)),
        }
    }

    /// A few directions that stand for all of it, found once.
    pub fn patches(&self) -> &[SkyPart] {
        self.patches.get_or_init(|| patches::patches(self))
    }

    /// Fluence: its radiance summed over the sphere.
    pub fn fluence(&self) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for patch in self.patches() {
            (0..3).for_each(|band| sum[band] += f64::from(patch.fluence[band]));
        }
        sum.map(|sum| sum as f32)
    }

    /// Rows and columns of even steps in angle that tell its light apart.
    fn steps(&self) -> [usize; 2] {
        match &self.source {
            Source::Clear(_) => [192, 384],
            Source::Image(image) => image.steps(),
        }
    }
}

/// Luminance of linear sRGB (Rec. 709).
pub fn luminance([red, green, blue]: [f32; 3]) -> f32 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

#[cfg(test)]
mod tests;
