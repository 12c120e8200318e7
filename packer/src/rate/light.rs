//! The light that errors are measured against: of a base by itself, or of the suns that several bases make together.

use crate::surface::POINTS_PER_SITE;

/// A peak below this, 2^-96, counts as none: its unit would be 0.
const DIMMEST: f32 = 1.0 / 79_228_162_514_264_337_593_543_950_336.0;
/// How much heavier than in bright places an error weighs at the brightest of the dark points; it grows with 1 /
/// light^2.
const DARK_WEIGHT: f32 = 1.5;
/// Light, in shares of that of the brightest dark point, below which weights grow no more.
const MIN_LIGHT: f32 = 0.1;

/// Samples of light at surfaces.
pub(super) struct Light {
    /// Largest magnitude in a band; 1 where that is below 2^-96.
    pub peak: f32,
    /// The darkest tenth of points with the norm of their light, relative to the peak, ascending by point.
    pub dark: Vec<(u32, f32)>,
    /// Largest norm of those.
    pub darkest_tenth: f32,
    /// `[site with points]` how much an error counts there if relative errors are asked for.
    pub weights: Vec<f32>,
}

impl Light {
    /// Of samples `[band][point]`; dark are points `on_leaves`, where there are any.
    pub(super) fn new(samples: &[Vec<f32>], on_leaves: &[bool]) -> Light {
        let peak = samples.iter().flatten().fold(0.0f32, |peak, v| peak.max(v.abs()));
        let peak = if peak >= DIMMEST { peak } else { 1.0 };
        let points = samples.first().map_or(0, Vec::len);
        let square = |p: usize| samples.iter().map(|s| s[p] / peak).map(|v| v * v).sum::<f32>();
        let all = !on_leaves.contains(&true);
        let judged = (0..points).filter(|p| all || on_leaves[*p]);
        let mut dark: Vec<(u32, f32)> = judged.map(|p| (p as u32, square(p))).collect();
        let tenth = dark.len().div_ceil(10);
        if tenth > 0 {
            dark.select_nth_unstable_by(tenth - 1, |a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        }
        dark.truncate(tenth);
        dark.sort_unstable_by_key(|d| d.0);
        let limit = dark.iter().fold(0.0f32, |most, d| most.max(d.1));
        dark.iter_mut().for_each(|d| d.1 = d.1.sqrt());
        let per_site = POINTS_PER_SITE as usize;
        let weight = |site: usize| {
            let mean = (0..per_site).map(|k| square(site * per_site + k)).sum::<f32>() / per_site as f32;
            let least = limit * MIN_LIGHT * MIN_LIGHT;
            1.0 + if mean.max(least) > 0.0 { DARK_WEIGHT * limit / mean.max(least) } else { 0.0 }
        };
        let weights = (0..points / per_site).map(weight).collect();
        Light { peak, dark, darkest_tenth: limit.sqrt(), weights }
    }

    /// Of the mean over suns of what bases `[base][band][point]` make together: harmonics first, whose mean is that of
    /// the first one, then terms of the near beam, which is between 0 and 1 and counts as half.
    pub(super) fn of_suns(samples: &[Vec<Vec<f32>>], harmonics: usize, on_leaves: &[bool]) -> Light {
        let mut mean = samples[0].clone();
        for term in samples.iter().skip(harmonics) {
            for (mean, term) in mean.iter_mut().zip(term) {
                mean.iter_mut().zip(term).for_each(|(m, t)| *m += 0.5 * t);
            }
        }
        Light::new(&mean, on_leaves)
    }
}
