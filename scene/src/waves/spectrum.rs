//! The spectrum of wind waves: how steep waves of each length are, and which ways they run.
//!
//! All formulas but the wind's drag are those of Elfouhaily and others (1997).

use std::f64::consts::{FRAC_PI_2, LN_2, PI};

/// Of the Earth, m/s^2.
const GRAVITY: f64 = 9.81;
/// Wave number at which waves are slowest, where surface tension is as strong as gravity, radians per metre.
const SLOWEST: f64 = 370.0;
/// Speed of those, m/s.
const SLOWEST_M_S: f64 = 0.23;
/// Inverse ages of waves for which the spectrum was found: from waves as fast as their wind to young ones.
const AGES: [f64; 2] = [0.84, 5.0];
/// Wave number beyond which viscosity has ended all waves, radians per metre.
const END: f64 = 1e4;
/// Steps of an integral over all wave numbers.
const STEPS: usize = 512;

/// The spectrum of a wind over a fetch.
pub(super) struct Spectrum {
    /// Wave number of the highest waves, radians per metre.
    pub peak: f64,
    inverse_age: f64,
    /// Equilibrium range parameter of the shortest waves, alpha_m.
    short: f64,
    /// Friction velocity, m/s.
    friction: f64,
}

/// Angular frequency of waves on deep water by gravity and surface tension, radians per second.
pub(super) fn frequency(wave_number: f64) -> f64 {
    wave_number * speed(wave_number)
}

/// Speed of their crests, m/s.
fn speed(wave_number: f64) -> f64 {
    let tension = wave_number / SLOWEST;
    (GRAVITY / wave_number * (1.0 + tension * tension)).sqrt()
}

impl Spectrum {
    pub(super) fn new(wind_m_s: f64, fetch_m: f64) -> Spectrum {
        let fetch = libm::pow(GRAVITY * fetch_m / (wind_m_s * wind_m_s) / 2.2e4, 0.4);
        let inverse_age = AGES[0] * libm::pow(libm::tanh(fetch), -0.75);
        // Drag of the wind on the water (Wu, Wind-stress coefficients over sea surface from breeze to hurricane, 1982).
        let friction = wind_m_s * ((0.8 + 0.065 * wind_m_s) * 1e-3).sqrt();
        let over = libm::log(friction / SLOWEST_M_S);
        let short = 0.01 * (1.0 + if over < 0.0 { over } else { 3.0 * over }).max(0.0);
        let peak = GRAVITY * inverse_age * inverse_age / (wind_m_s * wind_m_s);
        Spectrum { peak, inverse_age: inverse_age.clamp(AGES[0], AGES[1]), short, friction }
    }

    /// Variance of the slopes of waves by the logarithm of their wave number: the curvature spectrum, B_l + B_h.
    fn density(&self, wave_number: f64) -> f64 {
        let age = self.inverse_age;
        let ratio = wave_number / self.peak;
        let lull = libm::exp(-1.25 / (ratio * ratio));
        let width = 0.08 * (1.0 + 4.0 / (age * age * age));
        let off = (ratio.sqrt() - 1.0) / width;
        let peaked = if age <= 1.0 { 1.7 } else { 1.7 + 6.0 * libm::log10(age) };
        let peak = lull * libm::pow(peaked, libm::exp(-0.5 * off * off));
        let speed = speed(wave_number);
        let fall = libm::exp(-age / 10f64.sqrt() * (ratio.sqrt() - 1.0));
        let long = 0.5 * 0.006 * age.sqrt() * self::speed(self.peak) / speed * fall;
        let off = wave_number / SLOWEST - 1.0;
        let short = 0.5 * self.short * SLOWEST_M_S / speed * libm::exp(-0.25 * off * off);
        peak * (long + short)
    }

    /// Variance of the slopes of waves between two wave numbers.
    pub(super) fn variance_between(&self, from: f64, to: f64) -> f64 {
        self.integral(from, to, 8)
    }

    /// Variance of the slopes of waves from a wave number on.
    pub(super) fn variance_from(&self, from: f64) -> f64 {
        let from = from.max(self.peak / 4.0);
        if from >= END { 0.0 } else { self.integral(from, END, STEPS) }
    }

    fn integral(&self, from: f64, to: f64, steps: usize) -> f64 {
        let step = libm::log(to / from) / steps as f64;
        let at = |number: usize| self.density(from * libm::exp(step * (number as f64 + 0.5)));
        (0..steps).map(at).sum::<f64>() * step
    }

    /// How much more waves run along the wind than across it, from 0 to 1.
    fn spread(&self, wave_number: f64) -> f64 {
        let speed = speed(wave_number);
        let long = 4.0 * libm::pow(speed / self::speed(self.peak), 2.5);
        let short = 0.13 * self.friction / SLOWEST_M_S * libm::pow(SLOWEST_M_S / speed, 2.5);
        libm::tanh(LN_2 / 4.0 + long + short)
    }

    /// The angle from the wind's way, radians, that a share of the waves of a length stays below: of waves that
    /// run with the wind alone, as a still picture cannot tell.
    pub(super) fn turn_at(&self, wave_number: f64, share: f64) -> f64 {
        let spread = self.spread(wave_number);
        let below = |turn: f64| 0.5 + (turn + 0.5 * spread * libm::sin(2.0 * turn)) / PI;
        let [mut low, mut high] = [-FRAC_PI_2, FRAC_PI_2];
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if below(middle) < share { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}
