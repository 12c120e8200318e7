//! One volume of a file, a base, the density or the extinction, as a picture or as plain numbers for other programs.
//!
//! - [`slice_sheet_png`]: slices along z side by side, to look at.
//! - [`volume_exr`]: every value exactly, one EXR layer per z slice, one channel per band.
//! - [`volume_npy`]: every value exactly, as one NumPy array.
//!
//! In pictures (PNG, EXR) x runs to the right and y upwards, so a plant stands upright: pixel row `r` of a
//! slice is `y = N - 1 - r`. All three return the file's bytes; they are the same on every machine.

use std::borrow::Cow;
use std::io::Cursor;

use exr::image::write::WritableImage;
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds,
    Layer, LayerAttributes,
};
use flb_format::matter::{Class, TurbidMedium};
use flb_format::{Field, Medium};

use crate::InspectError;

/// Wood's share of red, green and blue in a density sheet; leaf is grey.
const WOOD_TINT: [f32; 3] = [1.0, 0.55, 0.2];

/// Array to extract.
#[derive(Debug, Clone, Copy)]
pub enum Volume<'a> {
    /// A base, with a name for each band.
    Base {
        /// The decoded field.
        field: &'a Field,
        /// Names of the bands, in the field's order.
        bands: &'a [String],
    },
    /// The medium. PNG and NPY hold its density alone; EXR its four arrays.
    Density(&'a Medium),
    /// Extinction of a `physical` species, m^-1. PNG holds the sum of leaf and wood; NPY and EXR both.
    Extinction(&'a TurbidMedium),
}

impl Volume<'_> {
    /// Sites per edge.
    pub fn lattice(&self) -> u32 {
        match self {
            Volume::Base { field, .. } => field.lattice,
            Volume::Density(medium) => medium.grid.lattice,
            Volume::Extinction(turbid) => turbid.grid.lattice,
        }
    }

    /// Names and values `[z][y][x]` of the channels, in the volume's order.
    fn channels(&self) -> Vec<(String, Vec<f32>)> {
        match self {
            Volume::Base { field, bands } => {
                (0..field.bands).map(|band| (channel_name(bands, band), field.band(band).to_vec())).collect()
            }
            Volume::Density(medium) => vec![
                ("density".to_owned(), medium.density.clone()),
                ("class".to_owned(), medium.class.iter().map(|c| f32::from(*c as u8)).collect()),
                ("leaf_area_density".to_owned(), medium.leaf_area_density.clone()),
                ("wood_area_density".to_owned(), medium.wood_area_density.clone()),
            ],
            Volume::Extinction(turbid) => vec![
                ("leaf_extinction".to_owned(), turbid.leaf_per_m.clone()),
                ("wood_extinction".to_owned(), turbid.wood_per_m.clone()),
            ],
        }
    }
}

/// A sheet of `slices` slices, evenly spread along z (all of them if there are no more), in a grid of
/// `ceil(sqrt(slices))` columns that fills from the upper left with a grey line of one pixel between.
///
/// Tone mapping: each value is divided by the largest of the whole volume (all bands), negative values are 0, and the
/// result is encoded as 8-bit sRGB. The first three bands are red, green and blue
/// ([`flb_format::Container::with_bands`] chooses them); one band is grey. Density is grey where leaf, tinted brown
/// where wood; of extinction, the part of wood is tinted.
pub fn slice_sheet_png(volume: &Volume, slices: u32) -> Result<Vec<u8>, InspectError> {
    let n = volume.lattice();
    let slices = slices.clamp(1, n);
    let columns = (1..=slices).find(|c| c * c >= slices).expect("slices itself is enough");
    let rows = slices.div_ceil(columns);
    let (width, height) = (columns * (n + 1) - 1, rows * (n + 1) - 1);

    let encode = Srgb::new();
    let scale = 1.0 / largest(volume);
    let mut pixels = vec![64u8; width as usize * height as usize * 3];
    for slice in 0..slices {
        let z = (2 * slice + 1) * n / (2 * slices);
        let (left, top) = (slice % columns * (n + 1), slice / columns * (n + 1));
        for row in 0..n {
            let site = ((z * n) as usize + (n - 1 - row) as usize) * n as usize;
            let start = ((top + row) as usize * width as usize + left as usize) * 3;
            for (x, pixel) in pixels[start..][..n as usize * 3].chunks_exact_mut(3).enumerate() {
                let color = color(volume, site + x);
                pixel.copy_from_slice(&color.map(|c| encode.byte(c * scale)));
            }
        }
    }
    png_bytes(width, height, &pixels)
}

/// Every value of the volume, unchanged: layers `z000`, `z001`, ... one per slice, each with one 32-bit
/// float channel per band, named as the band (channels of the density: `density`, `class` with 0 empty,
/// 1 leaf, 2 wood, `leaf_area_density`, `wood_area_density`). ZIP compressed, which loses nothing.
pub fn volume_exr(volume: &Volume) -> Result<Vec<u8>, InspectError> {
    let n = volume.lattice() as usize;
    let channels = volume.channels();
    let layers: Vec<Layer<AnyChannels<FlatSamples>>> = (0..n)
        .map(|z| {
            let channels = channels.iter().map(|(name, values)| {
                let upright = values[z * n * n..][..n * n].chunks_exact(n).rev().flatten().copied().collect();
                AnyChannel::new(name.as_str(), FlatSamples::F32(upright))
            });
            Layer::new(
                (n, n),
                LayerAttributes::named(format!("z{z:03}").as_str()),
                Encoding { compression: Compression::ZIP16, ..Encoding::FAST_LOSSLESS },
                AnyChannels::sort(channels.collect()),
            )
        })
        .collect();
    let image = Image::from_layers(ImageAttributes::new(IntegerBounds::from_dimensions((n, n))), layers);
    let mut bytes = Cursor::new(Vec::new());
    // One thread: the order of blocks in the file is then fixed.
    image.write().non_parallel().to_buffered(&mut bytes).map_err(|e| InspectError::Exr(e.to_string()))?;
    Ok(bytes.into_inner())
}

/// Every value of the volume, unchanged, as a NumPy array of little-endian 32-bit floats: a base is
/// `[band][z][y][x]`, the density `[z][y][x]`, the extinction `[leaf, wood][z][y][x]`.
pub fn volume_npy(volume: &Volume) -> Vec<u8> {
    let n = volume.lattice();
    let (shape, parts): (String, Vec<Cow<[f32]>>) = match volume {
        Volume::Base { field, .. } => (format!("{}, {n}, {n}, {n}", field.bands), vec![field.values()]),
        Volume::Density(medium) => (format!("{n}, {n}, {n}"), vec![medium.density.as_slice().into()]),
        Volume::Extinction(turbid) => {
            let parts = [&turbid.leaf_per_m, &turbid.wood_per_m];
            (format!("2, {n}, {n}, {n}"), parts.map(|part| part.as_slice().into()).to_vec())
        }
    };
    // Version 1.0 of NumPy's format (NEP 1): a dictionary of Python, filled up to 64 bytes with spaces and a newline.
    let dictionary = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({shape}), }}");
    let header = (NPY_MAGIC.len() + 2 + dictionary.len() + 1).next_multiple_of(64);
    let mut bytes = Vec::with_capacity(header + parts.iter().map(|part| part.len()).sum::<usize>() * 4);
    bytes.extend(NPY_MAGIC);
    bytes.extend(((header - NPY_MAGIC.len() - 2) as u16).to_le_bytes());
    bytes.extend(dictionary.as_bytes());
    bytes.resize(header - 1, b' ');
    bytes.push(b'\n');
    bytes.extend(parts.iter().flat_map(|part| part.iter()).flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Magic string and version of a NumPy file.
const NPY_MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// Largest value that the sheet shows; 1 if nothing is above 0.
fn largest(volume: &Volume) -> f32 {
    let of = |values: &[f32]| values.iter().fold(0.0f32, |l, v| l.max(*v));
    let largest = match volume {
        Volume::Base { field, .. } => of(&field.values()),
        Volume::Density(medium) => of(&medium.density),
        Volume::Extinction(turbid) => {
            (0..turbid.leaf_per_m.len()).fold(0.0, |l, site| turbid.extinction(site).max(l))
        }
    };
    if largest > 0.0 { largest } else { 1.0 }
}

/// Linear colour of a site, not yet scaled.
fn color(volume: &Volume, site: usize) -> [f32; 3] {
    match volume {
        Volume::Base { field, .. } => {
            match field.bands {
                1 => [field.value(0, site); 3],
                bands => std::array::from_fn(|band| {
                    if (band as u32) < bands { field.value(band as u32, site) } else { 0.0 }
                }),
            }
        }
        Volume::Density(medium) => {
            let density = medium.density[site];
            if medium.class[site] == Class::Wood { WOOD_TINT.map(|t| t * density) } else { [density; 3] }
        }
        Volume::Extinction(turbid) => {
            WOOD_TINT.map(|tint| turbid.leaf_per_m[site] + tint * turbid.wood_per_m[site])
        }
    }
}

/// A band's own name, or `band7` if it has none that is fit for a channel or shares it with another.
fn channel_name(bands: &[String], band: u32) -> String {
    let usable = |name: &&String| {
        !name.is_empty()
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && bands.iter().filter(|other| other == name).count() == 1
    };
    bands.get(band as usize).filter(usable).cloned().unwrap_or_else(|| format!("band{band}"))
}

fn png_bytes(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, InspectError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let write = || -> Result<(), png::EncodingError> {
        let mut writer = encoder.write_header()?;
        writer.write_image_data(rgb)?;
        writer.finish()
    };
    write().map_err(|e| InspectError::Png(e.to_string()))?;
    Ok(bytes)
}

/// Linear 0..=1 to the nearest 8-bit sRGB code (IEC 61966-2-1), by the limits between codes.
struct Srgb {
    /// `limits[k]`: the linear value half-way between codes k and k + 1.
    limits: [f32; 255],
}

impl Srgb {
    fn new() -> Srgb {
        let linear = |encoded: f64| {
            if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
        };
        Srgb { limits: std::array::from_fn(|k| linear((k as f64 + 0.5) / 255.0) as f32) }
    }

    /// Values beyond 0..=1 are clamped, NaN is 0.
    fn byte(&self, linear: f32) -> u8 {
        self.limits.partition_point(|limit| *limit <= linear) as u8
    }
}

#[cfg(test)]
mod tests;
