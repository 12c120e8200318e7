//! To how many digits coordinates of a file are written: exporters that keep seven lose a plant in national coordinates
//! (`v 448262.3 5411932 318.12`).

/// Digits behind the point that are told apart: finer steps than thousandths lose no plant.
const MAX_DIGITS: usize = 3;
const SCALES: [f64; MAX_DIGITS + 1] = [1.0, 10.0, 100.0, 1000.0];

/// An axis is coarse where its coordinates are this many steps from 0: digits were spent on where it stands.
const COARSE_STEPS: f64 = 1e5;

/// Digits of each axis so far.
#[derive(Debug)]
pub(super) struct Digits {
    behind_point: [usize; 3],
    low: [f64; 3],
    high: [f64; 3],
}

impl Digits {
    /// Of no point.
    pub(super) const NONE: Digits =
        Digits { behind_point: [0; 3], low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// Adds a point in units of the file.
    pub(super) fn add(&mut self, point: [f64; 3]) {
        for (axis, x) in point.into_iter().enumerate() {
            self.low[axis] = self.low[axis].min(x);
            self.high[axis] = self.high[axis].max(x);
            let digits = &mut self.behind_point[axis];
            while *digits < MAX_DIGITS && !is_whole(x * SCALES[*digits]) {
                *digits += 1;
            }
        }
    }

    /// The largest step of an axis along which there is something, and whose digits were spent on where it stands.
    pub(super) fn step(&self) -> Option<f64> {
        let of = |axis: usize| {
            let digits = self.behind_point[axis];
            let (step, far) = (1.0 / SCALES[digits], self.low[axis].abs().max(self.high[axis].abs()));
            let is_coarse = digits < MAX_DIGITS && far >= COARSE_STEPS * step;
            (is_coarse && self.high[axis] > self.low[axis]).then_some(step)
        };
        (0..3).filter_map(of).reduce(f64::max)
    }
}

/// But for what an f64 rounds off.
fn is_whole(x: f64) -> bool {
    (x - x.round()).abs() <= 1e-12 * x.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_of_the_axis_with_the_fewest_digits_that_are_spent() {
        let of = |points: &[[f64; 3]]| {
            let mut digits = Digits::NONE;
            points.iter().for_each(|&point| digits.add(point));
            digits.step()
        };
        let seven = [[448262.3, 5411932.0, 318.1234], [448262.4, 5411933.0, 318.5]];
        assert_eq!(of(&seven), Some(1.0));
        assert_eq!(of(&seven.map(|[x, y, z]| [x, y + 0.05, z])), Some(0.1));
        assert_eq!(of(&[[448262.25, 5411932.12, 0.0], [448263.5, 5411931.38, 1.0]]), Some(0.01));
        assert_eq!(of(&[[448262.255, 5411932.123, 0.0], [448263.5, 5411931.381, 1.0]]), None);
        assert_eq!(of(&[[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]), None, "nothing is spent near the origin");
        assert_eq!(of(&[[448262.255, 5411932.0, 0.0], [448263.5, 5411932.0, 1.0]]), None, "a flat sheet");
    }
}
