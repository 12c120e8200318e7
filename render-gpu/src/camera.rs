//! A view to the words of its uniform.

use flb_render::RenderError;
use flb_render::forest::View;

use crate::PictureRect;
use crate::layout::{Words, split};
use crate::stand::Stand;
use crate::surroundings::GroundAndWater;

/// First words of what a view has among the words of the stand, or `NONE`.
#[derive(Clone, Copy)]
pub(crate) struct ViewFirst {
    /// Start of the grid over the picture.
    pub cells: u32,
    /// Start of the waves.
    pub waves: u32,
}

/// The words of a `View` whose grid and waves begin at these words, for a part of the picture.
pub(crate) fn view_words(
    view: &View,
    part: PictureRect,
    stand: &Stand,
    soil: &GroundAndWater,
    first: ViewFirst,
) -> Result<Vec<u32>, RenderError> {
    view.check()?;
    part.check(view)?;
    if let Some(water) = &soil.water {
        water.check_eye(view.eye.position_m)?;
    }
    let [forward, right, up] = view.frame()?;
    let camera_m = view.eye.position_m;
    let eye: [[f32; 2]; 3] = std::array::from_fn(|axis| split(camera_m[axis] - stand.center_m[axis]));
    let around = stand
        .box_m
        .map(|corner| -> [f64; 3] { std::array::from_fn(|axis| corner[axis] - stand.center_m[axis]) });
    let [heights, columns, rows] = soil.heights();
    let (origin, ground_box, lift_m, spacing_m) = soil.seen_from(camera_m);
    let mut words = Words::default();
    words
        .rounded(forward)
        .whole(view.samples)
        .rounded(right)
        .whole(view.sky_rays)
        .rounded(up)
        .whole(view.width)
        .floats(eye.map(|[high, _]| high))
        .whole(view.height)
        .floats(eye.map(|[_, low]| low))
        .whole(soil.kind())
        .rounded(around[0])
        .whole(heights)
        .rounded(around[1])
        .whole(columns)
        .rounded(origin)
        .whole(rows)
        .rounded(ground_box[0])
        .rounded([lift_m])
        .rounded(ground_box[1])
        .whole(first.cells)
        .rounded(spacing_m)
        .rounded([soil.water_from(camera_m)])
        .whole(first.waves)
        .whole(part.left)
        .whole(part.top)
        .whole(part.width)
        .whole(part.height);
    Ok(words.0)
}
