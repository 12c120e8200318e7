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
use crate::ends::{End, Limits, Measured, Outcome, compared_bands, range_of};
use crate::turbid::BandScatter;

/// Limits of the light of suns and of the sky that is said to have converged. Rounding is what places within sites lose
/// in eight bits, and sums in f32.
pub(crate) const LIMITS: Limits =
    Limits { l2: 1e-2, at_a_site: 3e-2, imbalance: 2e-2, underestimate: 4.0, rounding: 1e-3 };

/// Largest step, relative to the light, at which the oracle has come to its end.
const REFERENCE_TOLERANCE: f64 = 1e-6;
const REFERENCE_STEPS: u32 = 20_000;
/// Fields that are held against the oracle where the suns are the lattice's: the sky, and one sun of each kind.
const COMPARED_SUNS: [u8; 3] = [4, 7, 18];

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

/// Solves a case and holds it against the oracle.
pub fn run(case: Case) -> Outcome {
    Outcome::new(case.name, case.end, measure(&case), &LIMITS)
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
        solves: bands.len(),
        converged: reports.iter().filter(|report| report.converged).count(),
        iterations: reports.iter().map(|report| report.passes).max().unwrap_or(0),
        error_estimate: reports.iter().map(|report| report.error_estimate).fold(0.0, f64::max),
        suns_rms: reports.iter().filter_map(|report| report.suns_rms).reduce(f64::max),
        range: range_of(solution.fields[..with_fields].iter().flat_map(|(_, field)| field.values().to_vec())),
        ..Measured::default()
    };
    for band in compared_bands(bands.len()) {
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

#[cfg(test)]
mod tests {
    use super::*;

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
