//! Where the wood of a plant stands: from its triangles to the side of its box at which it is thickest.
//!
//! Cut a thin layer off each side of the wood. At the bottom of an upright plant the layer holds the foot of the trunk,
//! or of the stems: much wood in one place. At the five other sides it holds tips of branches, ten times thinner. Where
//! another side is clearly thicker, the plant lies, hangs or stands on its head. The lowest point says nothing of this:
//! the branches of a tree that lies reach the bottom, and so do the twigs of one that weeps.
//!
//! The layer at the flank of a trunk holds much wood, too, where no branch reaches further. Its shape tells it from a
//! foot. The bottom of a palm that lies is such a flank; its leaves at one end of the trunk say that it lies.

use std::f64::consts::TAU;

use crate::import::area;

/// Thickness of the layer, as a share of the plant's longest edge.
const LAYER: f64 = 0.03;
/// A foot is no thinner, as a share of the longest edge. Trunks have 1/14 to 1/70, tips of branches below 1/250.
const THINNEST: f64 = 1.0 / 150.0;
/// It lies no further apart: the feet of several stems have 0.17.
const WIDEST: f64 = 0.2;
/// A tube's radius is its spread; several close together have more. What has far more lies flat in the layer: soil, a
/// board.
const MAX_OF_SPREAD: f64 = 3.0;
/// A foot belongs to a trunk: along the trunk the wood is longer than wide, which the flank of a trunk is not. Of the
/// length of all wood towards the side, the spread is no more than this; several stems have 0.19.
const WIDEST_OF_LENGTH: f64 = 0.3;
/// A side is clearly thicker than the bottom from here on.
const CLEARLY: f64 = 3.0;
/// The middle of the leaves is so far from the foot of a trunk without boughs, as a share of its length.
const CROWN_AT: f64 = 0.75;
/// Two ends of a trunk that does not taper: the leaves tell which is its top.
const ALIKE: f64 = 0.8;

/// Corners, model space, metres.
pub(super) type Triangle = [[f64; 3]; 3];

/// A side of a plant's box, in model space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    /// Axis of the side: 0 is x, 1 is y, 2 is z.
    pub axis: usize,
    /// Whether the side is the one of the larger coordinates.
    pub is_upper: bool,
}

impl Side {
    /// Side on which plants stand.
    pub const BOTTOM: Side = Side { axis: 1, is_upper: false };

    /// Both of x, of y and of z, the lower one first.
    fn all() -> [Side; 6] {
        std::array::from_fn(|index| Side { axis: index / 2, is_upper: index % 2 == 1 })
    }

    /// How far a point lies towards it.
    fn reach(self, point: [f64; 3]) -> f64 {
        if self.is_upper { point[self.axis] } else { -point[self.axis] }
    }

    /// Name of the side, such as "-y".
    pub fn name(self) -> &'static str {
        [["-x", "+x"], ["-y", "+y"], ["-z", "+z"]][self.axis][usize::from(self.is_upper)]
    }
}

/// The wood in the layer at a side, in shares of the plant's longest edge.
#[derive(Debug, Clone, Copy)]
struct Layer {
    side: Side,
    /// Of the tube that has as much surface.
    radius: f64,
    /// Root mean square distance from the middle of the wood in the layer, along the side.
    spread: f64,
    /// Of all wood, towards the side.
    length: f64,
    /// Where the layer ends, towards the side, metres.
    end_m: f64,
}

impl Layer {
    fn of(wood: &[Triangle], side: Side, longest_m: f64) -> Layer {
        let reaches = || wood.as_flattened().iter().map(|point| side.reach(*point));
        let low_m = reaches().fold(f64::INFINITY, f64::min);
        let end_m = reaches().fold(f64::NEG_INFINITY, f64::max);
        let mut sums = Sums::default();
        wood.iter().for_each(|triangle| cut_off(*triangle, side, end_m - LAYER * longest_m, &mut sums));
        let radius = sums.area_m2 / (TAU * LAYER * longest_m * longest_m);
        let length = (end_m - low_m) / longest_m;
        Layer { side, radius, spread: sums.spread_m() / longest_m, length, end_m }
    }

    /// Whether it may be where a plant stands. No comparison holds for what is no number.
    fn is_foot(&self) -> bool {
        let is_tube = self.radius <= MAX_OF_SPREAD * self.spread;
        let is_end = self.spread <= WIDEST.min(WIDEST_OF_LENGTH * self.length);
        self.radius >= THINNEST && is_tube && is_end
    }

    /// Of a point from this end of the wood, as a share of the wood's length.
    fn share(&self, point_m: [f64; 3], longest_m: f64) -> f64 {
        (self.end_m - self.side.reach(point_m)) / (self.length * longest_m)
    }
}

/// The side at which the plant's foot is, where that is clearly not the bottom. `leaves_m` is the middle of the leaves.
pub(super) fn foot_elsewhere(wood: &[Triangle], leaves_m: Option<[f64; 3]>, longest_m: f64) -> Option<Side> {
    let layers = Side::all().map(|side| Layer::of(wood, side, longest_m));
    let bottom = layers.iter().find(|layer| layer.side == Side::BOTTOM)?;
    let crown = |layer: &Layer| leaves_m.map_or(0.5, |leaves_m| layer.share(leaves_m, longest_m));
    let lies = |layer: &Layer| {
        layer.radius >= CLEARLY * bottom.radius || (!bottom.is_foot() && crown(layer) >= CROWN_AT)
    };
    let feet = layers.iter().filter(|layer| layer.side != Side::BOTTOM && layer.is_foot() && lies(layer));
    let thickest = feet.clone().max_by(|a, b| a.radius.total_cmp(&b.radius))?;
    let alike = feet.filter(|layer| layer.radius >= ALIKE * thickest.radius);
    alike.max_by(|a, b| crown(a).total_cmp(&crown(b))).map(|foot| foot.side)
}

/// The middle of triangles, by area; `None` without any area.
pub(super) fn middle(triangles: &[Triangle]) -> Option<[f64; 3]> {
    let mut sums = [0.0; 3];
    let mut all_m2 = 0.0;
    for triangle in triangles {
        let area_m2 = area(*triangle);
        all_m2 += area_m2;
        for (axis, sum) in sums.iter_mut().enumerate() {
            *sum += area_m2 * triangle.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0;
        }
    }
    (all_m2 > 0.0).then(|| sums.map(|sum| sum / all_m2))
}

/// Moments of area.
#[derive(Default)]
struct Sums {
    area_m2: f64,
    /// Along the two axes of the side.
    first: [f64; 2],
    second: f64,
}

impl Sums {
    fn add(&mut self, triangle: Triangle, side: Side) {
        let area_m2 = area(triangle);
        self.area_m2 += area_m2;
        for (first, axis) in self.first.iter_mut().zip([(side.axis + 1) % 3, (side.axis + 2) % 3]) {
            let [a, b, c] = triangle.map(|corner| corner[axis]);
            let sum = a + b + c;
            *first += area_m2 * sum / 3.0;
            // The mean of a square over a triangle, of the values at its corners.
            self.second += area_m2 * (a * a + b * b + c * c + sum * sum) / 12.0;
        }
    }

    fn spread_m(&self) -> f64 {
        if self.area_m2 <= 0.0 {
            return 0.0;
        }
        let [a, b] = self.first.map(|first| first / self.area_m2);
        (self.second / self.area_m2 - a * a - b * b).max(0.0).sqrt()
    }
}

/// Adds what of a triangle lies beyond `from_m` towards a side: a trunk of few triangles has long ones.
fn cut_off(triangle: Triangle, side: Side, from_m: f64, sums: &mut Sums) {
    let beyond = triangle.map(|corner| side.reach(corner) - from_m);
    if beyond.iter().all(|beyond| *beyond < 0.0) {
        return;
    }
    let mut corners = [[0.0; 3]; 4];
    let mut count = 0;
    let mut push = |point| {
        corners[count] = point;
        count += 1;
    };
    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
        let is_in = [beyond[a] >= 0.0, beyond[b] >= 0.0];
        if is_in[0] {
            push(triangle[a]);
        }
        if is_in[0] != is_in[1] {
            let t = beyond[a] / (beyond[a] - beyond[b]);
            push(std::array::from_fn(|axis| triangle[a][axis] + t * (triangle[b][axis] - triangle[a][axis])));
        }
    }
    for last in 2..count {
        sums.add([corners[0], corners[last - 1], corners[last]], side);
    }
}
