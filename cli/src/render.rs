//! `flb render`: the mesh ray traced, with the indirect light of a file.

use std::path::Path;

use flb_format::surfaces::BandSurfaces;
use flb_format::{FieldKind, SpeciesMeta, sun};
use flb_packer::publish::publish;
use flb_render::{
    Indirect, PHYSICAL_EXPOSURE, Picture, RenderSettings, Shading, Surfaces, contact_sheet, render,
    render_reference,
};
use flb_runtime::Library;
use serde::Serialize;

use crate::args::{IndirectArg, RenderArgs};
use crate::classes::{ClassedMesh, mesh_of_species};
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_output_of, choose_species, open};
use crate::lamp::Lamp;
use crate::memory::{check, sampler_bytes};
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
    /// How far the pictures of two files are apart, over all suns.
    difference: Option<Difference>,
    stages: Vec<Stage>,
}

/// Of tone-mapped pictures, whose values are 0 to 255.
#[derive(Serialize)]
struct Difference {
    rms: f64,
    max: u8,
}

/// A file, the species to show, and what it asks of the renderer.
struct Subject {
    library: Library,
    index: usize,
    settings: RenderSettings,
}

impl Subject {
    fn open(file: &Path, args: &RenderArgs) -> Result<Subject, Failure> {
        let library = open(file)?;
        let stem = args.mesh.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let index = choose_species(&library, args.species.as_deref(), stem.as_deref())?;
        let meta = &library.container().species()[index].meta;
        check_bands(meta).map_err(|failure| failure.at(library.path()))?;
        let needed = sampler_bytes(&library.container().species()[index]);
        check(&library, &format!("the bases of species {:?}", meta.name), needed, &args.memory)?;
        let settings = settings(args, meta).map_err(|failure| failure.at(library.path()))?;
        Ok(Subject { library, index, settings })
    }

    fn meta(&self) -> &SpeciesMeta {
        &self.library.container().species()[self.index].meta
    }

    fn lamp(&self, args: &RenderArgs) -> Result<Lamp<'_>, Failure> {
        let shows = !args.path_traced && self.settings.indirect != Indirect::Off;
        Lamp::new(&self.library, self.index, shows)
    }
}

fn check_bands(meta: &SpeciesMeta) -> Result<(), Failure> {
    if meta.band_count() == 3 {
        return Ok(());
    }
    let mut message = format!(
        "species {:?} has {} bands; a picture needs 3 (red, green, blue)",
        meta.name,
        meta.band_count()
    );
    if let Some(left_out) = meta.left_out.as_ref().filter(|left_out| !left_out.bands.is_empty()) {
        message += &format!("; left out: {} ({})", left_out.bands.join(", "), left_out.reason);
    }
    Err(Failure::new(USAGE, message))
}

/// Imports the mesh as it was baked, renders one picture per sun, writes them as one.
pub fn run(args: &RenderArgs) -> Result<u8, Failure> {
    let mut inputs: Vec<&Path> = vec![&args.file, &args.mesh];
    inputs.extend(args.against.as_deref());
    check_output_of(&args.output, &inputs, args.force)?;
    let format = picture_format(&args.output)?;
    let mut stages = Stages::default();
    let subject = Subject::open(&args.file, args)?;
    let other = args.against.as_deref().map(|file| Subject::open(file, args)).transpose()?;
    let (meta, settings) = (subject.meta(), &subject.settings);
    let mesh = stages.run("import", &meta.name, |_| mesh_of_species(&args.mesh, meta))?;
    let lamp = subject.lamp(args)?;
    let other_lamp = other.as_ref().map(|other| other.lamp(args)).transpose()?;
    let mut pictures = Vec::new();
    let mut squares = Squares::default();
    for &angles in &args.sun {
        let picture = relit(args, &lamp, &mesh, settings, angles, &mut stages)?;
        let Some((other, lamp)) = other.as_ref().zip(other_lamp.as_ref()) else {
            pictures.push(picture);
            continue;
        };
        let beside = relit(args, lamp, &mesh, &other.settings, angles, &mut stages)?;
        let difference = picture.difference(&beside, args.times)?;
        squares.add(&picture.tone_mapped(settings.exposure), &beside.tone_mapped(settings.exposure));
        pictures.extend([picture, beside, difference]);
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
        difference: other.is_some().then(|| squares.difference()),
        stages: stages.list().to_vec(),
    };
    match args.json {
        true => print::json(&rendered)?,
        false => print::out(&format!(
            "{}: {} under {} sun{}, {} x {} pixels\n{}",
            rendered.output,
            rendered.species,
            rendered.suns.len(),
            if rendered.suns.len() == 1 { "" } else { "s" },
            rendered.width,
            rendered.height,
            rendered.difference.as_ref().map_or_else(String::new, |d| format!(
                "difference: {:.3} rms, {} at most, of 255\n",
                d.rms, d.max
            ))
        ))?,
    }
    Ok(0)
}

/// Square differences of pairs of pictures.
#[derive(Default)]
struct Squares {
    sum: f64,
    count: usize,
    max: u8,
}

impl Squares {
    fn add(&mut self, a: &[u8], b: &[u8]) {
        for (a, b) in a.iter().zip(b) {
            let apart = a.abs_diff(*b);
            self.sum += f64::from(apart) * f64::from(apart);
            self.max = self.max.max(apart);
        }
        self.count += a.len();
    }

    fn difference(&self) -> Difference {
        Difference { rms: libm::sqrt(self.sum / self.count.max(1) as f64), max: self.max }
    }
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
