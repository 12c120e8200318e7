//! Colours of vertices as exporters write them: sRGB from 0 to 1, or from 0 to 255.

use crate::import::files::Files;
use crate::import::soup::{Soup, WITHIN};
use crate::texture::linear;

/// What may be a 1 that was rounded.
const ROUNDED_ONE: f32 = 1.01;
/// Whole numbers of up to 255 are larger than this somewhere.
const MIN_LARGEST: f32 = 3.0;

/// What the values of all vertices are like.
struct Values {
    largest: f32,
    beyond: u64,
    /// Those above 0.
    all: u64,
    are_whole: bool,
}

impl Values {
    fn of(soup: &Soup) -> Values {
        let none = Values { largest: 0.0, beyond: 0, all: 0, are_whole: true };
        soup.colors().flat_map(|[r, g, b, _]| [r, g, b]).fold(none, |so_far, value| Values {
            largest: so_far.largest.max(value),
            beyond: so_far.beyond + u64::from(value > ROUNDED_ONE),
            all: so_far.all + u64::from(value > 0.0),
            are_whole: so_far.are_whole && value == value.round(),
        })
    }

    /// Whole numbers well above 1, or numbers most of which are above 1. Of a colour from 0 to 1 a few highlights are
    /// above 1 at most.
    fn are_bytes(&self) -> bool {
        (self.are_whole && self.largest >= MIN_LARGEST) || 2 * self.beyond > self.all
    }
}

/// Makes linear light of the colours of all vertices.
pub(super) fn to_light(files: &mut Files, soup: &mut Soup) {
    let values = Values::of(soup);
    let scale = if values.are_bytes() { 255.0 } else { 1.0 };
    if scale == 1.0 && values.beyond > 0 {
        files.warn(format!(
            "colours of vertices (v x y z r g b) are up to {}, {WITHIN}; {} of {} values above 0 are taken as 1",
            values.largest, values.beyond, values.all
        ));
    }
    let in_light = |value: f32| linear((f64::from(value) / scale).clamp(0.0, 1.0)) as f32;
    soup.map_colors(|[r, g, b, alpha]| [in_light(r), in_light(g), in_light(b), alpha]);
    files.note(format!("colours of vertices (v x y z r g b) are read as sRGB from 0 to {scale}"));
}
