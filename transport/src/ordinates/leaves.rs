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

    /// Light of a beam along `from` that leaves send along `to` (unit vectors of travel) where they absorb nothing:
    /// through them, and back from them. `None` where they favour no inclination.
    pub(super) fn of_facets(&self, from: [f64; 3], to: [f64; 3]) -> Option<[f64; 2]> {
        self.facets.as_ref().map(|facets| facets.scattered(from, to))
    }

    /// Light of a beam along `from` that matter scatters into `to`, relative to its extinction along `to`, up to a
    /// factor for each `from`; of leaves by what [`of_facets`](Self::of_facets) gave.
    pub(super) fn scattered(
        &self,
        phase: Phase,
        of_facets: Option<[f64; 2]>,
        from: [f64; 3],
        to: [f64; 3],
    ) -> f64 {
        match (phase, of_facets) {
            (Phase::BiLambert { transmitted }, Some([through, back])) => {
                (transmitted * through + (1.0 - transmitted) * back) / self.relative(to)
            }
            _ => phase.at(from[0] * to[0] + from[1] * to[1] + from[2] * to[2]),
        }
    }
}
