//! Decodes textures to 8-bit RGBA, once each, within limits. A texture that cannot be had is a
//! warning, for the plant's shape does not hang on it; one that is too large is an error.

use std::collections::HashMap;
use std::io::Cursor;

use image::{ImageFormat, ImageReader, Limits};

use super::error::ImportError;
use super::files::Files;
use super::limits;
use crate::mesh::Image;

/// All images of a mesh so far.
#[derive(Default)]
pub struct Images {
    /// Decoded, in order of first use.
    pub images: Vec<Image>,
    known: HashMap<String, Option<u32>>,
    texels: u64,
}

/// Which channel of an image says how much of the surface is there (MTL's `-imfchan`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coverage {
    /// The mean of red, green and blue.
    Luminance,
    /// 0 red, 1 green, 2 blue, 3 alpha.
    Channel(usize),
}

impl Images {
    /// The image behind `key`, from `load` (name, bytes) at its first use. `None` after a warning.
    pub fn get(
        &mut self,
        files: &mut Files,
        key: &str,
        load: impl FnOnce(&mut Files) -> Result<Option<(String, Vec<u8>)>, ImportError>,
    ) -> Result<Option<u32>, ImportError> {
        if let Some(&known) = self.known.get(key) {
            return Ok(known);
        }
        let index = match load(files)? {
            Some((name, bytes)) => self.decode(files, name, &bytes)?,
            None => None,
        };
        self.known.insert(key.to_owned(), index);
        Ok(index)
    }

    /// The image file that `uri` means, beside the mesh.
    pub fn get_file(
        &mut self,
        files: &mut Files,
        uri: &str,
        place: &str,
    ) -> Result<Option<u32>, ImportError> {
        let path = match files.find(uri) {
            Ok(path) => path,
            Err(path) => {
                let path = path.display();
                files.warn(format!(
                    "{place} names the texture '{uri}', which is not there ({path}); going on without"
                ));
                return Ok(None);
            }
        };
        let key = path.display().to_string();
        self.get(files, &key, |files| {
            let name = super::files::name_of(&path);
            Ok(Some((name, files.read(&path, limits::FILE_BYTES)?)))
        })
    }

    /// A second image with the coverage of `image` in its alpha, white otherwise.
    pub fn coverage_of(&mut self, files: &Files, image: u32, coverage: Coverage) -> Result<u32, ImportError> {
        let key = format!("coverage {coverage:?} of {image}");
        if let Some(&Some(known)) = self.known.get(&key) {
            return Ok(known);
        }
        let source = &self.images[image as usize];
        let (name, width, height) = (source.name.clone(), source.width, source.height);
        self.count_texels(files, &name, width, height)?;
        let texel = |texel: &[u8]| match coverage {
            Coverage::Luminance => {
                ((u32::from(texel[0]) + u32::from(texel[1]) + u32::from(texel[2]) + 1) / 3) as u8
            }
            Coverage::Channel(channel) => texel[channel],
        };
        let source = &self.images[image as usize];
        let rgba: Vec<u8> =
            source.rgba.chunks_exact(4).flat_map(|rgba| [255, 255, 255, texel(rgba)]).collect();
        Ok(self.push(key, Image { name, width, height, has_cut: has_cut(&rgba), rgba }))
    }

    fn push(&mut self, key: String, image: Image) -> u32 {
        let index = self.images.len() as u32;
        self.images.push(image);
        self.known.insert(key, Some(index));
        index
    }

    fn count_texels(
        &mut self,
        files: &Files,
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
        let (width, height) = match ImageReader::with_format(Cursor::new(bytes), format).into_dimensions() {
            Ok((width, height)) if width > 0 && height > 0 => (width, height),
            Ok(_) => {
                files.warn(format!("the texture '{name}' has no texels; going on without"));
                return Ok(None);
            }
            Err(error) => return unreadable(files, error),
        };
        self.count_texels(files, &name, width, height)?;
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
        let rgba = rgba.into_raw();
        let index = self.images.len() as u32;
        self.images.push(Image { name, width, height, has_cut: has_cut(&rgba), rgba });
        Ok(Some(index))
    }
}

/// Share of texels whose alpha is below `cutoff`, 0..=1.
pub fn cut_share(image: &Image, cutoff: f32) -> f64 {
    let cut = image.rgba.chunks_exact(4).filter(|texel| f32::from(texel[3]) / 255.0 < cutoff).count();
    cut as f64 / (image.rgba.len() / 4).max(1) as f64
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
        None => format!("of an unknown kind (first bytes {:02x?})", &bytes[..bytes.len().min(4)]),
    }
}
