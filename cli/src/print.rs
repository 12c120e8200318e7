//! The one module that writes to stdout and stderr: data to the one, sentences to the other. What comes from outside
//! (names in files, words of servers) is made harmless here, secrets are left out, and nothing here panics.

#![allow(clippy::disallowed_methods, reason = "this is the module that all others go through")]

mod table;

use std::io::{self, IsTerminal, Write};

use serde::Serialize;

use crate::clean::{self, shown};
use crate::exit::{Failure, INPUT_OUTPUT, INTERNAL};
use crate::startup;

pub(crate) use crate::clean::one_line;
pub(crate) use flb_format::size_text::bytes;
pub(crate) use table::{mesh_error, table};

/// Most bytes of a message, its end included.
pub(crate) const MAX_MESSAGE_BYTES: usize = 2048;
/// Before every line of a message but the first, which begins with "flb: ": no name that holds a line break can pass
/// for a message of its own.
const NEXT_LINE: &str = "\n   | ";

/// Writes a sentence to stderr, as [`say_text`].
macro_rules! say {
    ($($words:tt)*) => { $crate::print::say_text(&format!($($words)*)) };
}
pub(crate) use say;

/// A line for [`out`]: what breaks it in the middle came from outside, and is shown by its letters.
macro_rules! line {
    ($($words:tt)*) => { $crate::print::one_line(&format!($($words)*)).into_owned() + "\n" };
}
pub(crate) use line;

/// Writes a sentence to stderr. Where stderr is closed or full there is nowhere to say so, and the work goes on.
pub(crate) fn say_text(text: &str) {
    let _ = io::stderr().lock().write_all(message(text).as_bytes());
}

/// A message as it is written.
fn message(text: &str) -> String {
    let lines = shown(text.trim_end()).replace('\n', NEXT_LINE);
    let whole = format!("flb: {lines}\n");
    if whole.len() <= MAX_MESSAGE_BYTES {
        return whole;
    }
    let end = format!(" ... ({} bytes in all)\n", whole.len());
    let cut = whole.floor_char_boundary(MAX_MESSAGE_BYTES - end.len());
    // Not between a line break and what begins the next line.
    whole[..cut].trim_end_matches(['\n', ' ', '|']).to_owned() + &end
}

/// Writes text to stdout, made of [`line`]s and tables. A reader that went away ends the command quietly.
pub(crate) fn out(text: &str) -> Result<(), Failure> {
    to_stdout(&shown(text))
}

/// Writes a value to stdout as indented JSON. What cannot be seen is written by its number, as JSON allows.
pub(crate) fn json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::new(INTERNAL, error))?;
    to_stdout(&(clean::json(&text) + "\n"))
}

/// Writes a value to stdout as one line of JSON.
pub(crate) fn json_line(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(value).map_err(|error| Failure::new(INTERNAL, error))?;
    to_stdout(&(clean::json(&text) + "\n"))
}

/// Writes help and version, which are ours alone, with what marks them on a terminal.
pub(crate) fn help(error: &clap::Error) -> Result<(), Failure> {
    check_open()?;
    error.print().and_then(|()| io::stdout().flush()).map_err(|error| failed(&error))
}

fn to_stdout(text: &str) -> Result<(), Failure> {
    check_open()?;
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()).map_err(|error| failed(&error))
}

fn check_open() -> Result<(), Failure> {
    match startup::stdout_was_closed() {
        true => Err(Failure::new(INPUT_OUTPUT, "standard output is closed")),
        false => Ok(()),
    }
}

fn failed(error: &io::Error) -> Failure {
    let mut failure = Failure::new(INPUT_OUTPUT, format!("standard output: {error}"));
    failure.quiet = error.kind() == io::ErrorKind::BrokenPipe;
    failure
}

/// A time: "40 s", "12 min", "3.5 h".
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// Whether sentences go to a terminal, so that a bar may move there.
pub(crate) fn is_terminal() -> bool {
    io::stderr().is_terminal()
}

#[cfg(test)]
mod tests;
