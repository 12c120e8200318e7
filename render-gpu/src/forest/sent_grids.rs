//! The papers' grids over a picture and across a sun's rays, and the waves of a picture, sent behind the words of a
//! stand.

use flb_render::forest::{InstanceSearch, View};

use super::GpuForest;
use crate::ForestError;
use crate::camera::ViewFirst;
use crate::grids::{SUN_PAD, picture_words, sun_words};
use crate::layout::NONE;

/// Words of a view that were sent.
pub(super) struct SentView {
    view: View,
    first: ViewFirst,
    words: usize,
}

impl GpuForest {
    /// Sends the grid over a picture, if its rays use one, and its waves, if it has some. Parts of one picture share
    /// them.
    pub(super) fn send_view(&mut self, view: &View) -> Result<ViewFirst, ForestError> {
        view.check()?;
        if let Some(sent) = self.sent_view.as_ref().filter(|sent| sent.view == *view) {
            return Ok(sent.first);
        }
        // What lies behind it is lost.
        self.sent_view = None;
        let mut words = match self.settings.search.primary {
            InstanceSearch::Tree => Vec::new(),
            InstanceSearch::Grid => picture_words(&self.stand.around.view_grid(view)?, &self.stand.places()),
        };
        let grid = words.len();
        words.extend(self.soil.wave_words(view));
        let mut first = ViewFirst { cells: NONE, waves: NONE };
        if !words.is_empty() {
            let at = self.send_words(0, &words)?;
            first.cells = if grid > 0 { at } else { NONE };
            first.waves = if words.len() > grid { at + grid as u32 } else { NONE };
        }
        self.sent_view = Some(SentView { view: *view, first, words: words.len() });
        Ok(first)
    }

    /// The first word of the grid across the sun's rays, if they use one. It lies behind what the picture has.
    pub(super) fn send_sun_grid(&mut self, towards_sun: [f64; 3]) -> Result<u32, ForestError> {
        if self.settings.search.shadow == InstanceSearch::Tree {
            return Ok(NONE);
        }
        let grid = self.stand.around.sun_grid(towards_sun, SUN_PAD);
        let grid = sun_words(&grid, &self.stand.places(), towards_sun, &self.stand);
        self.send_words(self.sent_view.as_ref().map_or(0, |sent| sent.words), &grid)
    }

    fn send_words(&mut self, behind: usize, words: &[u32]) -> Result<u32, ForestError> {
        let sent = self.statics.put(&self.gpu, behind, words)?;
        if sent.is_elsewhere {
            self.scene = self.statics.group(&self.gpu, &self.stages, &self.stand);
        }
        Ok(sent.first)
    }
}
