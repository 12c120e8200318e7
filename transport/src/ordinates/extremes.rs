//! Discrete ordinates at the ends of their range: cases, each solved, measured and judged.

mod cases;
mod media;
pub mod table;

use flb_format::beam::{Beam, Near};
use flb_format::matter::TurbidMedium;

pub use cases::cases;

use super::band::{Band, Own};
use super::reference::{Entering, Reference};
use super::refine::Refined;
use super::suns::SolvePlan;
use super::{OrdinatesError, OrdinatesSettings, OrdinatesSolution, SunBasis, beams_of, solve};
use crate::extremes::{self, End, Outcome, range_of};
use crate::turbid::BandScatter;

/// Largest relative L2 error of the light of a sun or of the sky that is said to have converged.
pub const MAX_L2: f64 = 1e-2;
/// Largest difference at any non-empty site of such light, relative to its mean.
pub const MAX_AT_A_SITE: f64 = 3e-2;
/// Largest energy imbalance of such light.
pub const MAX_IMBALANCE: f64 = 2e-2;
/// An error estimate may be too small by this factor ...
pub const MAX_UNDERESTIMATE: f64 = 4.0;
/// ... and by what places within sites lose in eight bits, and sums in f32, relative to all light.
pub const ROUNDING: f64 = 1e-3;

/// Largest step, relative to the light, at which the oracle has come to its end.
const REFERENCE_TOLERANCE: f64 = 1e-6;
const REFERENCE_STEPS: u32 = 20_000;
/// Fields that are held against the oracle where the suns are the lattice's: the sky, and one sun of each kind.
const COMPARED_SUNS: [u8; 3] = [4, 7, 18];
/// Bands that are held against it: so many, evenly over all of them.
const COMPARED_BANDS: usize = 3;

/// A solve with extreme matter, optics or settings.
pub struct Case {
    /// Name of the extreme, in a few words.
    pub name: &'static str,
    /// The matter.
    pub medium: TurbidMedium,
    /// Scattering by leaf and wood in each band.
    pub bands: Vec<BandScatter>,
    /// Settings of the solve.
    pub settings: OrdinatesSettings,
    /// End that the solve must have.
    pub end: End,
}

/// Errors and work measured on a case: the worst of all bands, errors of the light that was compared.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measured {
    /// Non-empty sites.
    pub sites: usize,
    /// Number of bands.
    pub bands: usize,
    /// Bands of which all light converged.
    pub converged: usize,
    /// Largest number of passes.
    pub passes: u32,
    /// Lights that were held against the oracle.
    pub compared: usize,
    /// Largest error estimate.
    pub error_estimate: f64,
    /// Largest L2 error against the oracle, relative to all light, the beam with it.
    pub relative_l2: f64,
    /// Largest difference at a non-empty site, relative to the mean of all light.
    pub worst_site: f64,
    /// Largest share of the light that is met and neither leaves nor is absorbed, without its sign.
    pub imbalance: f64,
    /// Largest error of the fit or the blend over suns that were held out, as the solver states it.
    pub suns_rms: Option<f64>,
    /// Smallest and largest fluence of the sky, and of suns that have fields of their own; NaN if any is not finite.
    pub range: [f32; 2],
}

/// Solves a case and holds it against the oracle.
pub fn run(case: &Case) -> Outcome<Measured, OrdinatesError> {
    let measured = measure(case);
    let faults = judge(case, &measured);
    Outcome { name: case.name, measured, faults }
}

fn measure(case: &Case) -> Result<Measured, OrdinatesError> {
    let Case { medium, bands, settings, .. } = case;
    let solution = solve(medium, bands, settings, &|_| Ok(()))?;
    let reports = &solution.reports;
    let with_fields = match settings.suns {
        SunBasis::Lattice18 | SunBasis::Directions(_) => solution.fields.len(),
        SunBasis::Harmonics { .. } => 1,
    };
    let mut measured = Measured {
        sites: medium.sites().len(),
        bands: bands.len(),
        converged: reports.iter().filter(|report| report.converged).count(),
        passes: reports.iter().map(|report| report.passes).max().unwrap_or(0),
        error_estimate: reports.iter().map(|report| report.error_estimate).fold(0.0, f64::max),
        suns_rms: reports.iter().filter_map(|report| report.suns_rms).reduce(f64::max),
        range: range_of(solution.fields[..with_fields].iter().flat_map(|(_, field)| field.values().to_vec())),
        ..Measured::default()
    };
    let compared = COMPARED_BANDS.min(bands.len());
    for at in 0..compared {
        let band = at * (bands.len() - 1) / (compared - 1).max(1);
        if reports[band].converged && measured.sites > 0 {
            compare(case, &solution, band, &mut measured);
        }
    }
    Ok(measured)
}

/// Holds the light of a band against the oracle.
fn compare(case: &Case, solution: &OrdinatesSolution, band: usize, measured: &mut Measured) {
    let Case { medium, bands, settings, .. } = case;
    let sites = medium.sites();
    let refined = (settings.parts > 1).then(|| Refined::new(medium, &sites));
    let (fine, fine_sites) = match &refined {
        Some(refined) => (&refined.medium, &refined.sites),
        None => (medium, &sites),
    };
    let moments =
        Band::new(fine, fine_sites, &bands[band], &Own { albedos: None, transmitted: None }).moments;
    let oracle = Reference::new(fine, fine_sites, &bands[band], settings.ordinates, settings.rays, moments);
    let none = vec![0.0; sites.len()];
    let mut hold = |item: usize, entering: Entering, direct: &[f32]| {
        let exact = oracle.solve(entering, REFERENCE_TOLERANCE, REFERENCE_STEPS);
        let of_parts: Vec<f32> = exact.fluence.iter().map(|fluence| *fluence as f32).collect();
        let expected: Vec<f64> = match &refined {
            Some(refined) => refined.means(&of_parts).iter().map(|mean| f64::from(*mean)).collect(),
            None => exact.fluence.clone(),
        };
        let field = &solution.fields[item].1;
        let found: Vec<f64> =
            sites.iter().map(|&site| f64::from(field.value(band as u32, site as usize))).collect();
        let (mut error, mut norm, mut worst, mut sum) = (0.0, 0.0, 0.0, 0.0);
        for ((found, exact), direct) in found.iter().zip(&expected).zip(direct) {
            let (step, all) = ((found - exact).abs(), exact + f64::from(*direct));
            (error, norm, sum) = (error + step * step, norm + all * all, sum + all);
            worst = f64::max(worst, step);
        }
        let relative = |error: f64, whole: f64| if error > 0.0 { error / whole } else { 0.0 };
        measured.compared += usize::from(exact.ended);
        measured.relative_l2 = measured.relative_l2.max(libm::sqrt(relative(error, norm)));
        measured.worst_site = measured.worst_site.max(relative(worst, sum / sites.len() as f64));
        let in_parts = match &refined {
            Some(refined) => refined.to_parts(&found),
            None => found,
        };
        measured.imbalance = measured.imbalance.max(exact.imbalance(&in_parts).abs());
    };
    hold(0, Entering::Sky, &none);
    if settings.suns != SunBasis::Lattice18 {
        return;
    }
    let plan = SolvePlan::new(settings);
    for item in COMPARED_SUNS.map(usize::from) {
        let sun = &plan.suns[item - 1..item];
        let beam: Beam = match &refined {
            Some(refined) => refined.beam(sun[0].towards),
            None => beams_of(&Near::new(medium, &sites, false), sun).remove(0).beam,
        };
        let direct = match &refined {
            Some(refined) => refined.means(&beam.mean),
            None => beam.mean.clone(),
        };
        hold(item, Entering::Beam(&beam), &direct);
    }
}

fn judge(case: &Case, measured: &Result<Measured, OrdinatesError>) -> Vec<String> {
    extremes::faults(case.end, measured, |found, faults| {
        faults.expect_light(found.range);
        faults.expect_converged(case.end, found.converged, found.bands);
        if case.end == End::Converges {
            let estimate = MAX_UNDERESTIMATE * found.error_estimate + ROUNDING;
            faults.expect_at_most([
                ("L2 error", found.relative_l2, MAX_L2),
                ("L2 error against the estimate", found.relative_l2, estimate),
                ("error at a site", found.worst_site, MAX_AT_A_SITE),
                ("energy imbalance", found.imbalance, MAX_IMBALANCE),
            ]);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_end_is_a_fault() {
        let all = cases();
        let tree = all.iter().find(|case| case.name == "a tree, green light").expect("a case of this name");
        let outcome = run(tree);
        assert!(outcome.faults.is_empty());
        let found = outcome.measured.unwrap();
        assert_eq!((found.compared, found.suns_rms), (4, None));
        let spoil = |change: &dyn Fn(&mut Measured)| {
            let mut spoilt = found.clone();
            change(&mut spoilt);
            judge(tree, &Ok(spoilt)).len()
        };
        assert_eq!(spoil(&|_| {}), 0);
        assert_eq!(spoil(&|m| m.range = [f32::NAN; 2]), 1);
        assert_eq!(spoil(&|m| m.range[0] = -1e-9), 1);
        assert_eq!(spoil(&|m| m.converged = 0), 1);
        assert_eq!(spoil(&|m| (m.relative_l2, m.error_estimate) = (9e-3, 1e-3)), 1);
        assert_eq!(spoil(&|m| m.worst_site = 0.1), 1);
        assert_eq!(spoil(&|m| m.imbalance = 0.1), 1);
        assert_eq!(judge(tree, &Err(OrdinatesError::Bands(0))).len(), 1);
    }

    /// The oracle finds what the solver gets wrong.
    #[test]
    fn light_of_another_medium_is_far_from_the_oracle() {
        let all = cases();
        let tree = all.iter().find(|case| case.name == "a tree, green light").expect("a case of this name");
        let mut denser = tree.medium.clone();
        denser.leaf_per_m.iter_mut().for_each(|per_m| *per_m *= 1.1);
        let solution = solve(&denser, &tree.bands, &tree.settings, &|_| Ok(())).unwrap();
        let mut measured = Measured { sites: 1, ..Measured::default() };
        compare(tree, &solution, 0, &mut measured);
        assert!(measured.relative_l2 > 1e-2 && measured.imbalance > 1e-3, "{measured:?}");
    }
}
