//! What a run was started with: how large its stack may be, and whether stdout was open. The standard library puts
//! `/dev/null` in the place of a closed stdout before `main` begins, so that data would vanish and the run look like a
//! success.
//!
//! The one file of this crate that leaves safe Rust: a function that the system's loader calls before the standard
//! library starts. It makes one system call and keeps one bit.

use std::sync::atomic::{AtomicBool, Ordering};

static STDOUT_WAS_CLOSED: AtomicBool = AtomicBool::new(false);

/// Whether the program was started without a stdout, or with one that is open for reading alone, whose errors the
/// standard library passes over.
pub(crate) fn stdout_was_closed() -> bool {
    STDOUT_WAS_CLOSED.load(Ordering::Relaxed)
}

/// Bytes that the stack of the main thread may have; `None` where there is no limit, or none is told.
pub(crate) fn stack_bytes() -> Option<u64> {
    #[cfg(target_os = "linux")]
    return rustix::process::getrlimit(rustix::process::Resource::Stack).current;
    #[cfg(not(target_os = "linux"))]
    None
}

#[cfg(target_os = "linux")]
mod before_main {
    #![allow(unsafe_code, reason = "the loader calls what stands in .init_array")]

    use rustix::fs::OFlags;

    use super::*;

    // SAFETY: the loader calls every pointer of this section, with arguments that a function without parameters does
    // not read. `look` neither allocates nor needs anything that the standard library sets up.
    #[used]
    #[unsafe(link_section = ".init_array")]
    static LOOK: extern "C" fn() = look;

    extern "C" fn look() {
        let flags = rustix::fs::fcntl_getfl(rustix::stdio::stdout());
        let takes = flags.is_ok_and(|flags| flags & OFlags::ACCMODE != OFlags::RDONLY);
        STDOUT_WAS_CLOSED.store(!takes, Ordering::Relaxed);
    }
}
