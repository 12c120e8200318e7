//! `plant_in_a_window` on a screen in software: what it shows is lit, and obeys its keys.
#![cfg(target_os = "linux")]

use std::process::{Child, Command};
use std::time::{Duration, Instant};

use flb_testkit::xvfb::Xvfb;

/// Of the screen, and of the window on it.
const SIZE: [u16; 2] = [640, 480];
/// Longest wait for a picture: lavapipe on cores that other tests share.
const PATIENCE: Duration = Duration::from_secs(240);

/// X key symbols.
const SPACE: u32 = 0x20;
const UP: u32 = 0xff52;

/// A process that ends with the value.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The first photograph that fits, or the last before the patience ends.
fn wait(screen: &Xvfb, window: &mut Running, fits: impl Fn(&[[u8; 3]]) -> bool) -> Vec<[u8; 3]> {
    let end = Instant::now() + PATIENCE;
    loop {
        let shot = screen.photograph();
        let has_ended = window.0.try_wait().expect("a process").is_some();
        if fits(&shot) || has_ended || Instant::now() > end {
            return shot;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Of the pixels that `of` takes.
fn mean(pixels: &[[u8; 3]], of: impl Fn(usize) -> bool) -> f64 {
    let taken = || pixels.iter().enumerate().filter(|(place, _)| of(*place)).map(|(_, pixel)| pixel);
    let sum: f64 = taken().flatten().map(|value| f64::from(*value)).sum();
    sum / (3 * taken().count()).max(1) as f64
}

fn start(screen: &Xvfb, words: &[&str]) -> Running {
    let program = Command::new(env!("CARGO_BIN_EXE_plant_in_a_window"))
        .args(words)
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY")
        .spawn();
    Running(program.expect("it was built for this test"))
}

#[test]
fn a_plant_in_a_window_is_lit_by_a_sun_that_keys_move_and_turn_off() {
    let screen = Xvfb::start(SIZE);
    let mut window = start(&screen, &["--seconds", "1200"]);
    let lit = wait(&screen, &mut window, |shot| mean(shot, |_| true) > 5.0);
    // The corner shows the sky.
    let plant = |place: usize| lit[place] != lit[0];
    let seen = (0..lit.len()).filter(|place| plant(*place)).count();
    assert!(10 * seen > lit.len(), "{seen} of {} pixels show a plant", lit.len());
    if let Some(folder) = std::env::var_os("FLB_KEEP_PICTURES") {
        let rgb: Vec<u8> = lit.iter().flatten().copied().collect();
        let head = format!("P6 {} {} 255\n", SIZE[0], SIZE[1]);
        let path = std::path::Path::new(&folder).join("window.ppm");
        std::fs::write(path, [head.as_bytes(), &rgb].concat()).expect("the folder is writable");
    }

    // The light of the sky alone.
    screen.press(SPACE);
    let dark = wait(&screen, &mut window, |shot| *shot != lit[..]);
    let [bright, dim] = [&lit, &dark].map(|shot| mean(shot, plant));
    assert!(dim < 0.8 * bright, "{dim} without the sun, {bright} with it");
    assert!(dim > 10.0, "the sky lights it, too: {dim}");
    // The sun again, and higher.
    screen.press(SPACE);
    let again = wait(&screen, &mut window, |shot| *shot == lit[..]);
    assert!(again == lit, "the same light gives the same picture");
    screen.press(UP);
    let high = wait(&screen, &mut window, |shot| *shot != lit[..]);
    let high = mean(&high, plant);
    assert!(high > 1.2 * dim && (high - bright).abs() > 0.1, "{high} under a high sun, {bright} before");
}

#[test]
fn the_window_closes_by_itself_and_says_what_it_cannot_draw() {
    let screen = Xvfb::start(SIZE);
    let mut window = start(&screen, &["--seconds", "0.5"]);
    assert!(window.0.wait().expect("it ends").success());
    let mut window = start(&screen, &["none.flb"]);
    assert!(!window.0.wait().expect("it ends").success());
}
