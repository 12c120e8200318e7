//! Streams a library: every frame says what it shows, worker threads read, verify and decompress, and what has come is
//! put in its place between frames.
//!
//! ```text
//! NeedFinder -Need-> Streamer::frame: take what came | Residency::plan | drop | send jobs ──> workers
//!                         └──> Resident (light at points)                      <── payloads ──┘
//! ```
//!
//! A frame never waits for a file. Its own work is bounded by [`StreamSettings::frame_time`]: what came beyond that
//! waits for the next one. A failure is told at once, tried again after pauses, and told once more when it is given up;
//! everything else goes on.

mod job;
mod pool;
pub mod replay;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use flb_format::FormatError;

pub use job::Job;
pub(crate) use job::jobs;
pub(crate) use job::read;

use crate::residency::{Lack, Need, Residency, ResidencySettings, UnitId, UnitKind, Units};
use crate::resident::{Payload, Resident};
use crate::source::is_replaced;
use crate::{Library, RuntimeError};
use pool::Pool;

/// Budget and threads of streaming.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamSettings {
    /// Budgets of memory and of requests.
    pub residency: ResidencySettings,
    /// Threads that read, 1 or more.
    pub workers: usize,
    /// Time of a frame after which no more of what came is put in its place; one unit always is.
    pub frame_time: Duration,
    /// Frames over which light that came takes the place of what stood in for it, 1 or more.
    pub blend_frames: u16,
}

impl Default for StreamSettings {
    /// Four workers, 2 ms, 48 frames: the lightest leaves then change by 15 % of the plant's mean light a frame
    /// (`cargo bench -p flb-tests --bench budget`).
    fn default() -> StreamSettings {
        StreamSettings {
            residency: ResidencySettings::default(),
            workers: 4,
            frame_time: Duration::from_millis(2),
            blend_frames: 48,
        }
    }
}

/// A unit that failed.
#[derive(Debug)]
pub struct Failure {
    /// Unit that failed.
    pub unit: UnitId,
    /// Error of the unit, the last one where it is given up.
    pub error: FormatError,
}

/// Units that a frame requested, dropped and put in place, and the state that it left.
#[derive(Debug, Default)]
pub struct Frame {
    /// Units asked for.
    pub requests: Vec<UnitId>,
    /// Units dropped.
    pub evictions: Vec<UnitId>,
    /// Units put in place.
    pub loaded: Vec<UnitId>,
    /// Units that were given up, each once.
    pub failures: Vec<Failure>,
    /// Units that failed for the first time and will be asked for again: trouble is known here at once, and given up
    /// seconds later.
    pub retries: Vec<Failure>,
    /// Share of the frame's worth that is loaded, as [`LoadPlan::quality`](crate::residency::LoadPlan::quality).
    pub quality: f32,
    /// Whether nothing stands in for light, as [`LoadPlan::is_complete`](crate::residency::LoadPlan::is_complete).
    pub is_complete: bool,
    /// Whether nothing more would be loaded, as [`LoadPlan::is_final`](crate::residency::LoadPlan::is_final).
    pub is_final: bool,
    /// Memory that is lacking, as [`LoadPlan::lacks`](crate::residency::LoadPlan::lacks).
    pub lacks: Vec<Lack>,
}

/// Loaded units and the choice of them: all of a [`Streamer`] but its threads.
pub struct Stage {
    library: Arc<Library>,
    units: Arc<Units>,
    residency: Residency,
    resident: Resident,
    /// Pages that came before the averages that they refine.
    parked: Vec<(UnitId, Payload)>,
}

impl Stage {
    /// Makes a stage on which nothing is loaded.
    ///
    /// # Errors
    /// [`RuntimeError::NotStreamed`].
    pub fn new(library: Arc<Library>, settings: ResidencySettings) -> Result<Stage, RuntimeError> {
        let units = Arc::new(Units::new(library.container(), library.path())?);
        let resident = Resident::new(library.container(), &units);
        Ok(Stage {
            residency: Residency::new(Arc::clone(&units), settings),
            library,
            units,
            resident,
            parked: Vec::new(),
        })
    }

    /// The library.
    pub fn library(&self) -> &Arc<Library> {
        &self.library
    }

    /// Units that there are.
    pub fn units(&self) -> &Arc<Units> {
        &self.units
    }

    /// Loaded units.
    pub fn resident(&self) -> &Resident {
        &self.resident
    }

    /// Units that are loaded or on their way.
    pub fn residency(&self) -> &Residency {
        &self.residency
    }

    /// A new budget, which holds from the next plan on.
    pub fn set_budget(&mut self, budget_bytes: u64) {
        self.residency.set_budget(budget_bytes);
    }

    /// Plans a frame and drops what it evicts; what it requests is the caller's to read.
    pub fn plan(&mut self, need: &Need, frame: &mut Frame) {
        let plan = self.residency.plan(need);
        for unit in &plan.evictions {
            self.resident.remove(&self.units, *unit);
        }
        frame.requests = plan.requests;
        frame.evictions = plan.evictions;
        frame.quality = plan.quality;
        // What has come may not be shown in full yet.
        let is_blending = need.seen().any(|(species, _)| self.resident.is_blending(species));
        frame.is_complete = plan.is_complete && !is_blending;
        frame.is_final = plan.is_final && !is_blending;
        frame.lacks = plan.lacks;
    }

    /// Jobs for what a plan requests, the most urgent first.
    pub fn jobs(&self, requests: &[UnitId]) -> Vec<Job> {
        jobs(self.library.container(), &self.units, &self.resident, requests)
    }

    /// Reads, verifies and decodes the units of a job.
    pub fn read(&self, job: &Job) -> Vec<(UnitId, Result<Payload, FormatError>)> {
        read(&self.library, &self.units, job)
    }

    /// Puts what came of a unit in its place.
    pub fn take(&mut self, unit: UnitId, outcome: Result<Payload, FormatError>, frame: &mut Frame) {
        match outcome {
            Err(error) => self.fail(unit, error, frame),
            Ok(payload) if self.waits(unit) => self.parked.push((unit, payload)),
            Ok(payload) => self.place(unit, payload, frame),
        }
        // Those that waited for it, whatever became of it.
        let (parked, ready): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.parked).into_iter().partition(|(unit, _)| self.waits(*unit));
        self.parked = parked;
        for (unit, payload) in ready {
            self.place(unit, payload, frame);
        }
    }

    /// Whether what a unit stands on is still on its way.
    fn waits(&self, unit: UnitId) -> bool {
        self.units.stands_on(unit).is_some_and(|below| self.residency.is_on_its_way(below))
    }

    fn place(&mut self, unit: UnitId, payload: Payload, frame: &mut Frame) {
        if !self.residency.can_keep(unit) {
            self.residency.lost(unit);
            return;
        }
        let (species, kind) = (self.units.get(unit).species as usize, self.units.get(unit).kind);
        match (kind, &payload) {
            (UnitKind::Shared, Payload::Shared(_, runs)) => self.residency.set_runs(species, runs.clone()),
            (UnitKind::Averages { base }, Payload::Averages(coded)) => {
                self.residency.set_peak(species, base as usize, coded.head().peak);
            }
            _ => {}
        }
        match self.resident.insert(&self.units, unit, payload) {
            Ok(()) => {
                self.residency.loaded(unit);
                frame.loaded.push(unit);
            }
            Err(fault) => {
                let place = job::place(self.library.container(), &self.units, unit);
                self.fail(unit, FormatError::blocks(place, fault), frame);
            }
        }
    }

    fn fail(&mut self, unit: UnitId, error: FormatError, frame: &mut Frame) {
        // A read may succeed the next time; bytes that are wrong stay wrong, and a file that was replaced is another
        // file.
        let lasting = is_replaced(&error) || !matches!(error, FormatError::Read { .. });
        if self.residency.failed(unit, lasting) {
            frame.failures.push(Failure { unit, error });
        } else if self.residency.has_failed_once(unit) {
            frame.retries.push(Failure { unit, error });
        }
    }
}

/// A library that is streamed by worker threads.
pub struct Streamer {
    stage: Stage,
    pool: Pool,
    came: VecDeque<(UnitId, Result<Payload, FormatError>)>,
    frame_time: Duration,
}

impl Streamer {
    /// Starts the workers; they end with the streamer, each after the read that it is at.
    ///
    /// # Errors
    /// [`RuntimeError::NotStreamed`]; [`RuntimeError::Io`] if a thread cannot be started.
    pub fn new(library: Arc<Library>, settings: StreamSettings) -> Result<Streamer, RuntimeError> {
        let mut stage = Stage::new(library, settings.residency)?;
        stage.resident = stage.resident.blending_over(settings.blend_frames);
        let pool = Pool::new(&stage.library, &stage.units, settings.workers.max(1));
        let pool = pool.map_err(|source| {
            let path = stage.library.path().to_owned();
            RuntimeError::Io { path, action: "start a thread to read", source }
        })?;
        Ok(Streamer { stage, pool, came: VecDeque::new(), frame_time: settings.frame_time })
    }

    /// The library.
    pub fn library(&self) -> &Arc<Library> {
        &self.stage.library
    }

    /// Loaded units; nothing of them changes between frames.
    pub fn resident(&self) -> &Resident {
        self.stage.resident()
    }

    /// Units that are loaded or on their way.
    pub fn residency(&self) -> &Residency {
        self.stage.residency()
    }

    /// Describes for people what a frame could not be complete without: "oak: the sun's light needs 1.1 MB more; ...".
    pub fn describe(&self, lacks: &[Lack]) -> Vec<String> {
        lacks.iter().map(|lack| lack.describe(self.library().container())).collect()
    }

    /// A new budget, which holds from the next frame on.
    pub fn set_budget(&mut self, budget_bytes: u64) {
        self.stage.set_budget(budget_bytes);
    }

    /// Does a frame's work: takes what came, plans, drops, asks.
    pub fn frame(&mut self, need: &Need) -> Frame {
        let start = Instant::now();
        let mut frame = Frame::default();
        self.stage.resident.advance();
        self.came.extend(self.pool.came());
        while let Some((unit, outcome)) = self.came.pop_front() {
            self.stage.take(unit, outcome, &mut frame);
            if start.elapsed() >= self.frame_time {
                break;
            }
        }
        self.stage.plan(need, &mut frame);
        for job in self.stage.jobs(&frame.requests) {
            self.pool.send(job);
        }
        frame
    }

    /// Waits until something came or `most` has passed: for tools that would rather wait than draw what is there. Where
    /// nothing is on its way there is nothing to wait for.
    pub fn wait(&mut self, most: Duration) {
        if self.came.is_empty() && self.stage.residency.requested() > 0 {
            self.came.extend(self.pool.wait(most));
        }
    }
}

#[cfg(test)]
mod tests;
