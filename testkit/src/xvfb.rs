//! A screen of X that is none: what stands on it can be photographed, and keys be pressed.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    ConnectionExt as _, ImageFormat, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// Of time: now.
const NOW: u32 = 0;

/// Ends with the value.
pub struct Xvfb {
    server: Child,
    connection: RustConnection,
    root: u32,
    size: [u16; 2],
    /// What `DISPLAY` has to be.
    pub display: String,
}

impl Xvfb {
    /// Starts one of a size, with a number that is free.
    ///
    /// # Panics
    /// Where Xvfb is not installed.
    pub fn start(size: [u16; 2]) -> Xvfb {
        let screen = format!("{}x{}x24", size[0], size[1]);
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp", "-nocursor"])
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
        Xvfb { server, connection, root, size, display }
    }

    /// What the screen shows: RGB, row 0 on top.
    ///
    /// # Panics
    /// If the server has gone.
    pub fn photograph(&self) -> Vec<[u8; 3]> {
        let [width, height] = self.size;
        let asked =
            self.connection.get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, width, height, u32::MAX);
        let image = asked.expect("a request").reply().expect("a picture of the screen");
        image.data.as_chunks::<4>().0.iter().map(|[blue, green, red, _]| [*red, *green, *blue]).collect()
    }

    /// Gives the one window the keyboard, and presses and releases a key: a character, or an X key symbol.
    ///
    /// # Panics
    /// If no window is open, or the keyboard has no such key.
    pub fn press(&self, key: impl Into<u32>) {
        let key = key.into();
        let windows =
            self.connection.query_tree(self.root).expect("a request").reply().expect("windows").children;
        let first = windows.first().copied().expect("a window is open");
        self.connection.set_input_focus(InputFocus::PARENT, first, NOW).expect("a request");
        let setup = self.connection.setup();
        let (low, count) = (setup.min_keycode, setup.max_keycode - setup.min_keycode + 1);
        let keys =
            self.connection.get_keyboard_mapping(low, count).expect("a request").reply().expect("its keys");
        let row = keys.keysyms.chunks(usize::from(keys.keysyms_per_keycode));
        let place = row.into_iter().position(|signs| signs[0] == key).expect("a key of the keyboard");
        for event in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            let code = low + place as u8;
            self.connection.xtest_fake_input(event, code, NOW, self.root, 0, 0, 0).expect("a request");
        }
        self.connection.flush().expect("it is sent");
    }
}

impl Drop for Xvfb {
    fn drop(&mut self) {
        // A test that failed may have ended it.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
