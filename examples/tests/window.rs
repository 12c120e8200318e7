//! `plant_in_a_window` on a screen in software: what it shows is lit, and obeys its keys.
#![cfg(target_os = "linux")]

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    ConnectionExt as _, ImageFormat, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

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

/// A screen of X that is none.
struct Screen {
    _server: Running,
    connection: RustConnection,
    root: u32,
    /// What `DISPLAY` has to be.
    display: String,
}

impl Screen {
    fn start() -> Screen {
        let size = format!("{}x{}x24", SIZE[0], SIZE[1]);
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &size, "-nolisten", "tcp", "-nocursor"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts (scripts/setup test installs it)");
        let mut number = String::new();
        let out = server.stdout.take().expect("it is a pipe");
        BufReader::new(out).read_line(&mut number).expect("Xvfb says which display it is");
        let display = format!(":{}", number.trim());
        let (connection, screen) = x11rb::connect(Some(&display)).expect("Xvfb answers");
        let root = connection.setup().roots[screen].root;
        Screen { _server: Running(server), connection, root, display }
    }

    /// `[pixel]` blue, green, red.
    fn photograph(&self) -> Vec<[u8; 3]> {
        let asked =
            self.connection.get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, SIZE[0], SIZE[1], u32::MAX);
        let image = asked.expect("a request").reply().expect("a picture of the screen");
        image.data.as_chunks::<4>().0.iter().map(|[blue, green, red, _]| [*blue, *green, *red]).collect()
    }

    /// Gives the one window the keyboard, and presses and releases a key.
    fn press(&self, key: u32) {
        let tree = self.connection.query_tree(self.root).expect("a request").reply().expect("windows");
        let window = tree.children.first().copied().expect("the window is open");
        self.connection.set_input_focus(InputFocus::PARENT, window, 0u32).expect("a request");
        let setup = self.connection.setup();
        let (low, count) = (setup.min_keycode, setup.max_keycode - setup.min_keycode + 1);
        let keys = self.connection.get_keyboard_mapping(low, count).expect("a request").reply();
        let keys = keys.expect("its keys");
        let mut rows = keys.keysyms.chunks(usize::from(keys.keysyms_per_keycode));
        let place = rows.position(|signs| signs[0] == key).expect("a key of the keyboard");
        for event in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            let code = low + place as u8;
            self.connection.xtest_fake_input(event, code, 0, self.root, 0, 0, 0).expect("a request");
        }
        self.connection.flush().expect("it is sent");
    }

    /// The first photograph that fits, or the last before the patience ends.
    fn wait(&self, window: &mut Running, fits: impl Fn(&[[u8; 3]]) -> bool) -> Vec<[u8; 3]> {
        let end = Instant::now() + PATIENCE;
        loop {
            let shot = self.photograph();
            let has_ended = window.0.try_wait().expect("a process").is_some();
            if fits(&shot) || has_ended || Instant::now() > end {
                return shot;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

/// Of the pixels that `of` takes.
fn mean(pixels: &[[u8; 3]], of: impl Fn(usize) -> bool) -> f64 {
    let taken = || pixels.iter().enumerate().filter(|(place, _)| of(*place)).map(|(_, pixel)| pixel);
    let sum: f64 = taken().flatten().map(|value| f64::from(*value)).sum();
    sum / (3 * taken().count()).max(1) as f64
}

fn start(screen: &Screen, words: &[&str]) -> Running {
    let program = Command::new(env!("CARGO_BIN_EXE_plant_in_a_window"))
        .args(words)
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY")
        .spawn();
    Running(program.expect("it was built for this test"))
}

#[test]
fn a_plant_in_a_window_is_lit_by_a_sun_that_keys_move_and_turn_off() {
    let screen = Screen::start();
    let mut window = start(&screen, &["--seconds", "1200"]);
    let lit = screen.wait(&mut window, |shot| mean(shot, |_| true) > 5.0);
    // The corner shows the sky.
    let plant = |place: usize| lit[place] != lit[0];
    let seen = (0..lit.len()).filter(|place| plant(*place)).count();
    assert!(10 * seen > lit.len(), "{seen} of {} pixels show a plant", lit.len());
    if let Some(folder) = std::env::var_os("FLB_KEEP_PICTURES") {
        let rgb: Vec<u8> = lit.iter().flat_map(|[blue, green, red]| [*red, *green, *blue]).collect();
        let head = format!("P6 {} {} 255\n", SIZE[0], SIZE[1]);
        let path = std::path::Path::new(&folder).join("window.ppm");
        std::fs::write(path, [head.as_bytes(), &rgb].concat()).expect("the folder is writable");
    }

    // The light of the sky alone.
    screen.press(SPACE);
    let dark = screen.wait(&mut window, |shot| *shot != lit[..]);
    let [bright, dim] = [&lit, &dark].map(|shot| mean(shot, plant));
    assert!(dim < 0.8 * bright, "{dim} without the sun, {bright} with it");
    assert!(dim > 10.0, "the sky lights it, too: {dim}");
    // The sun again, and higher.
    screen.press(SPACE);
    let again = screen.wait(&mut window, |shot| *shot == lit[..]);
    assert!(again == lit, "the same light gives the same picture");
    screen.press(UP);
    let high = screen.wait(&mut window, |shot| *shot != lit[..]);
    let high = mean(&high, plant);
    assert!(high > 1.2 * dim && (high - bright).abs() > 0.1, "{high} under a high sun, {bright} before");
}

#[test]
fn the_window_closes_by_itself_and_says_what_it_cannot_draw() {
    let screen = Screen::start();
    let mut window = start(&screen, &["--seconds", "0.5"]);
    assert!(window.0.wait().expect("it ends").success());
    let mut window = start(&screen, &["none.flb"]);
    assert!(!window.0.wait().expect("it ends").success());
}
