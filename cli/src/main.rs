//! The `flb` command: parse the words, call the rooms, print, exit with a code.
//!
//! stdout is data, stderr is talk. Exit codes: see [`exit`].
#![forbid(unsafe_code)]

mod args;
mod bake;
mod bake_scene;
mod cache;
mod classes;
mod diff;
mod doctor;
mod exit;
mod extract;
mod forest;
mod grow;
mod info;
mod inputs;
mod lamp;
mod materials;
mod memory;
mod migrate;
mod pack;
mod physical;
mod plan;
mod preset;
mod print;
mod render;
mod saving;
mod scatter;
mod scene;
mod solving;
mod stages;
mod stream;
mod summary;
mod toml_text;
mod torture;
mod trade;
mod validate;
#[cfg(feature = "view")]
mod view;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use exit::Failure;
use flb_runtime::retry_replaced;

#[global_allocator]
static HEAP: peak_alloc::PeakAlloc = peak_alloc::PeakAlloc;

fn main() -> ExitCode {
    let cli = Cli::parse();
    #[cfg(feature = "remote")]
    inputs::allow_private_redirects(cli.allow_private_redirects);
    let threads = usize::from(cli.threads.unwrap_or(0));
    // 0 lets rayon take every core. The results do not depend on it.
    if let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global() {
        eprintln!("flb: cannot start {threads} threads: {error}");
        return ExitCode::from(exit::INTERNAL);
    }
    // An interrupted command leaves nothing behind. Without the handler it still works, so that is no error.
    let _ = ctrlc::set_handler(|| {
        flb_packer::publish::remove_unfinished();
        std::process::exit(exit::INTERRUPTED.into());
    });
    // A panic is a fault of ours; it has printed its own message, and must not look like a verdict.
    let outcome = std::panic::catch_unwind(|| run(cli.command));
    match outcome {
        Ok(Ok(code)) => ExitCode::from(code),
        Ok(Err(failure)) => {
            if !failure.quiet {
                eprintln!("flb: {}", failure.message);
            }
            ExitCode::from(failure.code)
        }
        Err(_) => ExitCode::from(exit::INTERNAL),
    }
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
        Command::Render(args) => again(|| render::run(&args)),
        Command::Stream(args) => again(|| stream::run(&args)),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(&args),
        Command::Grow(args) => grow::run(&args),
        Command::Scatter(args) => scatter::run(&args),
        Command::Scene(args) => scene::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Trade(args) => trade::run(&args),
    }
}

/// Runs a command that reads files behind URLs, and again from its start where one was replaced meanwhile. Such commands
/// write only after they have read everything.
fn again(command: impl FnMut() -> Result<u8, Failure>) -> Result<u8, Failure> {
    retry_replaced(
        command,
        |failure| failure.replaced,
        |failure| eprintln!("flb: {}; reading it again", failure.message),
    )
}
