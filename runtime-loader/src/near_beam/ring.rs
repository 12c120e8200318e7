//! Near beams of suns all around a plant at one height, kept in a few bits a site: between two of them any sun of that
//! height is found without a march and without noise.
//!
//! A plant that is turned, and a sun that moves on, only choose another place on the ring. What counts for the error is
//! the arc between two suns, so fewer do where the sun stands high. The sun's height changes slowly; two rings a step
//! apart are faded (`light/rings.rs`).

mod packed;

use std::f64::consts::TAU;

use flb_format::beam::single::BESIDE;
use flb_format::beam::{BEAM_RAYS, Beam, MAX_MEANS, Near};
use flb_format::sun::towards_sun;

use super::MediumSites;
use super::sites::AroundBlocks;
use packed::Turn;

/// Suns of a ring on the horizon.
const TURNS: f64 = 56.0;
/// Fewest suns of a ring.
const MIN_TURNS: f64 = 4.0;

/// Near beams of suns all around a plant, at one height above the horizon of its model.
#[derive(Debug, Clone, PartialEq)]
pub struct SunRing {
    /// Clockwise from above; the first stands in the north.
    turns: Vec<Turn>,
}

/// Place on a ring: two suns and the share of the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OnRing {
    turns: [usize; 2],
    share: f32,
}

impl SunRing {
    /// Finds the near beams of all suns of a ring.
    pub(crate) fn of(sites: &MediumSites, near: &Near, single: bool, elevation_deg: f64) -> SunRing {
        let count = turns_at(elevation_deg);
        let sun = |turn| towards_sun(360.0 * turn as f64 / count as f64, elevation_deg);
        let suns: Vec<[f64; 3]> = (0..count).map(sun).collect();
        let mut turns = Vec::with_capacity(count);
        for some in suns.chunks(BESIDE) {
            let beams: Vec<Beam> = some.iter().map(|sun| near.uncollided(*sun, BEAM_RAYS)).collect();
            let means: Vec<&[f32]> = beams.iter().map(|beam| &beam.mean[..]).collect();
            for (mean, around) in means.iter().zip(near.around_each(&means)) {
                let all: Vec<&[f32]> =
                    std::iter::once(*mean).chain(around.iter().map(Vec::as_slice)).collect();
                turns.push(Turn::of(sites, single, &all));
            }
        }
        SunRing { turns }
    }

    /// Number of suns.
    pub fn suns(&self) -> usize {
        self.turns.len()
    }

    /// Memory that it takes, bytes.
    pub fn size_bytes(&self) -> usize {
        self.turns.iter().map(Turn::size_bytes).sum()
    }

    /// The place of a sun, whatever its height.
    pub(crate) fn place(&self, towards_sun: [f64; 3]) -> OnRing {
        let count = self.turns.len();
        let turns = turned(towards_sun) * count as f64;
        let first = libm::floor(turns);
        let turn = first as usize % count;
        OnRing { turns: [turn, (turn + 1) % count], share: (turns - first) as f32 }
    }

    /// Means of the near beam near sites with matter.
    pub(crate) fn sample(&self, place: OnRing, around: &AroundBlocks) -> [f32; MAX_MEANS] {
        let [a, b] = place.turns.map(|turn| self.turns[turn].sample(around));
        std::array::from_fn(|j| a[j] + place.share * (b[j] - a[j]))
    }
}

/// Suns of a ring at a height.
fn turns_at(elevation_deg: f64) -> usize {
    libm::ceil((TURNS * libm::cos(elevation_deg.to_radians())).max(MIN_TURNS)) as usize
}

/// Share of a whole turn from north to a direction, clockwise from above.
fn turned([x, _, z]: [f64; 3]) -> f64 {
    let turned = libm::atan2(x, -z) / TAU;
    turned - libm::floor(turned)
}

/// Height of a direction above the horizon, in degrees.
pub(crate) fn elevation_deg([x, y, z]: [f64; 3]) -> f64 {
    libm::atan2(y, libm::sqrt(x * x + z * z)).to_degrees()
}
