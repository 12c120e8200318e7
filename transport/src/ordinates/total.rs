//! All light of the non-empty sites, scattered and beam, as a surface elsewhere receives it.

use flb_format::beam::{NearBeam, means};
use flb_format::sun::harmonics;
use rayon::prelude::*;

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
    /// Projection of each mean of the near beam on each harmonic, `[harmonic][mean][site]`; empty without harmonics.
    pub near: Vec<Vec<Vec<f32>>>,
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
    let suns = plan.suns.iter().zip(light).zip(beams).take(plan.fitted());
    match settings.suns {
        SunBasis::Lattice18 | SunBasis::Directions(_) => suns
            .map(|((_, light), near)| {
                light.iter().zip(&near.beam.mean).map(|(scattered, direct)| scattered + direct).collect()
            })
            .collect(),
        SunBasis::Harmonics { degree, .. } => {
            let mut fields = vec![vec![0.0_f32; beams[0].beam.mean.len()]; harmonics::count(degree)];
            for ((sun, light), near) in suns {
                let values = harmonics::evaluate(sun.towards);
                fields.par_iter_mut().zip(values).for_each(|(field, value)| {
                    let weight = (sun.weight * value) as f32;
                    let lit = light.iter().zip(&near.beam.mean);
                    field
                        .iter_mut()
                        .zip(lit)
                        .for_each(|(sum, (light, beam))| *sum += weight * (light + beam));
                });
            }
            fields
        }
    }
}

/// The means of the near beam projected on each harmonic, `[harmonic][mean][site]`; nothing where there are none.
pub(super) fn of_near(
    plan: &suns::SolvePlan,
    beams: &[NearBeam],
    settings: &OrdinatesSettings,
) -> Vec<Vec<Vec<f32>>> {
    let SunBasis::Harmonics { degree, single } = settings.suns else { return Vec::new() };
    let sites = beams[0].beam.mean.len();
    let suns: Vec<_> = plan.suns.iter().zip(beams).take(plan.fitted()).collect();
    let projected = |harmonic: usize, mean: usize| {
        let mut values = vec![0.0_f32; sites];
        for (sun, near) in &suns {
            let weight = (sun.weight * harmonics::evaluate(sun.towards)[harmonic]) as f32;
            values.iter_mut().enumerate().for_each(|(site, sum)| *sum += weight * near.mean(mean, site));
        }
        values
    };
    let of_harmonic = |harmonic| (0..means(single)).map(|mean| projected(harmonic, mean)).collect();
    (0..harmonics::count(degree)).into_par_iter().map(of_harmonic).collect()
}
