//! The suns that plants of a species see: a plant that is turned or tilted sees the same sun from elsewhere.
//!
//! ```text
//! row ..  own + 1   . . . . . . . .     a step higher in the model's frame
//!         own       . . . . . . . .     as high as the sun is: all plants that stand upright
//!         own - 1   . . . . . . . .     a step lower
//!                   yaw 0 .. yaws
//! ```
//!
//! A cell is a sun of this grid, `row * yaws + yaw`. A plant lies between four cells, one that stands upright between
//! two of the row `own`. The first and the last row are the poles. Where there is no room for all volumes, there is one
//! for every second row and yaw, counted from the own row and yaw 0, or every fourth, and so on: a *stride* of them.

use std::collections::BTreeMap;

use flb_format::Transform;
use flb_format::sun::towards_sun;

use super::stand::{EXACT, Stand, angles, model_from_world, turn};
use crate::sun_terms::unit;

/// Least and largest step from row to row, degrees; between them it is that of the yaws.
const STEP_DEG: [f64; 2] = [5.0, 15.0];

/// Least distance of two rows that counts, degrees.
const SHORT_DEG: f64 = 1e-3;

/// The grid of suns of one sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Suns {
    /// Unit vector, world.
    pub towards_sun: [f64; 3],
    pub azimuth_deg: f64,
    pub elevation_deg: f64,
    pub yaws: u32,
    /// The row of plants that stand upright, and the highest one.
    pub own: u32,
    pub top: u32,
}

/// Degrees from row to row.
pub(super) fn row_step_deg(yaws: u32) -> f64 {
    (360.0 / f64::from(yaws)).clamp(STEP_DEG[0], STEP_DEG[1])
}

/// Rows of any sun, at most.
pub(super) fn rows(yaws: u32) -> u32 {
    libm::ceil(180.0 / row_step_deg(yaws)) as u32 + 2
}

/// Of some yaws of a circle, which ascend, the nearest to one.
fn nearest_yaw(there: &[u32], yaw: u32, yaws: u32) -> u32 {
    let after = there.partition_point(|other| *other < yaw);
    let both = [after % there.len(), (after + there.len() - 1) % there.len()].map(|at| there[at]);
    let away = |other: u32| yaw.abs_diff(other).min(yaws - yaw.abs_diff(other));
    both.into_iter().min_by_key(|other| away(*other)).unwrap_or(yaw)
}

impl Suns {
    /// Of a sun along a vector of the world; one without a direction is above.
    pub(super) fn of(towards_sun: [f64; 3], yaws: u32) -> Suns {
        let towards_sun = unit(towards_sun).unwrap_or([0.0, 1.0, 0.0]);
        let [azimuth_deg, elevation_deg] = angles(towards_sun);
        let rows = |degrees: f64| libm::ceil(degrees / row_step_deg(yaws)) as u32;
        let own = rows(elevation_deg + 90.0);
        let top = (own + rows(90.0 - elevation_deg)).min(self::rows(yaws) - 1);
        Suns { towards_sun, azimuth_deg, elevation_deg, yaws, own, top }
    }

    /// Whether they are those of a sun, or of one that is off by no more than so many degrees.
    pub(super) fn are_near(&self, towards_sun: [f64; 3], off_deg: f64) -> bool {
        let Some(towards_sun) = unit(towards_sun) else { return true };
        let cos: f64 = self.towards_sun.iter().zip(towards_sun).map(|(a, b)| a * b).sum();
        cos >= libm::cos(off_deg.to_radians())
    }

    /// Number of cells of any sun.
    pub(super) fn count(yaws: u32) -> usize {
        (rows(yaws) * yaws) as usize
    }

    /// `[cell]`: itself where it is one of these, which ascend, or the one whose sun is nearest.
    pub(super) fn nearest(&self, cells: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut there: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for cell in cells {
            there.entry(cell / self.yaws).or_default().push(cell % self.yaws);
        }
        let suns: Vec<[f64; 3]> = (0..Suns::count(self.yaws) as u32).map(|cell| self.sun(cell)).collect();
        let nearest = |cell: u32| {
            let (row, yaw) = (cell / self.yaws, cell % self.yaws);
            let is_there = there.get(&row).is_some_and(|yaws| yaws.binary_search(&yaw).is_ok());
            let in_rows = there.iter().filter(|_| !is_there);
            let of_rows = in_rows.map(|(row, yaws)| row * self.yaws + nearest_yaw(yaws, yaw, self.yaws));
            let cos = |other: u32| -> f64 {
                suns[cell as usize].iter().zip(suns[other as usize]).map(|(a, b)| a * b).sum()
            };
            of_rows.max_by(|a, b| cos(*a).total_cmp(&cos(*b))).unwrap_or(cell)
        };
        (0..suns.len() as u32).map(nearest).collect()
    }

    /// Cells in an order in which each so many are spread over the yaws; those of the own row first.
    pub(super) fn spread(&self, cells: &[u32], parts: usize) -> Vec<u32> {
        let is_own = |cell: &u32| cell / self.yaws == self.own;
        let (own, mut others): (Vec<u32>, Vec<u32>) = cells.iter().partition(|cell| is_own(cell));
        others.sort_by_key(|cell| (cell % self.yaws, cell / self.yaws));
        let each = |cells: Vec<u32>| {
            let step = cells.len().div_ceil(parts);
            (0..step).flat_map(|first| cells.iter().copied().skip(first).step_by(step)).collect::<Vec<u32>>()
        };
        [each(own), each(others)].concat()
    }

    /// Elevation of a row in the model's frame, degrees.
    fn row_deg(&self, row: u32) -> f64 {
        let above = f64::from(row) - f64::from(self.own);
        (self.elevation_deg + above * row_step_deg(self.yaws)).clamp(-90.0, 90.0)
    }

    /// Unit vector towards the sun of a cell, in the model's frame.
    pub(super) fn sun(&self, cell: u32) -> [f64; 3] {
        let (row, yaw) = (cell / self.yaws, cell % self.yaws);
        let yaw_deg = 360.0 * f64::from(yaw) / f64::from(self.yaws);
        if row == self.own {
            return Transform::from_yaw([0.0; 3], yaw_deg, 1.0).model_from_world_direction(self.towards_sun);
        }
        towards_sun(self.azimuth_deg - yaw_deg, self.row_deg(row))
    }

    /// The cells between which a plant's sun lies, with their shares, where every so manieth row and yaw has a volume.
    pub(super) fn cells(&self, stand: Stand, stride: u32) -> impl Iterator<Item = (u32, f32)> {
        let (rows, turn) = match stand {
            Stand::Upright(turn) => (alone(self.own), f64::from(turn)),
            Stand::Tilted(rotation) => {
                let [azimuth_deg, elevation_deg] = angles(model_from_world(rotation, self.towards_sun));
                let turn = turn(self.azimuth_deg - azimuth_deg, self.yaws);
                (self.rows_between(elevation_deg, stride), turn)
            }
        };
        let yaws = self.yaws_between(turn, stride);
        let cell = |(row, of_row): (u32, f32), (yaw, of_yaw)| (row * self.yaws + yaw, of_row * of_yaw);
        let [low, high] = rows.map(|row| yaws.map(|yaw| cell(row, yaw)));
        low.into_iter().chain(high).filter(|(_, share)| *share > 0.0)
    }

    /// The cells that a plant near one asks for, where every so manieth row and yaw has a volume: itself, or those
    /// around it. All yaws of a pole are the same sun.
    pub(super) fn around(&self, cell: u32, stride: u32) -> [u32; 4] {
        let (row, yaw) = (cell / self.yaws, cell % self.yaws);
        let [low, high] = self.rows_around(f64::from(row) - f64::from(self.own), stride);
        let rows = if row == low || row == high { [row; 2] } else { [low, high] };
        let (first, next) = self.yaws_around(f64::from(yaw), stride);
        let yaws = if yaw == first { [first; 2] } else { [first, next] };
        let at = |row: u32, yaw: u32| row * self.yaws + if self.is_pole(row) { 0 } else { yaw };
        let [low, high] = rows.map(|row| yaws.map(|yaw| at(row, yaw)));
        [low[0], low[1], high[0], high[1]]
    }

    /// The yaws between which an upright plant lies, with their shares.
    pub(super) fn yaws_of(&self, turn: f32) -> impl Iterator<Item = (u32, f32)> {
        self.yaws_between(f64::from(turn), 1).into_iter().filter(|(_, share)| *share > 0.0)
    }

    fn is_pole(&self, row: u32) -> bool {
        self.row_deg(row).abs() >= 90.0
    }

    /// The two rows around an elevation, with their shares.
    fn rows_between(&self, elevation_deg: f64, stride: u32) -> [(u32, f32); 2] {
        let [low, high] =
            self.rows_around((elevation_deg - self.elevation_deg) / row_step_deg(self.yaws), stride);
        let [low_deg, high_deg] = [low, high].map(|row| self.row_deg(row));
        // Between the poles and their neighbours the step is shorter.
        both(low, high, (elevation_deg - low_deg) / (high_deg - low_deg).max(SHORT_DEG))
    }

    /// The two rows with volumes around a place, in rows above the own one. Where there is one yaw, there is one row.
    fn rows_around(&self, above: f64, stride: u32) -> [u32; 2] {
        if stride >= self.yaws {
            return [self.own; 2];
        }
        let (own, stride) = (f64::from(self.own), f64::from(stride));
        let low = own + libm::floor(above / stride) * stride;
        [low, low + stride].map(|row| row.clamp(0.0, f64::from(self.top)) as u32)
    }

    /// The two yaws around a place on the circle, with their shares.
    fn yaws_between(&self, turn: f64, stride: u32) -> [(u32, f32); 2] {
        if stride >= self.yaws {
            return alone(0);
        }
        let (first, next) = self.yaws_around(turn, stride);
        let span = stride.min(self.yaws.saturating_sub(first)).max(1);
        both(first, next, (turn - f64::from(first)) / f64::from(span))
    }

    fn yaws_around(&self, turn: f64, stride: u32) -> (u32, u32) {
        let first = turn as u32 / stride * stride;
        (first, if first + stride < self.yaws { first + stride } else { 0 })
    }
}

/// One that counts alone.
fn alone(one: u32) -> [(u32, f32); 2] {
    [(one, 1.0), (one, 0.0)]
}

/// Two with the share of the second; of shares that hardly count there are none.
fn both(first: u32, second: u32, share: f64) -> [(u32, f32); 2] {
    match share {
        share if share > 1.0 - EXACT => alone(second),
        share if share >= EXACT => [(first, 1.0 - share as f32), (second, share as f32)],
        _ => alone(first),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::stand::tests::{apart_deg, rotations};
    use super::*;

    #[test]
    fn the_cells_of_a_plant_lie_around_its_sun() {
        for yaws in [8, 16, 64, 100] {
            for (azimuth_deg, elevation_deg) in
                [(120.0, 35.0), (0.0, 0.0), (300.0, 85.0), (10.0, -20.0), (200.0, 90.0), (77.0, 15.0)]
            {
                let suns = Suns::of(towards_sun(azimuth_deg, elevation_deg), yaws);
                for (stands, stride) in rotations().iter().flat_map(|stands| [(stands, 1), (stands, 2)]) {
                    let stand = Stand::of(stands, yaws, 0.01);
                    let seen = stands.model_from_world_direction(suns.towards_sun);
                    let cells: Vec<(u32, f32)> = suns.cells(stand, stride).collect();
                    let whole: f32 = cells.iter().map(|(_, share)| share).sum();
                    assert!((whole - 1.0).abs() < 1e-5, "{cells:?}");
                    let [_, height_deg] = angles(seen);
                    let mut mean_deg = 0.0;
                    for (cell, share) in cells {
                        assert!((cell as usize) < Suns::count(yaws), "{cell} of {yaws}");
                        let away = apart_deg(suns.sun(cell), seen);
                        let most = f64::from(stride) * (360.0 / f64::from(yaws) + row_step_deg(yaws));
                        assert!(away < most, "{away}: {stands:?}");
                        mean_deg += f64::from(share) * angles(suns.sun(cell))[1];
                    }
                    // Between its cells the height is linear.
                    assert!((mean_deg - height_deg).abs() < 0.04, "{mean_deg} {height_deg} {suns:?}");
                }
            }
        }
    }

    #[test]
    fn an_upright_plant_has_cells_of_the_row_of_the_sun_and_its_very_direction() {
        let suns = Suns::of([0.6, 0.5, -0.62], 8);
        let cells = |yaw_deg: f64, stride: u32| -> Vec<(u32, f32)> {
            let stand = Stand::of(&Transform::from_yaw([0.0; 3], yaw_deg, 2.0), 8, 1.0);
            suns.cells(stand, stride).map(|(cell, share)| (cell - 8 * suns.own, share)).collect()
        };
        assert_eq!(cells(90.0, 1), [(2, 1.0)]);
        assert_eq!(cells(101.25, 1), [(2, 0.75), (3, 0.25)]);
        assert_eq!(cells(359.99, 1), [(0, 1.0)]);
        // Where there are fewer volumes it blends those that there are; the last step of a circle may be shorter.
        assert_eq!(cells(101.25, 2), [(2, 0.875), (4, 0.125)]);
        assert_eq!(cells(292.5, 3), [(6, 0.75), (0, 0.25)]);
        assert_eq!(cells(101.25, 8), [(0, 1.0)]);
        let ninety = Transform::from_yaw([0.0; 3], 90.0, 1.0);
        assert_eq!(suns.sun(8 * suns.own + 2), ninety.model_from_world_direction(suns.towards_sun));
    }

    #[test]
    fn the_cells_of_a_plant_are_among_those_that_it_asks_for_at_every_stride() {
        for (elevation_deg, yaws) in [(35.0, 16), (-80.0, 8), (90.0, 64), (0.0, 6), (-90.0, 12), (10.0, 1)] {
            let suns = Suns::of(towards_sun(30.0, elevation_deg), yaws);
            let upright = (0..40).map(|number| Transform::from_yaw([0.0; 3], 9.7 * f64::from(number), 1.0));
            for stands in rotations().into_iter().chain(upright) {
                let stand = Stand::of(&stands, yaws, 0.01);
                for stride in [1, 2, 4, 8, yaws].map(|stride| stride.min(yaws)) {
                    let asked: Vec<u32> =
                        suns.cells(stand, 1).flat_map(|(cell, _)| suns.around(cell, stride)).collect();
                    let nearest = suns.nearest(asked.iter().copied().collect::<BTreeSet<u32>>().into_iter());
                    let used = suns.cells(stand, stride).map(|(cell, _)| nearest[cell as usize]);
                    let used: Vec<u32> = used.collect();
                    // A cell at a pole has the volume of its first yaw.
                    let itself = suns.cells(stand, stride).all(|(cell, _)| {
                        let own = nearest[cell as usize];
                        own == cell || apart_deg(suns.sun(cell), suns.sun(own)) < 1e-4
                    });
                    assert!(itself, "{used:?} {suns:?} {stride}");
                    assert!(
                        used.iter().all(|cell| asked.contains(cell)),
                        "{used:?} {asked:?} {suns:?} {stride}"
                    );
                    for cell in asked {
                        assert_eq!(suns.around(cell, stride), [cell; 4], "{suns:?} {stride}");
                        assert!((cell as usize) < Suns::count(yaws) && cell / yaws <= suns.top);
                    }
                }
                assert!(suns.cells(stand, yaws).all(|(cell, _)| cell == suns.own * yaws));
            }
        }
    }

    #[test]
    fn what_is_there_stands_in_for_what_is_not() {
        let suns = Suns::of(towards_sun(30.0, 20.0), 8);
        let at = |row: u32, yaw: u32| (suns.own + row - 2) * 8 + yaw;
        let nearest = suns.nearest([at(0, 3), at(2, 1), at(2, 6)].into_iter());
        assert_eq!(nearest.len(), Suns::count(8));
        for (cell, expected) in [
            ((0, 7), (2, 6)),
            ((0, 4), (0, 3)),
            ((2, 1), (2, 1)),
            ((2, 2), (2, 1)),
            ((2, 0), (2, 1)),
            ((2, 5), (2, 6)),
            ((2, 4), (0, 3)),
            // The nearest sun, be it of another row.
            ((1, 3), (0, 3)),
            ((1, 1), (2, 1)),
            ((4, 1), (2, 1)),
        ] {
            assert_eq!(nearest[at(cell.0, cell.1) as usize], at(expected.0, expected.1), "{cell:?}");
        }
        let cells: Vec<u32> = (0..4).map(|yaw| at(0, yaw)).chain((0..8).map(|yaw| at(2, yaw))).collect();
        let spread = suns.spread(&cells, 4);
        assert_eq!(spread[..4], [0, 2, 4, 6].map(|yaw| at(2, yaw)));
        let mut others = spread[8..].to_vec();
        others.sort_unstable();
        assert_eq!(others, [0, 1, 2, 3].map(|yaw| at(0, yaw)));
        // Of several rows the first ones are of yaws all around.
        let rows: Vec<u32> =
            [0, 1, 3, 4].into_iter().flat_map(|row| (0..8).map(move |yaw| at(row, yaw))).collect();
        let yaws: BTreeSet<u32> = suns.spread(&rows, 4)[..4].iter().map(|cell| cell % 8).collect();
        assert_eq!(yaws, BTreeSet::from([0, 2, 4, 6]));
        assert!(suns.spread(&[], 4).is_empty());
    }
}
