//! What pictures of a plant and of a scene share: what `--json` says of one, its format, its light by default.

use std::path::Path;

use flb_files::{Existing, publish};
use flb_render::Picture;
use serde::Serialize;

use crate::exit::{Failure, USAGE};
use crate::stages::Stage;

/// What `--json` prints (cli/schema/render.json).
#[derive(Serialize)]
pub(crate) struct Rendered<S> {
    pub output: String,
    pub species: String,
    pub width: u32,
    pub height: u32,
    pub suns: Vec<[f64; 2]>,
    /// Whether the light of a single plant is of its mesh: "same", "differs" or "unknown".
    pub mesh_match: Option<&'static str>,
    /// How far the pictures of two files of a single plant are apart, over all suns.
    pub difference: Option<Difference>,
    /// Only of scenes.
    pub scene: Option<S>,
    pub stages: Vec<Stage>,
}

/// Of tone-mapped pictures, whose values are 0 to 255.
#[derive(Serialize)]
pub(crate) struct Difference {
    pub rms: f64,
    pub max: u8,
}

/// Writes a picture as its name asks for.
pub(crate) fn write(
    output: &Path,
    existing: Existing,
    picture: &Picture,
    format: PictureFormat,
    exposure: f32,
) -> Result<(), Failure> {
    let bytes = match format {
        PictureFormat::Png => picture.to_png(exposure)?,
        PictureFormat::Exr => picture.to_exr()?,
    };
    Ok(publish(output, existing, |file| file.write_all(&bytes))?)
}

#[derive(Clone, Copy)]
pub(crate) enum PictureFormat {
    Png,
    Exr,
}

pub(crate) fn picture_format(output: &Path) -> Result<PictureFormat, Failure> {
    match output.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("png") => Ok(PictureFormat::Png),
        Some("exr") => Ok(PictureFormat::Exr),
        found => {
            let found = found.map_or("no extension".to_owned(), |e| format!(".{e}"));
            Err(Failure::new(USAGE, format!("found {found}, expected .png or .exr")).at(output))
        }
    }
}
