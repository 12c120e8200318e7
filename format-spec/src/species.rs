//! A species before coding: what a bake returns and a packer takes.

use crate::turbid::TurbidMedium;
use crate::{Field, Medium, SpeciesMeta};

/// Everything about a species that its file is made of. Baker and packer meet here alone.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesFields {
    /// Name, units, optics, provenance. `settings` gains the keys `encode.*` when it is coded.
    pub meta: SpeciesMeta,
    /// Medium of the plant, on the grid of `meta`.
    pub medium: Medium,
    /// Extinction of the plant, with the grid and the leaf angles of `meta`: of the model `physical`, and of no other.
    pub turbid: Option<TurbidMedium>,
    /// Item and field, in any order: 0..=18 where `meta` says so; all items where the suns are harmonics or a list of
    /// directions.
    pub bases: Vec<(u8, Field)>,
}
