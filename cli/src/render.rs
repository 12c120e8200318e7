//! `flb render`: the mesh ray traced, with the indirect light of a file.

use std::path::Path;

use flb_format::sun;
use flb_packer::publish::publish;
use flb_render::{Indirect, Picture, RenderSettings, contact_sheet, render};
use flb_runtime::{Library, SpeciesSampler, bases_needed};
use serde::Serialize;

use crate::args::{IndirectArg, RenderArgs};
use crate::classes::{ClassedMesh, mesh_of_species};
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_output, choose_species};
use crate::print;
use crate::stages::{Stage, Stages};

/// Pixels between the pictures of a contact sheet.
const SHEET_GAP: u32 = 4;

#[derive(Serialize)]
struct Rendered {
    output: String,
    species: String,
    width: u32,
    height: u32,
    suns: Vec<[f64; 2]>,
    stages: Vec<Stage>,
}

/// Imports the mesh as it was baked, renders one picture per sun, writes them as one.
pub fn run(args: &RenderArgs) -> Result<u8, Failure> {
    check_output(&args.output, &[&args.file, &args.mesh], args.force)?;
    let format = picture_format(&args.output)?;
    let mut stages = Stages::default();
    let library = Library::open(&args.file)?;
    let stem = args.mesh.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let index = choose_species(&library, args.species.as_deref(), stem.as_deref())?;
    let meta = &library.container().species()[index].meta;
    if meta.band_count() != 3 {
        let mut message = format!(
            "species {:?} has {} bands; a picture needs 3 (red, green, blue)",
            meta.name,
            meta.band_count()
        );
        if let Some(left_out) = meta.left_out.as_ref().filter(|left_out| !left_out.bands.is_empty()) {
            message += &format!("; left out: {} ({})", left_out.bands.join(", "), left_out.reason);
        }
        return Err(Failure::new(USAGE, message).at(&args.file));
    }
    let mesh = stages.run("import", &meta.name, |_| mesh_of_species(&args.mesh, meta))?;

    let mut pictures = Vec::new();
    for &angles in &args.sun {
        pictures.push(relit(args, &library, index, &mesh, angles, &mut stages)?);
    }
    let picture = match pictures.len() {
        1 => pictures.remove(0),
        _ => contact_sheet(&pictures, SHEET_GAP)?,
    };
    let bytes = match format {
        PictureFormat::Png => picture.to_png(args.exposure)?,
        PictureFormat::Exr => picture.to_exr()?,
    };
    publish(&args.output, args.force, |file| file.write_all(&bytes))?;
    let rendered = Rendered {
        output: args.output.display().to_string(),
        species: meta.name.clone(),
        width: picture.width,
        height: picture.height,
        suns: args.sun.clone(),
        stages: stages.list().to_vec(),
    };
    match args.json {
        true => print::json(&rendered)?,
        false => print::out(&format!(
            "{}: {} under {} sun{}, {} x {} pixels\n",
            rendered.output,
            rendered.species,
            rendered.suns.len(),
            if rendered.suns.len() == 1 { "" } else { "s" },
            rendered.width,
            rendered.height
        ))?,
    }
    Ok(0)
}

/// One picture under the sun at azimuth and elevation.
fn relit(
    args: &RenderArgs,
    library: &Library,
    index: usize,
    mesh: &ClassedMesh,
    [azimuth, elevation]: [f64; 2],
    stages: &mut Stages,
) -> Result<Picture, Failure> {
    let towards_sun = sun::towards_sun(azimuth, elevation);
    let blend = sun::blend(towards_sun).ok_or_else(|| Failure::new(USAGE, "the sun has no direction"))?;
    let sampler = match args.indirect {
        // Nothing of the file shows, so nothing is read.
        IndirectArg::Off => None,
        _ => Some(SpeciesSampler::load(library, index, &bases_needed(&blend, args.ambient > 0.0))?),
    };
    let light = |point: [f32; 3], phi: &mut [f32; 3]| match &sampler {
        Some(sampler) => sampler.indirect(&blend, 1.0, args.ambient, point, phi),
        None => *phi = [0.0; 3],
    };
    let settings = RenderSettings {
        width: args.size[0],
        height: args.size[1],
        samples: args.samples,
        sun: towards_sun,
        ambient: args.ambient,
        indirect: match args.indirect {
            IndirectArg::On => Indirect::On,
            IndirectArg::Off => Indirect::Off,
            IndirectArg::Only => Indirect::Only,
        },
        indirect_scale: args.indirect_scale,
        view_azimuth_deg: args.view[0],
        view_elevation_deg: args.view[1],
        exposure: args.exposure,
        ground: args.ground,
        ..RenderSettings::default()
    };
    let subject = format!("sun {azimuth},{elevation}");
    Ok(stages
        .run("render", &subject, |progress| render(&mesh.mesh, &mesh.classes, &light, &settings, progress))?)
}

enum PictureFormat {
    Png,
    Exr,
}

fn picture_format(output: &Path) -> Result<PictureFormat, Failure> {
    match output.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("png") => Ok(PictureFormat::Png),
        Some("exr") => Ok(PictureFormat::Exr),
        found => {
            let found = found.map_or("no extension".to_owned(), |e| format!(".{e}"));
            Err(Failure::new(USAGE, format!("found {found}, expected .png or .exr")).at(output))
        }
    }
}
