//! A linear picture and what it can be written as: tone-mapped PNG, linear EXR, a sheet of several.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, WritableImage,
};

use crate::{
    RenderError,
    settings::{MAX_EDGE, MAX_PIXELS},
};

/// Stops at which a picture in the `physical` shading looks right under a sun of strength 1. Real leaves send
/// out a few hundredths of the sun's irradiance as radiance. One number for all pictures, so that they can be
/// compared.
pub const PHYSICAL_EXPOSURE: f32 = 3.0;

/// Linear colour with Rec. 709 primaries. In the `paper` shading white in full sun is 1, in the `physical`
/// one it is the pi-th part of the sun's irradiance.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Values of the pixels, `[y][x][band]`, row 0 on top, R, G, B; width x height x 3 of them.
    pub rgb: Vec<f32>,
}

impl Picture {
    /// Stops that put the brightest pixels but one in a hundred at 0.8 before tone mapping, by luminance;
    /// pixels without light do not count. 0 for a black picture. Pictures exposed each by its own are no
    /// longer comparable.
    pub fn auto_exposure(&self) -> f32 {
        let luminance = |rgb: &[f32]| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        let mut lit: Vec<f32> = self.rgb.chunks_exact(3).map(luminance).filter(|&v| v > 0.0).collect();
        if lit.is_empty() {
            return 0.0;
        }
        let rank = (lit.len() - 1) * 99 / 100;
        let (_, bright, _) = lit.select_nth_unstable_by(rank, f32::total_cmp);
        libm::log2f(0.8 / *bright).clamp(-32.0, 32.0)
    }

    /// The magnitude of the difference from another picture, times `factor`.
    ///
    /// # Errors
    /// [`RenderError::Sheet`] for a picture of another size.
    pub fn difference(&self, other: &Picture, factor: f32) -> Result<Picture, RenderError> {
        self.check_size(other)?;
        let rgb = self.rgb.iter().zip(&other.rgb).map(|(a, b)| (a - b).abs() * factor).collect();
        Ok(Picture { rgb, ..*self })
    }

    /// Adds another picture of the same size, times a factor per band: light adds up.
    ///
    /// # Panics
    /// If the other one has another number of values.
    pub fn add(&mut self, other: &Picture, factor: [f32; 3]) {
        assert_eq!(self.rgb.len(), other.rgb.len(), "pictures of one size");
        for (sum, more) in self.rgb.chunks_exact_mut(3).zip(other.rgb.chunks_exact(3)) {
            (0..3).for_each(|band| sum[band] += more[band] * factor[band]);
        }
    }

    /// 8-bit sRGB, `[y][x][band]`: exposed by `exposure` stops, put through a filmic curve, encoded.
    pub fn tone_mapped(&self, exposure: f32) -> Vec<u8> {
        let gain = libm::exp2f(exposure);
        self.rgb.iter().map(|&linear| srgb_byte(filmic(linear * gain))).collect()
    }

    /// A PNG file of [`Picture::tone_mapped`].
    ///
    /// # Errors
    /// [`RenderError::Png`] if the encoder refuses.
    pub fn to_png(&self, exposure: f32) -> Result<Vec<u8>, RenderError> {
        png_of([self.width, self.height], &self.tone_mapped(exposure))
    }

    /// A PNG file of a picture without a backdrop, and of how much of each pixel it covers (one value per pixel in all
    /// bands): as PNG has it, colours are those of what covers, not multiplied by the alpha.
    ///
    /// # Errors
    /// [`RenderError::Sheet`] for a cover of another size; [`RenderError::Png`] if the encoder refuses.
    pub fn to_png_with_alpha(&self, exposure: f32, cover: &Picture) -> Result<Vec<u8>, RenderError> {
        self.check_size(cover)?;
        let alone =
            self.rgb.iter().zip(&cover.rgb).map(|(v, alpha)| if *alpha > 0.0 { v / alpha } else { 0.0 });
        let alone = Picture { rgb: alone.collect(), ..*self }.tone_mapped(exposure);
        let alpha = cover.rgb.iter().step_by(3).map(|alpha| (alpha.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
        let rgba = alone.chunks_exact(3).zip(alpha).flat_map(|(rgb, alpha)| [rgb[0], rgb[1], rgb[2], alpha]);
        png([self.width, self.height], png::ColorType::Rgba, &rgba.collect::<Vec<u8>>())
    }

    /// An OpenEXR file with the linear values, 32-bit float R, G, B, without loss.
    ///
    /// # Errors
    /// [`RenderError::Exr`] if the encoder refuses.
    pub fn to_exr(&self) -> Result<Vec<u8>, RenderError> {
        exr_of(&[("", self)], None)
    }

    fn check_size(&self, other: &Picture) -> Result<(), RenderError> {
        match (self.width, self.height) == (other.width, other.height) {
            true => Ok(()),
            false => Err(RenderError::Sheet(format!(
                "a picture of {} x {} pixels, expected {} x {} as the other",
                other.width, other.height, self.width, self.height
            ))),
        }
    }
}

/// An OpenEXR file of pictures of one size as named layers, 32-bit float without loss: channels `NAME.R`, `NAME.G` and
/// `NAME.B`, and `R`, `G`, `B` of the one without a name. `cover` is channel `A`: pictures without a backdrop are
/// multiplied by it, as OpenEXR has it.
///
/// # Errors
/// [`RenderError::Sheet`] without pictures, and for one of another size; [`RenderError::Exr`] if the encoder refuses.
pub fn exr_of(layers: &[(&str, &Picture)], cover: Option<&Picture>) -> Result<Vec<u8>, RenderError> {
    let pictures = || layers.iter().map(|(_, picture)| *picture).chain(cover);
    let first = pictures().next().ok_or_else(|| RenderError::Sheet("no pictures".into()))?;
    pictures().try_for_each(|picture| first.check_size(picture))?;
    let channel = |name: &str, picture: &Picture, band: usize| {
        let values: Vec<f32> = picture.rgb.iter().skip(band).step_by(3).copied().collect();
        AnyChannel::new(name, FlatSamples::F32(values))
    };
    let mut channels = SmallVec::new();
    for (name, picture) in layers {
        let dot = if name.is_empty() { "" } else { "." };
        for (band, letter) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push(channel(&format!("{name}{dot}{letter}"), picture, band));
        }
    }
    channels.extend(cover.map(|cover| channel("A", cover, 0)));
    let layer = Layer::new(
        (first.width as usize, first.height as usize),
        LayerAttributes::named("linear"),
        Encoding::SMALL_FAST_LOSSLESS,
        AnyChannels::sort(channels),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// A PNG file of 8-bit sRGB, `[y][x][band]`, row 0 on top.
///
/// # Errors
/// [`RenderError::Png`] if the encoder refuses.
pub fn png_of(size: [u32; 2], rgb: &[u8]) -> Result<Vec<u8>, RenderError> {
    png(size, png::ColorType::Rgb, rgb)
}

fn png([width, height]: [u32; 2], color: png::ColorType, pixels: &[u8]) -> Result<Vec<u8>, RenderError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}

/// Width of the black gaps between the pictures of a contact sheet, in pixels.
pub const SHEET_GAP: u32 = 4;

/// Several pictures of one height side by side, from left to right, with black gaps of `gap` pixels
/// between them.
///
/// # Errors
/// [`RenderError::Sheet`] without pictures, with pictures of different heights, or beyond the size limits of
/// a picture.
pub fn contact_sheet(pictures: &[Picture], gap: u32) -> Result<Picture, RenderError> {
    let first = pictures.first().ok_or_else(|| RenderError::Sheet("no pictures".into()))?;
    for (at, picture) in pictures.iter().enumerate() {
        if picture.height != first.height {
            return Err(RenderError::Sheet(format!(
                "picture {at} is {} pixels high, expected {} as the first",
                picture.height, first.height
            )));
        }
        let expected = picture.width as usize * picture.height as usize * 3;
        if picture.rgb.len() != expected {
            return Err(RenderError::Sheet(format!(
                "picture {at} holds {} values, expected {expected}",
                picture.rgb.len()
            )));
        }
    }
    let gaps = u64::from(gap) * (pictures.len() as u64 - 1);
    let width = pictures.iter().map(|p| u64::from(p.width)).sum::<u64>() + gaps;
    if width > u64::from(MAX_EDGE) || width * u64::from(first.height) > MAX_PIXELS {
        return Err(RenderError::Sheet(format!(
            "{width} x {} pixels, expected at most {MAX_EDGE} across and {MAX_PIXELS} altogether",
            first.height
        )));
    }
    let mut rgb = Vec::with_capacity(width as usize * first.height as usize * 3);
    for y in 0..first.height as usize {
        for (at, picture) in pictures.iter().enumerate() {
            if at > 0 {
                rgb.resize(rgb.len() + gap as usize * 3, 0.0);
            }
            let row = picture.width as usize * 3;
            rgb.extend_from_slice(&picture.rgb[y * row..(y + 1) * row]);
        }
    }
    Ok(Picture { width: width as u32, height: first.height, rgb })
}

/// A pixel's mean, cut off at 0: light of single rays may be below it, by noise. What is no number stays so.
pub fn not_below_0(mean: [f32; 3]) -> [f32; 3] {
    mean.map(|value| if value < 0.0 { 0.0 } else { value })
}

/// The picture, if all its values are finite.
///
/// # Errors
/// [`RenderError::NotFinite`] for the first that is not.
pub fn if_finite(picture: Picture) -> Result<Picture, RenderError> {
    let width = picture.width as usize;
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

/// The filmic curve of Narkowicz 2015 ("ACES Filmic Tone Mapping Curve"), 0..infinity to 0..1.
fn filmic(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1e4) * 0.8;
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

/// Linear 0..1 to an sRGB byte (IEC 61966-2-1).
fn srgb_byte(linear: f32) -> u8 {
    let encoded =
        if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests;
