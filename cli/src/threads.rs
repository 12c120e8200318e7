//! The threads of a run, started before its work, so that a limit on threads is said at once.

use std::sync::mpsc;
use std::thread;

use crate::exit::{Failure, LIMIT};

/// Threads that a command may start beside those that work together: it waits for signals, moves a bar, reads behind
/// URLs, streams.
const OTHERS: usize = 16;

/// Starts the threads that work together; without a number as many as there are cores. Results do not depend on it.
///
/// # Errors
/// The system gives fewer threads than a command may need.
pub(crate) fn start(count: Option<u16>) -> Result<(), Failure> {
    let cores = || thread::available_parallelism().map_or(1, usize::from);
    // Said, so that no variable of the environment says another number.
    let count = count.map(usize::from).filter(|count| *count > 0).unwrap_or_else(cores);
    let refused = |error: &dyn std::fmt::Display| {
        let wanted = count + OTHERS;
        let message = format!(
            "cannot start {wanted} threads: {error}; a higher limit (ulimit -u) or fewer --threads help"
        );
        Failure::new(LIMIT, message)
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build_global();
    pool.map_err(|error| refused(&error))?;
    match is_limited() {
        true => try_others().map_err(|error| refused(&error)),
        false => Ok(()),
    }
}

/// Whether the user may have so few threads that a command could run out of them.
#[cfg(unix)]
fn is_limited() -> bool {
    use rustix::process::{Resource, getrlimit};
    /// Users have fewer running, all programs together.
    const ENOUGH: u64 = 4096;
    getrlimit(Resource::Nproc).current.is_some_and(|most| most < ENOUGH)
}

#[cfg(not(unix))]
fn is_limited() -> bool {
    false
}

/// Starts as many as there may be, all at once, and lets them end.
fn try_others() -> std::io::Result<()> {
    let start = || {
        let (stop, wait) = mpsc::channel::<()>();
        // It ends when `stop` is dropped.
        let wait = thread::Builder::new().spawn(move || wait.recv().unwrap_or_default())?;
        Ok((stop, wait))
    };
    let started: Vec<std::io::Result<_>> = (0..OTHERS).map(|_| start()).collect();
    for thread in started {
        let (stop, wait) = thread?;
        drop(stop);
        drop(wait.join());
    }
    Ok(())
}
