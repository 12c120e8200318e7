//! Pictures of baked plants, and how far two pictures are apart.

use flb_format::{Daylight, sun};
use flb_render::{Indirect, LightQuery, Lighting, Look, Picture, Portrait, Shading, Species, render_plant};
use flb_runtime::Library;
use flb_runtime::samplers::{SpeciesSampler, bases_needed};
use flb_scene::{MaterialClass, Mesh};

use crate::pipeline::Baked;

/// Factor on the ambient base, the command's default.
pub const AMBIENT: f32 = 0.02;

/// What is seen and in which light. The camera stands in the south (azimuth 180): east is on the right.
#[derive(Debug, Clone, Copy)]
pub struct Scene {
    /// Azimuth and elevation of the sun, degrees.
    pub sun: [f64; 2],
    /// Which part of the light.
    pub indirect: Indirect,
    /// Factor on the ambient base.
    pub ambient: f32,
    /// Pixels per edge.
    pub edge: u32,
    /// Rays per pixel.
    pub samples: u32,
}

/// Sums of R, G, B over a picture.
pub fn light_of(picture: &Picture) -> [f64; 3] {
    [0, 1, 2].map(|band| picture.rgb.iter().skip(band).step_by(3).map(|v| f64::from(*v)).sum())
}

/// The plant alone, before black, lit from its own file.
///
/// # Panics
/// If the file is not valid or the scene has no sun.
pub fn portrait(baked: &Baked, scene: &Scene) -> Picture {
    let library = Library::from_source("baked", Box::new(baked.file.clone())).expect("a valid file");
    portrait_of(&library, &baked.mesh, &baked.classes(), scene)
}

/// As [`portrait`], from a library's first species and a mesh.
///
/// # Panics
/// As [`portrait`].
pub fn portrait_of(library: &Library, mesh: &Mesh, classes: &[MaterialClass], scene: &Scene) -> Picture {
    let towards_sun = sun::towards_sun(scene.sun[0], scene.sun[1]);
    let blend = sun::blend(towards_sun).expect("angles give a direction");
    let bases = bases_needed(&blend, scene.ambient > 0.0);
    let sampler = SpeciesSampler::load(library, 0, &bases).expect("the file holds all bases");
    let light = |query: LightQuery, phi: &mut [f32; 3]| {
        sampler.indirect(&blend, 1.0, scene.ambient, query.point, phi)
    };
    let plant = Species { mesh, classes, shading: Shading::Paper };
    let (edge, samples) = (scene.edge, scene.samples);
    let portrait = Portrait { width: edge, height: edge, samples, has_ground: false, ..Portrait::default() };
    let lighting = Lighting::of(Daylight { towards_sun, sun: 1.0, sky: scene.ambient });
    let look = Look { indirect: scene.indirect, has_sky: false, ..Look::default() };
    render_plant(&plant, &portrait, &lighting, &look, &light, &|_| Ok(())).expect("a plant renders")
}

/// Linear luminance (Rec. 709) per pixel.
pub fn luminance(picture: &Picture) -> Vec<f64> {
    let of =
        |rgb: &[f32]| 0.2126 * f64::from(rgb[0]) + 0.7152 * f64::from(rgb[1]) + 0.0722 * f64::from(rgb[2]);
    picture.rgb.chunks_exact(3).map(of).collect()
}

/// Mean luminance of the left and of the right half.
pub fn halves(picture: &Picture) -> [f64; 2] {
    let width = picture.width as usize;
    let mut sums = [0.0; 2];
    for (i, value) in luminance(picture).into_iter().enumerate() {
        sums[usize::from(i % width >= width.div_ceil(2))] += value;
    }
    sums.map(|sum| sum / (width * picture.height as usize / 2) as f64)
}

/// How far two 8-bit pictures are apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Root of the mean square difference, 0..=255.
    pub rms: f64,
    /// Largest difference, 0..=255.
    pub max: u8,
}

/// Compares two pictures of one size.
///
/// # Panics
/// If their sizes differ.
pub fn distance(a: &[u8], b: &[u8]) -> Distance {
    assert_eq!(a.len(), b.len(), "pictures of one size");
    let differences = || a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    let squares: f64 = differences().map(|d| f64::from(d) * f64::from(d)).sum();
    Distance { rms: (squares / a.len().max(1) as f64).sqrt(), max: differences().max().unwrap_or(0) }
}
