//! The command under `strace`, which lists its system calls and makes chosen ones fail, come late or bring a signal.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::flb::{Folder, Run};

/// The first call that `main` makes, behind all that the loader and the standard library do. Before it nothing is
/// injected.
const FIRST: &str = "\"/proc/self/status\"";

/// System calls of the main thread, by name and in order.
pub(crate) struct Trace {
    /// From the start of the process.
    calls: Vec<String>,
    /// Calls before `main`'s first.
    before: usize,
}

impl Trace {
    /// How often each call is made: before `main`, and in all.
    pub(crate) fn counts(&self) -> BTreeMap<String, (usize, usize)> {
        let mut counts = BTreeMap::new();
        for (at, call) in self.calls.iter().enumerate() {
            let name = call.split('(').next().unwrap_or_default().to_owned();
            let (before, all): &mut (usize, usize) = counts.entry(name).or_default();
            *before += usize::from(at < self.before);
            *all += 1;
        }
        counts
    }

    /// Paths of all files that were opened for reading, as they were named.
    pub(crate) fn read(&self) -> Vec<PathBuf> {
        let opened = self.calls[self.before..].iter().filter(|call| {
            call.starts_with("openat(")
                && call.contains("O_RDONLY")
                && !call.contains("O_DIRECTORY")
                && !call.contains(" = -1 ")
        });
        opened.filter_map(|call| call.split('"').nth(1)).map(PathBuf::from).collect()
    }
}

fn log(folder: &Folder) -> PathBuf {
    // Beside the folder, which a test may list.
    folder.path("").with_extension("strace")
}

/// Runs the command whole and lists its calls.
pub(crate) fn trace(folder: &Folder, words: &[&str]) -> (Run, Trace) {
    let log = log(folder);
    let run = strace(folder, &["-o", log.to_str().expect("a plain name")], words);
    let text = std::fs::read_to_string(&log).expect("strace writes its log");
    std::fs::remove_file(&log).expect("it is ours");
    let calls: Vec<String> = text.lines().map(str::to_owned).collect();
    let before = calls.iter().position(|call| call.contains(FIRST)).expect("main begins");
    (run, Trace { calls, before })
}

/// Runs the command with one thing injected: words of strace's `-e inject=`.
pub(crate) fn inject(folder: &Folder, injection: &str, words: &[&str]) -> Run {
    let call = injection.split(':').next().unwrap_or_default();
    let (traced, injected) = (format!("trace={call}"), format!("inject={injection}"));
    strace(folder, &["-o", "/dev/null", "-e", &traced, "-e", &injected], words)
}

/// `code` is 128 and the signal's number where a signal ended it.
fn strace(folder: &Folder, options: &[&str], words: &[&str]) -> Run {
    // A signal that the tests were started to ignore, as by nohup, would be ignored by all that they start.
    let mut command = Command::new("env");
    command.args(["--default-signal", "strace"]);
    // A memory mapping is no file, and alignments make for other addresses; one thread works.
    command.args(options).args(["-s", "4096", "--", env!("CARGO_BIN_EXE_flb")]).args(words);
    let output = command
        .current_dir(folder.path(""))
        .stdin(Stdio::null())
        .output()
        .expect("scripts/setup installs strace");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let signal = std::os::unix::process::ExitStatusExt::signal(&output.status).unwrap_or(0);
    let code = output.status.code().unwrap_or(128 + signal);
    Run { code, stdout: text(output.stdout), stderr: text(output.stderr) }
}
