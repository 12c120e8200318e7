//! Fields to the payloads of `flb_format::blocks`, at an error that was asked for.
//!
//! Blocks are coded in parallel, each by one thread, and sums go in one order, so the bytes do not depend on the number of
//! threads. Every step of the search is measured at the surface points of the quality report, and an encoding that misses
//! its target is refused, never returned. Memory: the filled coefficients of the stored blocks, 256 bytes for each block,
//! base and band, beside one field of errors for each thread.

mod choose;
mod fill;
mod geometry;
mod pass;
mod quantise;
mod ready;
mod rotate;
mod search;

use flb_format::Field;
use flb_format::blocks::classes::bits;
use flb_format::blocks::coarse;
use flb_format::blocks::{Averages, ClassTable, Classes, Coding, Head, MAX_HALVINGS, detail, transform};
use rayon::prelude::*;

use crate::PackError;
use choose::Chooser;
use geometry::Geometry;
use pass::{Coded, Pass, Quality, Try};
use ready::Ready;
use search::{COARSEST, Next, Search};

pub use search::JUMP_DB;

/// The error that a coding may make, for each base by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Peak signal to noise of samples at surfaces, dB, to the base's largest sample.
    Psnr(f64),
    /// 99th percentile of the relative error over the darkest tenth of the samples. Steps become finer in dark blocks.
    Relative(f64),
}

impl Target {
    /// Whether a coding may have it.
    ///
    /// # Errors
    /// [`PackError::Setting`].
    pub fn check(self) -> Result<(), PackError> {
        let (what, found, expected) = match self {
            Target::Psnr(db) if !(10.0..=80.0).contains(&db) => {
                ("the target PSNR", format!("{db} dB"), "10 to 80 dB")
            }
            Target::Relative(share) if !(0.005..=0.5).contains(&share) => {
                ("the target relative error", share.to_string(), "0.005 to 0.5")
            }
            _ => return Ok(()),
        };
        Err(PackError::Setting { what, found, expected })
    }
}

/// Which detail coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DetailCoding {
    /// Classes of blocks, trained on the species.
    Classed,
    /// Masks and widths over Haar coefficients.
    Haar,
}

/// How a species is coded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateSettings {
    /// Which coding.
    pub coding: DetailCoding,
    /// The error asked for.
    pub target: Target,
    /// Whether blocks away from geometry are stored too.
    pub all_blocks: bool,
    /// Most bytes of a page of detail.
    pub page_bytes: u32,
}

/// Decibels that a base may be off its target, of a relative error 1.2 %; where the error jumps over the target, a base may
/// be better by [`JUMP_DB`].
pub const SLACK_DB: f64 = 0.1;
/// Weighted square error, in steps, that a bit is worth to a class, and to a mask.
const LAMBDA: [f32; 2] = [0.03, 0.08];
/// Light of the largest average at the coarsest step, relative to the peak.
const MOST_LIGHT: f32 = 16_000.0;
/// Blocks on which a step is guessed.
const GUESS_BLOCKS: usize = 400;
/// Samples, over all bases, that classes of first and other components are trained on.
const TRAINING: [usize; 2] = [5000, 3000];
/// Rounds of training.
const ROUNDS: usize = 4;
/// Trainings at most after the first, and the factor of steps that asks for one.
const RETRAININGS: usize = 4;
const FAR: f32 = 1.5;
/// Bases from which on a pass over one of them is worth its time.
const CALIBRATED_BASES: usize = 4;
/// Largest step, in shares of a block's average, for each unit of the relative error asked for.
const RELATIVE_STEP: f64 = 1.0;
/// Class tables to start from, trained on the built-in oak at 45 dB.
const START: &[u8] = include_bytes!("rate/start.classes");

/// A coded species, as payloads.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesPayloads {
    /// The block map.
    pub map: Vec<u8>,
    /// Class tables; none for `haar`.
    pub classes: Option<Vec<u8>>,
    /// In the order given.
    pub bases: Vec<BasePayloads>,
}

/// A coded base, as payloads.
#[derive(Debug, Clone, PartialEq)]
pub struct BasePayloads {
    /// Index of the base.
    pub base: u8,
    /// What its head says.
    pub head: Head,
    /// Averages.
    pub averages: Vec<u8>,
    /// In order.
    pub pages: Vec<DetailPage>,
}

/// A page of detail.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DetailPage {
    /// Rank of its first block.
    pub first: u32,
    /// Number of its blocks.
    pub count: u32,
    /// Its payload.
    pub payload: Vec<u8>,
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

/// Codes the bases of a species; `non_empty` are the sites with surfaces, `[z][y][x]`.
///
/// # Errors
/// [`PackError::Setting`] for a target that no coding has, [`PackError::Shape`] for fields that do not fit the sites,
/// [`PackError::Target`] for a base whose error stays off the target whatever the step.
pub fn code_species(
    lattice: u32,
    non_empty: &[bool],
    bases: &[(u8, &Field)],
    settings: &RateSettings,
) -> Result<SpeciesPayloads, PackError> {
    check(lattice, non_empty, bases, settings)?;
    let rows = match settings.coding {
        DetailCoding::Classed => &transform::SMOOTH,
        DetailCoding::Haar => &transform::HAAR,
    };
    let geometry = Geometry::new(lattice, non_empty, settings.all_blocks, rows);
    let (ready, filled) = ready::ready(bases, &geometry);
    if let Some(dim) = ready.iter().find(|r| r.finest > COARSEST) {
        return Err(PackError::Setting {
            what: "the light near surfaces",
            found: format!("{} times that of base {} at them", dim.finest * MOST_LIGHT / COARSEST, dim.base),
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
        relative: match settings.target {
            Target::Psnr(_) => None,
            Target::Relative(share) => Some((share * RELATIVE_STEP) as f32),
        },
    };
    let mut searches: Vec<Search> =
        ready.iter().map(|r| Search::new(first_guess(settings.target), r.finest)).collect();
    if !classed {
        guess(&pass, settings.target, &mut searches, 2);
        let coded = search(&pass, settings.target, searches)?;
        return Ok(payloads(&pass, Coding::Haar, &coded, settings));
    }
    for _ in 0..2 {
        // Widths for the steepest block, or a guess would take clipped coefficients for too coarse a step.
        let tables = train(&pass, &searches, &start, 0);
        let choosers = tables.each_ref().map(Chooser::new);
        guess(&Pass { choosers: Some(&choosers), ..pass }, settings.target, &mut searches, 1);
    }
    let mut tables = train(&pass, &searches, &start, ROUNDS);
    for _ in 0..RETRAININGS {
        let choosers = tables.each_ref().map(Chooser::new);
        if !regauge(&Pass { choosers: Some(&choosers), ..pass }, settings.target, &mut searches) {
            break;
        }
        tables = train(&pass, &searches, &start, ROUNDS);
    }
    let choosers = tables.each_ref().map(Chooser::new);
    let pass = Pass { choosers: Some(&choosers), ..pass };
    calibrate(&pass, settings.target, &mut searches);
    let coded = search(&pass, settings.target, searches)?;
    Ok(payloads(&pass, Coding::Classed(Classes::new(tables)), &coded, settings))
}

fn check(
    lattice: u32,
    non_empty: &[bool],
    bases: &[(u8, &Field)],
    settings: &RateSettings,
) -> Result<(), PackError> {
    let setting = |what, found: String, expected| Err(PackError::Setting { what, found, expected });
    settings.target.check()?;
    if bases.is_empty() {
        return Err(PackError::Empty);
    }
    let fits = |v: &f32| v.abs() <= flb_format::records::MAX_MAGNITUDE; // not of NaN
    let sites = (lattice as usize).saturating_pow(3);
    if !flb_format::records::LATTICES.contains(&lattice)
        || !lattice.is_power_of_two()
        || non_empty.len() != sites
    {
        let found = format!("{} for a lattice of {lattice}", non_empty.len());
        return setting("the number of sites", found, "N^3, N a power of two from 16 to 256");
    }
    for (base, field) in bases {
        let bands = field.bands;
        let shaped = field.lattice == lattice && (1..=flb_format::records::MAX_BANDS).contains(&bands);
        if !shaped || field.values.len() != sites * bands as usize {
            let found = format!("base {base} of {bands} bands and {} values", field.values.len());
            return setting("a field", found, "1 to 64 bands of N^3 values");
        }
        if let Some(i) = field.values.iter().position(|v| !fits(v)) {
            return Err(PackError::FieldValue {
                species: String::new(),
                base: *base,
                band: (i / sites) as u32,
                site: i % sites,
                found: field.values[i],
                most: "2^96",
            });
        }
    }
    Ok(())
}

fn first_guess(target: Target) -> f32 {
    match target {
        Target::Psnr(db) => 3.5 * libm::exp10(-db / 20.0) as f32,
        Target::Relative(share) => 0.5 * share as f32,
    }
}

/// How many decibels an error is better than the target.
fn off(target: Target, quality: Quality) -> f64 {
    match target {
        Target::Psnr(db) => -20.0 * libm::log10(quality.rms) - db,
        Target::Relative(share) => -20.0 * libm::log10(quality.dark / share),
    }
}

fn tries(pass: &Pass, searches: &[Search], bases: impl Iterator<Item = usize>) -> Vec<Try> {
    bases
        .map(|base| Try { base, step: searches[base].step, components: pass.kept(base, searches[base].step) })
        .collect()
}

/// Betters all guesses by what `G` expects of a few blocks. It says nothing of relative errors.
fn guess(pass: &Pass, target: Target, searches: &mut [Search], rounds: usize) {
    let Target::Psnr(db) = target else { return };
    let stride = pass.geometry.map.len().div_ceil(GUESS_BLOCKS);
    for _ in 0..rounds {
        for coded in pass.code(&tries(pass, searches, 0..searches.len()), stride) {
            let expected = pass.expected(&coded, stride);
            if expected > 0.0 {
                searches[coded.tried.base].guess(-10.0 * libm::log10(expected) - db);
            }
        }
    }
}

/// Betters all guesses with the classes at hand; for a relative error, of which nothing is expected beforehand, by measuring
/// all bases. Says whether some step is far from that which the classes were trained for: they may be too narrow then.
fn regauge(pass: &Pass, target: Target, searches: &mut [Search]) -> bool {
    let before: Vec<f32> = searches.iter().map(|search| search.step).collect();
    match target {
        Target::Psnr(_) => guess(pass, target, searches, 1),
        Target::Relative(_) => {
            let coded = pass.code(&tries(pass, searches, 0..searches.len()), 1);
            let off: Vec<f64> = coded.par_iter().map(|coded| off(target, pass.measure(coded))).collect();
            searches.iter_mut().zip(off).for_each(|(search, off)| search.guess(off));
        }
    }
    let is_far = |(search, before): (&Search, f32)| !(1.0 / FAR..FAR).contains(&(search.step / before));
    searches.iter().zip(before).any(is_far)
}

/// What `G` expects is off by much the same for all bases of a species: measures it on one of them.
fn calibrate(pass: &Pass, target: Target, searches: &mut [Search]) {
    if matches!(target, Target::Psnr(_)) && searches.len() >= CALIBRATED_BASES {
        let coded = pass.code(&tries(pass, searches, std::iter::once(searches.len() / 2)), 1);
        let off = off(target, pass.measure(&coded[0]));
        searches.iter_mut().for_each(|search| search.guess(off));
    }
}

/// Classes for the steps of all searches: the tables to start from after so many rounds, and some for the steepest blocks.
fn train(pass: &Pass, searches: &[Search], start: &Classes, rounds: usize) -> [ClassTable; 2] {
    let tries = tries(pass, searches, 0..searches.len());
    let strides = TRAINING.map(|count| (pass.geometry.map.len() * tries.len()).div_ceil(count));
    let mut samples = [Vec::new(), Vec::new()];
    for tried in &tries {
        for c in 0..tried.components {
            let table = Classes::table(c);
            samples[table].extend(pass.training(tried, c, strides[table]));
        }
    }
    std::array::from_fn(|i| choose::train(&samples[i], &start.tables[i], pass.lambda, rounds))
}

/// Codes all bases until each meets the target.
fn search(
    pass: &Pass,
    target: Target,
    mut searches: Vec<Search>,
) -> Result<Vec<(Coded, Quality)>, PackError> {
    let mut done: Vec<Option<(Coded, Quality)>> = searches.iter().map(|_| None).collect();
    let mut components = vec![0; searches.len()];
    let mut open: Vec<usize> = (0..searches.len()).collect();
    while !open.is_empty() {
        let mut tries = tries(pass, &searches, open.iter().copied());
        for tried in &mut tries {
            // A component once kept stays, or its coming and going would keep the search from closing in.
            let before = components[tried.base];
            tried.components = tried.components.max(before);
            if before > 0 && tried.components > before {
                searches[tried.base].forget_worse();
            }
            components[tried.base] = tried.components;
        }
        let coded = pass.code(&tries, 1);
        let quality: Vec<Quality> = coded.par_iter().map(|coded| pass.measure(coded)).collect();
        open.clear();
        for (coded, quality) in coded.into_iter().zip(quality) {
            let base = coded.tried.base;
            match searches[base].tried(off(target, quality), SLACK_DB) {
                Next::Done => done[base] = Some((coded, quality)),
                Next::Again => open.push(base),
                Next::Refused => {
                    return Err(PackError::Target {
                        base: pass.ready[base].base,
                        found_db: -20.0 * libm::log10(quality.rms),
                        dark: quality.dark,
                        step: coded.tried.step,
                        expected: match target {
                            Target::Psnr(db) => format!("{db} dB"),
                            Target::Relative(share) => format!("a relative error of {share}"),
                        },
                    });
                }
            }
        }
    }
    Ok(done.into_iter().map(|d| d.expect("no base is open")).collect())
}

fn payloads(
    pass: &Pass,
    coding: Coding,
    coded: &[(Coded, Quality)],
    settings: &RateSettings,
) -> SpeciesPayloads {
    let bases =
        coded.par_iter().map(|(coded, quality)| base_payloads(pass, &coding, coded, *quality, settings));
    SpeciesPayloads {
        map: pass.geometry.map.to_bytes(),
        bases: bases.collect(),
        classes: match &coding {
            Coding::Classed(classes) => Some(classes.to_bytes()),
            Coding::Haar => None,
        },
    }
}

fn base_payloads(
    pass: &Pass,
    coding: &Coding,
    coded: &Coded,
    quality: Quality,
    settings: &RateSettings,
) -> BasePayloads {
    let Try { base, step, components } = coded.tried;
    let ready: &Ready = &pass.ready[base];
    let head = Head {
        bands: ready.field.bands,
        axes: ready.axes,
        // A texel of 1 is a sixteenth of a step, and a step of row 0 along each axis is 1/216.
        unit: step * ready.peak / (216.0 * (2 << MAX_HALVINGS) as f32),
        thresholds: pass::thresholds(pass.relative),
        peak: ready.peak,
        rms_error: quality.rms as f32,
        dark_error: quality.dark as f32,
        rotation: ready.rotation[..components * ready.bands()].to_vec(),
    }
    .checked()
    .expect("fields were checked");
    let coarse_of = |c: usize| -> Vec<i16> {
        ready.coarse[c].iter().map(|v| libm::roundf(v / step).clamp(-32767.0, 32767.0) as i16).collect()
    };
    let has_coarse = coarse::edge(&pass.geometry.map) > 0;
    let averages = Averages {
        blocks: (0..components)
            .map(|c| coded.blocks.iter().skip(c).step_by(components).map(|b| b.values[0]).collect())
            .collect(),
        coarse: (0..if has_coarse { components } else { 0 }).map(coarse_of).collect(),
    };
    let order = head.order();
    let pages = page_ranges(coding, components, coded, settings.page_bytes)
        .into_iter()
        .map(|(first, count)| DetailPage {
            first: first as u32,
            count: count as u32,
            payload: detail::encode(
                coding,
                &order,
                components,
                &coded.blocks[first * components..][..count * components],
            ),
        })
        .collect();
    BasePayloads { base: ready.base, averages: averages.to_bytes(&pass.geometry.map), head, pages }
}

/// Runs of blocks whose payloads fit a page; a block that does not fit by itself has one of its own.
fn page_ranges(coding: &Coding, components: usize, coded: &Coded, page_bytes: u32) -> Vec<(usize, usize)> {
    let length = |(i, block): (usize, &flb_format::blocks::CodedBlock)| -> u64 {
        match coding {
            Coding::Classed(classes) => {
                let table = &classes.tables[Classes::table(i % components)];
                u64::from(table.class_bits() + bits(&table.widths()[usize::from(block.class)]))
            }
            Coding::Haar => {
                let kept = block.values[1..].iter().filter(|v| **v != 0).count() as u64;
                4 + if block.class > 0 { 64 } else { 0 } + kept * u64::from(block.class)
            }
        }
    };
    let lengths: Vec<u64> = coded.blocks.iter().enumerate().map(length).collect();
    let (mut ranges, mut first, mut held) = (Vec::new(), 0, 0);
    for (rank, block) in lengths.chunks_exact(components).enumerate() {
        let bits: u64 = block.iter().sum();
        if rank > first && held + bits > 8 * u64::from(page_bytes) {
            ranges.push((first, rank - first));
            (first, held) = (rank, 0);
        }
        held += bits;
    }
    ranges.push((first, lengths.len() / components - first));
    ranges
}
