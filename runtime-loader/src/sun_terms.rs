//! What the direction of a sun gives each basis of a species: the one place where the kinds of suns are told apart.
//! Samplers, streamed light and the terms of GPUs all take it from here.

use std::ops::Range;
use std::sync::Arc;

use flb_format::light::{Light, SunBasis};
use flb_format::matter::LeafAngles;
use flb_format::model::Model;
use flb_format::sun::harmonics::{self, MAX_DEGREE};

/// Most bases of a sun beside the near beam's: harmonics of the highest degree.
pub(crate) const MAX_BASES: usize = harmonics::count(MAX_DEGREE);

/// Dependence of a species' light on the sun.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SpeciesSuns {
    basis: SunBasis,
    /// Where the near beam leans with them.
    angles: Option<Arc<LeafAngles>>,
}

impl SpeciesSuns {
    pub(crate) fn of(model: &Model) -> SpeciesSuns {
        let basis = model.suns().clone();
        let of = |light: &Light| Arc::new(light.leaf_angles.clone());
        let angles = model.physical().filter(|_| basis.is_leaning()).map(|(_, light)| of(light));
        SpeciesSuns { basis, angles }
    }

    pub(crate) fn basis(&self) -> &SunBasis {
        &self.basis
    }

    /// How often the near beam of a sun along a unit vector counts.
    pub(crate) fn near_factor(&self, unit: [f64; 3]) -> f32 {
        self.angles.as_ref().map_or(1.0, |angles| angles.relative(unit[1]) as f32)
    }
}

/// Factors that a sun of irradiance 1 gives each basis; for those of the near beam, times a mean that differs from
/// point to point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunTerms {
    /// Unit vector towards the sun, model space.
    pub towards_sun: [f64; 3],
    bases: [u8; MAX_BASES],
    factors: [f32; MAX_BASES],
    len: u8,
    /// First basis of the near beam, and the one behind its last.
    near: [u8; 2],
    near_factor: f32,
}

impl SunTerms {
    /// For a sun along `towards_sun` (model space, any length); `None` where that is zero or not finite.
    pub(crate) fn of(suns: &SpeciesSuns, towards_sun: [f64; 3]) -> Option<SunTerms> {
        SunTerms::with(suns, towards_sun, unit(towards_sun)?)
    }

    /// For a sun along a vector that is of unit length, which stays as it is to the bit.
    pub(crate) fn of_unit(suns: &SpeciesSuns, unit: [f64; 3]) -> Option<SunTerms> {
        SunTerms::with(suns, unit, unit)
    }

    fn with(suns: &SpeciesSuns, towards_sun: [f64; 3], unit: [f64; 3]) -> Option<SunTerms> {
        let mut terms = SunTerms {
            towards_sun: unit,
            bases: [0; MAX_BASES],
            factors: [0.0; MAX_BASES],
            len: 0,
            near: [0; 2],
            near_factor: suns.near_factor(unit),
        };
        let suns = &suns.basis;
        match suns {
            SunBasis::Harmonics { degree, .. } => {
                if !unit.iter().all(|c| c.is_finite()) || unit == [0.0; 3] {
                    return None;
                }
                let values = harmonics::evaluate(unit);
                (1..).zip(&values[..harmonics::count(*degree)]).for_each(|(base, y)| {
                    terms.push(base, *y as f32);
                });
            }
            SunBasis::Lattice18 | SunBasis::Directions(_) => {
                let blend = suns.blend(towards_sun)?;
                for (base, weight) in blend.bases.into_iter().zip(blend.weights) {
                    // A basis without weight is not needed, and may be missing.
                    if weight != 0.0 {
                        terms.push(base, weight);
                    }
                }
            }
        }
        let near = near_bases(suns);
        terms.near = [near.start, near.end];
        Some(terms)
    }

    fn push(&mut self, base: u8, factor: f32) {
        self.bases[usize::from(self.len)] = base;
        self.factors[usize::from(self.len)] = factor;
        self.len += 1;
    }

    /// Bases and their factors, in the order in which they are added up.
    pub fn bases(&self) -> impl ExactSizeIterator<Item = (u8, f32)> {
        let len = usize::from(self.len);
        self.bases[..len].iter().copied().zip(self.factors[..len].iter().copied())
    }

    /// Bases whose factors are the means of the near beam, times [`SunTerms::near_factor`], in their order; empty where
    /// the species needs none.
    pub fn near_bases(&self) -> Range<u8> {
        self.near[0]..self.near[1]
    }

    /// How often the near beam counts.
    pub fn near_factor(&self) -> f32 {
        self.near_factor
    }
}

/// A direction of any length as one of unit length; `None` where it is zero or not finite.
pub(crate) fn unit(direction: [f64; 3]) -> Option<[f64; 3]> {
    // Scaled first, so that neither tiny nor huge vectors lose their direction.
    let longest = direction.iter().fold(0.0, |longest: f64, c| longest.max(c.abs()));
    if longest == 0.0 || !direction.iter().all(|c| c.is_finite()) {
        return None;
    }
    let scaled = direction.map(|c| c / longest);
    let length = libm::sqrt(scaled.iter().map(|c| c * c).sum());
    Some(scaled.map(|c| c / length))
}

/// Bases of the near beam; empty where the species needs none.
pub(crate) fn near_bases(suns: &SunBasis) -> Range<u8> {
    suns.first_near_item().map_or(0..0, |first| first..suns.items() as u8)
}

#[cfg(test)]
mod tests {
    use flb_format::sun;

    use super::*;

    fn plain(basis: SunBasis) -> SpeciesSuns {
        SpeciesSuns { basis, angles: None }
    }

    #[test]
    fn a_blend_has_its_weights_and_harmonics_their_values_and_near_bases() {
        let direction = [0.48, 0.6, -0.64];
        let blend = sun::blend(direction).expect("a direction");
        let terms = SunTerms::of_unit(&plain(SunBasis::Lattice18), direction).expect("a direction");
        let expected: Vec<_> =
            blend.bases.into_iter().zip(blend.weights).filter(|(_, w)| *w != 0.0).collect();
        assert_eq!((terms.bases().collect::<Vec<_>>(), terms.near_bases()), (expected, 0..0));
        let up = SunTerms::of(&plain(SunBasis::Lattice18), [0.0, 2.0, 0.0]).expect("a direction");
        assert_eq!(up.bases().collect::<Vec<_>>(), [(4, 1.0)], "those without weight are left out");
        for (degree, single, near) in
            [(1, false, 5..9), (2, false, 10..14), (2, true, 10..13), (3, true, 17..20)]
        {
            let suns = plain(SunBasis::Harmonics { degree, single, leaning: false });
            let terms = SunTerms::of_unit(&suns, direction).expect("a direction");
            let values = harmonics::evaluate(direction);
            let expected: Vec<_> =
                (1..).zip(&values[..harmonics::count(degree)]).map(|(base, y)| (base, *y as f32)).collect();
            assert_eq!((terms.bases().collect::<Vec<_>>(), terms.near_bases()), (expected, near));
            assert_eq!(terms.near_factor(), 1.0);
        }
    }

    #[test]
    fn a_near_beam_that_leans_counts_as_often_as_leaves_meet_it() {
        let basis = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
        let suns = SpeciesSuns { basis, angles: Some(Arc::new(LeafAngles::planophile())) };
        let factor = |sun| SunTerms::of(&suns, sun).expect("a direction").near_factor();
        let [up, level] = [factor([0.0, 3.0, 0.0]), factor([-2.0, 0.0, 0.0])];
        assert!((1.5..1.9).contains(&up) && (0.4..0.6).contains(&level), "{up}, {level}");
        assert_eq!(factor([0.0, -1.0, 0.0]), up);
    }

    #[test]
    fn what_is_no_direction_has_no_terms() {
        for suns in [SunBasis::Lattice18, SunBasis::Harmonics { degree: 2, single: true, leaning: false }] {
            let suns = plain(suns);
            for none in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
                assert_eq!(SunTerms::of(&suns, none), None, "{suns:?} {none:?}");
                assert_eq!(SunTerms::of_unit(&suns, none), None, "{suns:?} {none:?}");
            }
        }
    }
}
