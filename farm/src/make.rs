//! The bake of one species, from its mesh to the bytes of its file.

use std::sync::Mutex;
use std::time::Instant;

use flb_baker::bake::{BakeObserver, Baked, Event, Store, bake};
use flb_inspector::validate::{Level, validate};
use flb_packer::{encode_species, write_library_to};
use flb_scene::color::words;
use flb_scene::{Observer, Step};

use crate::FarmError;
use crate::job::Job;
use crate::pictures::thumbnails;
use crate::record::{Facts, Record};

/// A species as it was baked.
#[derive(Debug, Clone, PartialEq)]
pub struct Made {
    /// Bytes of the file.
    pub file: Vec<u8>,
    /// Record.
    pub record: Record,
    /// Pictures of it, as a PNG file; empty where its light has no colours.
    pub picture: Vec<u8>,
    /// Log of the bake, in lines.
    pub log: String,
}

/// Hears how far a species is.
pub trait Listener: Sync {
    /// Called when a stage begins, and as it goes on, with the share that is done, 0..=1.
    fn at(&self, step: Step, share: f64) {
        let _ = (step, share);
    }

    /// Called once the sites with matter are known, before most memory is taken. It may wait for memory.
    fn matter(&self, sites: u64) {
        let _ = sites;
    }

    /// Whether to stop.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Bakes a species. What its stages made before is taken from the store, and what they make is kept there.
///
/// # Errors
/// What a mesh, a bake, a coding or a picture is refused for; [`FarmError::Changed`] where the mesh or a file that it
/// names was written meanwhile; [`FarmError::Stopped`].
pub fn make(job: &Job, store: &dyn Store, listener: &dyn Listener) -> Result<Made, FarmError> {
    let start = Instant::now();
    let heard = Heard { listener, state: Mutex::default() };
    let Job { entry, bake: settings, coding, .. } = job;
    let stopped = |error: FarmError| if listener.is_stopped() { FarmError::Stopped } else { error };
    let read = Step::Import.run(&heard, &entry.name, |_| job.read(&heard))?;
    let (plant, mut warnings) = (read.plant, read.warnings);
    check_sources(job, &plant.classed.mesh.sources)?;
    let mesh = plant.classed.clone();
    if job.follows_colors() {
        words::decisions(&plant).iter().for_each(|told| heard.note(&format!("{}: {told}", entry.name)));
    }
    let at_mesh = |source| stopped(FarmError::Bake { mesh: entry.mesh.clone(), source: Box::new(source) });
    let Baked { fields, converged, .. } = bake(plant, settings, store, &heard).map_err(at_mesh)?;
    let encode = |progress: &flb_format::progress::Progress<'_>| encode_species(&fields, coding, progress);
    let species = Step::Encode.run(&heard, &entry.name, encode).map_err(|error| stopped(error.into()))?;
    let mut file = Vec::new();
    Step::Write.run(&heard, &entry.name, |_| write_library_to(&mut file, &[&species]))?;
    let report = validate(&file, Level::Decode);
    if let Some(issue) = report.issues.first() {
        let issue = format!("{}: {}", issue.place, issue.code);
        return Err(FarmError::Unsound { species: entry.name.clone(), issue });
    }
    let picture = Step::Render.run(&heard, &entry.name, |_| thumbnails(&mesh, &entry.name, &file))?;
    warnings.extend(species.missed().filter(|missed| missed.is_loss()).map(|missed| missed.to_string()));
    let State { log, stages, .. } = heard.state.into_inner().expect("no holder panics");
    if !converged {
        warnings.push("a solve ended before it met its tolerance".to_owned());
    }
    let facts = Facts {
        is_converged: converged,
        seconds: start.elapsed().as_secs_f64(),
        warnings,
        ..Facts::of(&species, &job.key, &file)
    };
    let (name, parts, sites) = (entry.name.clone(), job.parts.clone(), fields.medium.nonempty_sites() as u64);
    let record = Record { name, parts, sites, stages, facts };
    Ok(Made { file, record, picture: picture.unwrap_or_default(), log })
}

/// Refuses a mesh whose files are others than when their digests were taken.
fn check_sources(job: &Job, sources: &[flb_format::meta::SourceFile]) -> Result<(), FarmError> {
    let Some(first) = sources.first() else { return Ok(()) };
    match job.parts.has_digest(&first.blake3) {
        true => Ok(()),
        false => Err(FarmError::Changed { file: job.entry.mesh.clone() }),
    }
}

/// What a bake tells, kept for the log and passed on.
struct Heard<'l> {
    listener: &'l dyn Listener,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    log: String,
    stages: Vec<(String, f64)>,
    running: Option<(Step, Instant)>,
}

impl Observer for Heard<'_> {
    fn begin(&self, step: Step, _: &str) {
        self.state.lock().expect("no holder panics").running = Some((step, Instant::now()));
        self.listener.at(step, 0.0);
    }

    fn progress(&self, share: f64) {
        let running = self.state.lock().expect("no holder panics").running;
        if let Some((step, _)) = running {
            self.listener.at(step, share);
        }
    }

    fn end(&self, step: Step) {
        let mut state = self.state.lock().expect("no holder panics");
        let Some((_, start)) = state.running.take() else { return };
        let seconds = start.elapsed().as_secs_f64();
        match state.stages.iter_mut().find(|(name, _)| name == step.name()) {
            Some((_, sum)) => *sum += seconds,
            None => state.stages.push((step.name().to_owned(), seconds)),
        }
    }

    fn note(&self, text: &str) {
        self.state.lock().expect("no holder panics").log.push_str(&format!("{text}\n"));
    }

    fn is_cancelled(&self) -> bool {
        self.listener.is_stopped()
    }
}

impl BakeObserver for Heard<'_> {
    fn hear(&self, event: &Event) {
        match event {
            Event::Matter { sites, .. } => self.listener.matter(*sites),
            told => self.note(&told.to_string()),
        }
    }
}
