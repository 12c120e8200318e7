//! The forest of an engine as WebAssembly: a file of light comes as bytes, plants stand in a moving sun, and their
//! light is asked for. A browser calls [`push`] for each byte of the file, [`run`] once, and [`value`] for each number.
//!
//! `scripts/browser` builds it with Debian's tools, runs it in Chromium, and compares its light with that of this
//! machine, bit by bit.
#![deny(unsafe_code)]

use std::cell::RefCell;
use std::sync::Arc;

use flb_format::sun::towards_sun;
use flb_runtime::forest::{Forest, ForestSettings, Work};
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, Library, Placement, RuntimeError, Transform};

/// Most frames for all that a sun needs.
const MAX_FRAMES: u32 = 200;

/// Light of eight plants at 50 points each, R, G, B, under four suns.
///
/// # Errors
/// [`RuntimeError`] for bytes that are no file of blocks near geometry.
pub fn light(file: Vec<u8>) -> Result<Vec<f32>, RuntimeError> {
    let library = Arc::new(Library::from_source("the page's file", Box::new(file))?);
    let mut forest = Forest::new(library, ForestSettings { blend_frames: 4, ..ForestSettings::default() })?;
    let stands = |number: u32| {
        let number = f64::from(number);
        Placement { species: 0, transform: Transform::from_yaw([3.0 * number, 0.0, 0.0], 33.0 * number, 1.0) }
    };
    let plants = (0..8).map(|number| forest.add(&stands(number))).collect::<Result<Vec<_>, _>>()?;
    let camera = Camera {
        position_m: [10.0, 2.0, 20.0],
        forward: [0.0, 0.0, -1.0],
        up: [0.0, 1.0, 0.0],
        fov_deg: 90.0,
        width_px: 640,
        height_px: 480,
    };
    let mut all = Vec::new();
    for hour in 0..4 {
        let hour = f64::from(hour);
        let towards_sun = towards_sun(90.0 + 30.0 * hour, 10.0 + 12.0 * hour);
        let day = Daylight { towards_sun, sun: 1.0, sky: 0.36 };
        // A page would take one frame for each that it draws, and run the work in a worker.
        for _ in 0..MAX_FRAMES {
            if forest.frame(&camera, &day, Work::run).is_final {
                break;
            }
        }
        let snapshot = forest.snapshot();
        for plant in &plants {
            for number in 0..50 {
                let (along, mut rgb) = (0.01 * number as f32, [0.0; 3]);
                snapshot.at(*plant, [along, 3.0 * along, -0.2], &mut rgb);
                all.extend(rgb);
            }
        }
    }
    Ok(all)
}

thread_local! {
    static FILE: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static LIGHT: RefCell<Vec<f32>> = const { RefCell::new(Vec::new()) };
}

/// Adds a byte to the file.
#[expect(unsafe_code, reason = "a page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn push(byte: u32) {
    FILE.with_borrow_mut(|file| file.push(byte as u8));
}

/// Finds the light; how many numbers there are, 0 for a file that is refused.
#[expect(unsafe_code, reason = "a page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn run() -> u32 {
    let found = light(FILE.take()).unwrap_or_default();
    let count = found.len() as u32;
    LIGHT.set(found);
    count
}

/// A number of the light, as its bits.
#[expect(unsafe_code, reason = "a page calls it by its name")]
#[unsafe(no_mangle)]
pub extern "C" fn value(at: u32) -> u32 {
    LIGHT.with_borrow(|light| light.get(at as usize).map_or(0, |value| value.to_bits()))
}
