//! Outcomes -> the markdown table of docs/extremes.md.

use super::LIMITS;
use crate::ends::{Limits, Outcome, short};

/// Header of the table of outcomes.
pub const HEADER: &str = "\
| case | sites | bands converged | passes | estimate | L2 error | worst site | imbalance | suns | fluence from | to | verdict |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---|
";

/// Formats one outcome as a row, with its line end.
pub fn row(outcome: &Outcome) -> String {
    let (Outcome { name, measured, .. }, verdict) = (outcome, outcome.verdict());
    match measured {
        Err(error) => {
            format!("| {name} | | | | | | | | | | | refused, {verdict}: {} |\n", short(error))
        }
        Ok(found) => {
            let [low, high] = found.range;
            let errors = [found.relative_l2, found.worst_site, found.imbalance];
            let [l2, worst, imbalance] =
                errors.map(|error| if found.compared > 0 { format!("{error:.1e}") } else { String::new() });
            let suns = found.suns_rms.map_or(String::new(), |rms| format!("{rms:.1e}"));
            let ended = if found.converged == 0 { "gave up, " } else { "" };
            format!(
                "| {name} | {} | {} of {} | {} | {:.1e} | {l2} | {worst} | {imbalance} | {suns} | {low:.1e} | {high:.1e} | {ended}{verdict} |\n",
                found.sites, found.converged, found.solves, found.iterations, found.error_estimate,
            )
        }
    }
}

/// Describes the columns and the limits that are asked of them.
pub fn legend() -> String {
    let Limits { l2, at_a_site, imbalance, underestimate, rounding } = LIMITS;
    format!(
        "\
Unless a row says otherwise, the suns are those of `lattice18`, the ordinates 50, and leaf and wood those of green light. The
worst of all bands stands in the table. Estimate: relative error of the scattered light, as the solver states it. L2 error
and worst site: against the same rays in f64, solved to the end by plain steps, of the sky and of three suns, where suns have
fields of their own; relative to all light, the beam with it, and to its mean. Imbalance: light that is met and neither leaves
nor is absorbed, as a share. Suns: error of the fit or the blend under suns that were held out, as the solver states it, of the
mean fluence. Asked of a case that must converge: L2 error up to {l2:.0e}, and up to {underestimate} times the estimate and {rounding:.0e};
worst site up to {at_a_site:.0e}; imbalance up to {imbalance:.0e}. Of every case that is solved: fluence finite and never below 0.
"
    )
}
