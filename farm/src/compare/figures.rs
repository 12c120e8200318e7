//! By how much values of light differ: root mean square, percentile, mean and the worst of all.

/// Values of light at the same points, `[light][point][band]`.
pub(super) struct Values<'a> {
    pub old: &'a [Vec<f32>],
    pub new: &'a [Vec<f32>],
    /// Number of bands.
    pub bands: usize,
    /// Number of lights at the beginning that are suns; the others are skies.
    pub suns: usize,
}

/// Differences as shares of the mean light.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figures {
    pub rms: f64,
    /// No more than this at 99 of 100 samples.
    pub p99: f64,
    /// Above 0 where the light became brighter.
    pub mean: f64,
    pub worst: Sample,
}

/// One value of both.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sample {
    pub light: usize,
    pub point: usize,
    pub band: usize,
    pub old: f32,
    pub new: f32,
    /// Magnitude of the difference.
    pub share: f64,
}

/// Why values have no figures.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum NoFigures {
    /// A value that is not finite, in one of both.
    NotFinite(Sample),
    /// The old light is black, and the new one is not.
    Black,
    /// There is no point.
    NoPoints,
}

/// Finds the figures. Each difference counts as a share of the mean old light over all bands: under the suns, or
/// under the sky. A band of its own mean would show the noise of the coding where it is dark. Sums run in f64 in the
/// order of the values.
pub(super) fn figures(values: &Values) -> Result<Figures, NoFigures> {
    let Values { old, new, bands, suns } = *values;
    let count: usize = old.iter().map(Vec::len).sum();
    if count == 0 {
        return Err(NoFigures::NoPoints);
    }
    let (of_suns, of_skies) = old.split_at(suns);
    let means = [mean(of_suns), mean(of_skies)];
    let (mut squares, mut sum, mut shares) = (0.0f64, 0.0f64, Vec::with_capacity(count));
    let mut worst: Option<Sample> = None;
    for (light, (old, new)) in old.iter().zip(new).enumerate() {
        let mean = means[usize::from(light >= suns)];
        for (index, (&old, &new)) in old.iter().zip(new).enumerate() {
            let (point, band) = (index / bands, index % bands);
            let sample = |share| Sample { light, point, band, old, new, share };
            let difference = f64::from(new) - f64::from(old);
            if !difference.is_finite() {
                return Err(NoFigures::NotFinite(sample(0.0)));
            }
            let share = match (difference == 0.0, mean > 0.0) {
                (true, _) => 0.0,
                (false, true) => difference / mean,
                (false, false) => return Err(NoFigures::Black),
            };
            squares += share * share;
            sum += share;
            shares.push(share.abs() as f32);
            if worst.as_ref().is_none_or(|worst| share.abs() > worst.share) {
                worst = Some(sample(share.abs()));
            }
        }
    }
    let rank = (count * 99).div_ceil(100) - 1;
    let (_, p99, _) = shares.select_nth_unstable_by(rank, f32::total_cmp);
    let of_all = count as f64;
    let worst = worst.ok_or(NoFigures::NoPoints)?;
    Ok(Figures { rms: (squares / of_all).sqrt(), p99: f64::from(*p99), mean: sum / of_all, worst })
}

/// Mean over lights, points and bands; 0 of none.
fn mean(lights: &[Vec<f32>]) -> f64 {
    let sum: f64 = lights.iter().flatten().map(|value| f64::from(*value)).sum();
    sum / lights.iter().map(Vec::len).sum::<usize>().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(old: &[Vec<f32>], new: &[Vec<f32>], bands: usize, suns: usize) -> Result<Figures, NoFigures> {
        figures(&Values { old, new, bands, suns })
    }

    #[test]
    fn figures_of_made_up_numbers_are_those_worked_out_by_hand() {
        // Mean 2; differences 0, 1, -1, 2: shares 0, 0.5, -0.5, 1.
        let found = of(&[vec![1.0, 2.0, 2.0, 3.0]], &[vec![1.0, 3.0, 1.0, 5.0]], 1, 1).unwrap();
        assert!((found.rms - (1.5f64 / 4.0).sqrt()).abs() < 1e-15, "{found:?}");
        assert_eq!((found.p99, found.mean), (1.0, 0.25));
        assert_eq!(found.worst, Sample { light: 0, point: 3, band: 0, old: 3.0, new: 5.0, share: 1.0 });
    }

    #[test]
    fn one_value_of_a_hundred_does_not_move_the_percentile_and_two_do() {
        let old = vec![1.0f32; 200];
        let with = |count: usize| {
            let mut new = old.clone();
            new[..count].fill(1.5);
            of(std::slice::from_ref(&old), &[new], 1, 1).unwrap().p99
        };
        assert_eq!((with(2), with(3)), (0.0, 0.5));
    }

    #[test]
    fn suns_and_the_sky_have_a_mean_of_their_own() {
        // The suns' mean is 4 over both bands, the sky's 10.
        let old = [vec![7.0, 1.0, 7.0, 1.0], vec![10.0, 10.0, 10.0, 10.0]];
        for (light, at, mean) in [(0, 0, 4.0), (0, 1, 4.0), (1, 3, 10.0)] {
            let mut new = old.clone();
            new[light][at] += 2.0;
            let found = of(&old, &new, 2, 1).unwrap();
            let worst = &found.worst;
            assert_eq!(worst.share, 2.0 / mean, "{light} {at}: {found:?}");
            assert_eq!((worst.light, worst.point, worst.band), (light, at / 2, at % 2));
        }
        let twice: Vec<Vec<f32>> = old.iter().map(|all| all.iter().map(|v| 2.0 * v).collect()).collect();
        let found = of(&old, &twice, 2, 1).unwrap();
        assert_eq!((found.rms, found.mean), ((0.5f64 * (50.0 / 32.0 + 1.0)).sqrt(), 1.0));
    }

    #[test]
    fn values_without_figures_are_told() {
        assert_eq!(of(&[], &[], 1, 0), Err(NoFigures::NoPoints));
        assert_eq!(of(&[vec![0.0; 2]], &[vec![0.0, 1.0]], 2, 1), Err(NoFigures::Black));
        assert_eq!(of(&[vec![0.0; 2]], &[vec![0.0; 2]], 2, 1).unwrap().rms, 0.0);
        let bad = of(&[vec![1.0, 1.0]], &[vec![1.0, f32::NAN]], 1, 1);
        assert!(matches!(bad, Err(NoFigures::NotFinite(Sample { point: 1, .. }))), "{bad:?}");
    }
}
