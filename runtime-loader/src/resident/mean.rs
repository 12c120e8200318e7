//! The mean light of a plant, which stands in for what is not loaded: a file says it before its first page
//! (SPEC.md, section 9.4).

use flb_format::SpeciesMeta;
use flb_format::mean_light::MeanLight;

use super::{Terms, UNKNOWN_SHARE};

/// What averages may be off by, at most; beyond it a file is taken to say nothing.
const MAX_OVER_AVERAGES: f64 = 2.0;

/// Of a species; what its file does not say is taken for a share of the light outside.
#[derive(Debug, Clone)]
pub(super) struct Mean {
    light: MeanLight,
    /// Light of the sky over that of its averages.
    over_averages: f32,
}

impl Mean {
    pub(super) fn of(meta: &SpeciesMeta) -> Mean {
        let bands = meta.band_count();
        let told = meta.mean_light.clone().unwrap_or(MeanLight { sky: Vec::new(), sun: Vec::new() });
        let share = f64::from(UNKNOWN_SHARE);
        let or = |told: Vec<_>, unknown| if told.is_empty() { unknown } else { told };
        let sky = or(told.sky, vec![share * f64::from(meta.model.empty_value(0)); bands]);
        let sun = if told.sun.is_empty() { vec![vec![share; bands]] } else { told.sun };
        let sum = |bands: &[f64]| bands.iter().sum::<f64>();
        let over = meta.sky_averages.as_ref().map_or(1.0, |averages| sum(&sky) / sum(averages));
        let is_sound = (1.0 / MAX_OVER_AVERAGES..=MAX_OVER_AVERAGES).contains(&over);
        let over_averages = if is_sound { over as f32 } else { 1.0 };
        Mean { light: MeanLight { sky, sun }, over_averages }
    }

    /// Factor on the light of the sky of which this share of blocks has detail, by which its mean is that of all of it.
    pub(super) fn of_detail(&self, share: f32) -> f32 {
        if share >= 1.0 { 1.0 } else { share + (1.0 - share) * self.over_averages }
    }

    /// Light of a sky of 1 in a band.
    pub(super) fn of_sky(&self, band: usize) -> f32 {
        self.light.sky[band] as f32
    }

    /// The largest factor of the sky's light that leaves nothing below 0 to be added in any band for a sun of
    /// irradiance 1 along a unit vector.
    pub(super) fn sun_over_sky(&self, towards_sun: [f64; 3]) -> f32 {
        let of_sun = self.light.of_sun(towards_sun);
        let ratio = |(band, sky): (usize, &f64)| of_sun(band) / sky;
        let least =
            self.light.sky.iter().enumerate().filter(|(_, sky)| **sky > 0.0).map(ratio).reduce(f64::min);
        least.unwrap_or(0.0) as f32
    }

    /// What is added for what a sun of irradiance 1 lacks (source 0), or a sky of light 1 (source 1), by source and
    /// band.
    pub(super) fn constants(&self, terms: &Terms) -> impl Fn(usize, usize) -> f32 + '_ {
        let ([sun, sky], stand_in) = terms.missing();
        let of_sun = self.light.of_sun(terms.towards_sun());
        move |source, band| match source {
            0 if sun == 0.0 => 0.0,
            0 => (f64::from(sun) * of_sun(band) - f64::from(stand_in) * self.light.sky[band]).max(0.0) as f32,
            _ => sky * self.of_sky(band),
        }
    }
}
