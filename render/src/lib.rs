//! A mesh and the light of an `.flb` file in, a relit picture out, on the CPU.
//!
//! ```text
//! Mesh -prepare-> Scene -trace, shade, average-> Picture -tone map-> PNG, or linear EXR
//! ```
//!
//! The shading is the `paper` model of `lighting-model.md`, section 10: direct Lambert light through a
//! shadow ray, a small highlight on leaves, and indirect light = texture colour x phi x scale. Where phi
//! comes from is the caller's: a closure from a point in model space to phi per band, with sun and
//! ambient already blended in. So this crate ray traces and nothing else, and tests need no file.
//!
//! The same scene and settings give the same bytes for any number of threads: every pixel has its own
//! sequence of samples, summed in order by one thread.
#![forbid(unsafe_code)]

mod camera;
pub mod error;
pub mod picture;
mod scene;
pub mod settings;
mod shade;
mod texture;

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_baker::{MaterialClass, Mesh};
use rayon::prelude::*;

pub use error::RenderError;
pub use picture::{Picture, contact_sheet};
pub use settings::{Indirect, RenderSettings};

use camera::Camera;
use scene::Scene;
use shade::Shader;

/// Where phi comes from: takes a point of the mesh in model space (metres) and writes phi per band, R, G, B, sun blend and ambient already applied.
pub type Light<'a> = dyn Fn([f32; 3], &mut [f32; 3]) + Sync + 'a;

/// Ray traces `mesh` in the light of one sun and of `light`.
///
/// `classes` holds one class per material: leaves get a highlight, everything else is matt. `progress` is
/// called with the share of rows done, 0..=1, from any thread.
///
/// # Errors
/// [`RenderError`] for settings outside their limits, a mesh without triangles, a wrong number of classes,
/// vertices that are not finite, and light that is not finite.
pub fn render(
    mesh: &Mesh,
    classes: &[MaterialClass],
    light: &Light<'_>,
    settings: &RenderSettings,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Picture, RenderError> {
    let towards_sun = settings.validated()?;
    let scene = Scene::prepare(mesh, classes)?;
    let camera = Camera::framing(&scene, settings);
    let shader = Shader::new(&scene, settings, towards_sun, light);

    let (width, height) = (settings.width as usize, settings.height as usize);
    let mut rgb = vec![0.0f32; width * height * 3];
    let rows_done = AtomicUsize::new(0);
    progress(0.0);
    rgb.par_chunks_mut(width * 3).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            pixel.copy_from_slice(&average(&camera, &shader, x as u32, y as u32, settings.samples));
        }
        let done = rows_done.fetch_add(1, Ordering::Relaxed) + 1;
        progress(done as f64 / height as f64);
    });

    let picture = Picture { width: settings.width, height: settings.height, rgb };
    match picture.rgb.iter().position(|value| !value.is_finite()) {
        None => Ok(picture),
        Some(at) => Err(RenderError::NotFinite {
            x: (at / 3 % width) as u32,
            y: (at / 3 / width) as u32,
            band: ["R", "G", "B"][at % 3],
            found: picture.rgb[at],
        }),
    }
}

/// The mean of a pixel's samples, linear.
fn average(camera: &Camera, shader: &Shader<'_>, x: u32, y: u32, samples: u32) -> [f32; 3] {
    let mut sum = [0.0f32; 3];
    for sample in 0..samples {
        let [dx, dy] = jitter(x, y, sample, samples);
        let color = shader.color(camera.ray(x as f32 + dx, y as f32 + dy));
        for band in 0..3 {
            sum[band] += color[band];
        }
    }
    sum.map(|value| value / samples as f32)
}

/// Where in its pixel a sample lies, 0..1 in x and y: the additive sequence of the plastic number (R2,
/// M. Roberts 2018), turned by a hash of the pixel. A lone sample lies in the middle.
fn jitter(x: u32, y: u32, sample: u32, samples: u32) -> [f32; 2] {
    const STEP: [u32; 2] = [3_242_174_889, 2_447_445_414]; // 1/p and 1/p^2 as fractions of 2^32
    if samples == 1 {
        return [0.5, 0.5];
    }
    let turn = hash(x ^ hash(y));
    let turns = [turn, hash(turn)];
    [0, 1].map(|axis| {
        let fraction = turns[axis].wrapping_add(sample.wrapping_mul(STEP[axis]));
        (fraction >> 8) as f32 / (1u32 << 24) as f32
    })
}

/// A bijective 32-bit mix (two rounds of xorshift-multiply).
fn hash(value: u32) -> u32 {
    let mut v = value.wrapping_add(0x9e37_79b9);
    v = (v ^ (v >> 16)).wrapping_mul(0x21f0_aaad);
    v = (v ^ (v >> 15)).wrapping_mul(0x735a_2d97);
    v ^ (v >> 15)
}

#[cfg(test)]
mod tests;
