//! Libraries in files that change and behind servers of all kinds.

mod forest;
#[cfg(feature = "remote")]
mod server;

mod changing;
mod hostile;
mod remote;
