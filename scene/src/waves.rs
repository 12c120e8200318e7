//! Waves on water: a random surface of plane waves, as steep as wind makes it.
//!
//! ```text
//! wind, fetch -Spectrum-> share of the slope's variance at each wavelength -WaveField-> plane waves with random phases
//! ```
//!
//! The spectrum is that of Elfouhaily, Chapron, Katsaros and Vandemark, A unified directional spectrum for long and
//! short wind-driven waves (J. Geophys. Res. 102, 1997), from swell to ripples of a few millimetres; it agrees with the
//! slopes that Cox and Munk measured in the sun's glitter (1954), which a test holds it to. Waves that a field leaves
//! out, since they are too short to be drawn one by one, are told by the variance of their slopes.

mod spectrum;

use std::f64::consts::TAU;

use flb_format::sun::towards_sun;

use spectrum::Spectrum;

/// Smallest and largest speed of a wind, m/s.
pub const WINDS_M_S: [f64; 2] = [0.5, 30.0];
/// Smallest and largest fetch, metres.
pub const FETCHES_M: [f64; 2] = [1.0, 1e6];
/// Largest factor on slopes.
pub const MAX_STEEPNESS: f64 = 10.0;
/// Largest root mean square of slopes: steeper waves would fold over.
pub const MAX_SLOPE: f64 = 0.4;
/// Largest magnitude of a time, seconds.
pub const MAX_TIME_S: f64 = 1e9;

/// Plane waves of a field.
pub const WAVE_COUNT: usize = 96;
/// Shortest of them, metres: shorter ones are smaller than a pixel of most pictures.
const SHORTEST_M: f64 = 0.03;
/// Wave numbers of the longest and, where all of them are short, of the shortest, in those of the highest waves.
const AROUND_PEAK: [f64; 2] = [0.5, 4.0];

/// Wind over water, and the choice of one surface among those that it may make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waves {
    /// Speed of the wind 10 m above the water, m/s.
    pub wind_m_s: f64,
    /// Azimuth from which it blows, degrees, as of a sun.
    pub from_deg: f64,
    /// Length of open water over which it has blown, metres: the shorter, the shorter are the waves.
    pub fetch_m: f64,
    /// Factor on the slopes, 1 as the wind makes them.
    pub steepness: f64,
    /// Seed of the phases.
    pub seed: u32,
}

/// A plane wave: the slope along its direction is `slope` times the cosine of `wave_vector . (x, z) - frequency * time
/// + phase`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneWave {
    /// Wave vector along x and z, radians per metre.
    pub wave_vector: [f64; 2],
    /// Angular frequency, radians per second.
    pub frequency: f64,
    /// Phase at the origin at time 0, radians.
    pub phase: f64,
    /// Largest slope, dh/dx and dh/dz.
    pub slope: [f64; 2],
}

/// The waves of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveField {
    /// Plane waves, [`WAVE_COUNT`] of them, from the longest to the shortest.
    pub waves: Vec<PlaneWave>,
    /// Variance of the slopes of all shorter waves, along both axes together.
    pub rest_variance: f64,
    /// Of each wave: wave vector, frequency and phase in turns, and slopes, as [`WaveField::slope_at`] adds them up.
    numbers: [Vec<f64>; 6],
}

impl Default for Waves {
    /// A breeze over a pond.
    fn default() -> Waves {
        Waves { wind_m_s: 3.0, from_deg: 270.0, fetch_m: 300.0, steepness: 1.0, seed: 1 }
    }
}

impl Waves {
    /// Root mean square of the slopes of all waves, along both axes together.
    pub fn rms_slope(&self) -> f64 {
        self.steepness * Spectrum::new(self.wind_m_s, self.fetch_m).variance_from(0.0).sqrt()
    }

    /// Finds what is wrong with them, if anything: name of the value, found, expected.
    pub fn fault(&self) -> Option<(&'static str, f64, String)> {
        let within = |name, found: f64, [low, high]: [f64; 2]| {
            (!(low..=high).contains(&found)).then(|| (name, found, format!("{low} to {high}")))
        };
        within("wind_m_s", self.wind_m_s, WINDS_M_S)
            .or_else(|| within("from_deg", self.from_deg, [-360.0, 360.0]))
            .or_else(|| within("fetch_m", self.fetch_m, FETCHES_M))
            .or_else(|| within("steepness", self.steepness, [0.0, MAX_STEEPNESS]))
            .or_else(|| {
                let slope = self.rms_slope();
                let folds =
                    || format!("at most {:.2}: steeper waves fold over", self.steepness * MAX_SLOPE / slope);
                (slope > MAX_SLOPE).then(|| ("steepness", self.steepness, folds()))
            })
    }

    /// Computes the surface. The same settings give the same waves on every machine.
    ///
    /// # Panics
    /// If there is a [`Waves::fault`].
    pub fn field(&self) -> WaveField {
        assert_eq!(self.fault(), None, "waves were checked");
        let spectrum = Spectrum::new(self.wind_m_s, self.fetch_m);
        let [longest, least] = AROUND_PEAK.map(|times| times * spectrum.peak);
        let shortest = (TAU / SHORTEST_M).max(least);
        let step = libm::log(shortest / longest) / WAVE_COUNT as f64;
        let [toward_x, _, toward_z] = towards_sun(self.from_deg, 0.0).map(|c| -c);
        let mut draws = Draws(u64::from(self.seed));
        let order = draws.shuffled(WAVE_COUNT);
        let wave = |number: usize| {
            let from = longest * libm::exp(step * number as f64);
            let wave_number = from * libm::exp(step * draws.share());
            let variance = spectrum.variance_between(from, from * libm::exp(step));
            let slope = self.steepness * (2.0 * variance).sqrt();
            let share = (order[number] as f64 + draws.share()) / WAVE_COUNT as f64;
            let turn = spectrum.turn_at(wave_number, share);
            let (sin, cos) = (libm::sin(turn), libm::cos(turn));
            let along = [toward_x * cos - toward_z * sin, toward_z * cos + toward_x * sin];
            PlaneWave {
                wave_vector: along.map(|c| c * wave_number),
                frequency: spectrum::frequency(wave_number),
                phase: TAU * draws.share(),
                slope: along.map(|c| c * slope),
            }
        };
        let rest_variance = self.steepness * self.steepness * spectrum.variance_from(shortest);
        WaveField::new((0..WAVE_COUNT).map(wave).collect(), rest_variance)
    }
}

impl PlaneWave {
    /// Phase at a point at a time, in turns, from 0 to below 1.
    pub fn turns_at(&self, [x, z]: [f64; 2], time_s: f64) -> f64 {
        let [kx, kz] = self.wave_vector;
        let turns = (kx * x + kz * z - self.frequency * time_s + self.phase) / TAU;
        turns - turns.floor()
    }
}

impl WaveField {
    fn new(waves: Vec<PlaneWave>, rest_variance: f64) -> WaveField {
        let of = |number: fn(&PlaneWave) -> f64| waves.iter().map(number).collect();
        let numbers = [
            of(|wave| wave.wave_vector[0] / TAU),
            of(|wave| wave.wave_vector[1] / TAU),
            of(|wave| -wave.frequency / TAU),
            of(|wave| wave.phase / TAU),
            of(|wave| wave.slope[0]),
            of(|wave| wave.slope[1]),
        ];
        WaveField { waves, rest_variance, numbers }
    }

    /// Slope at a point at a time: dh/dx and dh/dz.
    pub fn slope_at(&self, [x, z]: [f64; 2], time_s: f64) -> [f64; 2] {
        let [kx, kz, frequency, phase, slope_x, slope_z] =
            self.numbers.each_ref().map(|numbers| numbers.as_chunks::<LANES>().0);
        let mut sums = [[0.0; LANES]; 2];
        // Lanes side by side, each with a sum of its own: the order does not depend on the machine.
        for run in 0..kx.len() {
            for lane in 0..LANES {
                let of = |numbers: &[[f64; LANES]]| numbers[run][lane];
                let height = cos_turns(of(kx) * x + of(kz) * z + of(frequency) * time_s + of(phase));
                sums[0][lane] += of(slope_x) * height;
                sums[1][lane] += of(slope_z) * height;
            }
        }
        sums.map(|lanes| lanes.iter().sum())
    }
}

/// Waves that are summed side by side.
const LANES: usize = 4;

/// The cosine of so many turns, at most 2^50 of them, to 6e-8: the sine's series about the nearest of its zeros,
/// without branches and calls, so that it runs on lanes.
fn cos_turns(turns: f64) -> f64 {
    // Added and taken away, it leaves the nearest whole number.
    const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;
    let part = turns - ((turns + WHOLE) - WHOLE);
    let angle = TAU * (0.25 - part.abs());
    let square = angle * angle;
    let series = [-1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0];
    angle * series.into_iter().fold(0.0, |sum, term| sum * square + term)
}

/// Numbers as if drawn by lot (SplitMix64; Steele, Lea and Flood, Fast splittable pseudorandom number generators,
/// 2014).
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to below 1.
    fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The numbers below `count` in some order.
    fn shuffled(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, (self.next() % (last as u64 + 1)) as usize);
        }
        order
    }
}

#[cfg(test)]
mod tests;
