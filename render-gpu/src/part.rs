//! A picture in rectangles, each of which a GPU can draw by itself: its pixels are to the bit those that they are in
//! the whole.

use flb_render::RenderError;
use flb_render::forest::View;

/// A rectangle of a picture, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PictureRect {
    /// Columns before it.
    pub left: u32,
    /// Rows above it.
    pub top: u32,
    /// Columns of it, from 1 on.
    pub width: u32,
    /// Rows of it, from 1 on.
    pub height: u32,
}

/// Tiles are of whole cells of this edge in pixels, which workgroups and the grid over the picture divide.
const CELL_PX: u32 = 16;

impl PictureRect {
    /// Returns the rectangle of a whole picture.
    pub fn whole(view: &View) -> PictureRect {
        PictureRect { left: 0, top: 0, width: view.width, height: view.height }
    }

    /// Refuses a part that has no pixels, or some outside the picture.
    ///
    /// # Errors
    /// [`RenderError::Setting`].
    pub fn check(&self, view: &View) -> Result<(), RenderError> {
        let is_within = |first: u32, count: u32, all: u32| count > 0 && first < all && count <= all - first;
        if is_within(self.left, self.width, view.width) && is_within(self.top, self.height, view.height) {
            return Ok(());
        }
        Err(RenderError::Setting {
            name: "part",
            found: format!("{} x {} pixels from {}, {} on", self.width, self.height, self.left, self.top),
            expected: format!("some of {} x {}", view.width, view.height),
        })
    }
}

/// A picture in squares, row by row: about so many, or fewer where they would be smaller than a cell.
pub(crate) fn tiles(view: &View, about: u32) -> Vec<PictureRect> {
    if about <= 1 {
        return vec![PictureRect::whole(view)];
    }
    let pixels = u64::from(view.width) * u64::from(view.height);
    let edge = ((pixels / u64::from(about)).isqrt() as u32 / CELL_PX).max(1) * CELL_PX;
    let steps = |all: u32| (0..all).step_by(edge as usize).map(move |first| (first, edge.min(all - first)));
    steps(view.height)
        .flat_map(|(top, height)| {
            steps(view.width).map(move |(left, width)| PictureRect { left, top, width, height })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use flb_testkit::scenes::view;

    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (size, about) in
            [([203, 117], 1), ([203, 117], 8), ([16, 16], 8), ([7, 500], 5), ([1920, 1080], 16)]
        {
            let view = view(size, 1, 10.0);
            let tiles = tiles(&view, about);
            let mut seen = vec![0; (size[0] * size[1]) as usize];
            for tile in &tiles {
                tile.check(&view).unwrap();
                for y in tile.top..tile.top + tile.height {
                    (tile.left..tile.left + tile.width).for_each(|x| seen[(y * size[0] + x) as usize] += 1);
                }
            }
            assert!(seen.iter().all(|times| *times == 1), "{size:?} in {about}");
            assert!(tiles.len() <= 3 * about as usize || size[0] < 16, "{size:?}: {}", tiles.len());
        }
        assert!(tiles(&view([1920, 1080], 1, 10.0), 16).len() >= 16);
    }

    #[test]
    fn parts_that_reach_out_of_the_picture_are_refused() {
        let view = view([64, 48], 1, 10.0);
        let whole = PictureRect::whole(&view);
        for part in [
            PictureRect { width: 65, ..whole },
            PictureRect { height: 0, ..whole },
            PictureRect { left: 64, width: 1, ..whole },
            PictureRect { top: 40, height: 9, ..whole },
            PictureRect { left: 1, width: u32::MAX, ..whole },
        ] {
            let error = part.check(&view).unwrap_err().to_string();
            assert!(error.contains("part") && error.contains("64 x 48"), "{error}");
        }
    }
}
