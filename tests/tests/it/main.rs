//! The whole pipeline, and the rules of the repository.

mod autumn;
mod beside_paths;
mod comments;
mod default_bake;
mod determinism;
mod documents;
mod faces;
mod goldens;
mod imports;
mod included;
mod light;
mod mesh_light;
mod one_wall;
mod pictures;
mod plants;
mod pot;
mod regressions;
mod rest_pose;
mod scene_light;
mod sky;
mod spelling;
mod stages;
mod unsafe_code;
