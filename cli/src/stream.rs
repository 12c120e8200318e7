//! `flb stream`: what a viewer would see when, if the library lay behind a link of a given speed.

use std::path::Path;
use std::sync::Arc;

use flb_files::publish;
use flb_format::Placement;
use flb_format::sun::towards_sun;
use flb_runtime::residency::{NeedFinder, Placed, ResidencySettings, Units};
use flb_runtime::stream::replay::{Link, Moment, Trace, replay};
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, Library};
use flb_scene::scene::Scene;
use flb_stage::frames::{FramePath, water_plane};
use flb_stage::{FrameSettings, SceneFrame, StageError};
use serde::Serialize;

use crate::args::StreamArgs;
use crate::exit::{Failure, INTERNAL, LIMIT, LOSS, USAGE};
use crate::forest::scene_species;
use crate::inputs::{check_output_of, open, read_scene};
use crate::memory::check_plants;
use crate::print::{self, line, say};

/// Most frames of a replay.
const MAX_FRAMES: f64 = 1_000_000.0;
/// Width of the picture by its height.
const ASPECT: f64 = 16.0 / 9.0;

/// What `--json` prints (cli/schema/stream.json), and the trace with its frames.
#[derive(Serialize)]
struct Streamed {
    library: String,
    /// Of the whole file.
    file_bytes: u64,
    scene: String,
    instances: usize,
    rtt_ms: f64,
    bandwidth_mb_s: f64,
    connections: u16,
    budget_bytes: u64,
    frames: usize,
    seconds: f64,
    /// Header and tables, which come before the first frame.
    opening_bytes: u64,
    requests: usize,
    bytes: u64,
    evictions: usize,
    /// The most memory that was loaded.
    peak_bytes: u64,
    /// Seconds to the first frame on which nothing stood in for the light of what was seen; null: it never came.
    first_picture_s: Option<f64>,
    /// Seconds to the first frame that nothing was missing from that fits; null: it never came.
    final_picture_s: Option<f64>,
    stalls: Stalls,
    /// Mean over the frames of the share of what they could use, by the error that it removes, that was loaded.
    mean_quality: f64,
    /// Units that were given up.
    failures: Vec<String>,
    /// What light could not be complete without and the budget had no room for.
    lacks: Vec<String>,
}

/// Runs of frames after the first picture on which something stood in for the light of what was seen.
#[derive(Serialize)]
struct Stalls {
    count: usize,
    frames: usize,
    seconds: f64,
}

/// The trace's file.
#[derive(Serialize)]
struct TraceFile<'a> {
    #[serde(flatten)]
    streamed: &'a Streamed,
    moments: Vec<FrameLine>,
}

#[derive(Serialize)]
struct FrameLine {
    time_s: f64,
    requests: usize,
    requested_bytes: u64,
    loaded: usize,
    evictions: usize,
    loaded_bytes: u64,
    quality: f32,
    is_complete: bool,
    is_final: bool,
}

/// Reads scene and library, replays, prints.
pub(crate) fn run(args: &StreamArgs) -> Result<u8, Failure> {
    if let Some(trace) = &args.trace {
        check_output_of(trace, &[&args.library, &args.scene], args.existing)?;
    }
    let frames = (args.seconds * args.fps).max(1.0);
    if frames > MAX_FRAMES {
        let message =
            format!("{frames:.0} frames, expected at most {MAX_FRAMES}: fewer seconds or frames a second");
        return Err(Failure::new(LIMIT, message));
    }
    let outputs: Vec<&Path> = args.trace.iter().map(|path| path.as_path()).collect();
    let scene = read_scene(&args.scene, &outputs)?;
    check_plants(&args.scene, scene.instances.len(), Placed::PLANT_BYTES, &args.memory)?;
    let settings = FrameSettings { needs_sun: true, ..FrameSettings::default() };
    let path = FramePath::of(&scene, &settings).map_err(|error| match error {
        StageError::NoSun => Failure::new(
            USAGE,
            "the sun has no place, expected `fixed = [[AZIMUTH, ELEVATION], ...]` or `path` in [sun]",
        )
        .at(&args.scene),
        error => Failure::from(error).at(&args.scene),
    })?;
    let library = Arc::new(open(&args.library)?);
    let placed = place(&scene, &library).map_err(|failure| failure.at(&args.scene))?;
    let units = Units::new(library.container(), library.path())?;
    let mut finder = NeedFinder::new(library.container(), &units);
    let frames = frames as usize;
    let water = water_plane(&scene);
    let need = |frame: usize| {
        let t = if frames > 1 { frame as f64 / (frames - 1) as f64 } else { 0.0 };
        let (camera, daylight) = seen(&scene, &path.at(t));
        let mut need = finder.find_over_water(&placed, &camera, water, &daylight);
        for added in &scene.sunlight.added {
            let towards_sun = towards_sun(added.sun_deg[0], added.sun_deg[1]);
            let alone = Daylight { towards_sun, sun: 1.0, sky: 0.0 };
            need.add(&finder.find_over_water(&placed, &camera, water, &alone));
        }
        need
    };
    let link = Link {
        round_trip_s: args.rtt / 1e3,
        bandwidth: args.bandwidth * 1e6,
        connections: usize::from(args.connections),
    };
    let settings =
        ResidencySettings { budget_bytes: (args.budget * 1e6) as u64, ..ResidencySettings::default() };
    let trace = replay(&library, settings, link, frames, 1.0 / args.fps, need)?;
    let streamed = Streamed::of(args, &library, &placed, &settings, &trace);
    if let Some(path) = &args.trace {
        let file =
            TraceFile { streamed: &streamed, moments: trace.moments.iter().map(FrameLine::of).collect() };
        let text = serde_json::to_string_pretty(&file).map_err(|error| Failure::new(INTERNAL, error))?;
        publish(path, args.existing, |file| file.write_all((text + "\n").as_bytes()))?;
    }
    match args.json {
        true => print::json(&streamed)?,
        false => print::out(&text(&streamed))?,
    }
    for failure in &streamed.failures {
        say!("{}: given up: {failure}", streamed.library);
    }
    for lack in &streamed.lacks {
        say!("{}: {lack}", streamed.library);
    }
    Ok(if streamed.failures.is_empty() && streamed.first_picture_s.is_some() { 0 } else { LOSS })
}

impl Streamed {
    fn of(
        args: &StreamArgs,
        library: &Library,
        placed: &Placed,
        settings: &ResidencySettings,
        trace: &Trace,
    ) -> Streamed {
        let (count, frames) = trace.stalls();
        Streamed {
            library: library.path().display().to_string(),
            file_bytes: library.container().header().file_bytes,
            scene: args.scene.display().to_string(),
            instances: placed.len(),
            rtt_ms: args.rtt,
            bandwidth_mb_s: args.bandwidth,
            connections: args.connections,
            budget_bytes: settings.budget_bytes,
            frames: trace.moments.len(),
            seconds: args.seconds,
            opening_bytes: trace.opening_bytes,
            requests: trace.requests(),
            bytes: trace.bytes(),
            evictions: trace.moments.iter().map(|moment| moment.evictions).sum(),
            peak_bytes: trace.peak_bytes(),
            first_picture_s: trace.first_picture_s,
            final_picture_s: trace.final_picture_s,
            stalls: Stalls { count, frames, seconds: frames as f64 / args.fps },
            mean_quality: trace.mean_quality(),
            lacks: trace.lacks.iter().map(|lack| lack.describe(library.container())).collect(),
            failures: trace.failures.iter().map(|failure| failure.error.to_string()).collect(),
        }
    }
}

impl FrameLine {
    fn of(moment: &Moment) -> FrameLine {
        let Moment { time_s, requests, requested_bytes, loaded, evictions, loaded_bytes, .. } = *moment;
        FrameLine {
            time_s,
            requests,
            requested_bytes,
            loaded,
            evictions,
            loaded_bytes,
            quality: moment.quality,
            is_complete: moment.is_complete,
            is_final: moment.is_final,
        }
    }
}

/// The camera and the daylight of a frame.
fn seen(scene: &Scene, frame: &SceneFrame) -> (Camera, Daylight) {
    let height_px = scene.camera.as_ref().map_or(0, |camera| camera.height_px);
    let width_px = (f64::from(height_px) * ASPECT) as u32;
    let [azimuth_deg, elevation_deg] = frame.sun_deg.unwrap_or_default();
    let daylight = Daylight {
        towards_sun: towards_sun(azimuth_deg, elevation_deg),
        sun: 1.0,
        sky: scene.ambient.unwrap_or(0.02) as f32,
    };
    (Camera::of(&frame.eye, [width_px, height_px]), daylight)
}

/// The scene's plants as those of the library.
fn place(scene: &Scene, library: &Library) -> Result<Placed, Failure> {
    let mut species = Vec::with_capacity(scene.species.len());
    for wanted in &scene.species {
        species.push(scene_species(library, wanted)?);
    }
    let plants = scene.instances.iter().map(|plant| Placement { species: species[plant.species], ..*plant });
    Ok(Placed::new(library.container(), plants))
}

fn text(streamed: &Streamed) -> String {
    let seconds = |value: Option<f64>| value.map_or("never".to_owned(), |value| format!("{value:.3} s"));
    let rows = [
        ("first picture", seconds(streamed.first_picture_s)),
        ("final picture", seconds(streamed.final_picture_s)),
        (
            "stalls",
            format!(
                "{} of {} frames, {:.2} s",
                streamed.stalls.count, streamed.stalls.frames, streamed.stalls.seconds
            ),
        ),
        (
            "quality",
            format!("{:.1} % of what the frames could use, on the mean", 100.0 * streamed.mean_quality),
        ),
        ("requests", format!("{}, of which 1 for the tables", streamed.requests)),
        (
            "bytes",
            format!("{} of a file of {}", print::bytes(streamed.bytes), print::bytes(streamed.file_bytes)),
        ),
        (
            "memory",
            format!("{} of {}", print::bytes(streamed.peak_bytes), print::bytes(streamed.budget_bytes)),
        ),
        ("evictions", streamed.evictions.to_string()),
    ];
    let mut text = line!(
        "{}: {} plants, {} frames in {} s, over {} ms and {} MB/s",
        streamed.library,
        streamed.instances,
        streamed.frames,
        streamed.seconds,
        streamed.rtt_ms,
        streamed.bandwidth_mb_s
    );
    for (name, value) in rows {
        text += &line!("  {name:<14} {value}");
    }
    text
}
