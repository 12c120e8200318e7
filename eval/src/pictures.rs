//! Pictures of a judged plant: what the file makes of a light, what traced paths make of it, and how they differ.

use flb_format::Daylight;
use flb_render::picture::{SHEET_GAP, png_of};
use flb_render::reference::render_reference;
use flb_render::{
    Indirect, LightQuery, Lighting, Look, Picture, Portrait, RenderError, Species, render_plant,
};
use flb_scene::{ClassedMesh, Observer, Step};

use crate::mesh::MeshJudge;

/// Rays and paths of each pixel.
const SAMPLES: u32 = 16;

/// Picture of a judged plant under one source: the light of the file, that of traced paths, and their difference, side
/// by side.
pub struct JudgePicture {
    /// Number of the source: a sun, or the sky after the last.
    pub source: usize,
    /// Difference of radiance, in the mean of the bands, from which red (the file is brighter) or blue is full: the
    /// plant's mean radiance in truth.
    pub full: f32,
    /// Bytes of a PNG.
    pub png: Vec<u8>,
}

impl MeshJudge<'_> {
    /// Draws the plant under a source, each of the three views `size` pixels wide and high.
    ///
    /// # Errors
    /// [`RenderError`], as [`render_plant`].
    ///
    /// # Panics
    /// If there is no such source.
    pub fn picture(
        &self,
        classed: &ClassedMesh,
        source: usize,
        size: [u32; 2],
        observer: &dyn Observer,
    ) -> Result<JudgePicture, RenderError> {
        let ClassedMesh { mesh, classes } = classed;
        let is_sky = source == self.suns().len();
        let [width, height] = size;
        let plant = Species { mesh, classes, shading: self.surfaces().into() };
        let portrait = Portrait { width, height, samples: SAMPLES, has_ground: false, ..Portrait::default() };
        let towards_sun = if is_sky { [0.0, 1.0, 0.0] } else { self.suns()[source] };
        let [sun, sky] = if is_sky { [0.0, 1.0] } else { [1.0, 0.0] };
        let lighting = Lighting::of(Daylight { towards_sun, sun, sky });
        // The sun's own beam is the same in both.
        let look = Look { indirect: Indirect::Only, ..Look::default() };
        let subject = if is_sky { "sky" } else { "sun" };
        let light = |query: LightQuery, phi: &mut [f32; 3]| self.fluence(source, query.point, phi);
        let found = Step::Render.run(observer, subject, |progress| {
            render_plant(&plant, &portrait, &lighting, &look, &light, progress)
        })?;
        let truth = Step::Render.run(observer, subject, |progress| {
            render_reference(&plant, &portrait, &lighting, &look, progress)
        })?;
        let truth = truth.picture;
        let full = mean_radiance(&found, &truth);
        // One exposure for both, so that they can be compared by eye.
        let exposure = truth.auto_exposure();
        let views = [found.tone_mapped(exposure), truth.tone_mapped(exposure), signed(&found, &truth, full)];
        let (size, rgb) = side_by_side(size, &views);
        Ok(JudgePicture { source, full, png: png_of(size, &rgb)? })
    }
}

/// Of the truth, over the bands and the pixels in which there is light in either picture: those of the plant.
fn mean_radiance(found: &Picture, truth: &Picture) -> f32 {
    let pixels = found.rgb.chunks_exact(3).zip(truth.rgb.chunks_exact(3));
    let lit = pixels.filter(|(found, truth)| found.iter().chain(*truth).any(|value| *value > 0.0));
    let (sum, count) = lit.fold((0.0, 0u32), |(sum, count), (_, truth)| {
        (sum + truth.iter().map(|value| f64::from(*value)).sum::<f64>(), count + 3)
    });
    (sum / f64::from(count.max(1))) as f32
}

/// White where they are the same, red where `found` is brighter, blue where it is darker; 8-bit sRGB.
fn signed(found: &Picture, truth: &Picture, full: f32) -> Vec<u8> {
    let pixels = found.rgb.chunks_exact(3).zip(truth.rgb.chunks_exact(3));
    pixels
        .flat_map(|(found, truth)| {
            let apart = (0..3).map(|band| found[band] - truth[band]).sum::<f32>() / 3.0;
            // Beside a truth that is black, all that is found is full.
            let share = if apart == 0.0 { 0.0 } else { (apart / full).clamp(-1.0, 1.0) };
            let paler = (255.0 * (1.0 - share.abs()) + 0.5) as u8;
            if share > 0.0 { [255, paler, paler] } else { [paler, paler, 255] }
        })
        .collect()
}

/// Bytes of three views of one size in one row, black between them.
fn side_by_side([width, height]: [u32; 2], views: &[Vec<u8>; 3]) -> ([u32; 2], Vec<u8>) {
    let (row, gap) = (width as usize * 3, SHEET_GAP as usize * 3);
    let mut rgb = Vec::with_capacity((3 * row + 2 * gap) * height as usize);
    for y in 0..height as usize {
        for (at, view) in views.iter().enumerate() {
            if at > 0 {
                rgb.resize(rgb.len() + gap, 0);
            }
            rgb.extend_from_slice(&view[y * row..(y + 1) * row]);
        }
    }
    ([3 * width + 2 * SHEET_GAP, height], rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(rgb: &[[f32; 3]]) -> Picture {
        Picture { width: rgb.len() as u32, height: 1, rgb: rgb.concat() }
    }

    #[test]
    fn what_is_brighter_is_red_and_what_is_darker_is_blue() {
        let truth = picture(&[[0.0; 3], [1.0; 3], [1.0; 3], [2.0; 3], [4.0; 3]]);
        let found = picture(&[[0.0; 3], [2.0; 3], [0.0; 3], [9.0; 3], [4.0; 3]]);
        assert_eq!(mean_radiance(&found, &truth), 2.0);
        let white = [255; 3];
        let expected = [white, [255, 128, 128], [128, 128, 255], [255, 0, 0], white];
        assert_eq!(signed(&found, &truth, 2.0), expected.concat());
        let dark = picture(&[[0.0; 3]; 5]);
        assert_eq!(mean_radiance(&dark, &truth), 2.0);
        let against_dark = signed(&found, &dark, mean_radiance(&found, &dark));
        assert_eq!(against_dark, [white, [255, 0, 0], white, [255, 0, 0], [255, 0, 0]].concat());
    }

    #[test]
    fn views_stand_in_a_row() {
        let views = [1, 2, 3].map(|shade| vec![shade; 2 * 3 * 3]);
        let (size, rgb) = side_by_side([2, 3], &views);
        assert_eq!((size, rgb.len()), ([14, 3], 14 * 3 * 3));
        let second = &rgb[14 * 3..2 * 14 * 3];
        let shades: Vec<u8> = second.chunks_exact(3).map(|pixel| pixel[0]).collect();
        assert_eq!(shades, [1, 1, 0, 0, 0, 0, 2, 2, 0, 0, 0, 0, 3, 3]);
    }
}
