//! Fields to the payloads of `flb_format::blocks`, at an error that was asked for.
//!
//! Blocks are coded in parallel, each by one thread, and sums go in one order, so the bytes do not depend on the number
//! of threads nor on what vector registers there are. Every step of the search is measured at the surface points of the
//! quality report, and an encoding that is worse than its target is named ([`Missed`]). Memory, beside the fields: for
//! each base and band 256 bytes a stored block (its filled coefficients) and 4 bytes a surface point (its samples), and
//! a lattice of floats for each thread. Of many bands that are alike, the components that no file could hold are left
//! out of the coefficients.

mod choose;
mod control;
mod fill;
mod geometry;
mod light;
mod pass;
mod payloads;
mod quantise;
mod ready;
mod rotate;
mod search;
mod target;

use flb_format::Field;
use flb_format::blocks::{Classes, Coding, Head, transform};

use crate::PackError;
use choose::Chooser;
use control::StepGroup;
use geometry::Geometry;
use pass::Pass;
use search::COARSEST;
pub use target::{DEFAULT_TARGET, Missed, SLACK_DB, Target};

/// Method by which detail is coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DetailCoding {
    /// Classes of blocks, trained on the species.
    Classed,
    /// Masks and widths over Haar coefficients.
    Haar,
}

/// Coding, target and layout of a species.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateSettings {
    /// Method by which detail is coded.
    pub coding: DetailCoding,
    /// The error asked for.
    pub target: Target,
    /// Whether blocks away from geometry are stored too.
    pub all_blocks: bool,
    /// Largest size of a page of detail, in bytes.
    pub page_bytes: u32,
}

/// Weighted square error, in steps, that a bit is worth to a class, and to a mask.
const LAMBDA: [f32; 2] = [0.03, 0.08];
/// Light of the largest average at the coarsest step, relative to the peak.
const MAX_LIGHT: f32 = 16_000.0;
/// Trainings at most after the first, where a relative error moves the steps.
const RETRAININGS: usize = 4;
/// Class tables to start from, trained on the built-in oak at 45 dB.
const START: &[u8] = include_bytes!("rate/start.classes");

/// A coded species, as payloads.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesPayloads {
    /// The block map.
    pub map: Vec<u8>,
    /// Class tables; none for `haar`.
    pub classes: Option<Vec<u8>>,
    /// Coded bases, in the order given.
    pub bases: Vec<BasePayloads>,
    /// Bases that missed their target, ascending by base.
    pub missed: Vec<Missed>,
}

/// A coded base, as payloads.
#[derive(Debug, Clone, PartialEq)]
pub struct BasePayloads {
    /// Index of the base.
    pub base: u8,
    /// Head of the base.
    pub head: Head,
    /// Payload of the averages.
    pub averages: Vec<u8>,
    /// Squared error that reading the averages removes.
    pub priority: f32,
    /// Pages in order.
    pub pages: Vec<DetailPage>,
}

/// A page of detail.
#[derive(Debug, Clone, PartialEq)]
pub struct DetailPage {
    /// Rank of its first block.
    pub first: u32,
    /// Number of its blocks.
    pub count: u32,
    /// Payload of the page.
    pub payload: Vec<u8>,
    /// Squared error that reading the page removes.
    pub priority: f32,
}

impl BasePayloads {
    /// Bytes of all payloads.
    pub fn bytes(&self) -> usize {
        self.head.to_bytes().len()
            + self.averages.len()
            + self.pages.iter().map(|p| p.payload.len()).sum::<usize>()
    }
}

impl SpeciesPayloads {
    /// Bytes of all payloads.
    pub fn bytes(&self) -> usize {
        self.map.len()
            + self.classes.as_ref().map_or(0, Vec::len)
            + self.bases.iter().map(BasePayloads::bytes).sum::<usize>()
    }
}

/// Sites in which light is sampled, `[z][y][x]`.
#[derive(Debug, Clone, Copy)]
pub struct SampledSites<'a> {
    /// Sites that samples lie in.
    pub all: &'a [bool],
    /// Sites of leaves among them, to whose darkest tenth errors are relative. Solids can be as dark as one likes.
    pub leaves: &'a [bool],
}

impl<'a> From<&'a [bool]> for SampledSites<'a> {
    fn from(all: &'a [bool]) -> SampledSites<'a> {
        SampledSites { all, leaves: all }
    }
}

/// Codes the bases of a species, each to the target by itself.
///
/// # Errors
/// [`PackError::Setting`] for a target that no coding has and for fields that do not fit the sites.
pub fn code_species(
    lattice: u32,
    sites: SampledSites,
    bases: &[(u8, &Field)],
    settings: &RateSettings,
) -> Result<SpeciesPayloads, PackError> {
    code(lattice, sites, bases, None, settings)
}

/// Codes bases of which all but base 0 make the light of a sun together: so many `harmonics` of its direction, then
/// terms of the near beam. They have one step and one peak, that of the mean light over all suns, and meet the target
/// together: a harmonic's mean square over all suns is 1, so that their square errors add up.
///
/// # Errors
/// Those of [`code_species`].
pub fn code_harmonics(
    lattice: u32,
    sites: SampledSites,
    bases: &[(u8, &Field)],
    harmonics: usize,
    settings: &RateSettings,
) -> Result<SpeciesPayloads, PackError> {
    code(lattice, sites, bases, Some(harmonics), settings)
}

fn code(
    lattice: u32,
    sites: SampledSites,
    bases: &[(u8, &Field)],
    harmonics: Option<usize>,
    settings: &RateSettings,
) -> Result<SpeciesPayloads, PackError> {
    check(lattice, sites, bases, settings)?;
    let target = settings.target;
    let rows = match settings.coding {
        DetailCoding::Classed => &transform::SMOOTH,
        DetailCoding::Haar => &transform::HAAR,
    };
    let geometry = Geometry::new(lattice, sites, settings.all_blocks, rows);
    let (ready, filled) = ready::ready(bases, &geometry, harmonics, target);
    if let Some(dim) = ready.iter().find(|r| r.finest > COARSEST) {
        return Err(PackError::Setting {
            what: "the light near surfaces",
            found: format!("{} times that of base {} at them", dim.finest * MAX_LIGHT / COARSEST, dim.base),
            expected: "up to 16,000 times",
        });
    }
    let start = Classes::from_bytes(START).expect("the tables to start from are sound");
    let classed = settings.coding == DetailCoding::Classed;
    let choosers = start.tables.each_ref().map(Chooser::new);
    let pass = Pass {
        geometry: &geometry,
        ready: &ready,
        filled: &filled,
        choosers: classed.then_some(&choosers),
        lambda: LAMBDA[usize::from(!classed)],
        weighted: !matches!(target, Target::Psnr(_)),
    };
    let mut groups = groups(&pass, target, harmonics.is_some());
    if !classed {
        control::guess(&pass, target, &mut groups, 2, 0.0);
        control::keep_dark_blocks(target, &mut groups);
        let (coded, missed) = control::search(&pass, target, &mut groups);
        return Ok(payloads::payloads(&pass, Coding::Haar, &coded, missed, settings));
    }
    control::guess_unclipped(&pass, target, &mut groups, &start);
    let mut tables = control::train(&pass, &groups, &start);
    let choosers = tables.each_ref().map(Chooser::new);
    let bias = control::calibrate(&Pass { choosers: Some(&choosers), ..pass }, target, &mut groups);
    control::keep_dark_blocks(target, &mut groups);
    for _ in 0..RETRAININGS {
        let choosers = tables.each_ref().map(Chooser::new);
        if !control::regauge(&Pass { choosers: Some(&choosers), ..pass }, target, &mut groups, bias) {
            break;
        }
        tables = control::train(&pass, &groups, &start);
    }
    let choosers = tables.each_ref().map(Chooser::new);
    let pass = Pass { choosers: Some(&choosers), ..pass };
    let (coded, missed) = control::search(&pass, target, &mut groups);
    Ok(payloads::payloads(&pass, Coding::Classed(Classes::new(tables)), &coded, missed, settings))
}

/// Bases that are judged together: each by itself, or all but base 0. Averages of terms that cross 0 do not say how
/// much light there is, so steps of those are even.
fn groups(pass: &Pass, target: Target, together: bool) -> Vec<StepGroup> {
    let alone = |base: usize| !together || pass.ready[base].base == 0;
    let (single, rest): (Vec<usize>, Vec<usize>) = (0..pass.ready.len()).partition(|base| alone(*base));
    let mut groups: Vec<StepGroup> =
        single.into_iter().map(|base| StepGroup::new(pass, vec![base], target, true)).collect();
    if !rest.is_empty() {
        groups.push(StepGroup::new(pass, rest, target, false));
    }
    groups
}

fn check(
    lattice: u32,
    sites: SampledSites,
    bases: &[(u8, &Field)],
    settings: &RateSettings,
) -> Result<(), PackError> {
    let setting = |what, found: String, expected| Err(PackError::Setting { what, found, expected });
    settings.target.check()?;
    if bases.is_empty() {
        return Err(PackError::Empty);
    }
    let fits = |v: &f32| v.abs() <= flb_format::container::records::MAX_MAGNITUDE; // not of NaN
    let count = (lattice as usize).saturating_pow(3);
    if !flb_format::container::records::LATTICES.contains(&lattice)
        || !lattice.is_power_of_two()
        || [sites.all, sites.leaves].iter().any(|list| list.len() != count)
    {
        let found = format!("{} for a lattice of {lattice}", sites.all.len());
        return setting("the number of sites", found, "N^3, N a power of two from 16 to 256");
    }
    for (base, field) in bases {
        let bands = field.bands;
        let shaped =
            field.lattice == lattice && (1..=flb_format::container::records::MAX_BANDS).contains(&bands);
        if !shaped || field.len() != count * bands as usize {
            let found = format!("base {base} of {bands} bands and {} values", field.len());
            return setting("a field", found, "1 to 64 bands of N^3 values");
        }
        if let Some((band, site)) = field.position(|v| !fits(v)) {
            return Err(PackError::FieldValue {
                species: String::new(),
                base: *base,
                band,
                site,
                found: field.value(band, site),
                most: "2^96",
            });
        }
    }
    Ok(())
}
