//! Outcomes -> the markdown table of docs/extremes.md.

use super::LIMITS;
use crate::ends::{Limits, Outcome, short};

/// Header of the table of outcomes.
pub const HEADER: &str = "\
| case | sites | converged | sweeps | estimate | L2 error | worst site | imbalance | phi from | to | verdict |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---|
";

/// Formats one outcome as a row, with its line end.
pub fn row(outcome: &Outcome) -> String {
    let (Outcome { name, measured, .. }, verdict) = (outcome, outcome.verdict());
    match measured {
        Err(error) => {
            format!("| {name} | | | | | | | | | | refused, {verdict}: {} |\n", short(error))
        }
        Ok(found) => {
            let [low, high] = found.range;
            let errors = match found.compared {
                0 => ["".to_owned(), "".to_owned()],
                _ => [found.relative_l2, found.worst_site].map(|error| format!("{error:.1e}")),
            };
            let ended = if found.converged == 0 && found.solves > 0 { "gave up, " } else { "" };
            format!(
                "| {name} | {} | {} of {} | {} | {:.1e} | {} | {} | {:.1e} | {low:.1e} | {high:.1e} | {ended}{verdict} |\n",
                found.sites,
                found.converged,
                found.solves,
                found.iterations,
                found.error_estimate,
                errors[0],
                errors[1],
                found.imbalance,
            )
        }
    }
}

/// Describes the columns and the limits that are asked of them.
pub fn legend() -> String {
    let Limits { l2, at_a_site, imbalance, underestimate, .. } = LIMITS;
    format!(
        "\
Every case is solved for 19 bases in all its bands, with default settings. The worst of all of them stands in the table.
Converged: solves, of all, whose estimated error reached the tolerance. L2 error (over the non-empty sites, relative) and worst site:
against the fixed point in f64, of one base of each kind in up to three bands. Imbalance: light that entered and neither left nor was
absorbed, as a share. Asked of a case that must converge: L2 error up to {l2:.0e}, and up to {underestimate} times the estimate; worst
site up to {at_a_site:.0e}; imbalance up to {imbalance:.0e}. Of every case that is solved: phi finite and never below 0.
"
    )
}
