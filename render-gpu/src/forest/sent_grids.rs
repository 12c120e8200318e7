//! The papers' grids over a picture and across a sun's rays, sent behind the words of a stand.

use flb_render::forest::{InstanceSearch, View};

use super::GpuForest;
use crate::ForestError;
use crate::grids::{SUN_PAD, picture_words, sun_words};
use crate::layout::NONE;

/// A grid over a picture, among the words of the stand.
pub(super) struct ViewGrid {
    view: View,
    first: u32,
    words: usize,
}

impl GpuForest {
    /// The first word of the grid over a picture, if its rays use one. Parts of one picture share it.
    pub(super) fn send_view_grid(&mut self, view: &View) -> Result<u32, ForestError> {
        view.check()?;
        if self.settings.search.primary == InstanceSearch::Tree {
            return Ok(NONE);
        }
        if let Some(grid) = self.view_grid.as_ref().filter(|grid| grid.view == *view) {
            return Ok(grid.first);
        }
        // What lies behind it is lost.
        self.view_grid = None;
        let grid = picture_words(&self.stand.around.view_grid(view)?, &self.stand.places());
        let first = self.send_grid(0, &grid)?;
        self.view_grid = Some(ViewGrid { view: *view, first, words: grid.len() });
        Ok(first)
    }

    /// The first word of the grid across a sun's rays, if they use one. It lies behind the picture's.
    pub(super) fn send_sun_grid(&mut self, towards_sun: [f64; 3]) -> Result<u32, ForestError> {
        if self.settings.search.shadow == InstanceSearch::Tree {
            return Ok(NONE);
        }
        let grid = self.stand.around.sun_grid(towards_sun, SUN_PAD);
        let grid = sun_words(&grid, &self.stand.places(), towards_sun, &self.stand);
        self.send_grid(self.view_grid.as_ref().map_or(0, |grid| grid.words), &grid)
    }

    fn send_grid(&mut self, behind: usize, words: &[u32]) -> Result<u32, ForestError> {
        let sent = self.statics.put(&self.gpu, behind, words)?;
        if sent.is_elsewhere {
            self.scene = self.statics.group(&self.gpu, &self.stages, &self.stand);
        }
        Ok(sent.first)
    }
}
