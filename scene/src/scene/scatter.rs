//! Where plants stand: points that keep their distance from each other and yet lie in no rows (blue noise), over a
//! rectangle and as densely as a grey picture says.
//!
//! Darts are thrown in rounds of ever shorter distance, each kept if it is far enough from all that stuck before (dart
//! throwing in a grid of squares that hold one point each). So points come in an order of which every beginning fills
//! the rectangle evenly. Where the picture is darker, only the beginning of that order stands: thinning by chance would
//! leave clumps and holes there.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{Grey, MAX_INSTANCES};

/// Area to fill with points.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Edges along x and z; its middle is the origin.
    pub area_m: [f64; 2],
    /// Number of points, or their spacing.
    pub amount: Amount,
    /// Density of points, white where they stand as densely as anywhere; it covers the rectangle, its upper left corner
    /// at the lowest x and z.
    pub density: Option<Grey>,
    /// Seed of the random numbers; each seed gives other points.
    pub seed: u64,
}

/// Amount of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Amount {
    /// Number of points.
    Count(usize),
    /// Least distance between points, metres: as many as keep it.
    Spacing(f64),
}

/// Points, and how far apart they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Spots {
    /// x and z.
    pub points_m: Vec<[f64; 2]>,
    /// Least distance between two points, metres.
    pub spacing_m: f64,
}

/// Reason why points cannot be scattered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScatterError {
    /// A value out of its range.
    #[error("{what} is {found}, expected {expected}")]
    Setting {
        /// Name of the setting.
        what: &'static str,
        /// Value of the setting.
        found: String,
        /// Values that are allowed.
        expected: &'static str,
    },
    /// More points than a scene may hold, or than can be thinned out to them.
    #[error("{what}: {found} is over the limit of {limit}")]
    Limit {
        /// Name of what is counted.
        what: &'static str,
        /// Number that was found.
        found: u64,
        /// Largest number.
        limit: u64,
    },
    /// Density map that is black all over.
    #[error("the density map is black all over, expected a place where plants stand")]
    Black,
}

/// Points before thinning.
const MAX_POINTS: u64 = 1 << 22;
/// Points times the square of their distance, as a share of the area, that darts reach without much waste. No throws
/// reach 0.7.
const FILL: f64 = 0.6;
/// Points of the first round.
const FIRST_ROUND: f64 = 16.0;
/// Throws for each point that a round may have; in the last round, which has to reach a number, more.
const THROWS: f64 = 8.0;
const LAST_THROWS: f64 = 40.0;

/// Scatters points. The same plot gives the same points on every machine.
///
/// # Errors
/// [`ScatterError`] for values out of range, too many points, and a density map without any light.
pub fn scatter(plot: &Plot) -> Result<Spots, ScatterError> {
    for edge in plot.area_m {
        if !(1e-3..=1e7).contains(&edge) {
            let found = format!("{:?}", plot.area_m);
            return Err(ScatterError::Setting { what: "area", found, expected: "edges of 0.001 to 1e7 m" });
        }
    }
    let area = plot.area_m[0] * plot.area_m[1];
    let mean = match &plot.density {
        None => 1.0,
        Some(grey) => mean_share(grey)?,
    };
    let mut darts = Darts::new(plot);
    match plot.amount {
        Amount::Count(count) => {
            if count == 0 {
                let (found, expected) = ("0".to_owned(), "1 plant or more");
                return Err(ScatterError::Setting { what: "count", found, expected });
            }
            limit("plants", count as f64, MAX_INSTANCES as u64)?;
            let all = (count as f64 / mean).ceil();
            limit("plants before thinning by the density map", all, MAX_POINTS)?;
            // On a narrow strip they stand in a row.
            let in_a_row = plot.area_m[0].max(plot.area_m[1]) / all / 2.0;
            darts.fill_up_to((FILL * area / all).sqrt().max(in_a_row), all as usize);
            Ok(Spots { points_m: darts.densest(plot, count), spacing_m: darts.spacing_m })
        }
        Amount::Spacing(spacing_m) => {
            if !(spacing_m.is_finite() && spacing_m > 0.0) {
                let (found, expected) = (spacing_m.to_string(), "a distance above 0");
                return Err(ScatterError::Setting { what: "spacing", found, expected });
            }
            // On a strip narrower than the spacing they stand in a row, so that its area does not bound them.
            let along = plot.area_m.map(|edge| edge / spacing_m + 1.0);
            let most = (0.7 * area / (spacing_m * spacing_m)).max(along[0]).max(along[1]);
            limit("plants at that spacing", most, MAX_INSTANCES as u64)?;
            darts.fill(spacing_m);
            let count = (darts.points_m.len() as f64 * mean).round().max(1.0) as usize;
            Ok(Spots { points_m: darts.densest(plot, count), spacing_m })
        }
    }
}

fn limit(what: &'static str, found: f64, limit: u64) -> Result<(), ScatterError> {
    match found <= limit as f64 {
        true => Ok(()),
        false => Err(ScatterError::Limit { what, found: found as u64, limit }),
    }
}

/// Mean of a density map, of its brightest value.
fn mean_share(grey: &Grey) -> Result<f64, ScatterError> {
    let brightest = brightest(grey);
    if brightest <= 0.0 {
        return Err(ScatterError::Black);
    }
    let sum: f64 = grey.values.iter().map(|value| f64::from(*value)).sum();
    Ok(sum / grey.values.len() as f64 / brightest)
}

fn brightest(grey: &Grey) -> f64 {
    f64::from(grey.values.iter().copied().fold(0.0, f32::max))
}

/// Points thrown so far, from 0 to the edges of the area.
struct Darts {
    area_m: [f64; 2],
    draw: Pcg64Mcg,
    points_m: Vec<[f64; 2]>,
    /// The shortest distance of the rounds so far.
    spacing_m: f64,
}

impl Darts {
    fn new(plot: &Plot) -> Darts {
        let draw = Pcg64Mcg::seed_from_u64(plot.seed);
        Darts { area_m: plot.area_m, draw, points_m: Vec::new(), spacing_m: f64::INFINITY }
    }

    fn area(&self) -> f64 {
        self.area_m[0] * self.area_m[1]
    }

    /// Rounds down to a distance, the last one thorough.
    fn fill(&mut self, spacing_m: f64) {
        self.coarse_rounds(spacing_m);
        self.round(spacing_m, LAST_THROWS, usize::MAX);
    }

    /// Rounds down to a distance, and below until there are so many points.
    fn fill_up_to(&mut self, mut spacing_m: f64, count: usize) {
        self.coarse_rounds(spacing_m);
        while self.points_m.len() < count {
            self.round(spacing_m, LAST_THROWS, count);
            spacing_m *= 0.97;
        }
        self.points_m.truncate(count);
    }

    fn coarse_rounds(&mut self, spacing_m: f64) {
        let mut distance_m = (FILL * self.area() / FIRST_ROUND).sqrt();
        while distance_m > spacing_m * 1.2 {
            self.round(distance_m, THROWS, usize::MAX);
            distance_m *= std::f64::consts::FRAC_1_SQRT_2;
        }
    }

    /// Throws darts that keep a distance from all others, up to so many points.
    fn round(&mut self, distance_m: f64, throws: f64, most: usize) {
        self.spacing_m = self.spacing_m.min(distance_m);
        let mut squares = Squares::new(self.area_m, distance_m);
        self.points_m.iter().for_each(|point| squares.put(*point));
        let in_a_row = self.area_m[0].max(self.area_m[1]) / distance_m;
        let expected = (FILL * self.area() / (distance_m * distance_m)).max(in_a_row).max(1.0);
        for _ in 0..(throws * expected) as u64 {
            if self.points_m.len() >= most {
                return;
            }
            let point = self.area_m.map(|edge| unit(&mut self.draw) * edge);
            if squares.is_free(point, distance_m) {
                squares.put(point);
                self.points_m.push(point);
            }
        }
    }

    /// So many points, those of the beginning of the order first, where the density map is darker only those; moved so
    /// that the middle of the area is the origin.
    fn densest(&self, plot: &Plot, count: usize) -> Vec<[f64; 2]> {
        let mut ranked: Vec<(f64, usize)> = self
            .points_m
            .iter()
            .enumerate()
            .filter_map(|(rank, point)| {
                let share = plot.density.as_ref().map_or(1.0, |grey| {
                    f64::from(grey.at(point[0] / self.area_m[0], point[1] / self.area_m[1])) / brightest(grey)
                });
                (share > 0.0).then_some((rank as f64 / share, rank))
            })
            .collect();
        ranked.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        ranked.truncate(count);
        ranked
            .into_iter()
            .map(|(_, rank)| std::array::from_fn(|axis| self.points_m[rank][axis] - self.area_m[axis] / 2.0))
            .collect()
    }
}

/// A grid whose squares are too small for two points that keep their distance.
struct Squares {
    per_m: f64,
    count: [usize; 2],
    /// `[row][column]`: a point's coordinates; NaN: none. Points of earlier rounds kept a larger distance.
    points: Vec<[f64; 2]>,
}

const NONE: [f64; 2] = [f64::NAN; 2];

impl Squares {
    fn new(area_m: [f64; 2], distance_m: f64) -> Squares {
        let per_m = std::f64::consts::SQRT_2 * 1.000_001 / distance_m;
        let count = area_m.map(|edge| (edge * per_m) as usize + 1);
        Squares { per_m, count, points: vec![NONE; count[0] * count[1]] }
    }

    fn square(&self, point: [f64; 2]) -> [usize; 2] {
        std::array::from_fn(|axis| ((point[axis] * self.per_m) as usize).min(self.count[axis] - 1))
    }

    fn put(&mut self, point: [f64; 2]) {
        let [column, row] = self.square(point);
        self.points[row * self.count[0] + column] = point;
    }

    fn is_free(&self, point: [f64; 2], distance_m: f64) -> bool {
        let [column, row] = self.square(point);
        let near = |at: usize, count: usize| at.saturating_sub(2)..=(at + 2).min(count - 1);
        near(row, self.count[1]).all(|row| {
            near(column, self.count[0]).all(|column| {
                let [x, z] = self.points[row * self.count[0] + column];
                let (dx, dz) = (x - point[0], z - point[1]);
                x.is_nan() || dx * dx + dz * dz >= distance_m * distance_m
            })
        })
    }
}

/// 0 to below 1.
fn unit(draw: &mut Pcg64Mcg) -> f64 {
    (draw.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests;
