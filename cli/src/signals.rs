//! What signals do. One that ends a run leaves nothing behind; one that the starter ignores (`nohup`, a job in the
//! background of a shell without job control) stays ignored; a file that outgrows the limit of `ulimit -f` is an error
//! of its write, and a failed allocation has its exit code.

#[cfg(unix)]
pub(crate) use unix::handle;

#[cfg(unix)]
mod unix {
    use std::io;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc;
    use std::thread;

    use signal_hook::consts::{
        SIGABRT, SIGALRM, SIGHUP, SIGINT, SIGIO, SIGPROF, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGVTALRM,
        SIGXCPU, SIGXFSZ,
    };
    use signal_hook::flag::{register, register_conditional_shutdown};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level;

    use crate::exit;

    /// Signals that end a process which does not handle them, but those of faults.
    const ENDING: [i32; 11] =
        [SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGIO, SIGXCPU];

    /// From here on signals do what this module says. Without it the command still works, so a failure of that is no
    /// error.
    pub(crate) fn handle() {
        // First, as what follows takes memory, and a thread of its own.
        let _ = abort_with_codes();
        let ignored = ignored();
        let is_heeded = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
        let _ = end_by(ENDING.into_iter().filter(is_heeded).collect());
        // A handler that does nothing, so that the write fails in place of the process.
        let _ = register(SIGXFSZ, Arc::default());
    }

    /// Rust aborts where an allocation fails, and has said so; and where a panic cannot go on.
    fn abort_with_codes() -> io::Result<()> {
        let panics = Arc::new(AtomicBool::new(false));
        let panicked = Arc::clone(&panics);
        let print = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            print(info);
            // After the message: where there is no memory for it, or another thread finds none meanwhile, memory is why
            // the run ends.
            panicked.store(true, Ordering::SeqCst);
        }));
        // In this order: what a signal does is done in the order of its registration.
        register_conditional_shutdown(SIGABRT, exit::INTERNAL.into(), panics)?;
        register_conditional_shutdown(SIGABRT, exit::LIMIT.into(), Arc::new(AtomicBool::new(true)))?;
        Ok(())
    }

    fn end_by(signals: Vec<i32>) -> io::Result<()> {
        if signals.is_empty() {
            return Ok(());
        }
        let (begun, begins) = mpsc::channel();
        let wait = move || {
            // In the thread, so that without it signals do what they do by default.
            let signals = Signals::new(signals);
            let _ = begun.send(()); // the other end waits
            let Ok(mut signals) = signals else { return };
            if signals.forever().next().is_some() {
                flb_files::stop_publishing();
                // At once: what else runs at the end of a process may be in use by the work that goes on.
                low_level::exit(exit::INTERRUPTED.into());
            }
        };
        thread::Builder::new().name("flb-signals".to_owned()).spawn(wait)?;
        let _ = begins.recv(); // the thread may have ended
        Ok(())
    }

    /// Bit `n - 1`: signal `n` was ignored when the program started. Linux tells; elsewhere none counts as ignored.
    fn ignored() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
    }
}

/// Signals are Unix's.
#[cfg(not(unix))]
pub fn handle() {}
