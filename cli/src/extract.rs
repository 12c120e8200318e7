//! `flb extract`: one base or the density, as a slice sheet or as a volume.

use flb_inspector::extract::{Volume, slice_sheet_png, volume_exr, volume_npy};
use flb_packer::publish::publish;
use flb_runtime::Library;
use serde::Serialize;

use crate::args::{ExtractArgs, VolumeFormat};
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_output, choose_species};
use crate::print;

#[derive(Serialize)]
struct Extracted {
    output: String,
    species: String,
    /// "density" or the base's number.
    volume: String,
    format: &'static str,
    lattice: u32,
    bytes: usize,
}

/// Reads the volume, writes it.
pub fn run(args: &ExtractArgs) -> Result<u8, Failure> {
    check_output(&args.output, &[&args.file], args.force)?;
    check_extension(args)?;
    let library = Library::open_positioned(&args.file)?;
    let (container, source) = (library.container(), library.source());
    let index = choose_species(&library, args.species.as_deref(), None)?;
    let meta = &container.species()[index].meta;
    let bands: Vec<String> = meta.bands().map(str::to_owned).collect();

    let base = wanted_base(args)?;
    let (field, medium);
    let volume = match base {
        Some(base) => {
            let have = &container.species()[index].bases;
            if !have.iter().any(|entry| entry.base == base) {
                let list: Vec<String> = have.iter().map(|entry| entry.base.to_string()).collect();
                let left_out = meta.left_out.as_ref().filter(|left_out| left_out.bases.contains(base));
                let why =
                    left_out.map_or(String::new(), |left_out| format!(" (left out: {})", left_out.reason));
                let message =
                    format!("species {:?} has no base {base}{why}; it has {}", meta.name, list.join(", "));
                return Err(Failure::new(USAGE, message).at(&args.file));
            }
            field = container.read_field(source, index, base).map_err(|e| Failure::from(e).at(&args.file))?;
            Volume::Base { field: &field, bands: &bands }
        }
        None => {
            medium = container.read_medium(source, index).map_err(|e| Failure::from(e).at(&args.file))?;
            Volume::Density(&medium)
        }
    };
    let (format, bytes) = match args.format {
        VolumeFormat::Png => ("png", slice_sheet_png(&volume, SHEET_SLICES)?),
        VolumeFormat::Exr => ("exr", volume_exr(&volume)?),
        VolumeFormat::Npy => ("npy", volume_npy(&volume)?),
    };
    publish(&args.output, args.force, |file| file.write_all(&bytes))?;
    let extracted = Extracted {
        output: args.output.display().to_string(),
        species: meta.name.clone(),
        volume: base.map_or("density".to_owned(), |base| base.to_string()),
        format,
        lattice: meta.grid.lattice,
        bytes: bytes.len(),
    };
    match args.json {
        true => print::json(&extracted)?,
        false => print::out(&format!(
            "{}: {} of {}, {}\n",
            extracted.output,
            base.map_or("density".to_owned(), |base| format!("base {base}")),
            extracted.species,
            print::bytes(bytes.len() as u64)
        ))?,
    }
    Ok(0)
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

/// `None` is the density.
fn wanted_base(args: &ExtractArgs) -> Result<Option<u8>, Failure> {
    match args.base.as_deref() {
        None | Some("density") => Ok(None),
        Some(text) => match text.parse() {
            Ok(base @ 0..=18) => Ok(Some(base)),
            _ => Err(Failure::new(USAGE, format!("--base is {text:?}, expected 0 to 18, or density"))),
        },
    }
}
