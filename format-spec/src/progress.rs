//! How long work tells how far it is, and how its caller stops it. Stopping is a value: it goes up through `?` as any
//! other error, and the error of each crate that works long carries it.

/// Callback of long work. It hears the share that is done, 0..=1, from any thread, and answers whether to go on: work
/// that gets [`Cancelled`] ends with it. `&|_| Ok(())` lets all work end.
pub type Progress<'a> = dyn Fn(f64) -> Result<(), Cancelled> + Sync + 'a;

/// Error of work that its caller stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the work was stopped")]
pub struct Cancelled;
