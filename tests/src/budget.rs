//! How right light is while it streams, and with less memory than it needs.

use std::sync::Arc;
use std::time::Duration;

use flb_format::{Placement, Transform};
use flb_runtime::residency::{NeedFinder, Placed, ResidencySettings, Units};
use flb_runtime::resident::{LightLevel, ResidentSpecies};
use flb_runtime::stream::{StreamSettings, Streamer};
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, Library, SpeciesLight};

/// How long a frame waits for what was asked for.
const PATIENCE: Duration = Duration::from_secs(10);

/// What became of the light of one plant, which stands near a camera.
#[derive(Debug)]
pub struct Streamed {
    /// Mean over points and bands at the end over that of the whole file, less 1.
    pub mean_off: f64,
    /// Root mean square error of a point at the end over the mean of the whole file.
    pub rms: f64,
    /// Largest change of a point from one frame to the next, over that mean, and its frame.
    pub largest_jump: (f64, usize),
    /// Frames until nothing more comes.
    pub frames: usize,
    /// At the end.
    pub level: LightLevel,
    /// Memory that the budget is short of light without stand-ins.
    pub lacks_bytes: u64,
    /// The smallest budget without any.
    pub least_bytes: u64,
}

/// Streams the first species of a library until nothing more comes.
///
/// # Panics
/// If the library is not of three bands coded near geometry.
pub fn streamed(
    library: &Arc<Library>,
    points: &[[f32; 3]],
    daylight: &Daylight,
    budget_bytes: u64,
    blend_frames: u16,
) -> Streamed {
    let whole = SpeciesLight::load(library, 0).expect("a valid file");
    let lit = |light: &SpeciesLight| -> Vec<[f64; 3]> {
        let lit = light.lit_by_in_model(daylight).expect("a direction");
        let at = |point: &[f32; 3]| {
            let mut phi = [0.0; 3];
            lit.at(*point, &mut phi);
            phi.map(f64::from)
        };
        points.iter().map(at).collect()
    };
    let mean = |light: &[[f64; 3]]| light.iter().flatten().sum::<f64>() / (3 * light.len()) as f64;
    let expected = lit(&whole);
    let all = mean(&expected);
    let residency = ResidencySettings { budget_bytes, ..ResidencySettings::default() };
    // A unit a frame: how many come in two milliseconds is the machine's affair.
    let settings =
        StreamSettings { residency, blend_frames, frame_time: Duration::ZERO, ..StreamSettings::default() };
    let mut streamer = Streamer::new(Arc::clone(library), settings).expect("coded near geometry");
    let container = library.container();
    let units = Units::new(container, library.path()).expect("coded near geometry");
    let bounds = &container.species()[0].meta.bounds_m;
    let across = (bounds.max[1] - bounds.min[1]) as f32;
    let plant = Placement { species: 0, transform: Transform::IDENTITY };
    let placed = Placed::new(container, [plant]);
    let camera = Camera {
        position_m: [0.0, across / 2.0, 2.0 * across],
        forward: [0.0, 0.0, -1.0],
        up: [0.0, 1.0, 0.0],
        fov_deg: 60.0,
        width_px: 1920,
        height_px: 1080,
    };
    let need = NeedFinder::new(container, &units).find(&placed, &camera, daylight);
    let now = |streamer: &Streamer| {
        let species: &ResidentSpecies = streamer.resident().species(0);
        (
            lit(&SpeciesLight::streamed(species)),
            species.terms(daylight.towards_sun, daylight.sun, daylight.sky).level,
        )
    };
    let (mut before, mut largest_jump, mut frames) = (now(&streamer).0, (0.0, 0), 0);
    loop {
        let frame = streamer.frame(&need);
        frames += 1;
        let (light, level) = now(&streamer);
        let jump = |(now, before): (&[f64; 3], &[f64; 3])| {
            now.iter().zip(before).map(|(now, before)| (now - before).abs() / all).fold(0.0, f64::max)
        };
        let jump = light.iter().zip(&before).map(jump).fold(0.0, f64::max);
        if jump > largest_jump.0 {
            largest_jump = (jump, frames);
        }
        if frame.is_final {
            let square = |(now, right): (&[f64; 3], &[f64; 3])| -> f64 {
                now.iter().zip(right).map(|(now, right)| (now - right) * (now - right)).sum()
            };
            let squares: f64 = light.iter().zip(&expected).map(square).sum();
            return Streamed {
                mean_off: mean(&light) / all - 1.0,
                rms: (squares / (3 * light.len()) as f64).sqrt() / all,
                largest_jump,
                frames,
                level,
                lacks_bytes: frame.lacks.iter().map(|lack| lack.bytes).sum(),
                least_bytes: streamer.residency().least_budget(&need),
            };
        }
        before = light;
        if frame.requests.is_empty() && frame.loaded.is_empty() && streamer.residency().requested() > 0 {
            streamer.wait(PATIENCE);
        }
    }
}
