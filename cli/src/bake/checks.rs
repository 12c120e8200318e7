//! What of a bake is refused before the long work.

use std::path::Path;

use flb_scene::plant::file_name;

use crate::args::{BackendArg, BakeArgs, FieldArg, ModelArg, SolverArg};
use crate::classes::MeshReader;
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_local, check_output};
use crate::print::say;

/// The names of the species; refuses two meshes that would make species of one name.
pub fn check_names(args: &BakeArgs, reader: &MeshReader) -> Result<Vec<String>, Failure> {
    let mut names: Vec<String> = Vec::new();
    for path in &args.meshes {
        let name = species_name(path, args, reader)?;
        if names.contains(&name) {
            let message = format!("a second species named {name:?}; a library's names are unique");
            return Err(Failure::new(USAGE, message).at(path));
        }
        names.push(name);
    }
    Ok(names)
}

/// Refuses a lattice that no format has.
pub fn check_lattice(lattice: u32) -> Result<(), Failure> {
    match lattice.is_power_of_two() && (16..=256).contains(&lattice) {
        true => Ok(()),
        false => {
            let message = format!("--lattice is {lattice}, expected a power of two, 16 to 256");
            Err(Failure::new(USAGE, message))
        }
    }
}

/// Refuses what cannot work before anything is read.
pub fn check_settings(args: &BakeArgs) -> Result<(), Failure> {
    let refuse = |message: String| Err(Failure::new(USAGE, message));
    args.lattice.map_or(Ok(()), check_lattice)?;
    if args.backend == BackendArg::Gpu && args.solver != SolverArg::Auto {
        let message = "--solver chooses among the solvers of the CPU, and --backend gpu has its own: leave one of them out";
        return refuse(message.to_owned());
    }
    if args.name.is_some() && args.meshes.len() > 1 {
        return refuse(format!("--name names one species, found {} meshes", args.meshes.len()));
    }
    let mut inputs: Vec<&Path> = args.meshes.iter().map(|path| path.as_path()).collect();
    inputs.extend(args.mesh.species.as_deref());
    inputs.extend(args.plan.as_deref());
    for output in [Some(&args.output), args.keep_fields.as_ref()].into_iter().flatten() {
        check_output(output, &inputs, args.force)?;
    }
    args.cache.as_deref().map_or(Ok(()), check_local)?;
    match &args.keep_fields {
        Some(fields) => Ok(flb_files::check_distinct(&args.output, fields)?),
        None => Ok(()),
    }
}

/// Refuses to judge what has no light of suns and sky in red, green and blue, before the long work.
pub fn check_judge(args: &BakeArgs, reader: &MeshReader) -> Result<(), Failure> {
    let refuse = |found: &str| {
        let expected = "--judge expects --model physical, --field scattered and the bands R, G and B";
        Err(Failure::new(USAGE, format!("found {found}, and {expected}")))
    };
    let bands = reader.plants.surfaces().bands.len();
    match () {
        () if !args.judge => Ok(()),
        () if args.model.model == ModelArg::Paper => refuse("--model paper"),
        () if args.model.field == Some(FieldArg::Total) => refuse("--field total"),
        () if bands != 3 => refuse(&format!("surfaces of {bands} bands")),
        () if args.plan.is_some() => refuse("--plan, which leaves out light"),
        () => Ok(()),
    }
}

/// Says where the species file describes leaves for the other model only.
pub fn say_other_model(args: &BakeArgs, reader: &MeshReader) {
    let Some((species, path)) = reader.plants.species.as_ref().zip(args.mesh.species.as_deref()) else {
        return;
    };
    let found = match args.model.model {
        ModelArg::Physical if species.surfaces.is_none() && species.optics.is_some() => {
            "its [[optics]] are for --model paper, and it has no [[surfaces]]: baking with those of common leaves and bark"
        }
        ModelArg::Paper if species.optics.is_none() && species.surfaces.is_some() => {
            "its surfaces are for --model physical, and it has no [[optics]]: baking with the papers'"
        }
        _ => return,
    };
    say!("warning: {}: {found}", path.display());
}

/// The flag's name, or the one that the reader gives. One name cannot serve several species: each is named after its
/// file.
fn species_name(path: &Path, args: &BakeArgs, reader: &MeshReader) -> Result<String, Failure> {
    let name = match args.meshes.len() {
        1 => args.name.clone().or_else(|| reader.plants.name(path)),
        _ => file_name(path),
    };
    name.filter(|name| !name.is_empty()).ok_or_else(|| Failure::new(USAGE, "the file has no name").at(path))
}
