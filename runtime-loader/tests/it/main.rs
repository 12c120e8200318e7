//! Libraries in files that change and behind servers of all kinds.

mod forest;

mod changing;
mod faults;
mod hostile;
mod remote;
