//! The error of the fields against Monte Carlo in the very same medium, for the file.

use flb_format::light::MonteCarloError;
use flb_format::sun;
use flb_scene::Step;
use flb_transport::monte_carlo::judge::{Judgement, Truth, photons, suns};
use flb_transport::ordinates::{OrdinatesSettings, OrdinatesSolution, SiteAlbedos, SunBasis, near};
use flb_transport::turbid::{BandScatter, TurbidMedium};

use super::observer::Event;
use super::{BakeError, Work};

/// Judges every band under `count` suns, tells what was found with its standard error, and returns it for the worst
/// band. `None` without suns: where none was asked for, or where the fields that a plan keeps make the light of none of
/// them.
pub(super) fn judge(
    work: &Work,
    count: usize,
    medium: &TurbidMedium,
    (bands, albedos): (&[BandScatter], &[SiteAlbedos]),
    solution: &OrdinatesSolution,
    settings: &OrdinatesSettings,
) -> Result<Option<MonteCarloError>, BakeError> {
    if count == 0 {
        return Ok(None);
    }
    let suns: Vec<[f64; 3]> = suns(count).into_iter().filter(|sun| has_light_of(settings, *sun)).collect();
    if suns.len() < count {
        let left = count - suns.len();
        work.hear(Event::SunsNotTraced { species: work.species.to_owned(), left, of: count });
    }
    let sites = medium.sites();
    let photons = photons(sites.len());
    let worst = work.run(Step::MonteCarlo, |progress| {
        let near = [near(medium, &sites, settings.suns.needs_single())];
        let mut differences = vec![Vec::new(); bands.len()];
        for (at, &towards_sun) in suns.iter().enumerate() {
            let part = |share: f64| progress((at as f64 + share) / suns.len() as f64);
            let truth = Truth::trace(medium, &near, bands, Some(albedos), towards_sun, photons, &part)?;
            for (band, differences) in (0u32..).zip(&mut differences) {
                differences.push(truth.difference(solution, settings, band, &sites)?);
            }
        }
        let mut worst: Option<(usize, Judgement)> = None;
        for (band, differences) in differences.iter().enumerate() {
            let judged = Judgement::over(differences).map(|judged| (band, judged));
            worst = match (worst, judged) {
                (Some(worst), Some(judged)) if worst.1.rms >= judged.1.rms => Some(worst),
                (worst, judged) => judged.or(worst),
            };
        }
        Ok(worst)
    })?;
    let Some((band, judged)) = worst else { return Ok(None) };
    let percent = |share: f64| 100.0 * share;
    let what = format!(
        "off Monte Carlo by {:.2} % rms (standard error {:.2} %; worst sun {:.2} %), bias {:+.2} % ({:.2} %), in its worst band, {band}; {} suns, 2 seeds of {photons} photons each",
        percent(judged.rms),
        percent(judged.rms_error),
        percent(judged.worst),
        percent(judged.bias),
        percent(judged.bias_error),
        judged.suns,
    );
    work.hear(Event::Judged { species: work.species.to_owned(), what });
    Ok(Some(MonteCarloError { rms: judged.rms, bias: judged.bias, photons, suns: judged.suns as u32 }))
}

/// Whether the fields that are solved make the light of a sun.
fn has_light_of(settings: &OrdinatesSettings, towards_sun: [f64; 3]) -> bool {
    let needed = sun::blend(towards_sun).expect("the suns are unit vectors").bases;
    settings.suns != SunBasis::Lattice18 || needed.into_iter().all(|base| settings.bases.contains(base))
}
