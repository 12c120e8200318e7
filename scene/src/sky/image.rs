//! Skies of images: OpenEXR or Radiance HDR, the whole sphere in equal steps of azimuth and elevation.
//!
//! The uppermost row is the zenith, the middle column north (-Z), and to the right of it lies east (+X), as one who
//! stands inside sees it.

mod openexr;
mod radiance;

use std::f64::consts::PI;
use std::io::Read;
use std::path::Path;

use super::primaries::{Primaries, ToSrgb};
use super::{SkyError, luminance};

/// Most columns: 8192 x 4096 pixels take 384 MiB.
const MAX_COLUMNS: usize = 8192;
/// Bytes of a file.
const FILE_BYTES: u64 = 640 << 20;
/// Largest number of half precision. What was brighter is stored as this, and its brightness is lost.
const HALF_MOST: f32 = 65_504.0;
/// Least mean luminance: of less, f32 has no factor that makes it a sky of fluence 1.
const MIN_LUMINANCE: f64 = 1e-30;
/// Fewest rows in which light is summed.
const MIN_ROWS: usize = 96;

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
        let faults = Faults { path };
        let (file, metadata) =
            flb_files::open_regular(path).map_err(|error| unreadable(error.to_string()))?;
        faults.limit("bytes of the file", metadata.len(), FILE_BYTES)?;
        let mut bytes = Vec::new();
        // A file that grows while it is read is longer than it said.
        let read = file.take(FILE_BYTES + 1).read_to_end(&mut bytes);
        read.map_err(|error| unreadable(error.to_string()))?;
        faults.limit("bytes of the file", bytes.len() as u64, FILE_BYTES)?;
        let raw = match &bytes[..] {
            [0x76, 0x2f, 0x31, 0x01, ..] => openexr::read(&bytes, &faults)?,
            [b'#', b'?', ..] => radiance::read(&bytes, &faults)?,
            other => {
                let start: Vec<String> = other.iter().take(4).map(|byte| format!("{byte:02x}")).collect();
                let found = if start.is_empty() { "nothing".to_owned() } else { start.join(" ") };
                return Err(SkyError::Kind { path: path.to_owned(), found });
            }
        };
        drop(bytes);
        SkyImage::new(path, raw)
    }

    /// Checks every pixel. `path` is named in errors.
    fn new(path: &Path, raw: Raw) -> Result<SkyImage, SkyError> {
        let Raw { size: [width, height], mut pixels, to_srgb } = raw;
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
        pixels.iter_mut().for_each(|pixel| *pixel = to_srgb.apply(*pixel));
        let mut image = SkyImage { width, height, pixels, mean_luminance: 0.0 };
        let of_row = |row: usize| {
            let sum: f64 = image.pixels[row * width..(row + 1) * width]
                .iter()
                .map(|&pixel| f64::from(luminance(pixel)))
                .sum();
            sum * image.solid_angle(row)
        };
        image.mean_luminance = (0..height).map(of_row).sum::<f64>() / (4.0 * PI);
        match image.mean_luminance {
            0.0 => Err(SkyError::Black { path: path.to_owned() }),
            found if found < MIN_LUMINANCE => {
                Err(SkyError::Dark { path: path.to_owned(), found, least: MIN_LUMINANCE })
            }
            _ => Ok(image),
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
        towards([x, y], self.size())
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

    /// Light in a direction of unit length, linear between the middles of pixels.
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
        let parts = MIN_ROWS.div_ceil(self.height);
        [self.height * parts, self.width * parts]
    }
}

/// The direction of a point of an image of the whole sphere, in pixels from its upper left corner: columns run from the
/// south over the west to the north, which is the middle, rows from the zenith to the nadir.
pub fn towards([x, y]: [f64; 2], [width, height]: [usize; 2]) -> [f32; 3] {
    let (sin, cos) = libm::sincos(2.0 * PI * x / width as f64);
    let (level, up) = libm::sincos(PI * y / height as f64);
    [-level * sin, up, level * cos].map(|c| c as f32)
}

/// What a file holds.
struct Raw {
    /// Columns and rows.
    size: [usize; 2],
    /// `[y][x]`
    pixels: Vec<[f32; 3]>,
    to_srgb: ToSrgb,
}

/// What is wrong with a file.
struct Faults<'p> {
    path: &'p Path,
}

impl Faults<'_> {
    fn damaged(&self, why: String) -> SkyError {
        SkyError::Damaged { path: self.path.to_owned(), why }
    }

    /// A line of a header that cannot be followed.
    fn header(&self, line: &str, expected: &'static str) -> SkyError {
        let end = line.floor_char_boundary(MAX_SHOWN);
        SkyError::Header { path: self.path.to_owned(), found: line[..end].to_owned(), expected }
    }

    fn limit(&self, what: &'static str, found: u64, limit: u64) -> Result<(), SkyError> {
        match found <= limit {
            true => Ok(()),
            false => Err(SkyError::Limit { path: self.path.to_owned(), what, found, limit }),
        }
    }

    /// A sky is the whole sphere.
    fn check_size(&self, width: usize, height: usize) -> Result<(), SkyError> {
        if height == 0 || width != 2 * height {
            let (found, expected) =
                (format!("{width} x {height}"), "a width of twice the height: the whole sphere");
            return Err(SkyError::Size { path: self.path.to_owned(), found, expected: expected.to_owned() });
        }
        self.check_most(width, height)
    }

    fn check_most(&self, width: usize, height: usize) -> Result<(), SkyError> {
        self.limit("columns", width as u64, MAX_COLUMNS as u64)?;
        self.limit("rows", height as u64, MAX_COLUMNS as u64 / 2)
    }

    fn to_srgb(&self, primaries: &Primaries, name: &'static str) -> Result<ToSrgb, SkyError> {
        ToSrgb::of(primaries).ok_or_else(|| SkyError::Primaries {
            path: self.path.to_owned(),
            name,
            found: format!("{primaries:?}"),
        })
    }
}

/// Bytes of a line of a header that a message shows.
const MAX_SHOWN: usize = 100;
