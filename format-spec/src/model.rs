//! Which model made the light of a species, and with what: the papers' optics, or surfaces and how the light is stored.
//!
//! Nothing else of this crate asks which of the two it is: what differs between them is asked here, by what it means.

use crate::light::{Light, SunBasis};
use crate::optics::Optics;
use crate::surfaces::Surfaces;

/// The light transport model of a species, with what belongs to it alone.
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "one per species: boxing the angles would save nothing worth it"
)]
pub enum Model {
    /// The papers', with what they leave open settled (lighting model, sections 1 to 6 and 11).
    Paper {
        /// Optical parameters per band; their order is the bands' order.
        optics: Optics,
    },
    /// Extinction in m^-1, surfaces from data (lighting model, section 9).
    Physical {
        /// Leaf and wood per band; their order is the bands' order.
        surfaces: Surfaces,
        /// Method and storage of the light.
        light: Light,
    },
}

/// Members of a model in a file: `optics`, `surfaces` and `light`.
pub(crate) type Members = (Option<Optics>, Option<Surfaces>, Option<Light>);

/// Basis of the papers' sun.
static LATTICE18: SunBasis = SunBasis::Lattice18;

impl Model {
    /// "paper" or "physical", as in files.
    pub fn name(&self) -> &'static str {
        match self {
            Model::Paper { .. } => "paper",
            Model::Physical { .. } => "physical",
        }
    }

    /// The papers' optics; `None` for another model.
    pub fn optics(&self) -> Option<&Optics> {
        match self {
            Model::Paper { optics } => Some(optics),
            Model::Physical { .. } => None,
        }
    }

    /// Surfaces and light of the model `physical`; `None` for another.
    pub fn physical(&self) -> Option<(&Surfaces, &Light)> {
        match self {
            Model::Paper { .. } => None,
            Model::Physical { surfaces, light } => Some((surfaces, light)),
        }
    }

    /// The members that a file has of it.
    pub(crate) fn into_members(self) -> Members {
        match self {
            Model::Paper { optics } => (Some(optics), None, None),
            Model::Physical { surfaces, light } => (None, Some(surfaces), Some(light)),
        }
    }

    /// The model of a name with the members that a file has of it, or what is wrong with them.
    pub(crate) fn of_members(name: &str, members: Members) -> Result<Model, String> {
        let there = |there: bool| if there { "present" } else { "missing" };
        Ok(match (name, members) {
            ("paper", (Some(optics), None, None)) => Model::Paper { optics },
            ("physical", (None, Some(surfaces), Some(light))) => Model::Physical { surfaces, light },
            ("paper" | "physical", (optics, surfaces, light)) => {
                return Err(format!(
                    "model {name:?} with `optics` {}, `surfaces` {}, `light` {}: paper has optics alone, physical has surfaces \
                     and light",
                    there(optics.is_some()),
                    there(surfaces.is_some()),
                    there(light.is_some())
                ));
            }
            (other, _) => return Err(format!("model is {other}, expected \"paper\" or \"physical\"")),
        })
    }

    /// Number of bands.
    pub fn band_count(&self) -> usize {
        match self {
            Model::Paper { optics } => optics.bands.len(),
            Model::Physical { surfaces, .. } => surfaces.bands.len(),
        }
    }

    /// Name of a band.
    ///
    /// # Panics
    /// If there is no such band.
    pub fn band(&self, band: usize) -> &str {
        match self {
            Model::Paper { optics } => &optics.bands[band].name,
            Model::Physical { surfaces, .. } => &surfaces.bands[band].name,
        }
    }

    /// Keeps these bands alone, in this order.
    ///
    /// # Panics
    /// If there is no such band.
    pub(crate) fn keep_bands(&mut self, bands: &[usize]) {
        match self {
            Model::Paper { optics } => {
                optics.bands = bands.iter().map(|&band| optics.bands[band].clone()).collect();
            }
            Model::Physical { surfaces, .. } => {
                surfaces.bands = bands.iter().map(|&band| surfaces.bands[band].clone()).collect();
            }
        }
    }

    /// Dependence of the fields on the sun.
    pub fn suns(&self) -> &SunBasis {
        match self {
            Model::Paper { .. } => &LATTICE18,
            Model::Physical { light, .. } => &light.suns,
        }
    }

    /// Number of base items that a species of this model can have, from 0 on.
    pub fn items(&self) -> u16 {
        self.suns().items()
    }

    /// Whether a file has every item (M12, M38): of harmonics each sun takes a share of all, and lists of directions
    /// are kept whole.
    pub fn needs_all_items(&self) -> bool {
        *self.suns() != SunBasis::Lattice18
    }

    /// Whether its medium has an extinction in m^-1 beside the shares that sites are filled to; such a file has the
    /// feature `physical`.
    pub fn has_extinction(&self) -> bool {
        self.physical().is_some()
    }

    /// Light of a sky of strength 1 where nothing stands: the papers' ambient base adds up 18 directions, the other's
    /// fluence is 1.
    pub fn open_sky(&self) -> f32 {
        match self {
            Model::Paper { .. } => crate::direction::MOVING as f32,
            Model::Physical { .. } => 1.0,
        }
    }

    /// Whether its light is never below 0: what a reader finds below is an error of the coding, to be cut off.
    pub fn is_bounded(&self) -> bool {
        self.physical().is_some()
    }

    /// Whether its light depends on the lattice that it was baked at (lighting model, section 2).
    pub fn is_bound_to_lattice(&self) -> bool {
        self.optics().is_some()
    }

    /// Light of a base in empty space, by which thresholds are scaled (SPEC.md, M28).
    pub fn empty_value(&self, base: u8) -> f32 {
        if base == 0 && self.optics().is_some() { 18.0 } else { 1.0 }
    }
}
