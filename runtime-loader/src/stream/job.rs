//! A job: units whose bytes lie close together in the file, read at once, verified and decoded.

use std::io;
use std::sync::Arc;

use flb_format::blocks::{CodedBase, Shared};
use flb_format::error::Place;
use flb_format::{Container, FormatError, Source};

use crate::Library;
use crate::extinction::Extinction;
use crate::residency::{Runs, UnitId, UnitKind, Units};
use crate::resident::{Payload, Resident};

/// Bytes between two pages that are rather read than asked for again.
const MAX_GAP_BYTES: u64 = 4 << 10;
/// Most bytes of a read of several units.
const MAX_READ_BYTES: u64 = 1 << 20;

/// Offset and length of bytes of the file.
type Range = (u64, u64);

/// Units to be read together.
#[derive(Debug, Clone)]
pub struct Job {
    /// Each with what its species shares, where it stands on that.
    pub units: Vec<(UnitId, Option<Arc<Shared>>)>,
    /// Offsets and lengths, ascending: what is read.
    pub ranges: Vec<(u64, u64)>,
}

impl Job {
    /// Bytes that it reads.
    pub fn bytes(&self) -> u64 {
        self.ranges.iter().map(|(_, bytes)| bytes).sum()
    }
}

/// Jobs for units, in the order of the most urgent unit of each.
pub(crate) fn jobs(
    container: &Container,
    units: &Units,
    resident: &Resident,
    requests: &[UnitId],
) -> Vec<Job> {
    let shared = |unit: UnitId| match units.get(unit).kind {
        UnitKind::Averages { .. } => resident.species(units.get(unit).species as usize).shared().cloned(),
        _ => None,
    };
    let mut ordered: Vec<(usize, UnitId, Vec<Range>)> = requests
        .iter()
        .enumerate()
        .map(|(urgency, unit)| (urgency, *unit, ranges(container, units, *unit)))
        .collect();
    ordered.sort_by_key(|(_, _, ranges)| ranges[0]);
    let mut found: Vec<(usize, Job)> = Vec::new();
    for (urgency, unit, ranges) in ordered {
        let unit = (unit, shared(unit));
        if let ([range], Some((before, job))) = (&ranges[..], found.last_mut())
            && let [joined] = &mut job.ranges[..]
            && let Some(bytes) = join(*joined, *range)
        {
            joined.1 = bytes;
            job.units.push(unit);
            *before = urgency.min(*before);
            continue;
        }
        found.push((urgency, Job { units: vec![unit], ranges }));
    }
    found.sort_by_key(|(urgency, _)| *urgency);
    found.into_iter().map(|(_, job)| job).collect()
}

/// Length of two ranges as one, the second behind the first's start; `None` if they lie too far apart.
fn join((start, bytes): Range, (next, next_bytes): Range) -> Option<u64> {
    let end = (start + bytes).max(next + next_bytes);
    (next <= start + bytes + MAX_GAP_BYTES && end - start <= MAX_READ_BYTES).then_some(end - start)
}

/// The first page of a unit, to be named in errors.
pub(super) fn place(container: &Container, units: &Units, unit: UnitId) -> Place {
    let (section, pages) = units.pages_of(container, unit).swap_remove(0);
    let offset = container.pages(section)[pages.start as usize].offset;
    Place::page(offset, container.sections()[section].key, pages.start)
}

/// Where a unit's pages lie, pages close together as one; never none, as each section of a unit has a page.
fn ranges(container: &Container, units: &Units, unit: UnitId) -> Vec<Range> {
    let mut pages: Vec<Range> = units
        .pages_of(container, unit)
        .into_iter()
        .flat_map(|(section, pages)| &container.pages(section)[pages.start as usize..pages.end as usize])
        .map(|page| (page.offset, u64::from(page.stored_bytes)))
        .collect();
    pages.sort_unstable();
    let mut ranges: Vec<Range> = Vec::new();
    for page in pages {
        match ranges.last_mut() {
            Some(last) if join(*last, page).is_some() => last.1 = join(*last, page).expect("asked"),
            _ => ranges.push(page),
        }
    }
    ranges
}

/// What was read of a file, as a source.
struct Windows<'a> {
    /// Offsets and bytes.
    windows: Vec<(u64, Vec<u8>)>,
    /// Where a window could not be read, so that pages fail one by one.
    file: &'a dyn Source,
}

impl Source for Windows<'_> {
    fn len_bytes(&self) -> io::Result<u64> {
        self.file.len_bytes()
    }

    fn read_exact_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        let end = offset_bytes + buffer.len() as u64;
        let holds =
            |(start, bytes): &&(u64, Vec<u8>)| *start <= offset_bytes && end <= start + bytes.len() as u64;
        match self.windows.iter().find(holds) {
            Some((start, bytes)) => {
                let from = (offset_bytes - start) as usize;
                buffer.copy_from_slice(&bytes[from..from + buffer.len()]);
                Ok(())
            }
            None => self.file.read_once_at(offset_bytes, buffer),
        }
    }
}

/// Reads, verifies and decodes the units of a job, one after another.
pub(crate) fn read(
    library: &Library,
    units: &Units,
    job: &Job,
) -> Vec<(UnitId, Result<Payload, FormatError>)> {
    let file = library.source();
    let mut windows = Windows { windows: Vec::new(), file };
    for &(offset, bytes) in &job.ranges {
        let mut window = vec![0; bytes as usize];
        if file.read_once_at(offset, &mut window).is_ok() {
            windows.windows.push((offset, window));
        }
    }
    let one = |(unit, shared): &(UnitId, Option<Arc<Shared>>)| {
        (*unit, decode(library.container(), &windows, units, *unit, shared.as_ref()))
    };
    job.units.iter().map(one).collect()
}

fn decode(
    container: &Container,
    source: &dyn Source,
    units: &Units,
    id: UnitId,
    shared: Option<&Arc<Shared>>,
) -> Result<Payload, FormatError> {
    let unit = units.get(id);
    let species = unit.species as usize;
    match unit.kind {
        UnitKind::Shared => {
            let shared = container.read_shared(source, species)?;
            let runs = Runs::of(&shared.map);
            Ok(Payload::Shared(shared, runs))
        }
        UnitKind::Extinction => {
            let turbid = container.read_turbid(source, species)?;
            let extinction = Extinction::of(&turbid);
            // Reckoned for extinction in the stored blocks alone, as this project's writer has it.
            let (found, limit) = (extinction.size_bytes() as u64, unit.memory_bytes);
            if found > limit {
                let [leaf, _] = container.species()[species].extinction.expect("it was read");
                let entry = &container.sections()[leaf];
                let place = Place::section(entry.data_offset, entry.key);
                return Err(FormatError::Limit {
                    place,
                    what: "memory of the extinction, bytes",
                    found,
                    limit,
                });
            }
            Ok(Payload::Extinction(Box::new(extinction)))
        }
        UnitKind::Averages { base } => {
            let item = units.bases(species)[base as usize].item;
            let shared = shared.expect("averages are requested when the block map is there");
            let base: CodedBase = container.read_averages(source, species, item, shared)?;
            Ok(Payload::Averages(Box::new(base)))
        }
        UnitKind::Detail { base, page } => {
            let section = units.bases(species)[base as usize].detail;
            container.read_page(source, section, page).map(Payload::Detail)
        }
    }
}
