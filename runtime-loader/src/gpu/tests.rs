//! Light on a GPU. The tests need an adapter, and fail without one; lavapipe (`scripts/setup test` installs it) will
//! do.

mod atlas;
mod following;
mod made;
mod near;
mod packed;
mod parity;
mod probe;
mod sky;
mod streaming;
mod wgsl;
