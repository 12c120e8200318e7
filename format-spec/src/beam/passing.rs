//! What becomes of light on its way through a site: of one ray, and of neighbouring rays side by side.

/// Optical depth below which the moments are series.
const SERIES_BELOW: f32 = 0.02;

/// Moments of exp(-s t), the transmittance along a way, for t from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing {
    /// Transmittance of the whole way, exp(-s).
    pub transmittance: f32,
    /// Mean transmittance along the way, (1 - exp(-s)) / s.
    pub mean: f32,
    /// The mean of (t - 1/2) exp(-s t), at most 0.
    pub lean: f32,
}

impl Passing {
    /// Computes the moments for an optical depth s of the whole way.
    pub fn new(s: f32) -> Passing {
        let gone = -libm::expm1f(-s);
        let transmittance = 1.0 - gone;
        // Series where the closed forms cancel: the next terms are below 1e-7 of the first.
        if s < SERIES_BELOW {
            let mean = 1.0 - s * (0.5 - s / 6.0);
            return Passing { transmittance, mean, lean: -s / 12.0 * (1.0 - s * (0.5 - s * 0.15)) };
        }
        let mean = gone / s;
        Passing { transmittance, mean, lean: (mean - transmittance) / s - 0.5 * mean }
    }
}

/// Number of rays side by side.
pub(super) const LANES: usize = 8;

/// One number of each ray.
pub(super) type Lanes = [f32; LANES];

/// Coefficients of q in 1 - 2^-f = f q(f), 0 <= f <= 1: the polynomial of degree 5 that is exact at Chebyshev's nodes.
/// Relative error 1.1e-8.
const Q: [f32; 6] =
    [std::f32::consts::LN_2, -0.240_226_1, 0.055_499_23, -0.009_597_035, 0.001_291_636_8, -0.000_114_919_95];

/// Adding and taking away 1.5 x 2^23 rounds a small number to an integer, which the low bits of the sum hold.
const ROUNDS: f32 = 12_582_912.0;

/// Largest exponent of 2^-k that is a normal number.
const MAX_EXPONENT: f32 = 126.0;

/// [`Passing`] of each lane. The same operations on each, without branches, so that the compiler may use any SIMD that
/// there is and the bits stay the same.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passings {
    pub transmittance: Lanes,
    pub mean: Lanes,
    pub lean: Lanes,
}

impl Passings {
    /// Computes the moments for optical depths s >= 0. Each, the lean times s, is within 5e-7 of that of
    /// [`Passing::new`], relative to 1.
    #[inline(always)]
    pub(super) fn new(s: Lanes) -> Passings {
        let mut passings = Passings { transmittance: [0.0; LANES], mean: [0.0; LANES], lean: [0.0; LANES] };
        for lane in 0..LANES {
            let s = s[lane];
            // exp(-s) = 2^-k 2^-f with an integer k and 0 <= f <= 1.
            let x = s * std::f32::consts::LOG2_E;
            let x = if x < MAX_EXPONENT { x } else { MAX_EXPONENT };
            let sum = x - 0.5 + ROUNDS;
            let f = x - (sum - ROUNDS);
            let power = f32::from_bits((127 + ROUNDS.to_bits() - sum.to_bits()) << 23);
            let q = Q[0] + f * (Q[1] + f * (Q[2] + f * (Q[3] + f * (Q[4] + f * Q[5]))));
            // All terms are positive, so that nothing cancels where s is small.
            let gone = (1.0 - power) + power * (f * q);
            let transmittance = 1.0 - gone;
            let is_series = s < SERIES_BELOW;
            let divisor = if is_series { 1.0 } else { s };
            let mean = gone / divisor;
            let lean = (mean - transmittance) / divisor - 0.5 * mean;
            passings.transmittance[lane] = transmittance;
            passings.mean[lane] = if is_series { 1.0 - s * (0.5 - s / 6.0) } else { mean };
            passings.lean[lane] = if is_series { -s / 12.0 * (1.0 - s * (0.5 - s * 0.15)) } else { lean };
        }
        passings
    }
}

/// Sums the lanes in their order by halves.
#[inline(always)]
pub(super) fn sum([a, b, c, d, e, f, g, h]: Lanes) -> f32 {
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_have_the_moments_of_single_crossings() {
        let depths =
            (0..4000).map(|i| libm::expf(-14.0 + 0.005 * i as f32)).chain([0.0, 87.0, 88.0, 200.0, 1e30]);
        let depths: Vec<f32> = depths.collect();
        let is_near = |found: f32, expected: f32, s: f32| {
            assert!((found - expected).abs() < 5e-7, "{found}, expected {expected}, at {s}");
        };
        for some in depths.chunks(LANES) {
            let lane = |at: usize| some.get(at).copied().unwrap_or(0.0);
            let found = Passings::new(std::array::from_fn(lane));
            for at in 0..LANES {
                let (s, expected) = (lane(at), Passing::new(lane(at)));
                is_near(found.transmittance[at], expected.transmittance, s);
                is_near(found.mean[at], expected.mean, s);
                // Its closed form cancels: rounding of the mean grows by 1 / s.
                is_near(found.lean[at] * s.min(1.0), expected.lean * s.min(1.0), s);
            }
        }
    }

    #[test]
    fn nothing_happens_on_no_way() {
        let none = Passings::new([0.0; LANES]);
        assert_eq!((none.transmittance, none.mean, none.lean), ([1.0; LANES], [1.0; LANES], [-0.0; LANES]));
    }
}
