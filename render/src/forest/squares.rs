//! A picture cut into squares, each the work of one thread at a time.

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_format::progress::{Cancelled, Progress};
use rayon::prelude::*;

use super::View;

/// Pixels along the edge of a square.
const EDGE_PX: u32 = 16;

/// A square of a picture, cut off at its right and lower edges.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Area {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
}

impl Area {
    /// Its pixels, column and row in the picture, row by row.
    pub(crate) fn pixels(self) -> impl Iterator<Item = (u32, u32)> {
        let Area { left, top, width, height } = self;
        (top..top + height).flat_map(move |y| (left..left + width).map(move |x| (x, y)))
    }
}

/// The squares of a picture, row by row.
fn areas(view: &View) -> Vec<Area> {
    let step = EDGE_PX as usize;
    let corners = (0..view.height)
        .step_by(step)
        .flat_map(|top| (0..view.width).step_by(step).map(move |left| (left, top)));
    let area = |(left, top)| Area {
        left,
        top,
        width: EDGE_PX.min(view.width - left),
        height: EDGE_PX.min(view.height - top),
    };
    corners.map(area).collect()
}

/// The number of the square that a pixel of the picture lies in.
pub(super) fn number_of(view: &View, x: u32, y: u32) -> usize {
    ((y / EDGE_PX) * view.width.div_ceil(EDGE_PX) + x / EDGE_PX) as usize
}

/// What `work` makes of each square, by its number, in order. `progress` hears the share done, 0..=1, from any thread.
pub(super) fn in_parallel<T: Send>(
    view: &View,
    progress: &Progress<'_>,
    work: impl Fn(usize, Area) -> T + Sync,
) -> Result<Vec<T>, Cancelled> {
    let areas = areas(view);
    let done = AtomicUsize::new(0);
    progress(0.0)?;
    let one = |(number, area): (usize, &Area)| {
        let made = work(number, *area);
        progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / areas.len() as f64)?;
        Ok(made)
    };
    areas.par_iter().enumerate().map(one).collect()
}

/// The picture, `[y][x]`, of what `work` makes of the pixels of each square, row by row.
pub(crate) fn pixels<T: Copy + Default + Send>(
    view: &View,
    progress: &Progress<'_>,
    work: impl Fn(usize, Area) -> Vec<T> + Sync,
) -> Result<Vec<T>, Cancelled> {
    let squares = in_parallel(view, progress, |number, area| (area, work(number, area)))?;
    let width = view.width as usize;
    let mut pixels = vec![T::default(); width * view.height as usize];
    for (area, made) in squares {
        for (row, made) in made.chunks_exact(area.width as usize).enumerate() {
            let first = (area.top as usize + row) * width + area.left as usize;
            pixels[first..first + made.len()].copy_from_slice(made);
        }
    }
    Ok(pixels)
}
