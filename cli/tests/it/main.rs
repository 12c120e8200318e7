//! The built command, run as its users run it: one binary, as each is linked against all of `flb`.

mod flb;
mod picture;
mod schema;
#[cfg(target_os = "linux")]
mod strace;

mod bands;
mod bucket;
mod caches;
mod coded;
mod colours;
mod exit_codes;
mod extents;
mod farm;
mod faults;
mod forest;
mod gpu;
mod guards;
mod help;
mod hostile;
mod hostile_scenes;
mod json;
mod judge;
mod killed;
mod library;
mod library_diff;
mod main_job;
mod migrate;
mod mistakes;
mod nightly;
mod odd_meshes;
mod outputs;
mod papers;
mod physical;
mod plan;
mod remote;
mod remote_secrets;
mod scene;
mod scene_light;
mod signals;
mod sky;
#[cfg(target_os = "linux")]
mod slurm;
mod stream;
mod torture;
mod trade;
mod version;
mod view;
mod words;
