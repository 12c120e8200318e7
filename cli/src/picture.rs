//! What pictures of a plant and of a scene share: what `--json` says of one, its format, its light by default.

use std::path::Path;

use flb_files::publish;
use flb_format::SpeciesMeta;
use flb_render::{Indirect, Picture};
use flb_runtime::{Library, SpeciesLight};
use flb_stage::open::with_bands;
use serde::Serialize;

use crate::args::{BandArgs, IndirectArg};
use crate::exit::{Failure, NO_SKY_LIGHT, USAGE, VERDICT};
use crate::stages::Stage;

/// Pixels between the pictures of a contact sheet.
pub(crate) const SHEET_GAP: u32 = 4;

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

/// The library with those bands of a species that pictures show, in the order red, green, blue: R, G and B by their
/// names, or those that the flag names. Refuses a species without them, or whose materials' surfaces cannot be used.
pub(crate) fn shown(library: Library, index: usize, args: &BandArgs) -> Result<Library, Failure> {
    let meta = &library.container().species()[index].meta;
    let bands = shown_bands(meta, args).map_err(|failure| failure.at(library.path()))?;
    Ok(with_bands(library, index, bands))
}

/// The places of those bands.
pub(crate) fn shown_bands(
    meta: &SpeciesMeta,
    BandArgs { show_bands }: &BandArgs,
) -> Result<[usize; 3], Failure> {
    let refuse = |message| Err(Failure::new(USAGE, message));
    if let Err(error) = meta.material_surfaces() {
        return Err(Failure::new(VERDICT, format!("species {:?}: {error}", meta.name)));
    }
    let names: Vec<&str> = meta.bands().collect();
    let found = names.join(", ");
    let mut bands = Vec::new();
    for wanted in show_bands {
        match names.iter().position(|name| name == wanted) {
            Some(band) => bands.push(band),
            None => {
                let message = format!(
                    "--show-bands {wanted}: species {:?} has no such band; it has {found}",
                    meta.name
                );
                return refuse(message);
            }
        }
    }
    match bands[..] {
        [] => {}
        [grey] => return Ok([grey; 3]),
        [red, green, blue] => return Ok([red, green, blue]),
        _ => return refuse(format!("--show-bands: found {} names, expected 1 or 3", bands.len())),
    }
    if let Some(bands) = meta.color_bands() {
        return Ok(bands);
    }
    let some: Vec<&str> = if names.len() < 3 { names[..1].to_vec() } else { names[..3].to_vec() };
    let mut message = format!(
        "species {:?} has the bands {found}; a picture needs R, G and B; --show-bands {} shows those as {}",
        meta.name,
        some.join(","),
        if some.len() == 1 { "grey" } else { "red, green and blue" },
    );
    if let Some(left_out) = meta.left_out.as_ref().filter(|left_out| !left_out.bands.is_empty()) {
        message += &format!("; left out: {} ({})", left_out.bands.join(", "), left_out.reason);
    }
    refuse(message)
}

/// Writes a picture as its name asks for.
pub(crate) fn write(
    output: &Path,
    force: bool,
    picture: &Picture,
    format: PictureFormat,
    exposure: f32,
) -> Result<(), Failure> {
    let bytes = match format {
        PictureFormat::Png => picture.to_png(exposure)?,
        PictureFormat::Exr => picture.to_exr()?,
    };
    Ok(publish(output, force, |file| file.write_all(&bytes))?)
}

/// Refuses a sky over a file that was made without its light.
pub(crate) fn check_sky(light: &SpeciesLight<'_>, ambient: f32) -> Result<(), Failure> {
    if ambient > 0.0 && !light.has_sky() {
        return Err(Failure::new(USAGE, NO_SKY_LIGHT));
    }
    Ok(())
}

/// Which part of the light the flag asks for.
pub(crate) fn indirect(arg: IndirectArg) -> Indirect {
    match arg {
        IndirectArg::On => Indirect::On,
        IndirectArg::Off => Indirect::Off,
        IndirectArg::Only => Indirect::Only,
    }
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
