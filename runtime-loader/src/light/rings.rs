//! Rings of suns of a species by height: the near beam of any sun without a march, at the price of a texture.
//!
//! A ring holds the near beams of suns all around a plant at one height above the horizon of its model. Plants that
//! stand upright see a sun at one height, however they are turned, so that two rings serve all of them; between the two
//! the light is faded. A sun that climbs needs the next ring every [`RING_STEP_DEG`] degrees. A plant that is tilted
//! sees the sun at another height, and takes rings of its own or marches.

use std::collections::BTreeMap;
use std::sync::Arc;

use flb_format::beam::{MAX_MEANS, Near};

use crate::near_beam::MediumSites;
use crate::near_beam::ring::{OnRing, SunRing, elevation_deg};
use crate::{InstanceLight, SpeciesLight};

/// Degrees of height from ring to ring.
pub const RING_STEP_DEG: f64 = 2.0;

/// Rings of suns of one species.
///
/// ```
/// # fn main() -> Result<(), flb_runtime::RuntimeError> {
/// # use std::sync::Arc;
/// # use flb_runtime::light::SunRings;
/// # use flb_runtime::{Daylight, Library, SpeciesLight, Transform};
/// # let library = Library::open("golden/shrub.flb")?;
/// # let shrub = SpeciesLight::load(&library, 0)?;
/// let morning = Daylight { towards_sun: [0.6, 0.5, -0.62], sun: 1.0, sky: 0.36 };
/// let mut rings = SunRings::default();
/// if let Some(near) = shrub.near() {
///     for step in SunRings::steps(morning.towards_sun) {
///         // Takes seconds for a large plant: a renderer does it in the background.
///         let ring = shrub.sun_ring(&near, step).expect("it has a near beam");
///         rings.insert(step, Arc::new(ring));
///     }
/// }
/// // The same rings serve every plant of the species that stands upright.
/// let lit = shrub.lit_by(&morning, &Transform::IDENTITY)?.with_rings(&rings);
/// let mut rgb = [0.0; 3];
/// lit.at([0.5, 1.0, -0.2], &mut rgb);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Default)]
pub struct SunRings {
    rings: BTreeMap<i32, Arc<SunRing>>,
}

impl SunRings {
    /// Steps of height that a sun lies between, along a direction in the frame of the model.
    pub fn steps(towards_sun: [f64; 3]) -> [i32; 2] {
        let low = libm::floor(elevation_deg(towards_sun) / RING_STEP_DEG);
        // Straight up there is nothing above.
        let low = low.min(90.0 / RING_STEP_DEG - 1.0) as i32;
        [low, low + 1]
    }

    /// Whether the ring of a step is there.
    pub fn has(&self, step: i32) -> bool {
        self.rings.contains_key(&step)
    }

    /// Adds the ring of a step.
    pub fn insert(&mut self, step: i32, ring: Arc<SunRing>) {
        self.rings.insert(step, ring);
    }

    /// Drops the rings of all other steps.
    pub fn keep(&mut self, steps: [i32; 2]) {
        self.rings.retain(|step, _| steps.contains(step));
    }

    /// Memory that the rings take, bytes.
    pub fn size_bytes(&self) -> usize {
        self.rings.values().map(|ring| ring.size_bytes()).sum()
    }

    /// The rings that a sun lies between; the one that is there alone where the other is missing.
    fn faded(&self, towards_sun: [f64; 3]) -> Option<Faded> {
        let steps = SunRings::steps(towards_sun);
        let share = elevation_deg(towards_sun) / RING_STEP_DEG - f64::from(steps[0]);
        let at = |step: i32| self.rings.get(&step).map(|ring| (Arc::clone(ring), ring.place(towards_sun)));
        match steps.map(at) {
            [Some(low), Some(high)] => Some(Faded { low, high: Some((high, share as f32)) }),
            [Some(one), None] | [None, Some(one)] => Some(Faded { low: one, high: None }),
            [None, None] => None,
        }
    }
}

/// Two rings, and the share of the second.
#[derive(Debug, Clone)]
pub(super) struct Faded {
    low: (Arc<SunRing>, OnRing),
    high: Option<((Arc<SunRing>, OnRing), f32)>,
}

impl Faded {
    /// Means of the near beam at a point, as [`MediumSites::near_at`] has them of one sun.
    pub(super) fn near_at(
        &self,
        sites: &MediumSites,
        single: bool,
        towards_sun: [f64; 3],
        point_model_m: [f32; 3],
    ) -> [f32; MAX_MEANS] {
        let around = sites.around_with_blocks(point_model_m);
        if around.sites.is_empty() {
            return sites.beam_alone(towards_sun, single, point_model_m);
        }
        let of = |(ring, place): &(Arc<SunRing>, OnRing)| ring.sample(*place, &around);
        let low = of(&self.low);
        match &self.high {
            None => low,
            Some((high, share)) => {
                let high = of(high);
                std::array::from_fn(|j| low[j] + share * (high[j] - low[j]))
            }
        }
    }
}

impl SpeciesLight<'_> {
    /// Finds the near beams of suns all around a plant at a step of height ([`SunRings::steps`]), by sums that rings
    /// share ([`SpeciesLight::near`]). It takes about as long as its suns take to be prepared, fewer the higher they
    /// stand, and may be done on any thread. `None` where the light needs no near beam.
    pub fn sun_ring(&self, near: &Near, step: i32) -> Option<SunRing> {
        let species = self.resident();
        let sites = species.sites().filter(|_| species.suns().has_near_beam())?;
        Some(SunRing::of(sites, near, species.needs_single(), f64::from(step) * RING_STEP_DEG))
    }
}

impl InstanceLight<'_> {
    /// Returns the light with the near beam of the rings that its sun lies between. Where neither is there, and where
    /// the light needs no near beam, it stays as it is.
    ///
    /// # Panics
    /// In the light of a point, if the rings are of another species.
    #[must_use]
    pub fn with_rings(self, rings: &SunRings) -> Self {
        match rings.faded(self.terms.towards_sun()) {
            Some(faded) => self.found_by_rings(faded),
            None => self,
        }
    }
}

#[cfg(test)]
mod tests;
