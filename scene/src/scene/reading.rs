//! Checks of what a scene file says, every refusal with the line that it is about.

use std::path::Path;

use super::parts::Parts;
use crate::import::ImportError;

/// Largest magnitude of a coordinate, metres.
pub(crate) const MAX_COORDINATE_M: f64 = 1e9;

/// What messages and paths need to know.
#[derive(Clone, Copy)]
pub(super) struct Reading<'a> {
    pub file: &'a str,
    pub folder: &'a Path,
    pub text: &'a str,
    /// Map of places in the text to the rest, where that is parsed alone.
    pub parts: Option<&'a Parts<'a>>,
}

pub(super) type Checked<T> = Result<T, ImportError>;

impl Reading<'_> {
    /// Every coordinate within its limit.
    pub(super) fn points(&self, at: usize, what: &str, points: &[[f64; 3]]) -> Checked<()> {
        points.iter().flatten().try_for_each(|coordinate| {
            self.within(at, what, *coordinate, -MAX_COORDINATE_M, MAX_COORDINATE_M).map(drop)
        })
    }

    pub(super) fn within(&self, at: usize, what: &str, value: f64, low: f64, high: f64) -> Checked<f64> {
        match (low..=high).contains(&value) {
            true => Ok(value),
            false => Err(self.malformed(at, what, value.to_string(), &format!("{low} to {high}"))),
        }
    }

    pub(super) fn malformed(
        &self,
        at: usize,
        what: &str,
        found: impl Into<String>,
        expected: &str,
    ) -> ImportError {
        ImportError::Malformed {
            file: self.file.to_owned(),
            place: format!("line {}, {what}", self.line(at)),
            found: found.into(),
            expected: expected.to_owned(),
        }
    }

    pub(super) fn limit(&self, what: &str, found: usize, limit: usize) -> Checked<()> {
        if found <= limit {
            return Ok(());
        }
        let (file, what) = (self.file.to_owned(), what.to_owned());
        Err(ImportError::Limit { file, what, found: found as u64, limit: limit as u64 })
    }

    /// The line that holds a byte, from 1.
    pub(super) fn line(&self, at: usize) -> usize {
        let at = self.parts.map_or(at, |parts| parts.place(at));
        1 + self.text.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count()
    }
}
