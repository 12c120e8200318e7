//! A mesh and the light of an `.flb` file in, a relit picture out, on the CPU.
//!
//! ```text
//! Mesh -prepare-> Scene -trace, shade, average-> Picture -tone map-> PNG, or linear EXR
//! ```
//!
//! Two shadings of docs/lighting-model.md, section 10. `paper`: direct Lambert light through a shadow ray, a
//! small highlight on leaves, and indirect light = texture colour x phi x scale. `physical`: leaves of
//! measured reflectance and transmittance in radiometric units, whose texture only says where they are
//! brighter or darker than the mean. Where phi comes from is the caller's: a closure from a point in model
//! space to phi per band, with sun and ambient already blended in. So this crate ray traces and nothing
//! else, and tests need no file.
//!
//! [`forest`] does the same for scenes of many plants.
//!
//! [`render_reference`] makes the `physical` picture by paths traced on the mesh, without any phi: what baked
//! light is judged by.
//!
//! The same scene and settings give the same bytes for any number of threads: every pixel has its own
//! sequence of samples, summed in order by one thread.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)] // cli/src/print.rs alone prints

mod backdrop;
mod camera;
pub mod classes;
pub mod error;
pub mod forest;
pub mod irradiance;
pub mod judge;
mod lens;
mod paper;
mod paths;
mod physical;
pub mod picture;
pub mod reference;
mod scene;
pub mod settings;
mod shade;
mod skylight;
mod sun;
pub mod surfaces;

use std::sync::atomic::{AtomicUsize, Ordering};

pub use flb_scene::sampling::hash;
use flb_scene::sampling::sequence;
use flb_scene::{MaterialClass, Mesh};
use glam::Vec3;
use rayon::prelude::*;

pub use error::RenderError;
pub use irradiance::{PointIrradiance, irradiance};
pub use picture::{PHYSICAL_EXPOSURE, Picture, contact_sheet, png_of};
pub use reference::{Reference, render_reference};
pub use settings::{Indirect, RenderSettings};
pub use surfaces::{Shading, Surfaces};

use camera::Camera;
use picture::{if_finite, not_below_0};
use scene::{Hit, Scene};
use shade::Shader;

/// Where phi comes from: takes a point of the mesh in model space (metres) and writes phi per band, R, G, B,
/// sun blend and ambient already applied. In the `physical` shading phi is the fluence of what was
/// scattered and of the sky, in units in which a sun of irradiance 1 has fluence 1.
pub type Light<'a> = dyn Fn([f32; 3], &mut [f32; 3]) + Sync + 'a;

/// What a surface asks its light for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    /// A point of model space, metres.
    pub point: [f32; 3],
    /// Of a solid the unit normal of the side that is seen; a leaf has one light for both of its sides.
    pub facing: Option<[f32; 3]>,
}

impl Asked {
    /// At a point that stands for where a ray met a surface.
    pub(crate) fn of(point: Vec3, hit: &Hit) -> Asked {
        let facing = (hit.class != MaterialClass::Leaf).then(|| hit.flat_normal.to_array());
        Asked { point: point.to_array(), facing }
    }
}

/// The same for light that differs by which way a solid faces: that of an uneven sky.
pub type FacingLight<'a> = dyn Fn(Asked, &mut [f32; 3]) + Sync + 'a;

/// Ray traces `mesh` in the light of one sun and of `light`.
///
/// `classes` holds one class per material: leaves get a highlight in the `paper` shading, and light passes
/// through them in the `physical` one. `progress` is called with the share of rows done, 0..=1, from any
/// thread.
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
    let light = |asked: Asked, phi: &mut [f32; 3]| light(asked.point, phi);
    render_facing(mesh, classes, &light, settings, progress)
}

/// The same for light that is asked with the way that a solid faces.
///
/// # Errors
/// As [`render`].
pub fn render_facing(
    mesh: &Mesh,
    classes: &[MaterialClass],
    light: &FacingLight<'_>,
    settings: &RenderSettings,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Picture, RenderError> {
    let towards_sun = settings.validated()?;
    let scene = Scene::prepare(mesh, classes)?;
    let camera = Camera::framing(&scene, settings);
    let shader = Shader::new(&scene, settings, towards_sun, light);

    let pixels = rows(settings, progress, |x, y| average(&camera, &shader, x, y, settings.samples));
    picture_of(settings, pixels)
}

/// What `pixel` makes of every pixel, `[y][x]`, rows in parallel.
fn rows<T: Copy + Default + Send>(
    settings: &RenderSettings,
    progress: &(dyn Fn(f64) + Sync),
    pixel: impl Fn(u32, u32) -> T + Sync,
) -> Vec<T> {
    let (width, height) = (settings.width as usize, settings.height as usize);
    let mut pixels = vec![T::default(); width * height];
    let rows_done = AtomicUsize::new(0);
    progress(0.0);
    pixels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, place) in row.iter_mut().enumerate() {
            *place = pixel(x as u32, y as u32);
        }
        let done = rows_done.fetch_add(1, Ordering::Relaxed) + 1;
        progress(done as f64 / height as f64);
    });
    pixels
}

fn picture_of(settings: &RenderSettings, pixels: Vec<[f32; 3]>) -> Result<Picture, RenderError> {
    if_finite(Picture { width: settings.width, height: settings.height, rgb: pixels.into_flattened() })
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
    not_below_0(sum.map(|value| value / samples as f32))
}

/// Where in its pixel a sample lies, 0..1 in x and y. A lone sample lies in the middle.
fn jitter(x: u32, y: u32, sample: u32, samples: u32) -> [f32; 2] {
    if samples == 1 { [0.5, 0.5] } else { sequence(x ^ hash(y), sample) }
}

#[cfg(test)]
mod tests;
