//! The sites of the plant's bounding box, and straight lines through them.
//!
//! Lengths are in sites and positions are relative to the box, so extinction is optical depth per edge of a site.

use glam::DVec3;

use crate::turbid::TurbidMedium;

/// Marks a site of the box that holds nothing.
const EMPTY: u32 = u32::MAX;

/// The bounding box of all matter.
pub(super) struct Sites {
    /// Sites along x, y, z.
    pub size: [u32; 3],
    /// `[z][y][x]` of the box: the place among the non-empty sites, or [`EMPTY`].
    slots: Vec<u32>,
    /// Mean extinction per edge, by leaves and by wood, of each non-empty site, in the order of
    /// [`TurbidMedium::sites`].
    pub matter: Vec<[f64; 2]>,
    /// Axes along which the box goes on for ever, by repetition. A plant has none; plane-parallel media have two.
    pub wraps: [bool; 3],
}

/// A point, and the site that it counts to; on a border that is for the flight to say.
#[derive(Debug, Clone, Copy)]
pub(super) struct PhotonPosition {
    /// Position in sites, relative to the box.
    pub at: DVec3,
    /// x, y, z in the box.
    pub site: [u32; 3],
}

/// Where a straight line ends.
pub(super) enum End {
    /// At a place that the visitor chose, in this non-empty site.
    Inside(PhotonPosition, u32),
    /// Outside of the box, past this side: -x, +x, -y, +y, -z, +z.
    Outside(usize),
}

impl Sites {
    /// Of a checked medium.
    pub(super) fn new(medium: &TurbidMedium, wraps: [bool; 3]) -> Sites {
        let full = medium.sites();
        let [low, high] = medium.grid.box_around(&full).expect("a checked medium holds matter");
        let size: [u32; 3] = std::array::from_fn(|axis| high[axis] - low[axis]);
        let mut slots = vec![EMPTY; size.iter().map(|&edge| edge as usize).product()];
        let spacing = medium.grid.spacing_m;
        let mut matter = Vec::with_capacity(full.len());
        for (slot, &site) in full.iter().enumerate() {
            let position = medium.grid.site(site as usize);
            slots[index_in(size, std::array::from_fn(|axis| position[axis] - low[axis]))] = slot as u32;
            let per_edge = |per_m: &[f32]| f64::from(per_m[site as usize]) * spacing;
            matter.push([per_edge(&medium.leaf_per_m), per_edge(&medium.wood_per_m)]);
        }
        Sites { size, slots, matter, wraps }
    }

    /// The slot of a site of the box; `None` if it is empty.
    pub(super) fn slot(&self, site: [u32; 3]) -> Option<u32> {
        Some(self.slots[index_in(self.size, site)]).filter(|&slot| slot != EMPTY)
    }

    /// Goes from a place along a unit direction, from site to site (Amanatides and Woo, 1987). `visit` hears of every
    /// non-empty site: its slot, how far away it begins, how long the line is in it. It ends the line by returning how
    /// far from the start.
    #[inline]
    pub(super) fn march(
        &self,
        from: PhotonPosition,
        direction: DVec3,
        mut visit: impl FnMut(u32, f64, f64) -> Option<f64>,
    ) -> End {
        let mut index = index_in(self.size, from.site) as isize;
        let strides = [1, self.size[0] as isize, (self.size[0] * self.size[1]) as isize];
        // Per axis: where the next border is, how far apart borders are, sites to go, and what a step adds to the
        // index.
        let (mut next, mut apart) = ([f64::INFINITY; 3], [f64::INFINITY; 3]);
        let (mut left, mut stride) = ([0u32; 3], [0isize; 3]);
        for axis in 0..3 {
            let (d, site) = (direction[axis], from.site[axis]);
            let forward = d >= 0.0;
            left[axis] = if forward { self.size[axis] - site } else { site + 1 };
            stride[axis] = if forward { strides[axis] } else { -strides[axis] };
            if d != 0.0 {
                let border = f64::from(site + u32::from(forward));
                next[axis] = ((border - from.at[axis]) / d).max(0.0);
                apart[axis] = 1.0 / d.abs();
            }
        }
        let mut wrapped = DVec3::ZERO;
        let mut passed = 0.0;
        loop {
            // Without branches: which border is next is anybody's guess.
            let nearer = usize::from(next[1] < next[0]);
            let axis = if next[2] < next[nearer] { 2 } else { nearer };
            let border = next[axis];
            let slot = self.slots[index as usize];
            if slot != EMPTY
                && let Some(stop) = visit(slot, passed, border - passed)
            {
                let site = std::array::from_fn(|axis| match direction[axis] >= 0.0 {
                    true => self.size[axis] - left[axis],
                    false => left[axis] - 1,
                });
                let low = DVec3::from_array(site.map(f64::from));
                let at = (from.at + direction * stop + wrapped).clamp(low, low + DVec3::ONE);
                return End::Inside(PhotonPosition { at, site }, slot);
            }
            passed = border;
            next[axis] += apart[axis];
            left[axis] -= 1;
            if left[axis] > 0 {
                index += stride[axis];
                continue;
            }
            let forward = direction[axis] >= 0.0;
            if !self.wraps[axis] {
                return End::Outside(2 * axis + usize::from(forward));
            }
            left[axis] = self.size[axis];
            index -= stride[axis] * (self.size[axis] as isize - 1);
            wrapped[axis] -= direction[axis].signum() * f64::from(self.size[axis]);
        }
    }

    /// Where a line that passes through `at` enters the box; `None` if it misses it.
    pub(super) fn entry(&self, at: DVec3, direction: DVec3) -> Option<PhotonPosition> {
        let (mut enter, mut leave, mut side) = (f64::NEG_INFINITY, f64::INFINITY, 0);
        for axis in 0..3 {
            let (d, size) = (direction[axis], f64::from(self.size[axis]));
            if d == 0.0 {
                if !(0.0..size).contains(&at[axis]) {
                    return None;
                }
                continue;
            }
            let (near, far) = if d > 0.0 { (0.0, size) } else { (size, 0.0) };
            let t = (near - at[axis]) / d;
            if t > enter {
                (enter, side) = (t, axis);
            }
            leave = leave.min((far - at[axis]) / d);
        }
        (enter < leave).then(|| self.on_side(side, at + direction * enter, direction))
    }

    /// The place at which light along `direction` enters through the side of an axis.
    pub(super) fn on_side(&self, side: usize, at: DVec3, direction: DVec3) -> PhotonPosition {
        let mut at = at;
        let site = std::array::from_fn(|axis| match (axis == side, direction[axis] >= 0.0) {
            (true, true) => 0,
            (true, false) => self.size[axis] - 1,
            _ => (at[axis].max(0.0) as u32).min(self.size[axis] - 1),
        });
        at[side] = if direction[side] >= 0.0 { 0.0 } else { f64::from(self.size[side]) };
        PhotonPosition { at, site }
    }
}

fn index_in(size: [u32; 3], site: [u32; 3]) -> usize {
    let [width, height, _] = size.map(|edge| edge as usize);
    (site[2] as usize * height + site[1] as usize) * width + site[0] as usize
}
