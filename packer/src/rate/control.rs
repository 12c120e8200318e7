//! Rate control: classes trained on the species, and steps searched until the error of every group of bases is the one
//! asked for.

use flb_format::blocks::{ClassTable, Classes};
use rayon::prelude::*;

use super::choose::{self, Chooser};
use super::pass::{self, Coded, Pass, Quality, Try};
use super::search::{Next, Search};
use super::target::{Missed, PURSUIT_DB, SLACK_DB, Target};

/// Blocks on which a step is guessed.
const GUESS_BLOCKS: usize = 400;
/// Samples, over all bases, that classes of first and other components are trained on.
const TRAINING: [usize; 2] = [5000, 3000];
/// Rounds of training.
const ROUNDS: usize = 4;
/// A factor of steps from which on classes are trained again.
const FAR: f32 = 1.5;
/// Groups from which on a pass over one of them is worth its time.
const CALIBRATED_GROUPS: usize = 4;
/// Largest step of a dark block, in shares of its mean, for each unit of the relative error asked for: smaller where
/// that alone says what the step is, as a step that grows makes more blocks dark.
const SHARE: [f64; 2] = [1.0, 1.2];

/// Bases that are judged together and have one step.
pub(super) struct StepGroup {
    /// Indices of the bases.
    pub bases: Vec<usize>,
    search: Search,
    /// Largest step of a dark block, in shares of its mean; none where steps are even.
    share: Option<f32>,
    /// Step at which that holds, so that the same blocks are dark at any other; every step where there is none.
    anchor: Option<f32>,
    /// `[base]` components kept so far.
    components: Vec<usize>,
}

impl StepGroup {
    /// Before the first guess. `halves` says whether steps of dark blocks may be halved.
    pub(super) fn new(pass: &Pass, bases: Vec<usize>, target: Target, halves: bool) -> StepGroup {
        let step = match target {
            Target::Psnr(db) | Target::Both { psnr_db: db, .. } => 3.5 * libm::exp10(-db / 20.0),
            Target::Relative(share) => 0.5 * share,
        };
        let finest = bases.iter().fold(0.0f32, |finest, base| finest.max(pass.ready[*base].finest));
        let share = match target {
            Target::Psnr(_) => None,
            Target::Relative(error) => Some(error * SHARE[0]),
            Target::Both { relative, .. } => Some(relative * SHARE[1]),
        };
        let components = vec![0; bases.len()];
        StepGroup {
            bases,
            search: Search::new(step as f32, finest),
            share: share.filter(|_| halves).map(|share| share as f32),
            anchor: None,
            components,
        }
    }

    /// Keeps the blocks dark that are dark at the step as it is: one that becomes finer for the sake of dark places
    /// would leave fewer of them.
    fn keep_dark_blocks(&mut self) {
        self.anchor = Some(self.search.step);
    }

    /// A component once kept stays, or its coming and going would keep the search from closing in.
    fn tries(&self, pass: &Pass) -> Vec<Try> {
        let step = self.search.step;
        let share = self.share.map(|share| share * self.anchor.map_or(1.0, |anchor| step / anchor));
        let of = |(base, kept): (&usize, &usize)| Try {
            base: *base,
            step,
            components: pass.kept(*base, step).max(*kept),
            thresholds: share.map_or([0; 3], |share| pass::thresholds(share, step, &pass.ready[*base].light)),
        };
        self.bases.iter().zip(&self.components).map(of).collect()
    }
}

/// How many decibels an error is better than the target; of two errors the worse. A relative error is a limit, so what
/// is aimed at is as much below it as may be missed.
fn off(target: Target, quality: &Quality) -> f64 {
    let mean = |db: f64| -20.0 * libm::log10(quality.rms) - db;
    let dark = |share: f64| -20.0 * libm::log10(quality.dark / share) - SLACK_DB;
    match target {
        Target::Psnr(db) => mean(db),
        Target::Relative(share) => dark(share),
        Target::Both { psnr_db, relative } => {
            let mean = mean(psnr_db);
            mean.min(dark(relative).max(mean - PURSUIT_DB))
        }
    }
}

/// Codes groups, one after the other in what is returned.
fn code(pass: &Pass, groups: &[&StepGroup], stride: usize) -> Vec<Vec<Coded>> {
    let tries: Vec<Try> = groups.iter().flat_map(|group| group.tries(pass)).collect();
    let mut coded = pass.code(&tries, stride).into_iter();
    groups.iter().map(|group| coded.by_ref().take(group.bases.len()).collect()).collect()
}

fn measure(pass: &Pass, coded: &[Coded]) -> Quality {
    pass.measure(&coded.iter().collect::<Vec<_>>())
}

/// Betters all guesses by what `G` expects of a few blocks, which is `bias` decibels too pessimistic. It says nothing
/// of relative errors, nor of weighted ones.
pub(super) fn guess(pass: &Pass, target: Target, groups: &mut [StepGroup], rounds: usize, bias: f64) {
    let (Target::Psnr(db) | Target::Both { psnr_db: db, .. }) = target else { return };
    let pass = &Pass { weighted: false, ..*pass };
    let stride = pass.geometry.map.len().div_ceil(GUESS_BLOCKS);
    for _ in 0..rounds {
        let coded = code(pass, &groups.iter().collect::<Vec<_>>(), stride);
        for (group, coded) in groups.iter_mut().zip(coded) {
            let expected: f64 = coded.iter().map(|coded| pass.expected(coded, stride)).sum();
            if expected > 0.0 {
                group.search.guess(-10.0 * libm::log10(expected) - db + bias);
            }
        }
    }
}

/// Betters guesses with the classes at hand: for a relative error, of which nothing is expected beforehand, by
/// measuring all groups. Says whether some step is far from that which the classes were trained for, as they may be too
/// narrow then.
pub(super) fn regauge(pass: &Pass, target: Target, groups: &mut [StepGroup], bias: f64) -> bool {
    if let Target::Psnr(_) = target {
        let before: Vec<f32> = groups.iter().map(|group| group.search.step).collect();
        guess(pass, target, groups, 1, bias);
        let is_far =
            |(group, before): (&StepGroup, f32)| !(1.0 / FAR..FAR).contains(&(group.search.step / before));
        return groups.iter().zip(before).any(is_far);
    }
    let coded = code(pass, &groups.iter().collect::<Vec<_>>(), 1);
    let mut is_far = false;
    for (group, coded) in groups.iter_mut().zip(coded) {
        let before = group.search.step;
        group.search.guess(off(target, &measure(pass, &coded)));
        is_far |= !(1.0 / FAR..FAR).contains(&(group.search.step / before));
    }
    is_far
}

/// Betters guesses for a mean error with the classes trained. What `G` expects is off by much the same for all bases of
/// a species: that is measured on one group, and returned in decibels.
pub(super) fn calibrate(pass: &Pass, target: Target, groups: &mut [StepGroup]) -> f64 {
    guess(pass, target, groups, 1, 0.0);
    let (Target::Psnr(db) | Target::Both { psnr_db: db, .. }) = target else { return 0.0 };
    if groups.len() < CALIBRATED_GROUPS {
        return 0.0;
    }
    let coded = code(pass, &[&groups[groups.len() / 2]], 1);
    let bias = off(Target::Psnr(db), &measure(pass, &coded[0]));
    groups.iter_mut().for_each(|group| group.search.guess(bias));
    bias
}

/// Of two errors asked for, the step guessed so far meets the mean one: says that its dark blocks stay dark.
pub(super) fn keep_dark_blocks(target: Target, groups: &mut [StepGroup]) {
    if let Target::Both { .. } = target {
        groups.iter_mut().for_each(StepGroup::keep_dark_blocks);
    }
}

/// Guesses with classes that are wide enough for the steepest blocks at the step so far, or clipped coefficients would
/// pass for a step too coarse.
pub(super) fn guess_unclipped(pass: &Pass, target: Target, groups: &mut [StepGroup], start: &Classes) {
    for _ in 0..2 {
        let tables = train_from(pass, groups, start, 0);
        let choosers = tables.each_ref().map(Chooser::new);
        guess(&Pass { choosers: Some(&choosers), ..*pass }, target, groups, 1, 0.0);
    }
}

/// Classes for the steps of the groups.
pub(super) fn train(pass: &Pass, groups: &[StepGroup], start: &Classes) -> [ClassTable; 2] {
    train_from(pass, groups, start, ROUNDS)
}

/// The tables to start from after so many rounds, and some classes for the steepest blocks.
fn train_from(pass: &Pass, groups: &[StepGroup], start: &Classes, rounds: usize) -> [ClassTable; 2] {
    let tries: Vec<Try> = groups.iter().flat_map(|group| group.tries(pass)).collect();
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

/// Codes all groups until each meets the target, or no step does: then the best that was found stands, and is named.
pub(super) fn search(
    pass: &Pass,
    target: Target,
    groups: &mut [StepGroup],
) -> (Vec<(Vec<Coded>, Quality)>, Vec<Missed>) {
    let mut best: Vec<Option<(f64, Vec<Coded>, Quality)>> = groups.iter().map(|_| None).collect();
    let mut missed = Vec::new();
    let mut open: Vec<usize> = (0..groups.len()).collect();
    while !open.is_empty() {
        let coded = code(pass, &open.iter().map(|i| &groups[*i]).collect::<Vec<_>>(), 1);
        let quality: Vec<Quality> = coded.par_iter().map(|coded| measure(pass, coded)).collect();
        let mut left = Vec::new();
        for ((i, coded), quality) in open.into_iter().zip(coded).zip(quality) {
            let group = &mut groups[i];
            let components: Vec<usize> = coded.iter().map(|coded| coded.tried.components).collect();
            if group.components.iter().zip(&components).any(|(before, kept)| *before > 0 && kept > before) {
                group.search.forget_worse();
            }
            group.components = components;
            let off = off(target, &quality);
            let next = group.search.tried(off, SLACK_DB);
            // What is done is what was asked for, whatever came nearer before.
            if next == Next::Done || best[i].as_ref().is_none_or(|best| best.0 < off) {
                best[i] = Some((off, coded, quality));
            }
            match next {
                Next::Again => left.push(i),
                Next::Done | Next::Refused => {
                    let (_, coded, quality) = best[i].as_ref().expect("it was coded");
                    let found = Missed {
                        base: pass.ready[coded[0].tried.base].base,
                        psnr_db: -20.0 * libm::log10(quality.rms),
                        dark_error: quality.dark,
                        target,
                    };
                    let (_, relative) = target.errors();
                    if next == Next::Refused || relative.is_some_and(|share| quality.dark > share) {
                        missed.push(found);
                    }
                }
            }
        }
        open = left;
    }
    missed.sort_by_key(|missed| missed.base);
    (best.into_iter().flatten().map(|(_, coded, quality)| (coded, quality)).collect(), missed)
}
