//! The words of `flb scene`.

use std::path::PathBuf;

use clap::{ArgAction, Args};
use flb_files::Existing;

use super::scatter::{area, range};
use super::values::existing;

#[derive(Args)]
pub(crate) struct SceneArgs {
    /// A glTF or GLB file whose nodes each show a plant's mesh, or many (EXT_mesh_gpu_instancing)
    #[arg(value_name = "FOREST.glb")]
    pub file: PathBuf,
    /// The library with a mesh's baked light; repeat it for more. MESH is the mesh's name, or its number as #3
    #[arg(long, value_name = "MESH=LIGHT.flb", value_parser = named_file)]
    pub light: Vec<(String, PathBuf)>,
    /// The species file of a mesh; repeat it for more
    #[arg(long, value_name = "MESH=FILE.toml", value_parser = named_file)]
    pub species_file: Vec<(String, PathBuf)>,
    /// A mesh that is no plant, the ground for example; repeat it for more
    #[arg(long, value_name = "MESH")]
    pub leave_out: Vec<String>,
    /// Nodes to take, each with all below it (glob, case ignored, or #3 for a node's number; repeat it for more)
    /// [default: all that the file shows]
    #[arg(long, value_name = "PATTERN")]
    pub node: Vec<String>,
    /// Height of a plane of ground, metres [default: no ground]
    #[arg(long, value_name = "METRES", conflicts_with = "height_map", allow_hyphen_values = true)]
    pub ground: Option<f64>,
    /// Grey PNG of the ground's height, its border pixels on the border of --area; north (-Z) is up
    #[arg(long, value_name = "MAP.png", requires_all = ["height", "area"])]
    pub height_map: Option<PathBuf>,
    /// Heights of the map's black and white, metres
    #[arg(long, value_name = "LOW..HIGH", value_parser = range, allow_hyphen_values = true, requires = "height_map")]
    pub height: Option<[f64; 2]>,
    /// Edges of the map along x and z, metres; its middle is the origin
    #[arg(long, value_name = "X,Z", value_parser = area, requires = "height_map")]
    pub area: Option<[f64; 2]>,
    /// The scene to write, with the camera and the sun of the file where it has some
    #[arg(short, long, value_name = "SCENE.toml")]
    pub output: PathBuf,
    /// Overwrite the output if it is there already
    #[arg(long = "force", action = ArgAction::SetTrue, value_parser = existing())]
    pub existing: Existing,
    /// Print what was found as JSON (schema: cli/schema/scene.json)
    #[arg(long)]
    pub json: bool,
}

/// `MESH=FILE`.
fn named_file(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=').filter(|(mesh, file)| !mesh.is_empty() && !file.is_empty()) {
        Some((mesh, file)) => Ok((mesh.to_owned(), file.into())),
        None => Err(format!("expected MESH=FILE, such as Oak=oak.flb; found {text:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_for_a_mesh() {
        assert_eq!(named_file("#3=a=b.flb"), Ok(("#3".to_owned(), PathBuf::from("a=b.flb"))));
        for text in ["oak.flb", "=oak.flb", "Oak=", ""] {
            assert!(named_file(text).unwrap_err().contains("expected MESH=FILE"), "{text}");
        }
    }
}
