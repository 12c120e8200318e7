//! What a bake tells while it works. The library prints nothing.

use std::fmt;

use flb_format::bases::BaseSet;
use flb_format::light::SunBasis;
use flb_scene::{Observer, Step, Unobserved};
use serde::Serialize;

/// Observer of a bake, who hears its events as well. Without a method of its own, each is a note.
pub trait BakeObserver: Observer {
    /// Called with what a user should know.
    fn hear(&self, event: &Event) {
        self.note(&event.to_string());
    }
}

impl BakeObserver for Unobserved {}

/// Event of a bake. As text, one sentence for a user.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// A result was taken from the store.
    Reused {
        /// The step.
        step: Step,
        /// Name of the species.
        species: String,
    },
    /// A result had to be made although the store has one of the same species: these parts of its key are others than
    /// last time.
    Changed {
        /// The step.
        step: Step,
        /// Name of the species.
        species: String,
        /// Names of the parts.
        parts: Vec<String>,
    },
    /// The matter of a plant is known, and with it how much memory its light will take.
    Matter {
        /// Name of the species.
        species: String,
        /// Sites with matter.
        sites: u64,
    },
    /// All fields are baked, though fewer were wanted: these suns cannot do without one.
    NeedsAll {
        /// Name of the species.
        species: String,
        /// Dependence of the fields on the sun.
        suns: SunBasis,
        /// Bases that `lattice18` would leave out.
        left_out: BaseSet,
    },
    /// A solve that ended before it met its tolerance.
    NotConverged {
        /// Name of the species.
        species: String,
        /// Solves that did not converge, in words.
        what: String,
    },
    /// The solves of a species ended.
    Solved(SolveSummary),
    /// Suns that Monte Carlo cannot judge, as the bases that they need are left out.
    SunsNotTraced {
        /// Name of the species.
        species: String,
        /// Number of suns that are not traced.
        left: usize,
        /// Number of all suns.
        of: usize,
    },
    /// The fields were compared with Monte Carlo.
    Judged {
        /// Name of the species.
        species: String,
        /// Error of the fields, in words.
        what: String,
    },
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Event::Reused { step, species } => write!(f, "{species}: {} from the cache", step.name()),
            Event::Changed { step, species, parts } => {
                let parts = parts.join(", ");
                write!(f, "{species}: {} is redone, as the last bake had other: {parts}", step.name())
            }
            Event::Matter { species, sites } => write!(f, "{species}: {sites} sites have matter"),
            Event::NeedsAll { species, suns, left_out } => write!(
                f,
                "{species}: {}, so all are baked; with --suns lattice18 this plan would leave out bases {}",
                why_whole(suns),
                base_list(*left_out)
            ),
            Event::NotConverged { species, what } => write!(f, "warning: {species}: {what}"),
            Event::Solved(summary) => {
                write!(f, "{}: {} of {} solves converged", summary.species, summary.converged, summary.solves)
            }
            Event::SunsNotTraced { species, left, of } => {
                write!(
                    f,
                    "{species}: {left} of {of} suns are not traced: the plan leaves out bases that they need"
                )
            }
            Event::Judged { species, what } => write!(f, "{species}: {what}"),
        }
    }
}

/// Returns the reason why fields of these suns cannot be left out (SPEC.md, M38).
pub fn why_whole(suns: &SunBasis) -> &'static str {
    match suns {
        SunBasis::Directions(_) => "a list of directions is stored whole",
        _ => "every sun needs all fields of harmonics",
    }
}

/// Formats a set of bases as "3 7 10", or "none".
pub fn base_list(bases: BaseSet) -> String {
    match bases.is_empty() {
        true => "none".to_owned(),
        false => bases.iter().map(|base| base.to_string()).collect::<Vec<_>>().join(" "),
    }
}

/// Result of the solves of one species. Numbers are the worst of all bases and bands, null where the fields came from
/// the store.
#[derive(Serialize, Debug, Clone, PartialEq)]
pub struct SolveSummary {
    /// Name of the species.
    pub species: String,
    /// sweep, explicit, literal, gpu, ordinates.
    pub solver: &'static str,
    /// Whether an earlier bake solved it.
    pub cached: bool,
    /// Bases times bands.
    pub solves: usize,
    /// Solves whose estimated error reached the tolerance.
    pub converged: usize,
    /// Sweeps, iterations or passes.
    pub sweeps: Option<u32>,
    /// Relative L2 change of phi in the last sweep.
    pub residual: Option<f64>,
    /// Estimated relative L2 error of phi over the non-empty sites.
    pub error_estimate: Option<f64>,
}
