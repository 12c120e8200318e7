//! Decodes textures to 8-bit RGBA, once each, within limits. A texture that cannot be had is a
//! warning, as the plant's shape does not depend on it; one that is too large is an error.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

use flb_format::text::url::shown_reference;
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::error::ImportError;
use super::files::{Files, Found};
use super::first_bytes::kind_of;
use super::limits;
use super::png::leave_out_metadata;
use crate::mesh::{Image, Material};

/// All images of a mesh so far.
#[derive(Default)]
pub(super) struct Images {
    /// Decoded, in order of first use.
    pub images: Vec<Image>,
    /// Whether an alpha channel that is 0 everywhere means that.
    pub keeps_zero_alpha: bool,
    known: HashMap<String, Option<u32>>,
    texels: u64,
    stored_bytes: u64,
}

/// A name for messages, and the bytes of an image file.
pub(super) type Stored<'a> = (String, Cow<'a, [u8]>);

/// Which channel of an image says how much of the surface is there (MTL's `-imfchan`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coverage {
    /// The mean of red, green and blue.
    Luminance,
    /// 0 red, 1 green, 2 blue, 3 alpha.
    Channel(usize),
}

impl Images {
    /// The image behind `key`, from `load` (name, bytes) at its first use. `None` after a warning.
    pub(super) fn get<'a>(
        &mut self,
        files: &mut Files,
        key: &str,
        load: impl FnOnce(&mut Files) -> Result<Stored<'a>, ImportError>,
    ) -> Result<Option<u32>, ImportError> {
        if let Some(&known) = self.known.get(key) {
            return Ok(known);
        }
        let (name, mut bytes) = load(files)?;
        self.stored_bytes += bytes.len() as u64;
        files.limit(format!("bytes of all images up to '{name}'"), self.stored_bytes, limits::IMAGE_BYTES)?;
        // It may be copied for this.
        files.room_for(&format!("the image '{name}'"), bytes.len() as u64)?;
        leave_out_metadata(&mut bytes);
        let index = self.decode(files, name, &bytes)?;
        self.known.insert(key.to_owned(), index);
        Ok(index)
    }

    /// The image file that `uri` means in one of the folders ([`Files::find`]).
    pub(super) fn get_file(
        &mut self,
        files: &mut Files,
        uri: &str,
        place: &str,
        folders: &[&Path],
    ) -> Result<Option<u32>, ImportError> {
        let path = match files.find(place, uri, folders)? {
            Found::File(path) => path,
            Found::Missing(path) => {
                let (uri, path) = (shown_reference(uri), path.display());
                files.warn(format!(
                    "{place} names the texture '{uri}', which is not there ({path}); going on without"
                ));
                return Ok(None);
            }
        };
        // Not as text, in which names that are no UTF-8 may be the same.
        let key = format!("{path:?}");
        self.get(files, &key, |files| {
            let name = super::files::name_of(&path);
            Ok((name, Cow::Owned(files.read(&path, limits::IMAGE_BYTES)?)))
        })
    }

    /// Whether one of the textures of a material differs from place to place.
    pub(super) fn differ_in(&self, material: &Material) -> bool {
        let passing = [material.passing_texture, material.passing_color_texture];
        let textures = [material.color_texture, material.alpha_texture].into_iter().chain(passing);
        let mut images = textures.flatten().map(|texture| &self.images[texture.image as usize]);
        images.any(|image| image.width > 1 || image.height > 1)
    }

    /// A second image with the coverage of `image` in its alpha, white otherwise.
    pub(super) fn coverage_of(
        &mut self,
        files: &mut Files,
        image: u32,
        coverage: Coverage,
    ) -> Result<u32, ImportError> {
        let key = format!("coverage {coverage:?} of {image}");
        if let Some(&Some(known)) = self.known.get(&key) {
            return Ok(known);
        }
        let source = &self.images[image as usize];
        let (name, width, height) = (source.name.clone(), source.width, source.height);
        self.count_texels(files, &name, width, height)?;
        let there = |texel: [u8; 4]| match coverage {
            Coverage::Luminance => {
                ((u32::from(texel[0]) + u32::from(texel[1]) + u32::from(texel[2]) + 1) / 3) as u8
            }
            Coverage::Channel(channel) => texel[channel],
        };
        let mut rgba = self.images[image as usize].rgba.clone();
        for texel in rgba.as_chunks_mut::<4>().0 {
            *texel = [255, 255, 255, there(*texel)];
        }
        Ok(self.push(key, Image { name, width, height, has_cut: has_cut(&rgba), rgba }))
    }

    /// A second image with the colours of `image`, all of it there.
    pub(super) fn without_alpha(&mut self, files: &mut Files, image: u32) -> Result<u32, ImportError> {
        let key = format!("colours of {image}");
        if let Some(&Some(known)) = self.known.get(&key) {
            return Ok(known);
        }
        let source = &self.images[image as usize];
        let (name, width, height) = (source.name.clone(), source.width, source.height);
        self.count_texels(files, &name, width, height)?;
        let mut rgba = self.images[image as usize].rgba.clone();
        rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|texel| texel[3] = 255);
        Ok(self.push(key, Image { name, width, height, has_cut: false, rgba }))
    }

    fn push(&mut self, key: String, image: Image) -> u32 {
        let index = self.images.len() as u32;
        self.images.push(image);
        self.known.insert(key, Some(index));
        index
    }

    /// Counts an image, and holds the memory of its texels.
    fn count_texels(
        &mut self,
        files: &mut Files,
        name: &str,
        width: u32,
        height: u32,
    ) -> Result<(), ImportError> {
        let edge = u64::from(width.max(height));
        files.limit(
            format!("texels along an edge of the image '{name}'"),
            edge,
            limits::IMAGE_EDGE.into(),
        )?;
        let texels = self.texels + u64::from(width) * u64::from(height);
        files.limit(format!("texels of all images up to '{name}'"), texels, limits::IMAGE_TEXELS)?;
        files.hold("images", 4 * (texels - self.texels))?;
        self.texels = texels;
        Ok(())
    }

    fn decode(&mut self, files: &mut Files, name: String, bytes: &[u8]) -> Result<Option<u32>, ImportError> {
        let Some(format) = format_of(&name, bytes) else {
            let kind = foreign_kind(bytes);
            files.warn(format!("the texture '{name}' is {kind}, which is not read (PNG, JPEG, WebP, TGA, BMP are); going on without"));
            return Ok(None);
        };
        let unreadable = |files: &mut Files, error: image::ImageError| {
            files.warn(format!("the texture '{name}' cannot be decoded ({error}); going on without"));
            Ok(None)
        };
        let decoder = match ImageReader::with_format(Cursor::new(bytes), format).into_decoder() {
            Ok(decoder) => decoder,
            Err(error) => return unreadable(files, error),
        };
        let (width, height) = decoder.dimensions();
        if width == 0 || height == 0 {
            files.warn(format!("the texture '{name}' has no texels; going on without"));
            return Ok(None);
        }
        let decoding = decoding_bytes(format, &decoder);
        drop(decoder);
        self.count_texels(files, &name, width, height)?;
        files.room_for(&format!("the decoding of the image '{name}'"), decoding + bytes.len() as u64)?;
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut bounds = Limits::default();
        bounds.max_image_width = Some(limits::IMAGE_EDGE);
        bounds.max_image_height = Some(limits::IMAGE_EDGE);
        bounds.max_alloc = Some(limits::IMAGE_DECODER_BYTES);
        reader.limits(bounds);
        let rgba = match reader.decode() {
            Ok(decoded) => decoded.into_rgba8(),
            Err(image::ImageError::Limits(_)) => {
                let bytes = u64::from(width) * u64::from(height) * 8;
                let what = format!("bytes to decode the image '{name}'");
                files.limit(what, bytes.max(limits::IMAGE_DECODER_BYTES + 1), limits::IMAGE_DECODER_BYTES)?;
                return Ok(None);
            }
            Err(error) => return unreadable(files, error),
        };
        let (width, height) = rgba.dimensions();
        let mut rgba = rgba.into_raw();
        if !self.keeps_zero_alpha && rgba.as_chunks::<4>().0.iter().all(|texel| texel[3] == 0) {
            // Exporters that do not use the channel write zeros; a surface that is nowhere would not be exported.
            files.warn(format!("the alpha channel of '{name}' is 0 everywhere; it is not used"));
            rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|texel| texel[3] = 255);
        }
        let index = self.images.len() as u32;
        files.limit("images", u64::from(index) + 1, limits::MATERIALS)?;
        self.images.push(Image { name, width, height, has_cut: has_cut(&rgba), rgba });
        Ok(Some(index))
    }
}

/// Memory that decoding takes beside the texels as they are kept.
fn decoding_bytes(format: ImageFormat, decoder: &impl ImageDecoder) -> u64 {
    let (width, height) = decoder.dimensions();
    let texels = u64::from(width) * u64::from(height);
    match format {
        // Their decoders hold all of an image again: coefficients of a progressive JPEG, planes of a WebP.
        ImageFormat::Jpeg | ImageFormat::WebP => 9 * texels,
        _ if decoder.color_type() == ColorType::Rgba8 => 0,
        _ => decoder.total_bytes(),
    }
}

/// Share of texels whose alpha is below `cutoff`, 0..=1.
pub fn cut_share(image: &Image, cutoff: f32) -> f64 {
    let cut = image.rgba.chunks_exact(4).filter(|texel| f32::from(texel[3]) / 255.0 < cutoff).count();
    cut as f64 / (image.rgba.len() / 4).max(1) as f64
}

/// Largest [`soft_share`] of an outline: more is a map of gloss or height.
pub const MAX_SOFT: f64 = 0.5;

/// Share of texels whose alpha is neither near 0 nor near 1: few in the outline of a leaf, most in a map of gloss.
pub fn soft_share(image: &Image) -> f64 {
    let texels = image.rgba.as_chunks::<4>().0;
    let soft = texels.iter().filter(|texel| (26..230).contains(&texel[3])).count();
    soft as f64 / texels.len().max(1) as f64
}

fn has_cut(rgba: &[u8]) -> bool {
    rgba.chunks_exact(4).any(|texel| texel[3] < 255)
}

/// By the first bytes; TGA has none that tell, so there the name has to.
fn format_of(name: &str, bytes: &[u8]) -> Option<ImageFormat> {
    use ImageFormat::{Bmp, Jpeg, Png, Tga, WebP};
    match image::guess_format(bytes) {
        Ok(format) => [Png, Jpeg, WebP, Bmp].contains(&format).then_some(format),
        Err(_) => name.to_lowercase().ends_with(".tga").then_some(Tga),
    }
}

fn foreign_kind(bytes: &[u8]) -> String {
    let known: [(&[u8], &str); 7] = [
        (b"\xABKTX 20\xBB", "KTX2"),
        (b"\xABKTX 11\xBB", "KTX"),
        (b"DDS ", "DDS"),
        (b"GIF8", "GIF"),
        (b"II*\0", "TIFF"),
        (b"MM\0*", "TIFF"),
        (b"8BPS", "PSD"),
    ];
    match known.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        Some((_, name)) => (*name).to_owned(),
        None if bytes.is_empty() => "empty".to_owned(),
        None => kind_of(bytes).map_or_else(
            || format!("of an unknown kind (first bytes {:02x?})", &bytes[..bytes.len().min(4)]),
            str::to_owned,
        ),
    }
}
