//! What pictures of a plant and of a scene share: what `--json` says of one, its format, its light by default.

use std::path::Path;

use flb_files::{Existing, publish};
use flb_render::Picture;
use flb_render::picture::{SHEET_GAP, contact_sheet, exr_of};
use flb_stage::SceneShow;
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

/// Writes the layers of a picture as its name asks for, which [`check_layers`] has passed.
pub(crate) fn write(
    output: &Path,
    existing: Existing,
    layers: &[(SceneShow, Picture)],
    format: PictureFormat,
    exposure: f32,
) -> Result<(), Failure> {
    let alpha = layers.iter().find(|(show, _)| *show == SceneShow::Alpha).map(|(_, picture)| picture);
    let shown: Vec<_> = layers.iter().filter(|(show, _)| *show != SceneShow::Alpha).collect();
    let bytes = match (format, alpha, &shown[..]) {
        (PictureFormat::Png, Some(alpha), [(_, picture)]) => picture.to_png_with_alpha(exposure, alpha)?,
        (PictureFormat::Png, None, [(_, picture)]) => picture.to_png(exposure)?,
        _ => {
            // The only one needs no name, and the light never has one.
            let name = |show: SceneShow| match show {
                SceneShow::Light => String::new(),
                _ if shown.len() == 1 => String::new(),
                SceneShow::Base(base) => format!("base{base}"),
                show => show.to_string(),
            };
            let names: Vec<String> = shown.iter().map(|(show, _)| name(*show)).collect();
            let layers: Vec<_> =
                names.iter().map(String::as_str).zip(shown.iter().map(|(_, picture)| picture)).collect();
            exr_of(&layers, alpha)?
        }
    };
    Ok(publish(output, existing, |file| file.write_all(&bytes))?)
}

/// Refuses layers that a format has no room for.
pub(crate) fn check_layers(output: &Path, format: PictureFormat, shows: &[SceneShow]) -> Result<(), Failure> {
    let pictures = shows.iter().filter(|show| **show != SceneShow::Alpha).count();
    if matches!(format, PictureFormat::Png) && pictures != 1 {
        let message = "--show: a .png holds one of light, direct, indirect, base:N and global, with or without alpha; an .exr \
                       holds all";
        return Err(Failure::new(USAGE, message).at(output));
    }
    Ok(())
}

/// Layers of several pictures side by side, as layers of one.
pub(crate) fn sheet(pictures: Vec<Vec<(SceneShow, Picture)>>) -> Result<Vec<(SceneShow, Picture)>, Failure> {
    let mut by_layer: Vec<(SceneShow, Vec<Picture>)> = Vec::new();
    for (place, (show, picture)) in pictures.into_iter().flat_map(|layers| layers.into_iter().enumerate()) {
        match by_layer.get_mut(place) {
            Some((_, pictures)) => pictures.push(picture),
            None => by_layer.push((show, vec![picture])),
        }
    }
    let of_layer = |(show, mut pictures): (SceneShow, Vec<Picture>)| match pictures.len() {
        1 => Ok((show, pictures.remove(0))),
        _ => Ok((show, contact_sheet(&pictures, SHEET_GAP)?)),
    };
    by_layer.into_iter().map(of_layer).collect()
}

#[derive(Clone, Copy)]
pub(crate) enum PictureFormat {
    Png,
    Exr,
}

/// Refuses an output whose name does not end in .png. `what` it is, and how it is called.
pub(crate) fn expect_png(output: &Path, what: &str) -> Result<(), Failure> {
    match picture_format(output) {
        Ok(PictureFormat::Png) => Ok(()),
        _ => Err(Failure::new(USAGE, what).at(output)),
    }
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
