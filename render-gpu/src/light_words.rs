//! A plant's light as light.wgsl reads it, and the check that every plant has one.

use flb_format::Placement;
use flb_render::Lighting;
use flb_render::forest::Scenery;
use flb_scene::sky::Sky;

use crate::ForestError;
use crate::layout::{NONE, Words};

/// Of the terms of a sky: they are of an uneven one; `UNEVEN`.
const UNEVEN: u32 = 1 << 31;

/// The daylight on a forest.
pub(crate) struct DaylightOn<'a> {
    /// Unit, in the frame of the world.
    pub towards_sun: [f64; 3],
    pub sun: f32,
    /// Strength of an even sky.
    pub sky: f32,
    /// An uneven sky in its place.
    pub dome: Option<&'a Sky>,
}

impl<'a> DaylightOn<'a> {
    pub(crate) fn new(scenery: &Scenery, lighting: &'a Lighting) -> DaylightOn<'a> {
        DaylightOn {
            towards_sun: scenery.towards_sun,
            sun: scenery.sun_strength,
            sky: lighting.daylight.sky,
            dome: lighting.dome.as_ref(),
        }
    }

    /// Strength of an even sky, or of one that stands in where what an uneven one needs is not there.
    pub(crate) fn even(&self) -> f32 {
        self.dome.map_or(self.sky, |dome| dome.fluence().iter().sum::<f32>() / 3.0)
    }
}

/// `sky_count` of so many terms of an uneven sky.
pub(crate) fn uneven(terms: usize) -> u32 {
    terms as u32 | UNEVEN
}

/// The members of a `SpeciesTerms`, in their order.
#[derive(Default)]
pub(crate) struct LightWords {
    pub constant: [f32; 3],
    /// `None`: nothing but the constant.
    pub species: Option<u32>,
    pub towards_sun: [f64; 3],
    pub first_term: u32,
    pub term_count: u32,
    pub near_count: u32,
    pub least: f32,
    pub sky_count: u32,
}

impl LightWords {
    pub(crate) fn add_to(&self, words: &mut Words) {
        words.floats(self.constant).whole(self.species.unwrap_or(NONE)).rounded(self.towards_sun);
        words.whole(self.first_term).whole(self.term_count).whole(self.near_count);
        words.float(self.least).whole(self.sky_count);
    }
}

/// Refuses plants of species beyond those that have an entry, with or without light.
pub(crate) fn check_species(plants: &[Placement], found: usize) -> Result<(), ForestError> {
    let expected = plants.iter().map(|plant| plant.species + 1).max().unwrap_or(0);
    match expected > found {
        true => Err(ForestError::Species { found, expected }),
        false => Ok(()),
    }
}
