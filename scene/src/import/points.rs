//! Points as precise as f64 in little more memory than f32 takes, and the origin that is taken off them.
//!
//! A plant in national coordinates stands millions of metres from its origin, where an f32 has steps of half a metre.
//! So points stay precise until a whole number of metres is taken off: `points - offset` is small, and an f32 holds it.

use crate::import::error::ImportError;
use crate::import::files::Files;

/// Coordinates beyond this keep what an f32 rounds off, metres or units of a file. Nearer ones are off by 4e-6 at most.
const NEAR: f64 = 100.0;

/// A box this many times its longest edge away from the origin is moved there: nearer than that the steps of an f32 are
/// below 8e-6 of the edge.
const FAR_EDGES: f64 = 64.0;

/// A box at most this many times its longest edge away from the origin never becomes far, whatever point is added: that
/// moves the box by no more than its own new edge.
const SETTLED_EDGES: f64 = 0.5 * FAR_EDGES;

/// Points of f64, as an f32 and the f32 of its rounding.
#[derive(Default)]
pub(super) struct Points {
    high: Vec<[f32; 3]>,
    /// Empty until a coordinate beyond [`NEAR`] comes; then as long as `high`.
    low: Vec<[f32; 3]>,
    /// Whether what f32s round off is kept no longer.
    settled: bool,
}

impl Points {
    /// How many.
    pub(super) fn len(&self) -> usize {
        self.high.len()
    }

    /// Adds a point of finite f32s; its memory is held.
    pub(super) fn push(&mut self, files: &mut Files, what: &str, point: [f64; 3]) -> Result<(), ImportError> {
        // Adding 0 makes -0 to 0: equal points have equal bits.
        let high = point.map(|x| x as f32 + 0.0);
        if !self.settled && (!self.low.is_empty() || point.iter().any(|x| x.abs() > NEAR)) {
            while self.low.len() < self.high.len() {
                files.push(what, &mut self.low, [0.0; 3])?;
            }
            let low = std::array::from_fn(|axis| (point[axis] - f64::from(high[axis])) as f32);
            files.push(what, &mut self.low, low)?;
        }
        files.push(what, &mut self.high, high)
    }

    /// Forgets what f32s round off, of all points and of those to come.
    pub(super) fn settle(&mut self, files: &mut Files) {
        files.release((self.low.capacity() * size_of::<[f32; 3]>()) as u64);
        self.low = Vec::new();
        self.settled = true;
    }

    /// Whether what f32s round off is kept.
    pub(super) fn is_precise(&self) -> bool {
        !self.low.is_empty()
    }

    /// The point `at`, to 48 bits.
    pub(super) fn get(&self, at: usize) -> [f64; 3] {
        let low = self.low.get(at).copied().unwrap_or_default();
        std::array::from_fn(|axis| f64::from(self.high[at][axis]) + f64::from(low[axis]))
    }

    /// Bytes that are held for them.
    pub(super) fn held_bytes(&self) -> u64 {
        ((self.high.capacity() + self.low.capacity()) * size_of::<[f32; 3]>()) as u64
    }

    /// The points less an offset, as f32.
    pub(super) fn into_f32(self, offset: [f64; 3]) -> Vec<[f32; 3]> {
        let Points { mut high, low, .. } = self;
        if offset != [0.0; 3] {
            for (at, point) in high.iter_mut().enumerate() {
                let low = low.get(at).copied().unwrap_or_default();
                *point = std::array::from_fn(|axis| {
                    (f64::from(point[axis]) - offset[axis] + f64::from(low[axis])) as f32 + 0.0
                });
            }
        }
        high
    }
}

/// A box of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reach {
    low: [f64; 3],
    high: [f64; 3],
}

impl Default for Reach {
    fn default() -> Reach {
        Reach::NONE
    }
}

impl Reach {
    /// Around no point.
    pub(super) const NONE: Reach = Reach { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// Makes room for a point.
    pub(super) fn add(&mut self, point: [f64; 3]) {
        for (axis, x) in point.into_iter().enumerate() {
            self.low[axis] = self.low[axis].min(x);
            self.high[axis] = self.high[axis].max(x);
        }
    }

    /// Whether f32s say too little where it lies.
    pub(super) fn is_far(&self) -> bool {
        self.farthest() > FAR_EDGES * self.longest().max(0.0)
    }

    /// Whether it is near, and stays so whatever is added.
    pub(super) fn is_settled(&self) -> bool {
        self.farthest() <= SETTLED_EDGES * self.longest()
    }

    /// Whole metres that move a far box to the origin: its middle along x and z, its bottom along y. Zeros for a box
    /// that is not far, and for one without points.
    pub(super) fn offset(&self) -> [f64; 3] {
        if !self.is_far() {
            return [0.0; 3];
        }
        let middle = |axis: usize| 0.5 * (self.low[axis] + self.high[axis]);
        [middle(0), self.low[1], middle(2)].map(|x| libm::round(x) + 0.0)
    }

    /// The step from one f32 to the next at the coordinate that is farthest from 0.
    pub(super) fn step(&self) -> f64 {
        let farthest = self.farthest() as f32;
        f64::from(farthest.next_up()) - f64::from(farthest)
    }

    /// The coordinate that is farthest from 0, without its sign; 0 without points.
    pub(super) fn farthest(&self) -> f64 {
        self.low.iter().chain(&self.high).filter(|x| x.is_finite()).fold(0.0, |most, x| most.max(x.abs()))
    }

    fn longest(&self) -> f64 {
        (0..3).map(|axis| self.high[axis] - self.low[axis]).fold(0.0, f64::max)
    }
}

/// Steps of coordinates that a mean edge needs at least: with fewer, the shape is that of the rounding.
const STEPS_PER_EDGE: f64 = 16.0;

/// The same where numbers were written with few digits: rounding that may be meant, as to whole centimetres, passes.
const DIGIT_STEPS_PER_EDGE: f64 = 2.0;

/// The largest share of triangles that may be smaller than that: leaves may be small where a trunk has long edges.
const MAX_SMALL: f64 = 0.25;

/// In what far coordinates were stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stored {
    /// Numbers of 32 bits.
    F32,
    /// Numbers written with digits down to this step.
    Digits(f64),
}

/// An error where the steps of the numbers in which a far shape was stored are near its edges. `triangles` are its
/// corners in the coordinates of `reach`.
pub(super) fn check_steps(
    files: &Files,
    place: &str,
    reach: &Reach,
    stored: Stored,
    triangles: impl Iterator<Item = [[f64; 3]; 3]>,
) -> Result<(), ImportError> {
    if !reach.is_far() {
        return Ok(());
    }
    let (step, least, how) = match stored {
        Stored::F32 => (reach.step(), STEPS_PER_EDGE, "in numbers of 32 bits, whose steps are"),
        Stored::Digits(step) => (step, DIGIT_STEPS_PER_EDGE, "with so few digits that their steps are"),
    };
    let (mut sum, mut count, mut small) = (0.0, 0u64, 0u64);
    for [a, b, c] in triangles {
        let mut longest: f64 = 0.0;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let squared = (0..3).map(|axis| (to[axis] - from[axis]) * (to[axis] - from[axis])).sum::<f64>();
            sum += squared;
            longest = longest.max(squared);
        }
        count += 1;
        small += u64::from(longest.sqrt() < least * step);
    }
    if count == 0 {
        return Ok(());
    }
    let edge = (sum / (3 * count) as f64).sqrt();
    let share = small as f64 / count as f64;
    let edges = match stored {
        _ if edge < least * step => format!("edges of {} in the mean", crate::extents::number(edge)),
        Stored::Digits(_) if share > MAX_SMALL => {
            format!("{:.0} % of the triangles within {least} steps", 100.0 * share)
        }
        _ => return Ok(()),
    };
    Err(files.malformed(
        place,
        format!("coordinates of {:.0} {how} {step} there, and {edges}", reach.farthest()),
        format!(
            "edges of {least} steps at least: the shape is lost in the file; export the plant near its origin"
        ),
    ))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn far_points_keep_what_an_f32_rounds_off_and_near_ones_their_bits() {
        let mut files = Files::beside(Path::new("a.obj"));
        let mut points = Points::default();
        let far = [[0.1, 0.2, 0.3], [448262.05, 5411932.318, -318.125], [448262.051, 5411932.319, -318.0]];
        for point in far {
            points.push(&mut files, "points", point).unwrap();
        }
        for (at, point) in far.into_iter().enumerate().skip(1) {
            let off = points.get(at).into_iter().zip(point).map(|(found, expected)| (found - expected).abs());
            assert!(off.fold(0.0, f64::max) < 1e-7, "{:?}", points.get(at));
        }
        assert_eq!(points.high[0], [0.1, 0.2, 0.3]);
        assert!(points.is_precise());
        let moved = points.into_f32([448262.0, 5411932.0, -318.0]);
        assert!((moved[2][0] - moved[1][0] - 0.001).abs() < 1e-7, "{moved:?}");
    }

    #[test]
    fn settled_points_are_f32_and_their_memory_is_released() {
        let mut files = Files::beside(Path::new("a.obj"));
        let mut points = Points::default();
        points.push(&mut files, "points", [120.1, 0.3, 0.7]).unwrap();
        assert!(points.get(0)[0] != f64::from(120.1_f32));
        points.settle(&mut files);
        points.push(&mut files, "points", [-120.1, 0.3, 0.7]).unwrap();
        assert!(!points.is_precise());
        assert_eq!([points.get(0)[0], points.get(1)[0]], [120.1_f32, -120.1].map(f64::from));
        // Released twice, memory would panic here.
        files.release(points.held_bytes());
    }

    #[test]
    fn a_box_is_far_where_its_size_is_lost_and_its_offset_is_whole() {
        let mut reach = Reach::NONE;
        assert_eq!((reach.offset(), reach.farthest()), ([0.0; 3], 0.0));
        reach.add([128.0, 0.0, 0.0]);
        reach.add([130.0, 2.0, 0.5]);
        assert_eq!(reach.offset(), [129.0, 0.0, 0.0]);
        reach.add([130.0, 2.2, 0.5]);
        assert_eq!(reach.offset(), [0.0; 3]);
        assert_eq!(reach.step(), 1.0 / 65536.0);
        // A box that is settled stays near, however far the next point is.
        assert!(!reach.is_settled());
        reach.add([125.0, 0.0, 0.5]);
        assert!(reach.is_settled());
        for far in [[1e4, 0.0, 0.0], [-1e9, 1e9, 1e9], [3e5, -6e6, 300.0]] {
            let mut reach = reach;
            reach.add(far);
            assert!(!reach.is_far(), "{far:?}");
        }
    }
}
