//! Grey pictures as numbers: heights of the ground, and for `flb scatter` how densely plants stand.

use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use super::HeightMap;
use crate::import::{ImportError, ask, leave_out_metadata, read_bytes};

/// Pixels along an edge of a grey picture.
pub const MAX_GREY_EDGE: u32 = 16_384;
/// Pixels of a grey picture.
pub const MAX_GREY_PIXELS: u64 = 1 << 26;
/// Bytes of its file.
pub const MAX_GREY_BYTES: u64 = 256 << 20;

/// A grey picture, 0 (black) to 1 (white).
#[derive(Debug, Clone, PartialEq)]
pub struct Grey {
    /// Pixels per row.
    pub columns: u32,
    /// Rows.
    pub rows: u32,
    /// `[row][column]`, the upper row first.
    pub values: Vec<f32>,
}

/// A height field: triangles between the points of a grid, cut from the upper right to the lower left.
#[derive(Debug, Clone, PartialEq)]
pub struct Heights {
    /// Points along x, 2 or more.
    pub columns: u32,
    /// Points along z, 2 or more.
    pub rows: u32,
    /// World y of each point, `[row][column]`, x fastest.
    pub height_m: Vec<f32>,
    /// x and z of the first point.
    pub origin_m: [f64; 2],
    /// Distance from the first point to the last, along x and z, metres.
    pub size_m: [f64; 2],
}

impl Grey {
    /// Reads a grey PNG of 8 or 16 bits.
    ///
    /// # Errors
    /// [`ImportError::Io`]; [`ImportError::Limit`]; [`ImportError::Syntax`] for what is no PNG;
    /// [`ImportError::Malformed`] for one with colours or alpha.
    pub fn read(path: &Path) -> Result<Grey, ImportError> {
        let (file, bytes) = read_bytes(path, MAX_GREY_BYTES)?;
        let mut bytes = Cow::Owned(bytes);
        leave_out_metadata(&mut bytes);
        let broken =
            |error: image::ImageError| ImportError::Syntax { file: file.clone(), message: error.to_string() };
        let limit = |what: &str, found: u64, limit: u64| match found <= limit {
            true => Ok(()),
            false => Err(ImportError::Limit { file: file.clone(), what: what.to_owned(), found, limit }),
        };
        let reader = || ImageReader::with_format(Cursor::new(&bytes), ImageFormat::Png);
        let (columns, rows) = reader().into_dimensions().map_err(broken)?;
        limit("pixels along an edge", columns.max(rows).into(), MAX_GREY_EDGE.into())?;
        let pixels = u64::from(columns) * u64::from(rows);
        limit("pixels", pixels, MAX_GREY_PIXELS)?;
        // Of 16 bits, and as they are kept.
        ask(&file, "pixels", pixels * (2 + size_of::<f32>() as u64))?;
        let mut reader = reader();
        let mut bounds = Limits::default();
        bounds.max_alloc = Some(MAX_GREY_PIXELS * 8);
        reader.limits(bounds);
        let values = match reader.decode().map_err(broken)? {
            DynamicImage::ImageLuma8(grey) => grey.iter().map(|&value| f32::from(value) / 255.0).collect(),
            DynamicImage::ImageLuma16(grey) => {
                grey.iter().map(|&value| f32::from(value) / 65_535.0).collect()
            }
            other => {
                let (place, found) = ("pixels".to_owned(), format!("{:?}", other.color()));
                let expected = "grey of 8 or 16 bits, without alpha".to_owned();
                return Err(ImportError::Malformed { file, place, found, expected });
            }
        };
        Ok(Grey { columns, rows, values })
    }

    /// The value at shares of width and height, 0 to 1 from the upper left corner, between pixels by their four
    /// nearest.
    pub fn at(&self, x: f64, y: f64) -> f32 {
        let along = |share: f64, count: u32| {
            let place = (share * f64::from(count) - 0.5).clamp(0.0, f64::from(count - 1));
            let first = (place as usize).min(count.saturating_sub(2) as usize);
            (first, (first + 1).min(count as usize - 1), (place - first as f64) as f32)
        };
        let ((left, right, u), (top, bottom, v)) = (along(x, self.columns), along(y, self.rows));
        let value = |row: usize, column: usize| self.values[row * self.columns as usize + column];
        let mix = |row: usize| value(row, left) * (1.0 - u) + value(row, right) * u;
        mix(top) * (1.0 - v) + mix(bottom) * v
    }
}

impl HeightMap {
    /// Reads the picture.
    ///
    /// # Errors
    /// As [`Grey::read`]; [`ImportError::Malformed`] for a picture with a single row or column.
    pub fn read(&self) -> Result<Heights, ImportError> {
        let grey = Grey::read(&self.file)?;
        if grey.columns < 2 || grey.rows < 2 {
            return Err(ImportError::Malformed {
                file: self.file.display().to_string(),
                place: "pixels".to_owned(),
                found: format!("{} x {}", grey.columns, grey.rows),
                expected: "2 x 2 or more for a height map".to_owned(),
            });
        }
        let [low, high] = self.height_m;
        let height = |value: f32| (self.origin_m[1] + low + (high - low) * f64::from(value)) as f32;
        Ok(Heights {
            columns: grey.columns,
            rows: grey.rows,
            height_m: grey.values.into_iter().map(height).collect(),
            origin_m: [self.origin_m[0], self.origin_m[2]],
            size_m: self.size_m,
        })
    }
}

impl Heights {
    /// Metres between neighbouring points, along x and z.
    pub fn spacing_m(&self) -> [f64; 2] {
        [self.size_m[0] / f64::from(self.columns - 1), self.size_m[1] / f64::from(self.rows - 1)]
    }

    /// Height of a point.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn point_m(&self, column: u32, row: u32) -> f64 {
        f64::from(self.height_m[row as usize * self.columns as usize + column as usize])
    }

    /// Height above a place in the square from a point to the next ones, at shares of the square.
    ///
    /// # Panics
    /// If there is no such square.
    pub fn within_m(&self, [column, row]: [u32; 2], [u, v]: [f64; 2]) -> f64 {
        let (right, down) = (self.point_m(column + 1, row), self.point_m(column, row + 1));
        match u + v <= 1.0 {
            true => {
                let corner = self.point_m(column, row);
                corner + u * (right - corner) + v * (down - corner)
            }
            false => {
                let corner = self.point_m(column + 1, row + 1);
                corner + (1.0 - u) * (down - corner) + (1.0 - v) * (right - corner)
            }
        }
    }

    /// Height above a place of the world; beyond the edge that of the nearest place of the edge.
    pub fn at_m(&self, x_m: f64, z_m: f64) -> f64 {
        let spacing = self.spacing_m();
        let along = |value: f64, axis: usize, count: u32| {
            let place = ((value - self.origin_m[axis]) / spacing[axis]).clamp(0.0, f64::from(count - 1));
            let first = (place as u32).min(count - 2);
            (first, place - f64::from(first))
        };
        let ((column, u), (row, v)) = (along(x_m, 0, self.columns), along(z_m, 1, self.rows));
        self.within_m([column, row], [u, v])
    }
}
