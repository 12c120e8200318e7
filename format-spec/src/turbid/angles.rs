//! How leaves are inclined, and how much of them light from a direction meets (the G function of Ross, 1981).

use std::f64::consts::PI;

/// Bins of the cosine between a leaf's normal and the vertical, equally wide from 0 (upright leaf) to 1 (flat).
pub const INCLINATIONS: usize = 32;

/// Points per bin at which the projection is evaluated.
const POINTS: usize = 8;

/// Places in the table of the projection over |up|, both ends included.
const TABLE: usize = 257;

/// How far the sum of stored shares may be from 1: they may have been rounded for print.
const SUM_TOLERANCE: f64 = 1e-6;

/// A distribution of leaf inclinations; azimuths are even.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafAngles {
    /// Share of the one-sided leaf area per bin; they sum to 1.
    shares: [f64; INCLINATIONS],
    /// G at |up| = i / (TABLE - 1), divided by its mean over all directions, 1/2.
    relative: Vec<f64>,
}

impl LeafAngles {
    /// Randomly oriented leaves: as the surface of a sphere. G is 1/2 everywhere.
    pub fn spherical() -> LeafAngles {
        LeafAngles { shares: [1.0 / INCLINATIONS as f64; INCLINATIONS], relative: vec![1.0; TABLE] }
    }

    /// Mostly flat leaves: density 2 (1 + cos 2 theta) / pi over the inclination theta (de Wit, 1965; Goel and
    /// Strebel, 1984).
    pub fn planophile() -> LeafAngles {
        LeafAngles::of_inclinations(|cumulated| 2.0 * (cumulated + libm::sin(2.0 * cumulated) / 2.0) / PI)
    }

    /// Mostly upright leaves: density 2 (1 - cos 2 theta) / pi.
    pub fn erectophile() -> LeafAngles {
        LeafAngles::of_inclinations(|cumulated| 2.0 * (cumulated - libm::sin(2.0 * cumulated) / 2.0) / PI)
    }

    /// From the share of leaves whose inclination is below an angle in radians.
    fn of_inclinations(cumulated: impl Fn(f64) -> f64) -> LeafAngles {
        // A leaf of inclination theta has a normal whose y component is cos theta.
        let edge = |bin: usize| libm::acos(bin as f64 / INCLINATIONS as f64);
        let shares = std::array::from_fn(|bin| cumulated(edge(bin)) - cumulated(edge(bin + 1)));
        LeafAngles::from_areas(shares).expect("a distribution has area")
    }

    /// Makes the distribution from measured leaf area per bin of |y| of the normal, in any unit. `None` unless the
    /// areas are finite and not negative, and their sum is above 0.
    pub fn from_areas(areas: [f64; INCLINATIONS]) -> Option<LeafAngles> {
        let total: f64 = areas.iter().sum();
        if areas.iter().any(|&area| !(area >= 0.0 && area.is_finite())) || !(total > 0.0 && total.is_finite())
        {
            return None;
        }
        Some(LeafAngles::of_shares(areas.map(|area| area / total)))
    }

    /// Makes the distribution from shares as files keep them. `None` unless each is from 0 to 1 and their sum within
    /// 1e-6 of 1.
    pub fn from_shares(shares: [f64; INCLINATIONS]) -> Option<LeafAngles> {
        let sum: f64 = shares.iter().sum();
        let fits =
            shares.iter().all(|share| (0.0..=1.0).contains(share)) && (sum - 1.0).abs() <= SUM_TOLERANCE;
        fits.then(|| LeafAngles::of_shares(shares))
    }

    /// Whether leaves favour no direction.
    pub fn is_spherical(&self) -> bool {
        self.shares == [1.0 / INCLINATIONS as f64; INCLINATIONS]
    }

    fn of_shares(shares: [f64; INCLINATIONS]) -> LeafAngles {
        let spherical = LeafAngles::spherical();
        if shares == spherical.shares {
            return spherical;
        }
        let along = |i: usize| {
            let up = i as f64 / (TABLE - 1) as f64;
            let of_bin = |(bin, share): (usize, &f64)| {
                let point = |k| (bin as f64 + (k as f64 + 0.5) / POINTS as f64) / INCLINATIONS as f64;
                share * (0..POINTS).map(|k| ring_projection(point(k), up)).sum::<f64>() / POINTS as f64
            };
            shares.iter().enumerate().map(of_bin).sum::<f64>()
        };
        let table: Vec<f64> = (0..TABLE).map(along).collect();
        // The mean over all directions, by the trapezoidal rule as the table is read, becomes 1.
        let ends = (table[0] + table[TABLE - 1]) / 2.0;
        let mean = (table[1..TABLE - 1].iter().sum::<f64>() + ends) / (TABLE - 1) as f64;
        LeafAngles { shares, relative: table.iter().map(|g| g / mean).collect() }
    }

    /// Share of the one-sided leaf area per bin of |y| of the normal; they sum to 1.
    pub fn shares(&self) -> &[f64; INCLINATIONS] {
        &self.shares
    }

    /// G(direction) / (1/2) for a unit direction whose y component is `up`: its mean over all directions is 1.
    pub fn relative(&self, up: f64) -> f64 {
        let at = up.abs().min(1.0) * (TABLE - 1) as f64;
        let low = (at as usize).min(TABLE - 2);
        let t = at - low as f64;
        self.relative[low] * (1.0 - t) + self.relative[low + 1] * t
    }
}

/// Mean of |n . d| over normals n of |y| component `c` and all azimuths, for a direction d of |y| component `up`
/// (Ross, 1981; Myneni, Ross and Asrar, 1989).
fn ring_projection(c: f64, up: f64) -> f64 {
    let level = c * up;
    let across = libm::sqrt((1.0 - c * c).max(0.0) * (1.0 - up * up).max(0.0));
    if level >= across {
        return level;
    }
    let turn = libm::acos(-level / across);
    (2.0 / PI) * (level * (turn - PI / 2.0) + across * libm::sin(turn))
}
