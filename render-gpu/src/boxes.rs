//! Boxes of a hierarchy as words.

use flb_render::forest::export::FlatBox;

use crate::layout::Words;

/// A `Box` whose boxes and items begin at these numbers.
pub(crate) fn box_words(words: &mut Words, found: &FlatBox, [first_box, first_item]: [u32; 2]) {
    let first = found.first + if found.count == 0 { first_box } else { first_item };
    words.floats(found.min).whole(first).floats(found.max).whole(found.count);
}
