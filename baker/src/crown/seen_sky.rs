//! The light of an even sky that comes to the leaves of a site straight, counted on the mesh.
//!
//! The cloud of the solver shades a flat leaf that sees all of the sky, and lights a leaf behind a wall. The rays that
//! measure a crown know better. Each meets a leaf at two sides, and a surface the more often the more it faces them. So
//! the share of sides before which the ray has met nothing is the share of the sky's light that comes to these sides.

use flb_transport::turbid::TurbidMedium;

use super::measure::SiteLight;

/// Sides that the cloud's word counts for beside those that were met: few rays meet a splinter of a leaf.
const PRIOR_SIDES: f32 = 8.0;

/// Most of the cloud's scattered light that leaves receive which see less of the sky than the cloud.
const MAX_SCATTERED: f32 = 4.0;

/// Sides of leaves that rays met, per site, in the order of [`TurbidMedium::sites`]. Rays count by the weights of their
/// axes, 1 in the mean.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SeenSky {
    /// All sides.
    pub sides: Vec<f32>,
    /// Sides before which the ray had met nothing: at most all.
    pub open: Vec<f32>,
    /// Sides that face wood: what the ray met last before.
    pub wood: Vec<f32>,
}

impl SeenSky {
    /// Of the `light` in `sites`, as far as they are sites of `turbid`.
    pub(super) fn of(turbid: &TurbidMedium, sites: &[u32], light: &[SiteLight]) -> SeenSky {
        let kept = sites.iter().zip(light).filter(|(site, _)| turbid.extinction(**site as usize) > 0.0);
        let mut seen = SeenSky::default();
        for (_, light) in kept {
            let [open, all, wood] = light.leaf_sides.map(|sides| sides as f32);
            seen.open.push(open);
            seen.sides.push(all);
            seen.wood.push(wood);
        }
        seen
    }

    /// The share of what its leaves see that is wood, in the site at a place of the list.
    pub fn of_wood(&self, place: usize) -> f32 {
        self.wood[place] / (self.sides[place] + PRIOR_SIDES)
    }

    /// Light that leaves receive under an even sky of fluence 1, 0..=1, in the site at a place of the list. The cloud
    /// says that they receive `all`, and `straight` of it straight from the sky.
    ///
    /// What a leaf does not see of the sky, it sees of the plant: scattered light goes with that share. So a plant that
    /// absorbs nothing stays as bright as the sky.
    pub fn on_leaves(&self, place: usize, all: f32, straight: f32) -> f32 {
        let straight = straight.min(1.0);
        let seen = (self.open[place] + PRIOR_SIDES * straight) / (self.sides[place] + PRIOR_SIDES);
        let hidden = (1.0 - seen) / (1.0 - straight).max(f32::EPSILON);
        (seen + hidden.min(MAX_SCATTERED) * (all - straight)).clamp(0.0, 1.0)
    }
}
