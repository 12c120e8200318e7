//! Woodcock tracking (1965): flights in a medium that is everywhere as dense as the densest site. Where a flight ends,
//! matter is met with the probability that the site is that dense; otherwise the flight goes on.
//!
//! It shares neither the marching nor the first collisions nor the scoring with regular tracking: its oracle.

use glam::DVec3;

use super::super::scatter::Scattering;
use super::super::sites::{PhotonPosition, Sites};
use super::super::source::Start;
use super::{Batch, MAX_COLLISIONS, MonteCarloError};

/// Where a delta flight ends.
enum Flown {
    Collision(PhotonPosition, u32),
    Left(usize),
}

/// The largest extinction of any site in any direction.
pub(super) fn majorant(sites: &Sites, scattering: &Scattering) -> f64 {
    let most = scattering.most_relative();
    sites.matter.iter().fold(0.0, |found: f64, [leaf, wood]| found.max(leaf * most + wood))
}

impl Batch<'_> {
    /// From the side of the box to the end.
    pub(super) fn photon_by_delta(&mut self, start: Start, majorant: f64) -> Result<(), MonteCarloError> {
        let (mut direction, mut weight) = (start.direction, start.area);
        // The beam before its first collision does not score.
        let Flown::Collision(mut place, mut slot) = self.fly_by_delta(start.place, direction, 0.0, majorant)
        else {
            return Ok(());
        };
        self.tally.balance.intercepted += weight;
        for _ in 0..MAX_COLLISIONS {
            let Some(turned) = self.collide(direction, slot, &mut weight, start.area) else { return Ok(()) };
            direction = turned;
            match self.fly_by_delta(place, direction, weight, majorant) {
                Flown::Collision(at, met) => (place, slot) = (at, met),
                Flown::Left(side) => {
                    self.tally.balance.escaped[side] += weight;
                    return Ok(());
                }
            }
        }
        Err(self.trapped())
    }

    fn fly_by_delta(&mut self, from: PhotonPosition, direction: DVec3, weight: f64, majorant: f64) -> Flown {
        let size = DVec3::from_array(self.sites.size.map(f64::from));
        let relative = self.scattering.relative(direction);
        let mut at = from.at;
        loop {
            at += direction * (self.draw.free_path() / majorant);
            for axis in (0..3).filter(|&axis| self.sites.wraps[axis]) {
                at[axis] = at[axis].rem_euclid(size[axis]).clamp(0.0, size[axis]);
            }
            if at.cmplt(DVec3::ZERO).any() || at.cmpge(size).any() {
                return Flown::Left(left_by(at, direction, size));
            }
            let site = at.to_array().map(|c| c as u32);
            let Some(slot) = self.sites.slot(site) else { continue };
            self.tally.lengths[slot as usize] += weight / majorant;
            let [leaf, wood] = self.sites.matter[slot as usize];
            if self.draw.unit() * majorant < leaf * relative + wood {
                return Flown::Collision(PhotonPosition { at, site }, slot);
            }
        }
    }
}

/// The side by which a line left the box that has come to `at`: the one that it passed first.
fn left_by(at: DVec3, direction: DVec3, size: DVec3) -> usize {
    let (mut first, mut side) = (f64::NEG_INFINITY, 0);
    for axis in 0..3 {
        let forward = direction[axis] > 0.0;
        let past = if forward { at[axis] - size[axis] } else { -at[axis] };
        let back = past / direction[axis].abs();
        if past >= 0.0 && back > first {
            (first, side) = (back, 2 * axis + usize::from(forward));
        }
    }
    side
}
