//! Leaves of a medium, as beams meet them: those that favour an inclination meet more of a beam that comes across them,
//! and send it on across them, too.

use crate::turbid::{Facets, LeafAngles, Phase};

/// Leaves of a medium.
pub(super) struct Leaves {
    angles: LeafAngles,
    /// Unless they favour no inclination.
    facets: Option<Facets>,
}

impl Leaves {
    pub(super) fn new(angles: &LeafAngles) -> Leaves {
        Leaves { angles: angles.clone(), facets: Facets::new(angles) }
    }

    /// Extinction by leaves along a direction, relative to the mean over all.
    pub(super) fn relative(&self, direction: [f64; 3]) -> f64 {
        if self.facets.is_some() { self.angles.relative(direction[1]) } else { 1.0 }
    }

    /// What matter scatters of a beam along `from` into `to` (unit vectors of travel), relative to its extinction along
    /// `to`, up to a factor for each `from`.
    pub(super) fn scattered(&self, phase: Phase, is_leaf: bool, from: [f64; 3], to: [f64; 3]) -> f64 {
        match (phase, &self.facets) {
            (Phase::BiLambert { transmitted }, Some(facets)) if is_leaf => {
                let [through, back] = facets.scattered(from, to);
                (transmitted * through + (1.0 - transmitted) * back) / self.relative(to)
            }
            _ => phase.at(from[0] * to[0] + from[1] * to[1] + from[2] * to[2]),
        }
    }
}
