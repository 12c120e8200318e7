//! Does a file keep every promise of SPEC.md? Four levels, each holding the ones before it.

use flb_format::error::ErrorClass;
use flb_format::{FormatError, Source};
use serde::Serialize;

pub use flb_format::container::verify::{Level, check};

/// The verdict on a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Report {
    /// Whether every promise of the level was kept.
    pub valid: bool,
    /// Broken promises, the first alone; empty for a valid file.
    pub issues: Vec<Issue>,
    /// Class of the fault, for the exit code; `None` for a valid file.
    #[serde(skip)]
    pub class: Option<ErrorClass>,
}

/// One broken promise.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Issue {
    /// "FLB-1003".
    pub code: String,
    /// Place of the fault: "page 17 of base 4 of species 0 at byte 81920".
    pub place: String,
    /// Value that was read and what was expected, with code and place.
    pub message: String,
}

impl Report {
    /// The verdict that an outcome of [`check`] stands for.
    pub fn of(outcome: Result<(), FormatError>) -> Report {
        match outcome {
            Ok(()) => Report { valid: true, issues: Vec::new(), class: None },
            Err(error) => {
                let place = error.place().map(|place| place.to_string()).unwrap_or_default();
                let issue =
                    Issue { code: format!("FLB-{}", error.code()), place, message: error.to_string() };
                Report { valid: false, issues: vec![issue], class: Some(error.class()) }
            }
        }
    }
}

/// Checks a file up to a level and stops at the first broken promise.
pub fn validate(source: &dyn Source, level: Level) -> Report {
    Report::of(check(source, level))
}

#[cfg(test)]
mod tests;
