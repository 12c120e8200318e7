//! All light of the non-empty sites, scattered and beam, as a surface elsewhere receives it.

use flb_format::beam::{NearBeam, means};
use flb_format::sun::harmonics;
use rayon::prelude::*;

use super::fit::Terms;
use super::{OrdinatesSettings, SunBasis, suns};

/// Scattered light and beam together at the non-empty sites: of the sky, and of every field of suns but those of the
/// near beam. Of harmonics it is the projection of the total light on each: what a surface elsewhere receives from a
/// site is linear in it, and harmonics of low degree are all that it can keep of the sun's direction.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TotalLight {
    /// Numbers of the fields, ascending.
    pub items: Vec<u8>,
    /// `[band][item][site]`.
    pub values: Vec<Vec<Vec<f32>>>,
    /// Projection of each mean of the near beam, as often as it counts, on each harmonic, `[harmonic][mean][site]`;
    /// empty without harmonics.
    pub near: Vec<Vec<Vec<f32>>>,
    /// Light of the beams that leaves meet beyond what `values` hold of it, by their inclinations; below 0 where they
    /// meet less. `[item of the suns][site]`; empty where they favour none.
    pub beyond: Vec<Vec<f32>>,
    /// Light of the sky that has met nothing, `[site]`; empty without a sky.
    pub open_sky: Vec<f32>,
}

/// Scattered light of suns and their beams together, `[item][site]`: see [`TotalLight`].
pub(super) fn of_suns(
    light: &[Vec<f32>],
    plan: &suns::SolvePlan,
    beams: &[NearBeam],
    settings: &OrdinatesSettings,
) -> Vec<Vec<f32>> {
    let direct = |sun: usize, site: usize| beams[sun].beam.mean[site];
    projected(plan, beams, settings, |sun, site| light[sun][site] + direct(sun, site))
}

/// Light of the suns that fields are made from, by sun and site, as light of the items.
fn projected(
    plan: &suns::SolvePlan,
    beams: &[NearBeam],
    settings: &OrdinatesSettings,
    light: impl Fn(usize, usize) -> f32 + Sync,
) -> Vec<Vec<f32>> {
    let sites = beams.first().map_or(0, |near| near.beam.mean.len());
    let of_sun = |sun: usize| (0..sites).map(|site| light(sun, site)).collect();
    let SunBasis::Harmonics { degree, .. } = settings.suns else {
        return (0..plan.fitted()).into_par_iter().map(of_sun).collect();
    };
    let mut fields = vec![vec![0.0_f32; sites]; harmonics::count(degree)];
    for (number, sun) in plan.suns.iter().enumerate().take(plan.fitted()) {
        let values = harmonics::evaluate(sun.towards);
        fields.par_iter_mut().zip(values).for_each(|(field, value)| {
            let weight = (sun.weight * value) as f32;
            field.iter_mut().enumerate().for_each(|(site, sum)| *sum += weight * light(number, site));
        });
    }
    fields
}

/// The means of the near beam projected on each harmonic, `[harmonic][mean][site]`; nothing where there are none.
pub(super) fn of_near(
    plan: &suns::SolvePlan,
    beams: &[NearBeam],
    settings: &OrdinatesSettings,
) -> Vec<Vec<Vec<f32>>> {
    let SunBasis::Harmonics { degree, single, leaning } = settings.suns else { return Vec::new() };
    let terms = Terms { degree, single, leaning };
    let sites = beams[0].beam.mean.len();
    let suns: Vec<_> = plan.suns.iter().zip(beams).take(plan.fitted()).collect();
    let projected = |harmonic: usize, mean: usize| {
        let mut values = vec![0.0_f32; sites];
        for (sun, near) in &suns {
            let weight = (sun.weight * harmonics::evaluate(sun.towards)[harmonic]) as f32;
            let weight = weight * terms.near_factor(near);
            values.iter_mut().enumerate().for_each(|(site, sum)| *sum += weight * near.mean(mean, site));
        }
        values
    };
    let of_harmonic = |harmonic| (0..means(single)).map(|mean| projected(harmonic, mean)).collect();
    (0..harmonics::count(degree)).into_par_iter().map(of_harmonic).collect()
}

/// See [`TotalLight::beyond`].
pub(super) fn beyond(
    plan: &suns::SolvePlan,
    beams: &[NearBeam],
    settings: &OrdinatesSettings,
) -> Vec<Vec<f32>> {
    if beams[..plan.fitted()].iter().all(|near| near.relative == 1.0) {
        return Vec::new();
    }
    projected(plan, beams, settings, |sun, site| (beams[sun].relative - 1.0) * beams[sun].beam.mean[site])
}
