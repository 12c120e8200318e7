//! Skies of images: OpenEXR or Radiance HDR, the whole sphere in equal steps of azimuth and elevation.
//!
//! The uppermost row is the zenith, the middle column north (-Z), and to the right of it lies east (+X), as one who
//! stands inside sees it.

use std::f64::consts::PI;
use std::io::{BufReader, Read};
use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers};
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;

use super::{SkyError, luminance};

/// Most columns: 8192 x 4096 pixels take 384 MiB.
const MOST_COLUMNS: usize = 8192;
/// Bytes of a file.
const FILE_BYTES: u64 = 640 << 20;
/// Largest number of half precision. What was brighter is stored as this, and its brightness is lost.
const HALF_MOST: f32 = 65_504.0;
/// Fewest rows in which light is summed.
const FEWEST_ROWS: usize = 96;

/// A sphere of light.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyImage {
    width: usize,
    height: usize,
    /// `[y][x]`
    pixels: Vec<[f32; 3]>,
    mean_luminance: f64,
}

impl SkyImage {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// [`SkyError`] that names the file and what was expected.
    pub fn read(path: &Path) -> Result<SkyImage, SkyError> {
        let unreadable = |why: String| SkyError::Read { path: path.to_owned(), why };
        let (file, _) = flb_files::open_regular(path).map_err(|error| unreadable(error.to_string()))?;
        let mut bytes = Vec::new();
        BufReader::new(file.take(FILE_BYTES + 1))
            .read_to_end(&mut bytes)
            .map_err(|error| unreadable(error.to_string()))?;
        if bytes.len() as u64 > FILE_BYTES {
            return Err(unreadable(format!("more than {FILE_BYTES} bytes")));
        }
        let damaged = |why: String| SkyError::Damaged { path: path.to_owned(), why };
        let size = |width: usize, height: usize| {
            let is_wide = width == 2 * height && width > 0;
            if is_wide && width <= MOST_COLUMNS {
                return Ok(());
            }
            let expected = match is_wide {
                true => format!("at most {MOST_COLUMNS} x {}", MOST_COLUMNS / 2),
                false => "a width of twice the height: the whole sphere".to_owned(),
            };
            Err(SkyError::Size { path: path.to_owned(), found: format!("{width} x {height}"), expected })
        };
        let ([width, height], pixels) = match &bytes[..] {
            [0x76, 0x2f, 0x31, 0x01, ..] => of_exr(&bytes, size, damaged)?,
            [b'#', b'?', ..] => of_hdr(&bytes, size, damaged)?,
            other => {
                let start: Vec<String> = other.iter().take(4).map(|byte| format!("{byte:02x}")).collect();
                let found = if start.is_empty() { "nothing".to_owned() } else { start.join(" ") };
                return Err(SkyError::Kind { path: path.to_owned(), found });
            }
        };
        SkyImage::new(path, [width, height], pixels)
    }

    /// Checks every pixel. `path` is named in errors.
    fn new(path: &Path, [width, height]: [usize; 2], pixels: Vec<[f32; 3]>) -> Result<SkyImage, SkyError> {
        for (at, pixel) in pixels.iter().enumerate() {
            for (band, &found) in ["R", "G", "B"].into_iter().zip(pixel) {
                let expected = match found {
                    _ if !found.is_finite() || found < 0.0 => "a finite value, 0 or more",
                    _ if found >= HALF_MOST => {
                        "less than 65504, the largest number of half precision: the sun is cut off; paint it out and \
                         give it by --sun"
                    }
                    _ => continue,
                };
                let (x, y, path) = (at % width, at / width, path.to_owned());
                return Err(SkyError::Pixel { path, x, y, band, found, expected });
            }
        }
        let mut image = SkyImage { width, height, pixels, mean_luminance: 0.0 };
        let of_row = |row: usize| {
            let sum: f64 = image.pixels[row * width..(row + 1) * width]
                .iter()
                .map(|&pixel| f64::from(luminance(pixel)))
                .sum();
            sum * image.solid_angle(row)
        };
        image.mean_luminance = (0..height).map(of_row).sum::<f64>() / (4.0 * PI);
        match image.mean_luminance > 0.0 {
            true => Ok(image),
            false => Err(SkyError::Black { path: path.to_owned() }),
        }
    }

    /// Mean over the sphere.
    pub fn mean_luminance(&self) -> f64 {
        self.mean_luminance
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Light of a pixel.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub fn pixel(&self, x: usize, y: usize) -> [f32; 3] {
        self.pixels[y * self.width + x]
    }

    /// Part of the sphere that a pixel of a row takes.
    pub fn solid_angle(&self, row: usize) -> f64 {
        let edge = |row: usize| libm::cos(row as f64 * PI / self.height as f64);
        2.0 * PI / self.width as f64 * (edge(row) - edge(row + 1))
    }

    /// The direction of a point of the image, in pixels from its upper left corner.
    pub fn towards(&self, x: f64, y: f64) -> [f32; 3] {
        let (sin, cos) = libm::sincos(2.0 * PI * x / self.width as f64);
        let (level, up) = libm::sincos(PI * y / self.height as f64);
        [-level * sin, up, level * cos].map(|c| c as f32)
    }

    /// Where a direction lies in the image, in pixels.
    fn place(&self, [x, y, z]: [f32; 3]) -> [f64; 2] {
        let turn = libm::atan2(f64::from(-x), f64::from(z)) / (2.0 * PI);
        let fall = libm::acos(f64::from(y).clamp(-1.0, 1.0)) / PI;
        [(turn - turn.floor()) * self.width as f64, fall * self.height as f64]
    }

    /// Light of the pixel that a direction of unit length meets.
    pub fn radiance(&self, towards: [f32; 3]) -> [f32; 3] {
        let [x, y] = self.place(towards);
        self.pixel((x as usize).min(self.width - 1), (y as usize).min(self.height - 1))
    }

    /// The same, linear between the middles of pixels.
    pub fn smooth(&self, towards: [f32; 3]) -> [f32; 3] {
        let [x, y] = self.place(towards);
        let (x, y) = (x - 0.5, (y - 0.5).clamp(0.0, self.height as f64 - 1.0));
        let (left, top) = (x.floor(), y.floor());
        let weights = [(x - left) as f32, (y - top) as f32];
        let column = |step: i64| (left as i64 + step).rem_euclid(self.width as i64) as usize;
        let row = |step: usize| (top as usize + step).min(self.height - 1);
        let across = |y: usize| {
            let (a, b) = (self.pixel(column(0), y), self.pixel(column(1), y));
            [0, 1, 2].map(|band| a[band] + (b[band] - a[band]) * weights[0])
        };
        let (above, below) = (across(row(0)), across(row(1)));
        [0, 1, 2].map(|band| above[band] + (below[band] - above[band]) * weights[1])
    }

    /// Rows and columns in which its light is summed: a whole number for each pixel.
    pub(super) fn steps(&self) -> [usize; 2] {
        let parts = FEWEST_ROWS.div_ceil(self.height);
        [self.height * parts, self.width * parts]
    }
}

type Pixels = ([usize; 2], Vec<[f32; 3]>);

fn of_exr(
    bytes: &[u8],
    check: impl Fn(usize, usize) -> Result<(), SkyError>,
    damaged: impl Fn(String) -> SkyError,
) -> Result<Pixels, SkyError> {
    let meta = exr::meta::MetaData::read_from_buffered(bytes, false);
    let meta = meta.map_err(|error| damaged(error.to_string()))?;
    for header in &meta.headers {
        check(header.layer_size.width(), header.layer_size.height())?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0_f32; 3]; size.area()]),
            |(width, pixels): &mut (usize, Vec<[f32; 3]>), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(|error| damaged(error.to_string()))?;
    let size = image.layer_data.size;
    Ok(([size.width(), size.height()], image.layer_data.channel_data.pixels.1))
}

fn of_hdr(
    bytes: &[u8],
    check: impl Fn(usize, usize) -> Result<(), SkyError>,
    damaged: impl Fn(String) -> SkyError,
) -> Result<Pixels, SkyError> {
    let decoder = HdrDecoder::new(bytes).map_err(|error| damaged(error.to_string()))?;
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    check(width, height)?;
    let mut raw = vec![0; width * height * 12];
    decoder.read_image(&mut raw).map_err(|error| damaged(error.to_string()))?;
    let value = |bytes: &[u8]| f32::from_ne_bytes(bytes.try_into().expect("four bytes"));
    let pixel = |bytes: &[u8]| [0, 1, 2].map(|band| value(&bytes[4 * band..4 * band + 4]));
    Ok(([width, height], raw.chunks_exact(12).map(pixel).collect()))
}
