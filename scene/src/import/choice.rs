//! Which nodes or groups of a file are read: patterns of their names.

use std::cell::RefCell;

use super::error::{ImportError, quoted};
use crate::mesh::Part;
use crate::name_pattern::NamePattern;

/// Where patterns of nodes come from, for messages.
const ORIGIN: &str = "--node";

/// Nodes that a message lists.
const LISTED: usize = 20;

/// Patterns of names (globs, any case), and which of them have matched so far.
pub(super) struct Choice {
    patterns: Vec<NamePattern>,
    matched: RefCell<Vec<bool>>,
}

impl Choice {
    /// From patterns; without any, everything is read.
    ///
    /// # Errors
    /// [`ImportError::BadPattern`].
    pub(super) fn compile(patterns: &[String]) -> Result<Choice, ImportError> {
        let patterns = patterns.iter().map(|pattern| compile(pattern)).collect::<Result<Vec<_>, _>>()?;
        Ok(Choice { matched: RefCell::new(vec![false; patterns.len()]), patterns })
    }

    /// Whether there is a pattern.
    pub(super) fn is_made(&self) -> bool {
        !self.patterns.is_empty()
    }

    /// Whether a pattern means one of the names; remembers which.
    pub(super) fn means<'n>(&self, names: impl Iterator<Item = &'n str>) -> bool {
        let mut any = false;
        for name in names {
            for (pattern, matched) in self.patterns.iter().zip(self.matched.borrow_mut().iter_mut()) {
                if pattern.matches(name) {
                    *matched = true;
                    any = true;
                }
            }
        }
        any
    }

    /// Whether every pattern has matched.
    pub(super) fn is_met(&self) -> bool {
        self.matched.borrow().iter().all(|matched| *matched)
    }

    /// An error for a pattern that has matched nothing. `names` are those that it could have.
    ///
    /// # Errors
    /// [`ImportError::UnknownNode`].
    pub(super) fn check(&self, file: &str, names: impl Iterator<Item = String>) -> Result<(), ImportError> {
        let Some(at) = self.matched.borrow().iter().position(|matched| !matched) else { return Ok(()) };
        let mut listed: Vec<String> = Vec::new();
        let mut more = 0;
        for name in names {
            match listed.len() < LISTED {
                true => listed.push(format!("'{}'", quoted(&name))),
                false => more += 1,
            }
        }
        if more > 0 {
            listed.push(format!("and {more} more"));
        }
        let nodes = if listed.is_empty() { "none".to_owned() } else { listed.join(", ") };
        let pattern = quoted(self.patterns[at].text());
        Err(ImportError::UnknownNode { file: file.to_owned(), pattern, nodes })
    }
}

/// What is no glob may be a name.
fn compile(text: &str) -> Result<NamePattern, ImportError> {
    match NamePattern::compile(text) {
        Err(_) if text.contains(['[', '{', '\\']) => Ok(NamePattern::exactly(text)),
        compiled => compiled.map_err(|error| ImportError::BadPattern {
            origin: ORIGIN.to_owned(),
            pattern: text.to_owned(),
            reason: error.kind().to_string(),
        }),
    }
}

/// The labels of parts, for messages.
pub(super) fn labels(parts: &[Part]) -> impl Iterator<Item = String> + '_ {
    parts.iter().map(Part::label)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_met_in_any_case_by_globs_and_as_they_are() {
        let choice = Choice::compile(&["oak_LOD0".to_owned(), "Twig*".to_owned(), "a[b".to_owned()]).unwrap();
        assert!(choice.is_made() && !choice.is_met());
        assert!(choice.means(["Oak_lod0"].into_iter()) && choice.means(["x", "twigs"].into_iter()));
        assert!(!choice.means(["Oak_LOD1"].into_iter()));
        let error = choice.check("a.glb", ["Oak_LOD1".to_owned()].into_iter()).unwrap_err().to_string();
        assert_eq!(error, "a.glb: --node 'a[b' means no node or group; there are: 'Oak_LOD1'");
        assert!(choice.means(["A[b"].into_iter()) && choice.is_met());
        assert!(choice.check("a.glb", std::iter::empty()).is_ok());
        assert!(!Choice::compile(&[]).unwrap().is_made());
    }
}
