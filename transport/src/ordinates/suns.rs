//! Which suns are solved.

use flb_format::direction::{DIRECTIONS, MOVING};

use super::fit::Sun;
use super::{OrdinatesSettings, SunBasis, whole_lanes};
use flb_format::ordinates::Ordinates;

/// Suns that a fit or a blend is judged by: they stand between every axis and its neighbours, and at most one of them
/// near a sun that fields are made from.
const JUDGES: [[f64; 3]; 6] = [
    [0.48, 0.64, 0.6],
    [-0.31, 0.87, 0.38],
    [-0.79, 0.21, -0.57],
    [0.22, 0.43, -0.87],
    [0.91, -0.28, 0.31],
    [-0.13, -0.62, 0.77],
];

/// Fewest of them.
const MIN_JUDGES: usize = 3;

/// The suns of a solve: first those that fields are made from, then those held out.
pub(super) struct SolvePlan {
    pub suns: Vec<Sun>,
    fitted: usize,
}

impl SolvePlan {
    pub(super) fn new(settings: &OrdinatesSettings) -> SolvePlan {
        let fitted: Vec<Sun> = match &settings.suns {
            SunBasis::Lattice18 => {
                let wanted = |(base, _): &(u8, Sun)| settings.bases.contains(*base);
                (1..).zip(lattice()).filter(wanted).map(|(_, sun)| sun).collect()
            }
            SunBasis::Harmonics { degree: 0..=1, .. } => cube(),
            SunBasis::Harmonics { .. } => {
                let sun = |o: super::Ordinate| Sun { towards: o.direction, weight: o.weight };
                Ordinates::Lebedev50.directions().into_iter().map(sun).collect()
            }
            SunBasis::Directions(list) => {
                let weight = 1.0 / list.directions().len() as f64;
                list.directions().iter().map(|&towards| Sun { towards, weight }).collect()
            }
        };
        let count = fitted.len();
        // Lanes that would be idle, but for the sky's, are free.
        let spare = match settings.suns {
            SunBasis::Lattice18 => 0,
            _ => (whole_lanes(count + 1 + MIN_JUDGES) - count - 1).min(JUDGES.len()),
        };
        let judges = JUDGES[..spare].iter().map(|&towards| Sun { towards: unit(towards), weight: 0.0 });
        SolvePlan { suns: fitted.into_iter().chain(judges).collect(), fitted: count }
    }

    /// The suns of a plan that are held out, alone.
    pub(super) fn held_out_of(plan: &SolvePlan) -> SolvePlan {
        SolvePlan { suns: plan.suns[plan.fitted..].to_vec(), fitted: 0 }
    }

    /// How many of the suns fields are made from.
    pub(super) fn fitted(&self) -> usize {
        self.fitted
    }

    /// How many are held out.
    pub(super) fn held_out(&self) -> usize {
        self.suns.len() - self.fitted
    }
}

/// Suns whose light travels along the lattice's directions, in their order.
fn lattice() -> Vec<Sun> {
    let sun =
        |m: usize| Sun { towards: unit(DIRECTIONS[m].map(|c| f64::from(-c))), weight: 1.0 / MOVING as f64 };
    (1..=MOVING).map(sun).collect()
}

/// Towards the faces, edges and corners of a cube: Lebedev's rule of 26 points, exact to degree 7.
fn cube() -> Vec<Sun> {
    const WEIGHTS: [f64; 4] = [0.0, 1.0 / 21.0, 4.0 / 105.0, 9.0 / 280.0];
    let mut suns = Vec::new();
    for x in [-1.0, 0.0, 1.0] {
        for y in [-1.0, 0.0, 1.0] {
            for z in [-1.0_f64, 0.0, 1.0] {
                let axes = [x, y, z].iter().filter(|c| **c != 0.0).count();
                if axes > 0 {
                    suns.push(Sun { towards: unit([x, y, z]), weight: WEIGHTS[axes] });
                }
            }
        }
    }
    suns
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = libm::sqrt(v.iter().map(|c| c * c).sum());
    v.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ordinates::{ico12, ico42};
    use flb_format::bases::BaseSet;
    use flb_format::sun::harmonics;

    fn plan(suns: SunBasis) -> SolvePlan {
        SolvePlan::new(&OrdinatesSettings { suns, ..OrdinatesSettings::default() })
    }

    #[test]
    fn suns_of_a_fit_integrate_the_products_of_its_harmonics() {
        for (degree, suns) in [(1, 26), (2, 50), (3, 50)] {
            let plan = plan(SunBasis::Harmonics { degree, single: false, leaning: false });
            assert_eq!(plan.fitted(), suns);
            assert!(plan.held_out() >= 5);
            for a in 0..harmonics::count(degree) {
                for b in 0..=a {
                    let of = |sun: &Sun| {
                        let y = harmonics::evaluate(sun.towards);
                        sun.weight * y[a] * y[b]
                    };
                    let sum: f64 = plan.suns.iter().map(of).sum();
                    assert!((sum - f64::from(u8::from(a == b))).abs() < 1e-12, "{degree}: {a}, {b}: {sum}");
                }
            }
        }
    }

    #[test]
    fn a_list_of_directions_is_solved_as_it_is_and_judged_between_them() {
        for (suns, count, judges) in [(ico12(), 12, 3), (ico42(), 42, 5)] {
            let SunBasis::Directions(list) = &suns else { panic!("{suns:?} is no list") };
            let plan = plan(suns.clone());
            assert_eq!((plan.fitted(), plan.held_out()), (count, judges));
            let fitted: Vec<[f64; 3]> = plan.suns[..count].iter().map(|sun| sun.towards).collect();
            assert_eq!(fitted, list.directions());
            // As far from the nearest direction as any sun is in the mean: 22.4 and 11.9 degrees.
            let angle = |judge: &Sun| {
                let cosine = |d: &[f64; 3]| d.iter().zip(judge.towards).map(|(a, b)| a * b).sum::<f64>();
                libm::acos(list.directions().iter().map(cosine).fold(-1.0, f64::max)).to_degrees()
            };
            let mean = plan.suns[count..].iter().map(angle).sum::<f64>() / judges as f64;
            let expected = if count == 12 { 22.4 } else { 11.9 };
            assert!((mean / expected - 1.0).abs() < 0.1, "{count} directions: {mean} degrees");
        }
    }

    #[test]
    fn lattice_suns_send_light_along_the_directions() {
        let plan = plan(SunBasis::Lattice18);
        assert_eq!((plan.fitted(), plan.held_out()), (18, 0));
        assert_eq!(plan.suns[2].towards, [0.0, -1.0, 0.0]); // direction 3 is +y
    }

    #[test]
    fn only_the_directions_that_are_wanted_are_solved() {
        let bases: BaseSet = [3, 18].into_iter().collect();
        let settings = OrdinatesSettings { suns: SunBasis::Lattice18, bases, ..OrdinatesSettings::default() };
        let towards = |plan: &SolvePlan| plan.suns.iter().map(|sun| sun.towards).collect::<Vec<_>>();
        let all = towards(&plan(SunBasis::Lattice18));
        assert_eq!(towards(&SolvePlan::new(&settings)), [all[2], all[17]]);
        assert_eq!(settings.solves(), 2);
        assert_eq!(OrdinatesSettings { bases: bases.with(0), ..settings.clone() }.solves(), 3);
    }
}
