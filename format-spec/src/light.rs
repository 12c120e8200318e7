//! How the light of a `physical` species was made and is stored: what its fields hold, and how they depend on the sun.

pub(crate) mod json;

use std::ops::RangeInclusive;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::beam::means;
use crate::direction::{DIRECTIONS, MOVING};
use crate::sun::directions::SunDirections;
use crate::sun::{self, SunBlend, harmonics};
use crate::turbid::LeafAngles;

/// Method and storage of the light of a `physical` species.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Whether the beam of the sun is part of the fields.
    pub field: FieldKind,
    /// Directions along which scattered light was followed: 18, 50 or 110.
    pub ordinates: u32,
    /// Rays per site edge of the marches, 1..=8.
    pub rays: u32,
    /// Dependence of the fields on the sun.
    pub suns: SunBasis,
    /// Distribution of leaf inclinations.
    pub leaf_angles: LeafAngles,
    /// Error of the stored light, as far as it is known.
    pub error: LightError,
    /// Distance from a solid's surface at which light is sampled, in sites, 0..=[`MAX_SOLID_OFFSET`]: the fields hold
    /// what surfaces receive. `None`: they hold the mean fluence of each site.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "json::solid_offset")]
    pub solid_offset: Option<f64>,
}

impl Light {
    /// Returns the light of leaves with these inclinations.
    #[must_use]
    pub fn of_leaves(self, angles: &LeafAngles) -> Light {
        Light { suns: self.suns.of_leaves(angles), leaf_angles: angles.clone(), ..self }
    }
}

/// Largest [`Light::solid_offset`].
pub const MAX_SOLID_OFFSET: f64 = 2.0;

/// Content of a field of the sun's light: with or without the uncollided beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum FieldKind {
    /// Light that was scattered once or more; a renderer adds the beam by its shadow rays.
    Scattered,
    /// The uncollided beam as well.
    Total,
}

impl FieldKind {
    /// "scattered" or "total", as in files.
    pub fn name(self) -> &'static str {
        match self {
            FieldKind::Scattered => "scattered",
            FieldKind::Total => "total",
        }
    }
}

/// Dependence of the fields of a `physical` species on the sun.
#[derive(Debug, Clone, PartialEq)]
pub enum SunBasis {
    /// One field per lattice direction, blended by three as in `paper`.
    Lattice18,
    /// Coefficients of real harmonics and of the near beam.
    Harmonics {
        /// Highest degree, 1..=3.
        degree: u8,
        /// Whether the near beam has a fifth mean: the light scattered once.
        single: bool,
        /// Whether a sun's near beam counts as often as leaves meet it: times [`LeafAngles::relative`] of its
        /// direction. Only where leaves favour an inclination, and fields leave the beam out.
        leaning: bool,
    },
    /// One field per direction of a list, blended by the three of a triangle.
    Directions(Arc<SunDirections>),
}

impl SunBasis {
    /// "lattice18", "harmonics" or "directions", as in files.
    pub fn name(&self) -> &'static str {
        match self {
            SunBasis::Lattice18 => "lattice18",
            SunBasis::Harmonics { .. } => "harmonics",
            SunBasis::Directions(_) => "directions",
        }
    }

    /// Fields of directions and their weights for a sun (model space, any length); `None` for harmonics, and where the
    /// vector is zero or not finite.
    pub fn blend(&self, towards_sun_model: [f64; 3]) -> Option<SunBlend> {
        match self {
            SunBasis::Lattice18 => sun::blend(towards_sun_model),
            SunBasis::Harmonics { .. } => None,
            SunBasis::Directions(list) => list.blend(towards_sun_model),
        }
    }

    /// Number of base items: the sky, then those of the sun.
    pub fn items(&self) -> u16 {
        match self {
            SunBasis::Lattice18 => 1 + MOVING as u16,
            SunBasis::Harmonics { degree, single, .. } => {
                (1 + harmonics::count(*degree) + means(*single)) as u16
            }
            SunBasis::Directions(list) => 1 + list.directions().len() as u16,
        }
    }

    /// Numbers of all items.
    pub fn item_numbers(&self) -> RangeInclusive<u8> {
        0..=(self.items() - 1) as u8
    }

    /// Whether the light of a sun needs the near beam beside the fields: of harmonics.
    pub fn has_near_beam(&self) -> bool {
        matches!(self, SunBasis::Harmonics { .. })
    }

    /// Item of the near beam's coefficient b_0, behind those of the harmonics; `None` where there is none.
    pub fn first_near_item(&self) -> Option<u8> {
        match self {
            SunBasis::Lattice18 | SunBasis::Directions(_) => None,
            SunBasis::Harmonics { degree, .. } => Some(1 + harmonics::count(*degree) as u8),
        }
    }

    /// Unit direction towards the sun whose light an item holds, in model space; `None` for the sky and for harmonics,
    /// whose items hold the light of all suns.
    pub fn sun_of(&self, item: u8) -> Option<[f64; 3]> {
        let number = usize::from(item).checked_sub(1)?;
        match self {
            SunBasis::Harmonics { .. } => None,
            SunBasis::Lattice18 => {
                let along = DIRECTIONS.get(usize::from(item))?.map(f64::from);
                let length = libm::sqrt(along.iter().map(|c| c * c).sum());
                Some(along.map(|c| -c / length))
            }
            SunBasis::Directions(list) => list.directions().get(number).copied(),
        }
    }

    /// Returns the same for fields of a kind: with the beam in them it cannot lean.
    #[must_use]
    pub fn of_field(self, field: FieldKind) -> SunBasis {
        self.leaning_if(field == FieldKind::Scattered)
    }

    /// Returns the same for leaves of these inclinations: without one that they favour nothing leans.
    #[must_use]
    pub fn of_leaves(self, angles: &LeafAngles) -> SunBasis {
        self.leaning_if(!angles.is_spherical())
    }

    fn leaning_if(mut self, may_lean: bool) -> SunBasis {
        if let SunBasis::Harmonics { leaning, .. } = &mut self {
            *leaning &= may_lean;
        }
        self
    }

    /// Whether the near beam counts as often as leaves meet it.
    pub fn is_leaning(&self) -> bool {
        matches!(self, SunBasis::Harmonics { leaning: true, .. })
    }

    /// Whether the near beam's fifth mean, the light scattered once, is needed.
    pub fn needs_single(&self) -> bool {
        matches!(self, SunBasis::Harmonics { single: true, .. })
    }
}

/// Error of the stored light of a `physical` species, before coding; shares of the mean total fluence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightError {
    /// Root mean square error of the fit over the suns that were held out, in the worst band.
    pub suns_rms: f64,
    /// Suns that were held out.
    pub held_out: u32,
    /// Estimated relative error of the solver.
    pub solver: f64,
    /// Against Monte Carlo in the same medium, where it was measured.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "json::present")]
    pub monte_carlo: Option<MonteCarloError>,
}

/// Error against Monte Carlo in the same medium.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MonteCarloError {
    /// Root mean square, noise removed.
    pub rms: f64,
    /// Mean; negative where the stored light is too dark.
    pub bias: f64,
    /// Photons per sun.
    pub photons: u64,
    /// Suns.
    pub suns: u32,
}
