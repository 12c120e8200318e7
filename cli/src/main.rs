//! The `flb` command: parse the words, call the rooms, print, exit with a code.
//!
//! stdout is data, stderr is talk. Exit codes: see [`exit`].
#![deny(unsafe_code, clippy::print_stdout, clippy::print_stderr)]

mod args;
mod bake;
mod bake_scene;
mod cache;
mod classes;
mod clean;
mod colors;
#[cfg(test)]
mod commit; // of build.rs
mod diff;
mod doctor;
mod exit;
mod extract;
mod farm;
mod folder;
mod forest;
mod grow;
mod info;
mod inputs;
mod judge;
mod library;
mod materials;
mod memory;
mod mesh_of_light;
mod migrate;
mod pack;
mod picture;
mod plan;
mod print;
#[cfg(all(test, feature = "gpu", feature = "remote", feature = "view"))]
mod reference;
mod render;
mod saving;
mod scatter;
mod scene;
mod signals;
mod size;
mod sky;
mod stages;
mod startup;
mod stream;
mod summary;
mod threads;
mod toml_text;
mod torture;
mod trade;
mod validate;
mod version;
#[cfg(feature = "view")]
mod view;

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use exit::Failure;
use flb_runtime::source::retry_replaced;
use print::say;

#[global_allocator]
static HEAP: peak_alloc::PeakAlloc = peak_alloc::PeakAlloc;

/// Stack of the thread that runs a command where the system gives the main one less than the least.
const STACK_BYTES: usize = 8 << 20;
const MIN_STACK_BYTES: u64 = 1 << 20;

fn main() -> ExitCode {
    if startup::stack_bytes().is_none_or(|bytes| bytes >= MIN_STACK_BYTES) {
        return guarded();
    }
    let command = std::thread::Builder::new().name("flb".to_owned()).stack_size(STACK_BYTES).spawn(guarded);
    match command {
        Ok(thread) => thread.join().unwrap_or(ExitCode::from(exit::INTERNAL)),
        Err(error) => {
            print::say_text(&format!(
                "a thread with {STACK_BYTES} bytes of stack: {error}; a higher limit (ulimit -s, -v) helps"
            ));
            ExitCode::from(exit::LIMIT)
        }
    }
}

/// Runs, and ends with a code whatever happens.
fn guarded() -> ExitCode {
    // A panic is a fault of ours; its message goes the way of all others, and it must not look like a verdict.
    std::panic::set_hook(Box::new(|info| say!("internal error: {info}")));
    let code = std::panic::catch_unwind(|| match start() {
        Ok(code) => code,
        Err(failure) => {
            if !failure.quiet {
                print::say_text(&failure.message);
            }
            failure.code
        }
    });
    ExitCode::from(code.unwrap_or(exit::INTERNAL))
}

/// Reads the command line, prepares the process, runs the command.
fn start() -> Result<u8, Failure> {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if !error.use_stderr() => return print::help(&error).map(|()| 0),
        Err(error) => {
            let text = error.render().to_string();
            return Err(Failure::new(exit::USAGE, text.strip_prefix("error: ").unwrap_or(&text)));
        }
    };
    #[cfg(feature = "remote")]
    inputs::allow_private_redirects(cli.allow_private_redirects);
    signals::handle();
    flb_files::guard_inputs();
    threads::start(cli.threads)?;
    run(cli.command)
}

/// Runs one command; `Ok` carries the exit code of a command that ran to its end.
fn run(command: Command) -> Result<u8, Failure> {
    match command {
        Command::Bake(args) => bake::run(&args),
        Command::BakeScene(args) => again(|| bake_scene::run(&args)),
        Command::Plan(args) => plan::run(&args),
        Command::Materials(args) => materials::run(&args),
        Command::Pack(args) => again(|| pack::run(&args)),
        Command::Migrate(args) => again(|| migrate::run(&args)),
        Command::Info(args) => again(|| info::run(&args)),
        Command::Validate(args) => validate::run(&args),
        Command::Torture(args) => torture::run(&args),
        Command::Diff(args) => again(|| diff::run(&args)),
        Command::Extract(args) => again(|| extract::run(&args)),
        Command::Render(args) if is_scene(&args.file) => again(|| forest::run(&args)),
        Command::Render(args) => again(|| render::run(&args)),
        Command::Judge(args) => again(|| judge::run(&args)),
        Command::Stream(args) => again(|| stream::run(&args)),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(&args),
        Command::Grow(args) => grow::run(&args),
        Command::Scatter(args) => scatter::run(&args),
        Command::Scene(args) => scene::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Trade(args) => trade::run(&args),
        Command::Library(args) => library::run(&args),
        Command::Cache(args) => cache::run(&args),
        Command::Farm(args) => farm::run(&args),
        Command::Task(args) => farm::run_task(&args),
    }
}

/// Whether a file to draw is a scene, by its name.
fn is_scene(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Runs a command that reads files behind URLs, and again from its start where one was replaced meanwhile. Such
/// commands write only after they have read everything.
fn again(command: impl FnMut() -> Result<u8, Failure>) -> Result<u8, Failure> {
    retry_replaced(
        command,
        |failure| failure.replaced,
        |failure| say!("{}; reading it again", failure.message),
    )
}
