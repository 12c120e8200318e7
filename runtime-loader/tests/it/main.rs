//! Libraries in files that change and behind servers of all kinds, and shaders under other compilers.

mod forest;

mod changing;
mod compiled;
mod faults;
mod hostile;
mod remote;
