//! Anderson mixing with a memory of one, for solves whose sweeps hardly get ahead.
//!
//! In closed wood, light creeps from site to site and a sweep takes away only a few hundredths of the error. Two
//! sweeps, there and back, are a linear map x -> g with residual f = g - x. From two successive maps follows how the
//! slow part goes on: the next start is `g - a (g - g')` with `a = <f - f', f> / <f - f', f - f'>`, primes for the map
//! before (Anderson 1965, for one term the secant method of vectors). Ordinary plants do not need it: over two sweeps
//! their error has many parts of about the same pace.

use super::kernel::{LANES, Lanes};

/// The last two starts and the last end, `[domain][row]`. Three times the light of the solves it serves.
pub(super) struct Mixing {
    start: Vec<Vec<Lanes>>,
    start_before: Vec<Vec<Lanes>>,
    end_before: Vec<Vec<Lanes>>,
    /// Whether there are two maps to compare.
    has_map: bool,
}

impl Mixing {
    /// From the light that the next two sweeps start from.
    pub(super) fn new<'a>(light: impl Iterator<Item = &'a Vec<Lanes>>) -> Mixing {
        let start: Vec<Vec<Lanes>> = light.cloned().collect();
        Mixing { start_before: start.clone(), end_before: start.clone(), start, has_map: false }
    }

    /// After two sweeps: replaces the light they ended with by the next start.
    pub(super) fn mix(&mut self, light: &mut [&mut Vec<Lanes>]) {
        let steps = self.steps(light);
        for (domain, rows) in light.iter_mut().enumerate() {
            let [start, start_before, end_before] =
                [&mut self.start, &mut self.start_before, &mut self.end_before].map(|kept| &mut kept[domain]);
            for (row, light) in rows.iter_mut().enumerate() {
                let end = *light;
                let of_lanes = light.0.iter_mut().zip(end_before[row].0).zip(&steps);
                for ((light, before), step) in of_lanes {
                    *light = (*light - step * (*light - before)).max(0.0);
                }
                start_before[row] = start[row];
                end_before[row] = end;
                start[row] = *light;
            }
        }
        self.has_map = true;
    }

    /// `a` of every lane. Sums run in the order of the rows.
    fn steps(&self, light: &[&mut Vec<Lanes>]) -> [f32; LANES] {
        let (mut along, mut square) = ([0.0_f64; LANES], [0.0_f64; LANES]);
        for (domain, rows) in light.iter().enumerate() {
            let kept =
                self.start[domain].iter().zip(&self.start_before[domain]).zip(&self.end_before[domain]);
            for (end, ((start, start_before), end_before)) in rows.iter().zip(kept) {
                for lane in 0..LANES {
                    let residual = end.0[lane] - start.0[lane];
                    let change = f64::from(residual - (end_before.0[lane] - start_before.0[lane]));
                    along[lane] += change * f64::from(residual);
                    square[lane] += change * change;
                }
            }
        }
        let step = |lane: usize| if square[lane] > 0.0 { (along[lane] / square[lane]) as f32 } else { 0.0 };
        std::array::from_fn(|lane| if self.has_map { step(lane) } else { 0.0 })
    }
}
