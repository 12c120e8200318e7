//! Alpha as a share of a surface: cutoffs that differ from texel to texel, so that the share of texels that are present
//! is the alpha, on any part of an image.

use super::Cut;
use crate::mesh::{Texture, Wrap};

/// Texels along an edge, at least: a share of 40 % needs more than one texel to be 40 % of.
const MIN_EDGE: u32 = 128;

/// Texture coordinates as they are.
const AS_THEY_ARE: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A cut by the alpha, from 0 to 1, of the texels of an image of `size`. Small images get several cutoffs a texel.
pub(super) fn of_texels(size: [u32; 2], texture: Texture, alpha: impl Fn(u32, u32) -> f64) -> Cut {
    let [across, down] = size.map(|edge| MIN_EDGE.div_ceil(edge));
    let present = |x: u32, y: u32| alpha(x / across, y / down) > cutoff(x, y);
    Cut::from_fn(size[0] * across, size[1] * down, texture.wrap, texture.transform, present)
}

/// A cut of the same alpha everywhere, placed as the texture of the colour is, if there is one.
pub(super) fn even(placed_as: Option<Texture>, alpha: f64) -> Cut {
    let (wrap, transform) =
        placed_as.map_or(([Wrap::Repeat; 2], AS_THEY_ARE), |texture| (texture.wrap, texture.transform));
    Cut::from_fn(MIN_EDGE, MIN_EDGE, wrap, transform, |x, y| alpha > cutoff(x, y))
}

/// From 0 to below 1, even over any rectangle of texels: the additive sequence of the plastic number (R2, M. Roberts
/// 2018) as an ordered dither.
fn cutoff(x: u32, y: u32) -> f64 {
    const STEP: [u32; 2] = [3_242_174_889, 2_447_445_414]; // 1/p and 1/p^2 as fractions of 2^32
    let fraction = x.wrapping_mul(STEP[0]).wrapping_add(y.wrapping_mul(STEP[1]));
    f64::from(fraction) / 4_294_967_296.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_of_cutoffs_below_an_alpha_is_that_alpha_on_any_square() {
        for corner in [[0, 0], [5, 900], [1000, 17]] {
            for alpha in [0.05, 0.4, 0.6, 0.95] {
                let below = |edge: u32| {
                    let texels = (0..edge * edge)
                        .filter(|i| alpha > cutoff(corner[0] + i % edge, corner[1] + i / edge));
                    texels.count() as f64 / f64::from(edge * edge)
                };
                assert!((below(16) - alpha).abs() < 0.03, "{alpha} at {corner:?}: {}", below(16));
                assert!((below(64) - alpha).abs() < 0.005, "{alpha} at {corner:?}: {}", below(64));
            }
        }
        assert!((0..1000).all(|i| 1.0 > cutoff(i, 7 * i) && cutoff(i, 7 * i) >= 0.0));
    }
}
