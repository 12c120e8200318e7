//! Directions and weights that integrate the sphere: 18 lattice directions, or Lebedev's rules of 50 and 110.
//!
//! Source: V. I. Lebedev, Quadratures on a sphere, USSR Comput. Math. Math. Phys. 16 (1976) and 17 (1977); 50 points
//! are exact to degree 11, 110 to degree 17. The 18 lattice directions with weights 1/30 (axial) and 1/15 (diagonal)
//! are exact to degree 5 (lighting model, section 9).

/// A direction of travel and its share of the sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ordinate {
    /// Unit vector, model space.
    pub direction: [f64; 3],
    /// Weights of a set sum to 1.
    pub weight: f64,
}

/// Largest number of rays per site edge that are marched.
pub const MAX_RAYS: u32 = 8;

/// Rays per site edge that a plant should have on a lattice whose sites are cut in `parts` along each edge: as many in
/// all as 128 sites with one each, at most 4. Large sites hold much, and one ray through each would miss where.
pub const fn rays_for(lattice: u32, parts: u32) -> u32 {
    match lattice * parts {
        0..=32 => 4,
        33..=64 => 2,
        _ => 1,
    }
}

/// Number of directions of travel along which the transport is marched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Ordinates {
    /// The lattice's 18 directions.
    Lattice18,
    /// Lebedev's rule of 50 points.
    Lebedev50,
    /// Lebedev's rule of 110 points.
    #[default]
    Lebedev110,
}

impl Ordinates {
    /// All sets, the coarsest first.
    pub const ALL: [Ordinates; 3] = [Ordinates::Lattice18, Ordinates::Lebedev50, Ordinates::Lebedev110];

    /// The set with so many directions.
    pub fn of_count(count: u32) -> Option<Ordinates> {
        Ordinates::ALL.into_iter().find(|set| set.count() == count)
    }

    /// Number of directions.
    pub fn count(self) -> u32 {
        match self {
            Ordinates::Lattice18 => 18,
            Ordinates::Lebedev50 => 50,
            Ordinates::Lebedev110 => 110,
        }
    }

    /// The directions, one of each pair of opposites; each stands for itself and its opposite, and has the weight of
    /// one of them. Half of the weights' sum is 1/2.
    pub fn axes(self) -> Vec<Ordinate> {
        let first_positive =
            |o: &Ordinate| o.direction.into_iter().find(|c| *c != 0.0).is_some_and(|c| c > 0.0);
        self.directions().into_iter().filter(first_positive).collect()
    }

    /// All directions.
    pub fn directions(self) -> Vec<Ordinate> {
        // Points (0, 0, 1), (0, 1, 1), (1, 1, 1), (l, l, m), (p, q, 0) up to length, and what symmetry makes of them.
        let on = |l: f64| [l, l, libm::sqrt(1.0 - 2.0 * l * l)];
        let orbits: &[([f64; 3], f64)] = &match self {
            Ordinates::Lattice18 => vec![([0.0, 0.0, 1.0], 1.0 / 30.0), ([0.0, 1.0, 1.0], 1.0 / 15.0)],
            Ordinates::Lebedev50 => vec![
                ([0.0, 0.0, 1.0], 0.012_698_412_698_412_7),
                ([0.0, 1.0, 1.0], 0.022_574_955_908_289_24),
                ([1.0, 1.0, 1.0], 0.021_093_75),
                (on(0.301_511_344_577_763_6), 0.020_173_335_537_918_87),
            ],
            Ordinates::Lebedev110 => vec![
                ([0.0, 0.0, 1.0], 0.003_828_270_494_937_162),
                ([1.0, 1.0, 1.0], 0.009_793_737_512_487_512),
                (on(0.185_115_635_344_736_2), 0.008_211_737_283_191_111),
                (on(0.690_421_048_382_292_2), 0.009_942_814_891_178_103),
                (on(0.395_689_473_055_941_9), 0.009_595_471_336_070_963),
                ([0.478_369_028_812_150_2, 0.878_158_910_604_066_1, 0.0], 0.009_694_996_361_663_028),
            ],
        };
        let mut all: Vec<Ordinate> =
            orbits.iter().flat_map(|&(point, weight)| orbit(point, weight)).collect();
        if self != Ordinates::Lattice18 {
            all.iter_mut().for_each(|ordinate| ordinate.direction = turned(ordinate.direction));
        }
        all
    }
}

/// A rotation that brings no direction near an axis or a diagonal of the lattice. Lebedev's points as they are run
/// along rows of sites, so that rays see the same few sites again and again: at 110 ordinates that costs twice the
/// error.
fn turned(direction: [f64; 3]) -> [f64; 3] {
    let mut d = direction;
    for (axis, angle) in [0.31, 0.17, 0.47].into_iter().enumerate() {
        let (sin, cos) = libm::sincos(angle);
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        (d[i], d[j]) = (cos * d[i] - sin * d[j], sin * d[i] + cos * d[j]);
    }
    d
}

/// Every permutation and reflection of a point, each once, in a fixed order.
fn orbit(point: [f64; 3], weight: f64) -> Vec<Ordinate> {
    let length = libm::sqrt(point.iter().map(|c| c * c).sum());
    let [a, b, c] = point.map(|c| c / length);
    let mut found: Vec<Ordinate> = Vec::new();
    for permuted in [[a, b, c], [a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]] {
        for signs in 0..8 {
            let direction = std::array::from_fn(|axis| {
                let negative = signs >> axis & 1 == 1 && permuted[axis] != 0.0;
                if negative { -permuted[axis] } else { permuted[axis] }
            });
            if found.iter().all(|other| other.direction != direction) {
                found.push(Ordinate { direction, weight });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of x^a y^b z^c over the sphere.
    fn exact(powers: [i32; 3]) -> f64 {
        if powers.iter().any(|p| p % 2 == 1) {
            return 0.0;
        }
        let double = |n: i32| (1..=n).rev().step_by(2).map(f64::from).product::<f64>();
        let odd = |p: i32| if p == 0 { 1.0 } else { double(p - 1) };
        powers.iter().map(|&p| odd(p)).product::<f64>() / double(powers.iter().sum::<i32>() + 1)
    }

    #[test]
    fn every_set_integrates_all_polynomials_up_to_its_degree() {
        for (set, degree) in
            [(Ordinates::Lattice18, 5), (Ordinates::Lebedev50, 11), (Ordinates::Lebedev110, 17)]
        {
            let directions = set.directions();
            assert_eq!(directions.len() as u32, set.count());
            for a in 0..=degree {
                for b in 0..=degree - a {
                    for c in 0..=degree - a - b {
                        let raised = |p: i32, x: f64| libm::pow(x, f64::from(p));
                        let term = |o: &Ordinate| {
                            let [x, y, z] = o.direction;
                            o.weight * raised(a, x) * raised(b, y) * raised(c, z)
                        };
                        let sum: f64 = directions.iter().map(term).sum();
                        let error = (sum - exact([a, b, c])).abs();
                        assert!(error < 2e-14, "{set:?}: x^{a} y^{b} z^{c} is off by {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn axes_are_one_of_each_pair_of_opposites() {
        for set in Ordinates::ALL {
            let axes = set.axes();
            assert_eq!(2 * axes.len() as u32, set.count());
            for o in &axes {
                let cosine =
                    |other: &Ordinate| (0..3).map(|i| other.direction[i] * o.direction[i]).sum::<f64>();
                assert!(axes.iter().all(|other| cosine(other) > -1.0 + 1e-9));
                assert!(set.directions().iter().any(|other| cosine(other) < -1.0 + 1e-12));
            }
        }
    }
}
