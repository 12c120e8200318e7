//! A plant's light as light.wgsl reads it, and the check that every plant has one.

use flb_format::Placement;

use crate::ForestError;
use crate::layout::{NONE, Words};

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
