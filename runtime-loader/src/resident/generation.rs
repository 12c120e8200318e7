//! When terms that a renderer keeps are no longer those of the species.

use super::ResidentSpecies;
use crate::base::Base;
use crate::residency::UnitKind;

impl ResidentSpecies {
    /// Number that changes whenever terms of the species do: when a base or the extinction comes or goes, a base
    /// becomes whole or is no longer, and each frame while something is blended in.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Whether the base of a page of detail has all of it.
    pub(super) fn is_whole(&self, kind: UnitKind) -> Option<bool> {
        let UnitKind::Detail { base, .. } = kind else { return None };
        Some(self.bases[usize::from(base)].as_ref().is_some_and(Base::is_whole))
    }

    /// Counts a unit that came or went, if terms change by it.
    pub(super) fn changed(&mut self, kind: UnitKind, was_whole: Option<bool>) {
        let changes_terms = match kind {
            UnitKind::Shared => false,
            UnitKind::Extinction | UnitKind::Averages { .. } => true,
            UnitKind::Detail { .. } => self.is_whole(kind) != was_whole,
        };
        self.generation += u64::from(changes_terms);
    }
}
