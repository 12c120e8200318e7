//! The plan file: what `flb bake` and `flb pack` are to keep. TOML or JSON by its extension; one plan, one byte string.
//!
//! ```toml
//! schema = 1
//! reason = "every sun above the horizon, plants that turn only about the vertical"
//! bands = ["R", "G", "B"]        # default: all
//! bases = [0, 1, 2]              # for every species; only where no [[species]] follow
//!
//! [[species]]                    # by name, ascending
//! name = "oak"
//! bases = [0, 1, 2]
//! lattice = 64                   # default: the bake's own
//! ```

use std::path::Path;

use flb_format::bases::BaseSet;
use flb_format::canonical;
use flb_format::meta::MAX_REASON_BYTES;
use flb_format::text::url::shown_lines;
use serde::{Deserialize, Serialize};

use super::Outline;
use flb_scene::ImportError;
use flb_scene::import::{TEXT_BYTES, read_text};
use flb_scene::species::MAX_BANDS;

/// The schema that this build writes and reads.
pub const SCHEMA: u32 = 1;

/// Bases, bands and lattices to bake.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Reason why the rest is left out; goes into the files.
    pub reason: String,
    /// Names of the bands to bake; `None`: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bands: Option<Vec<String>>,
    /// Bases of every species; exactly where `species` is empty.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bases: Option<BaseSet>,
    /// Ascending by name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub species: Vec<SpeciesPlan>,
}

/// Bases and lattice of a species to bake.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeciesPlan {
    /// Name of the species.
    pub name: String,
    /// Bases to keep; not none.
    pub bases: BaseSet,
    /// Sites along each edge; `None`: the bake decides.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice: Option<u32>,
}

/// Bases and lattice that a plan gives one species.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannedSpecies {
    /// Bases to keep.
    pub bases: BaseSet,
    /// The lattice, if the plan chose one.
    pub lattice: Option<u32>,
}

/// A plan that cannot be, or is not the one for the job.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// Plan without a base, as there is no sun and no ambient light.
    #[error("{subject} needs no base at all ({reason}): there is nothing to bake")]
    Nothing {
        /// The species, or the plan.
        subject: String,
        /// Reason why no base is needed.
        reason: String,
    },
    /// A species that is not in the plan.
    #[error("species {name:?} is not in the plan, which has: {}", known.join(", "))]
    UnknownSpecies {
        /// The species.
        name: String,
        /// Names of the plan's species.
        known: Vec<String>,
    },
    /// A band that a species does not have.
    #[error("the plan asks for band {name:?}, which species {species:?} does not have; it has: {}", known.join(", "))]
    UnknownBand {
        /// The band.
        name: String,
        /// The species.
        species: String,
        /// Names of the species' bands.
        known: Vec<String>,
    },
}

impl Plan {
    /// The plan of an outline.
    ///
    /// # Errors
    /// [`PlanError::Nothing`].
    pub fn of(outline: &Outline) -> Result<Plan, PlanError> {
        let needed = |subject: String, bases: BaseSet| match bases.is_empty() {
            true => Err(PlanError::Nothing { subject, reason: outline.reason.clone() }),
            false => Ok(bases),
        };
        let mut species = Vec::with_capacity(outline.species.len());
        for need in &outline.species {
            let bases = needed(format!("species {:?}", need.name), need.bases)?;
            let lattice = need.on_screen.map(|seen| seen.lattice);
            species.push(SpeciesPlan { name: need.name.clone(), bases, lattice });
        }
        species.sort_by(|a, b| a.name.cmp(&b.name));
        let bases = match species.is_empty() {
            true => Some(needed("the plan".to_owned(), outline.any_upright)?),
            false => None,
        };
        let (reason, bands) = (outline.reason.clone(), outline.bands.clone());
        Ok(Plan { schema: SCHEMA, reason, bands, bases, species })
    }

    /// Returns the bases and lattice of the species of this name.
    ///
    /// # Errors
    /// [`PlanError::UnknownSpecies`].
    pub fn share(&self, name: &str) -> Result<PlannedSpecies, PlanError> {
        if let Some(bases) = self.bases {
            return Ok(PlannedSpecies { bases, lattice: None });
        }
        let found = self.species.iter().find(|species| species.name == name);
        found.map(|species| PlannedSpecies { bases: species.bases, lattice: species.lattice }).ok_or_else(
            || {
                let known = self.species.iter().map(|species| species.name.clone()).collect();
                PlanError::UnknownSpecies { name: name.to_owned(), known }
            },
        )
    }

    /// Writes the plan as TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("names, numbers and lists are TOML")
    }

    /// Writes the plan as canonical JSON and a line break.
    pub fn to_json(&self) -> Vec<u8> {
        let value = serde_json::to_value(self).expect("names, numbers and lists are JSON");
        let mut bytes = canonical::to_bytes(&value).expect("it is neither deep nor are its numbers large");
        bytes.push(b'\n');
        bytes
    }

    /// Reads and validates a plan file: JSON if its name ends in `.json`, else TOML.
    ///
    /// # Errors
    /// [`ImportError::Io`], [`ImportError::Limit`], [`ImportError::Syntax`] with line and column,
    /// [`ImportError::Malformed`] for another schema and for values out of their range.
    pub fn read(path: &Path) -> Result<Plan, ImportError> {
        let (file, text) = read_text(path, TEXT_BYTES)?;
        let syntax = |message: String| {
            let message = shown_lines(&message).into_owned();
            ImportError::Syntax { file: file.clone(), message }
        };
        let json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
        let plan: Plan = match json {
            true => serde_json::from_str(&text).map_err(|error| syntax(error.to_string()))?,
            false => {
                toml::from_str(&text).map_err(|error| syntax(error.to_string().trim_end().to_owned()))?
            }
        };
        plan.check(&file)?;
        Ok(plan)
    }

    fn check(&self, file: &str) -> Result<(), ImportError> {
        let rule = |holds: bool, place: &str, found: String, expected: &str| match holds {
            true => Ok(()),
            false => {
                let (file, place, expected) = (file.to_owned(), place.to_owned(), expected.to_owned());
                Err(ImportError::Malformed { file, place, found, expected })
            }
        };
        rule(self.schema == SCHEMA, "schema", self.schema.to_string(), "1; a newer flb may have written it")?;
        let fits = (1..=MAX_REASON_BYTES).contains(&self.reason.len());
        let fits = fits && !self.reason.chars().any(char::is_control);
        let expected = "1 to 1000 bytes without control characters";
        rule(fits, "reason", format!("{:?}", self.reason.chars().take(80).collect::<String>()), expected)?;
        if let Some(bands) = &self.bands {
            let fits = (1..=MAX_BANDS).contains(&bands.len());
            rule(fits, "bands", format!("{} names", bands.len()), "1 to 64 names")?;
            let once = (1..bands.len()).all(|i| !bands[..i].contains(&bands[i]));
            rule(once, "bands", format!("{bands:?}"), "each name once")?;
        }
        let either = self.bases.is_some() == self.species.is_empty();
        let found = if self.bases.is_some() { "both bases and species" } else { "neither bases nor species" };
        rule(either, "bases", found.into(), "bases for every species, or [[species]] with their own")?;
        let some =
            |bases: &BaseSet, place: &str| rule(!bases.is_empty(), place, "[]".into(), "one base or more");
        self.bases.iter().try_for_each(|bases| some(bases, "bases"))?;
        for (i, species) in self.species.iter().enumerate() {
            let place = format!("species {:?}", species.name);
            let rises = i == 0 || self.species[i - 1].name < species.name;
            rule(rises, &place, "it here".into(), "names ascending, each once")?;
            some(&species.bases, &format!("{place}, bases"))?;
            let lattice = species.lattice.unwrap_or(16);
            let fits = lattice.is_power_of_two() && (16..=256).contains(&lattice);
            rule(fits, &format!("{place}, lattice"), lattice.to_string(), "a power of two, 16 to 256")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
