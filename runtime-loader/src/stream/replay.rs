//! Streams a library over a link that is only reckoned: for a round trip time and a bandwidth, what a viewer would have
//! seen when.
//!
//! Time is virtual, so a replay is the same on every machine. Files are read as they are; what is read is held back
//! until the link would have brought it. The link is a pipe: a request's first byte comes a round trip after it was
//! sent, or when the pipe is free, and up to [`Link::connections`] requests are open at once.

use std::collections::VecDeque;
use std::sync::Arc;

use super::{Frame, Job, Stage};
use crate::residency::{Lack, Need, ResidencySettings};
use crate::{Library, RuntimeError};

/// Bytes that the first request of a reader asks for.
const HEAD_BYTES: u64 = 64 << 10;

/// A link to where the file lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Time from a request to its first byte, seconds.
    pub round_trip_s: f64,
    /// Bytes a second, above 0.
    pub bandwidth: f64,
    /// Requests at once, 1 or more.
    pub connections: usize,
}

/// State of one frame of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Time since the file was asked for, seconds.
    pub time_s: f64,
    /// Requests sent.
    pub requests: usize,
    /// Bytes asked for.
    pub requested_bytes: u64,
    /// Units that came.
    pub loaded: usize,
    /// Units dropped.
    pub evictions: usize,
    /// Memory of what is loaded.
    pub loaded_bytes: u64,
    /// Share of the worth of what the frame could use that is loaded.
    pub quality: f32,
    /// Whether nothing stands in for the light of what is seen.
    pub is_complete: bool,
    /// Whether nothing more would be loaded if the view stayed.
    pub is_final: bool,
}

/// Recorded frames of a replay.
#[derive(Debug)]
pub struct Trace {
    /// Bytes of header and tables, which come before the first frame.
    pub opening_bytes: u64,
    /// State of each frame, `[frame]`.
    pub moments: Vec<Moment>,
    /// Units that were given up, with their errors.
    pub failures: Vec<super::Failure>,
    /// Memory that frames could not be complete without and had no room for: of each species and light the most.
    pub lacks: Vec<Lack>,
    /// Seconds to the first frame on which nothing stood in for the light of what was seen.
    pub first_picture_s: Option<f64>,
    /// Seconds to the first frame that nothing was missing from.
    pub final_picture_s: Option<f64>,
}

impl Trace {
    /// Requests, that for the tables included.
    pub fn requests(&self) -> usize {
        1 + self.moments.iter().map(|moment| moment.requests).sum::<usize>()
    }

    /// Bytes asked for, tables included.
    pub fn bytes(&self) -> u64 {
        self.opening_bytes + self.moments.iter().map(|moment| moment.requested_bytes).sum::<u64>()
    }

    /// Runs of frames after the first picture on which something that was seen had no averages yet: their number, and
    /// the frames in them.
    pub fn stalls(&self) -> (usize, usize) {
        let after = self.moments.iter().skip_while(|moment| !moment.is_complete);
        let (mut runs, mut frames, mut before) = (0, 0, true);
        for moment in after {
            runs += usize::from(before && !moment.is_complete);
            frames += usize::from(!moment.is_complete);
            before = moment.is_complete;
        }
        (runs, frames)
    }

    /// Mean quality over all frames.
    pub fn mean_quality(&self) -> f64 {
        let sum: f64 = self.moments.iter().map(|moment| f64::from(moment.quality)).sum();
        sum / self.moments.len().max(1) as f64
    }

    /// The most memory that was loaded.
    pub fn peak_bytes(&self) -> u64 {
        self.moments.iter().map(|moment| moment.loaded_bytes).max().unwrap_or(0)
    }
}

/// Replays `frames` frames of `frame_s` seconds; `need` says what each shows.
///
/// # Errors
/// [`RuntimeError::NotStreamed`].
pub fn replay(
    library: &Arc<Library>,
    settings: ResidencySettings,
    link: Link,
    frames: usize,
    frame_s: f64,
    mut need: impl FnMut(usize) -> Need,
) -> Result<Trace, RuntimeError> {
    let mut stage = Stage::new(Arc::clone(library), settings)?;
    let header = library.container().header();
    let opening_bytes = header.tables_end.max(HEAD_BYTES).min(header.file_bytes);
    let mut pipe = Pipe { link, free_s: 0.0, waiting: VecDeque::new(), open: VecDeque::new() };
    let start = link.round_trip_s + opening_bytes as f64 / link.bandwidth;
    pipe.free_s = start;
    let mut trace = Trace {
        opening_bytes,
        moments: Vec::with_capacity(frames),
        failures: Vec::new(),
        lacks: Vec::new(),
        first_picture_s: None,
        final_picture_s: None,
    };
    for index in 0..frames {
        let time_s = start + index as f64 * frame_s;
        let mut frame = Frame::default();
        for job in pipe.until(time_s) {
            for (unit, outcome) in stage.read(&job) {
                stage.take(unit, outcome, &mut frame);
            }
        }
        stage.plan(&need(index), &mut frame);
        let mut jobs = stage.jobs(&frame.requests);
        // What came with the tables is there.
        jobs.iter_mut().for_each(|job| job.ranges = beyond(&job.ranges, opening_bytes));
        let (requests, requested_bytes) =
            (jobs.iter().map(|job| job.ranges.len()).sum(), jobs.iter().map(Job::bytes).sum());
        jobs.into_iter().for_each(|job| pipe.send(job, time_s));
        if frame.is_complete {
            trace.first_picture_s.get_or_insert(time_s);
        }
        if frame.is_final {
            trace.final_picture_s.get_or_insert(time_s);
        }
        for lack in frame.lacks {
            let is_same =
                |other: &&mut Lack| (other.species, other.essential) == (lack.species, lack.essential);
            match trace.lacks.iter_mut().find(is_same) {
                Some(other) => other.bytes = other.bytes.max(lack.bytes),
                None => trace.lacks.push(lack),
            }
        }
        trace.failures.append(&mut frame.failures);
        trace.moments.push(Moment {
            time_s,
            requests,
            requested_bytes,
            loaded: frame.loaded.len(),
            evictions: frame.evictions.len(),
            loaded_bytes: stage.residency().loaded_bytes(),
            quality: frame.quality,
            is_complete: frame.is_complete,
            is_final: frame.is_final,
        });
    }
    Ok(trace)
}

/// What of ranges lies beyond the first bytes of the file.
fn beyond(ranges: &[(u64, u64)], head_bytes: u64) -> Vec<(u64, u64)> {
    let cut = |&(offset, bytes): &(u64, u64)| {
        let start = offset.max(head_bytes);
        let left = (offset + bytes).saturating_sub(start);
        (left > 0).then_some((start, left))
    };
    ranges.iter().filter_map(cut).collect()
}

/// The link, with what is under way.
struct Pipe {
    link: Link,
    /// When it has brought all that was asked for.
    free_s: f64,
    /// Jobs that wait for a connection, and since when.
    waiting: VecDeque<(Job, f64)>,
    /// Jobs that were asked for, and when their last byte comes; in that order.
    open: VecDeque<(Job, f64)>,
}

impl Pipe {
    fn send(&mut self, job: Job, now_s: f64) {
        self.waiting.push_back((job, now_s));
        self.connect(now_s);
    }

    /// Opens connections for what waits, as far as there are any.
    fn connect(&mut self, now_s: f64) {
        while self.open.len() < self.link.connections.max(1) {
            let Some((job, since_s)) = self.waiting.pop_front() else { return };
            let from_s = since_s.max(now_s);
            let at_s = if job.ranges.is_empty() {
                from_s
            } else {
                self.free_s = self.free_s.max(from_s + self.link.round_trip_s)
                    + job.bytes() as f64 / self.link.bandwidth;
                self.free_s
            };
            self.open.push_back((job, at_s));
        }
    }

    /// Jobs that have come by a time, in the order of asking; one that needs no link waits for those before it.
    fn until(&mut self, time_s: f64) -> Vec<Job> {
        let mut came = Vec::new();
        while let Some((_, at_s)) = self.open.front()
            && *at_s <= time_s
        {
            let (job, at_s) = self.open.pop_front().expect("it is there");
            came.push(job);
            self.connect(at_s);
        }
        came
    }
}

#[cfg(test)]
mod tests;
