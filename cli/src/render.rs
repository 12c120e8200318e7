//! `flb render`: the mesh ray traced, with the indirect light of a file.

use std::path::Path;

use flb_format::surfaces::BandSurfaces;
use flb_format::{FieldKind, SpeciesMeta, sun};
use flb_packer::publish::publish;
use flb_render::{
    Indirect, PHYSICAL_EXPOSURE, Picture, RenderSettings, Shading, Surfaces, contact_sheet, render,
    render_reference,
};
use serde::Serialize;

use crate::args::{IndirectArg, RenderArgs};
use crate::classes::{ClassedMesh, mesh_of_species};
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_output_of, choose_species, open};
use crate::lamp::Lamp;
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
    check_output_of(&args.output, &[&args.file, &args.mesh], args.force)?;
    let format = picture_format(&args.output)?;
    let mut stages = Stages::default();
    let library = open(&args.file)?;
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
        return Err(Failure::new(USAGE, message).at(library.path()));
    }
    let mesh = stages.run("import", &meta.name, |_| mesh_of_species(&args.mesh, meta))?;

    let settings = settings(args, meta).map_err(|failure| failure.at(library.path()))?;
    let shows = !args.path_traced && settings.indirect != Indirect::Off;
    let lamp = Lamp::new(&library, index, shows)?;
    let mut pictures = Vec::new();
    for &angles in &args.sun {
        pictures.push(relit(args, &lamp, &mesh, &settings, angles, &mut stages)?);
    }
    let picture = match pictures.len() {
        1 => pictures.remove(0),
        _ => contact_sheet(&pictures, SHEET_GAP)?,
    };
    let bytes = match format {
        PictureFormat::Png => picture.to_png(settings.exposure)?,
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
    lamp: &Lamp,
    mesh: &ClassedMesh,
    settings: &RenderSettings,
    [azimuth, elevation]: [f64; 2],
    stages: &mut Stages,
) -> Result<Picture, Failure> {
    let settings = RenderSettings { sun: sun::towards_sun(azimuth, elevation), ..settings.clone() };
    let subject = format!("sun {azimuth},{elevation}");
    if args.path_traced {
        let traced = stages.run("render", &subject, |progress| {
            render_reference(&mesh.mesh, &mesh.classes, &settings, progress)
        })?;
        return Ok(traced.picture);
    }
    let light = lamp.under(&settings, stages)?;
    Ok(stages.run("render", &subject, |progress| {
        render(&mesh.mesh, &mesh.classes, &*light, &settings, progress)
    })?)
}

/// What the flags ask for, of a file of its model. The sun comes later.
fn settings(args: &RenderArgs, meta: &SpeciesMeta) -> Result<RenderSettings, Failure> {
    let refuse = |message: &str| Err(Failure::new(USAGE, message));
    let physical = meta.physical();
    if physical.is_none() && args.path_traced {
        return refuse(
            "--path-traced needs a physical file: a paper file does not say what leaves reflect and transmit",
        );
    }
    if physical.is_some() && args.indirect_scale.is_some() {
        return refuse(
            "--indirect-scale is for paper files: a physical one has its light in the sun's units",
        );
    }
    if physical.is_some_and(|(_, light)| light.field == FieldKind::Total) && !args.path_traced {
        eprintln!(
            "flb: warning: the fields hold the sun's beam, which shadow rays add again: the sun counts twice"
        );
    }
    let defaults = RenderSettings::default();
    let (shading, ambient, exposure) = match physical {
        Some((surfaces, _)) => (Shading::Physical(shares(surfaces)), PHYSICAL_SKY, PHYSICAL_EXPOSURE),
        None => (Shading::Paper, defaults.ambient, defaults.exposure),
    };
    Ok(RenderSettings {
        width: args.size[0],
        height: args.size[1],
        samples: args.samples,
        shading,
        ambient: args.ambient.unwrap_or(ambient),
        indirect: match args.indirect {
            IndirectArg::On => Indirect::On,
            IndirectArg::Off => Indirect::Off,
            IndirectArg::Only => Indirect::Only,
        },
        indirect_scale: args.indirect_scale.unwrap_or(defaults.indirect_scale),
        view_azimuth_deg: args.view[0],
        view_elevation_deg: args.view[1],
        exposure: args.exposure.unwrap_or(exposure),
        ground: args.ground,
        ..defaults
    })
}

/// Fluence of the sky by default, the sun's being 1: a clear day's diffuse light.
const PHYSICAL_SKY: f32 = 0.36;

/// Surfaces of the first three bands, as the renderer takes them.
fn shares(surfaces: &flb_format::Surfaces) -> Surfaces {
    let of =
        |share: fn(&BandSurfaces) -> f64| std::array::from_fn(|band| share(&surfaces.bands[band]) as f32);
    Surfaces {
        leaf_reflectance: of(|band| band.leaf.reflectance),
        leaf_transmittance: of(|band| band.leaf.transmittance),
        wood_reflectance: of(|band| band.wood.reflectance),
    }
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
