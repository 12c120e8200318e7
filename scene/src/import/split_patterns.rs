//! Patterns of a material in a part, `MATERIAL@PART`: the way to say that one material is leaf here and wood there.

use super::error::ImportError;
use crate::mesh::Part;
use crate::name_pattern::NamePattern;

/// Parts the pattern of a material's name from that of a part's.
const AT: char = '@';

/// Most patterns: a bit each.
const MAX_PATTERNS: usize = 64;

/// Patterns with an `@`.
pub(super) struct SplitPatterns {
    patterns: Vec<Pattern>,
}

struct Pattern {
    material: NamePattern,
    part: NamePattern,
}

impl Pattern {
    fn compile(text: &str) -> Option<Pattern> {
        let (material, part) = text.rsplit_once(AT)?;
        Some(Pattern {
            material: NamePattern::compile(material).ok()?,
            part: NamePattern::compile(part).ok()?,
        })
    }

    fn is_met(&self, material: &str, part: &Part) -> bool {
        self.material.matches(material) && self.is_part(part)
    }

    fn is_part(&self, part: &Part) -> bool {
        let number = part.node.map(|node| format!("#{node}"));
        part.names.iter().chain(&number).any(|name| self.part.matches(name))
    }
}

impl SplitPatterns {
    /// Of patterns that have an `@`; others, and what is no glob, split nothing.
    ///
    /// # Errors
    /// [`ImportError::Setting`] for more than 64.
    pub(super) fn compile(patterns: &[String]) -> Result<SplitPatterns, ImportError> {
        let patterns: Vec<Pattern> =
            patterns.iter().filter_map(|pattern| Pattern::compile(pattern)).collect();
        match patterns.len() <= MAX_PATTERNS {
            true => Ok(SplitPatterns { patterns }),
            false => Err(ImportError::Setting {
                name: "patterns of a material in a part (MATERIAL@PART)",
                found: patterns.len().to_string(),
                expected: "at most 64",
            }),
        }
    }

    /// Which patterns a material meets in a part, a bit each.
    pub(super) fn met(&self, material: &str, part: &Part) -> u64 {
        let met = self.patterns.iter().enumerate().filter(|(_, pattern)| pattern.is_met(material, part));
        met.fold(0, |bits, (at, _)| bits | 1 << at)
    }
}

/// Whether a text is a pattern of a material in a part.
pub fn splits(pattern: &str) -> bool {
    pattern.contains(AT)
}

/// Whether a pattern `MATERIAL@PART` means a material by its name and by the parts that use it: after the split it is
/// in all of them or in none.
pub fn is_met_by<'p>(pattern: &str, material: &str, mut parts: impl Iterator<Item = &'p Part>) -> bool {
    Pattern::compile(pattern)
        .is_some_and(|pattern| pattern.material.matches(material) && parts.any(|part| pattern.is_part(part)))
}
