//! Flies past a row of plants whose light is streamed: what each frame shows is loaded, the coarse before the fine.
//!
//! `cargo run -p flb-examples --bin stream_a_forest [FILE.flb]`; without a file it takes the shrub of the tests.
#![forbid(unsafe_code)]

use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use flb_format::{Placement, Transform, sun};
use flb_runtime::residency::{NeedFinder, Placed};
use flb_runtime::stream::{StreamSettings, Streamer};
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, Library, SpeciesLight};

const SHRUB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../runtime-loader/golden/shrub.flb");

/// Frames of the flight, and how long a frame lasts at most until it is all there.
const FRAMES: u32 = 5;
const PATIENCE: Duration = Duration::from_millis(20);

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| SHRUB.to_owned());
    let library = Arc::new(Library::open(&path)?);
    let mut streamer = Streamer::new(library.clone(), StreamSettings::default())?;
    let mut finder = NeedFinder::new(library.container(), streamer.residency().units());
    let turned = |turns: f64| {
        let (sin, cos) = libm::sincos(turns);
        [[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]]
    };
    let stands =
        |i: f64| Transform { rotation: turned(0.7 * i), position_m: [3.0 * i, 0.0, -8.0], scale: 1.0 };
    let row: Vec<Placement> =
        (0..40).map(|i| Placement { species: 0, transform: stands(f64::from(i)) }).collect();
    let plants = Placed::new(library.container(), row.iter().copied());
    let daylight = Daylight { towards_sun: sun::towards_sun(135.0, 40.0), sun: 1.0, sky: 0.36 };
    for frame in 0..FRAMES {
        let camera = Camera {
            position_m: [25.0 * frame as f32, 1.7, 0.0],
            forward: [0.3, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            fov_deg: 50.0,
            width_px: 1280,
            height_px: 720,
        };
        let need = finder.find(&plants, &camera, &daylight);
        // A real renderer draws what is there and goes on; this one waits to show how the light becomes finer.
        loop {
            let now = streamer.frame(&need);
            let species = SpeciesLight::streamed(streamer.resident().species(0));
            let lit = species.lit_by(&daylight, &row[0].transform)?;
            let mut rgb = vec![0.0; species.bands()];
            lit.at([0.0, 0.5, 0.0], &mut rgb);
            println!(
                "frame {frame}: {} units came, quality {:.2}, light {rgb:.3?}",
                now.loaded.len(),
                now.quality
            );
            if now.is_final {
                break;
            }
            streamer.wait(PATIENCE);
        }
    }
    Ok(())
}
