//! `flb extract`: one base, the density or the extinction, as a slice sheet or as a volume.

use std::sync::Arc;

use flb_files::publish;
use flb_inspector::extract::{Volume, slice_sheet_png, volume_exr, volume_npy};
use flb_runtime::Library;
use flb_stage::plant::PlantLight;
use serde::Serialize;

use crate::args::{ExtractArgs, VolumeFormat};
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_output_of, choose_species, open};
use crate::memory::{check, field_bytes, read_bytes};
use crate::print::{self, line};

#[derive(Serialize)]
struct Extracted {
    output: String,
    species: String,
    /// "density", "extinction" or the base's number.
    volume: String,
    format: &'static str,
    lattice: u32,
    bytes: usize,
}

/// Reads the volume, writes it.
pub(crate) fn run(args: &ExtractArgs) -> Result<u8, Failure> {
    check_output_of(&args.output, &[&args.file], args.existing)?;
    check_extension(args)?;
    let library = open(&args.file)?;
    let index = choose_species(&library, args.species.as_deref(), None)?;
    let library = of_bands(library, index, args)?;
    let (container, source) = (library.container(), library.source());
    let meta = &container.species()[index].meta;
    let bands: Vec<String> = meta.bands().map(str::to_owned).collect();

    let wanted = wanted(args)?;
    let (field, medium, turbid);
    let volume = match wanted {
        Wanted::Base(base) => {
            let have = &container.species()[index].bases;
            if !have.iter().any(|entry| entry.base == base) {
                let list: Vec<String> = have.iter().map(|entry| entry.base.to_string()).collect();
                let left_out = meta.left_out.as_ref().filter(|left_out| left_out.bases.contains(base));
                let why =
                    left_out.map_or(String::new(), |left_out| format!(" (left out: {})", left_out.reason));
                let message =
                    format!("species {:?} has no base {base}{why}; it has {}", meta.name, list.join(", "));
                return Err(Failure::new(USAGE, message).at(library.path()));
            }
            let entry = container.find_base(index, base).expect("it was just found");
            let species = &container.species()[index];
            // The values, and the bytes that are written.
            let needed = read_bytes(species, entry).saturating_add(field_bytes(species));
            check(&library, &format!("base {base} of species {:?}", meta.name), needed, &args.memory)?;
            field =
                container.read_field(source, index, base).map_err(|e| Failure::from(e).at(library.path()))?;
            Volume::Base { field: &field, bands: &bands }
        }
        Wanted::Extinction => {
            turbid = container.read_turbid(source, index).map_err(|e| Failure::from(e).at(library.path()))?;
            Volume::Extinction(&turbid)
        }
        Wanted::Density => {
            medium = container.read_medium(source, index).map_err(|e| Failure::from(e).at(library.path()))?;
            Volume::Density(&medium)
        }
    };
    let (format, bytes) = match args.format {
        VolumeFormat::Png => ("png", slice_sheet_png(&volume, SHEET_SLICES)?),
        VolumeFormat::Exr => ("exr", volume_exr(&volume)?),
        VolumeFormat::Npy => ("npy", volume_npy(&volume)),
    };
    publish(&args.output, args.existing, |file| file.write_all(&bytes))?;
    let extracted = Extracted {
        output: args.output.display().to_string(),
        species: meta.name.clone(),
        volume: match wanted {
            Wanted::Density => "density".to_owned(),
            Wanted::Extinction => "extinction".to_owned(),
            Wanted::Base(base) => base.to_string(),
        },
        format,
        lattice: meta.grid.lattice,
        bytes: bytes.len(),
    };
    match args.json {
        true => print::json(&extracted)?,
        false => print::out(&line!(
            "{}: {} of {}, {}",
            extracted.output,
            match wanted {
                Wanted::Base(base) => format!("base {base}"),
                _ => extracted.volume.clone(),
            },
            extracted.species,
            print::bytes(bytes.len() as u64)
        ))?,
    }
    Ok(0)
}

/// With the bands that a sheet of a base shows; all of them for other formats, and one alone, which is grey.
fn of_bands(library: Library, index: usize, args: &ExtractArgs) -> Result<Arc<Library>, Failure> {
    let is_sheet = matches!((wanted(args)?, args.format), (Wanted::Base(_), VolumeFormat::Png));
    let meta = &library.container().species()[index].meta;
    match args.bands.show_bands.is_empty() {
        true if !is_sheet || meta.band_count() == 1 => Ok(Arc::new(library)),
        false if !is_sheet => Err(Failure::new(
            USAGE,
            "--show-bands is for --format png of a base; other formats have every band",
        )),
        _ => Ok(PlantLight::shown(library, index, &args.bands.show_bands)?.library),
    }
}

/// Slices of a sheet: enough to follow a crown from back to front.
const SHEET_SLICES: u32 = 64;

/// Refuses an output whose extension promises another of the formats.
fn check_extension(args: &ExtractArgs) -> Result<(), Failure> {
    let expected = match args.format {
        VolumeFormat::Png => "png",
        VolumeFormat::Exr => "exr",
        VolumeFormat::Npy => "npy",
    };
    let found = args.output.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if ["png", "exr", "npy"].contains(&found.as_str()) && found != expected {
        return Err(Failure::new(USAGE, format!("found .{found}, expected .{expected}")).at(&args.output));
    }
    Ok(())
}

/// What is extracted.
#[derive(Clone, Copy)]
enum Wanted {
    Density,
    Extinction,
    Base(u8),
}

fn wanted(args: &ExtractArgs) -> Result<Wanted, Failure> {
    match args.base.as_deref() {
        None | Some("density") => Ok(Wanted::Density),
        Some("extinction") => Ok(Wanted::Extinction),
        Some(text) => match text.parse() {
            Ok(base) => Ok(Wanted::Base(base)),
            Err(_) => {
                let message = format!("--base is {text:?}, expected 0 to 255, density or extinction");
                Err(Failure::new(USAGE, message))
            }
        },
    }
}
