//! Photons from their first collision to their end, in batches.

mod delta;
mod sums;

use flb_format::progress::Progress;
use glam::DVec3;

use super::draw::Draw;
use super::scatter::Scattering;
use super::sites::{End, PhotonPosition, Sites};
use super::source::{Source, Start};
use super::{BATCHES, Balance, Illumination, MonteCarloError, Settings, Tracking, check, in_order};
use crate::turbid::{BandScatter, LeafAngles};
use sums::Sums;

/// Walks fainter than this share of a full one play Russian roulette ...
const FAINT: f64 = 0.25;

/// ... and go on with this share if they win.
const REVIVED: f64 = 0.5;

/// Most collisions of a photon: a walk out of a medium of optical depth t takes some t^2 of them.
const MAX_COLLISIONS: u32 = 1_000_000;

/// What all batches gave; lengths in sites, power in square sites.
pub(super) struct Walked {
    pub scattered: Vec<f64>,
    pub error: Vec<f64>,
    pub mean_error: f64,
    pub balance: Balance,
}

/// Scattered light in checked sites under checked settings.
pub(super) fn scattered(
    sites: &Sites,
    angles: &LeafAngles,
    scatter: &BandScatter,
    albedos: Option<&[[f32; 2]]>,
    light: Illumination,
    settings: &Settings,
    progress: &Progress<'_>,
) -> Result<Walked, MonteCarloError> {
    let light = match light {
        Illumination::Sun(toward) => Illumination::Sun(check::direction(toward)?),
        Illumination::Sky => Illumination::Sky,
    };
    let scattering = Scattering::new(scatter, angles, albedos);
    let photons = settings.photons.div_ceil(BATCHES as u64);
    let majorant = delta::majorant(sites, &scattering);
    let run = |batch: usize| {
        let draw = Draw::new(settings.seed, batch as u64);
        let mut walk = Batch { sites, scattering: &scattering, draw, tally: Tally::new(sites) };
        let mut source = Source::new(light, &mut walk.draw);
        for _ in 0..photons {
            let start = source.start(sites);
            match settings.tracking {
                Tracking::Regular => walk.photon(start)?,
                Tracking::Delta => walk.photon_by_delta(start, majorant)?,
            }
        }
        Ok(walk.tally)
    };
    let mut sums = Sums::new(sites.matter.len(), photons as f64);
    in_order(BATCHES, progress, run, |tally| sums.add(tally))?;
    Ok(sums.finish())
}

/// What one batch of photons left behind.
struct Tally {
    /// Weight times length of flight per non-empty site.
    lengths: Vec<f64>,
    balance: Balance,
}

impl Tally {
    fn new(sites: &Sites) -> Tally {
        Tally { lengths: vec![0.0; sites.matter.len()], balance: Balance::default() }
    }
}

struct Batch<'a> {
    sites: &'a Sites,
    scattering: &'a Scattering<'a>,
    draw: Draw,
    tally: Tally,
}

impl Batch<'_> {
    /// The first collision is drawn from where the beam is lost, so that every ray that meets matter counts.
    fn photon(&mut self, start: Start) -> Result<(), MonteCarloError> {
        let relative = self.scattering.relative(start.direction);
        let sites = self.sites;
        let depth_of = |slot: u32, length: f64| {
            let [leaf, wood] = sites.matter[slot as usize];
            (leaf * relative + wood) * length
        };
        let (mut depth, mut last) = (0.0, 0);
        sites.march(start.place, start.direction, |slot, _, length| {
            let here = depth_of(slot, length);
            if here > 0.0 {
                (depth, last) = (depth + here, slot);
            }
            None
        });
        if depth == 0.0 {
            return Ok(());
        }
        let lost = -libm::expm1(-depth);
        let mut left = -libm::log1p(-start.depth * lost);
        let end = sites.march(start.place, start.direction, |slot, away, length| {
            let here = depth_of(slot, length);
            // The sum may round otherwise than before: what is left in the last site ends there.
            if here > 0.0 && (left < here || slot == last) {
                return Some(away + length * (left / here).min(1.0));
            }
            left -= here;
            None
        });
        let End::Inside(place, slot) = end else { return Ok(()) };
        let weight = start.area * lost;
        self.tally.balance.intercepted += weight;
        self.walk(start.direction, place, slot, weight, start.area)
    }

    /// From a collision to the end; `full` is the weight before any loss.
    fn walk(
        &mut self,
        mut direction: DVec3,
        mut place: PhotonPosition,
        mut slot: u32,
        mut weight: f64,
        full: f64,
    ) -> Result<(), MonteCarloError> {
        for _ in 0..MAX_COLLISIONS {
            let Some(turned) = self.collide(direction, slot, &mut weight, full) else { return Ok(()) };
            direction = turned;
            match self.fly(place, direction, weight) {
                End::Inside(at, met) => (place, slot) = (at, met),
                End::Outside(side) => {
                    self.tally.balance.escaped[side] += weight;
                    return Ok(());
                }
            }
        }
        Err(self.trapped())
    }

    /// A collision in a site: the weight that is left, and the direction; `None` if the walk ends.
    fn collide(&mut self, direction: DVec3, slot: u32, weight: &mut f64, full: f64) -> Option<DVec3> {
        let met = self.scattering.meet(slot, self.sites.matter[slot as usize], direction, &mut self.draw);
        self.tally.balance.absorbed += *weight * (1.0 - met.albedo);
        *weight *= met.albedo;
        let whole = full * self.scattering.albedo(slot);
        if *weight < FAINT * whole {
            let revived = REVIVED * whole;
            if self.draw.unit() * revived >= *weight {
                return None;
            }
            *weight = revived;
        }
        (*weight > 0.0).then(|| self.scattering.turn(&met, direction, &mut self.draw))
    }

    /// A free flight; every site crossed scores its length.
    fn fly(&mut self, from: PhotonPosition, direction: DVec3, weight: f64) -> End {
        let relative = self.scattering.relative(direction);
        let mut left = self.draw.free_path();
        let (sites, lengths) = (self.sites, &mut self.tally.lengths);
        sites.march(from, direction, |slot, away, length| {
            let [leaf, wood] = sites.matter[slot as usize];
            let extinction = leaf * relative + wood;
            let depth = extinction * length;
            if depth > left {
                let run = left / extinction;
                lengths[slot as usize] += weight * run;
                return Some(away + run);
            }
            left -= depth;
            lengths[slot as usize] += weight * length;
            None
        })
    }

    fn trapped(&self) -> MonteCarloError {
        let depth = self.sites.matter.iter().fold(0.0, |most: f64, [leaf, wood]| most.max(leaf + wood));
        MonteCarloError::Trapped { limit: MAX_COLLISIONS, depth }
    }
}
