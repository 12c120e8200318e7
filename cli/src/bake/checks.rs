//! What of a bake is refused before the long work.

use std::path::{Path, PathBuf};

use flb_farm::recipe::check_lattice;
use flb_format::colors::color_bands;
use flb_scene::plant::file_name;

use super::model::recipe;
use crate::args::{BackendArg, BakeArgs, SolverArg};
use crate::classes::MeshReader;
use crate::exit::{Failure, USAGE};
use crate::inputs::check_output;

/// The names of the species; refuses two meshes that would make species of one name.
pub(crate) fn check_names(args: &BakeArgs, reader: &MeshReader) -> Result<Vec<String>, Failure> {
    let mut names: Vec<String> = Vec::new();
    for (index, path) in args.meshes.iter().enumerate() {
        let name = species_name(index, args, reader)?;
        if names.contains(&name) {
            let flags: Vec<String> =
                suggested(&args.meshes).iter().map(|name| format!("--name {name}")).collect();
            let message = format!(
                "a second species named {name:?}; a library's names are unique: give one for each mesh, in their \
                 order, such as {}",
                flags.join(" ")
            );
            return Err(Failure::new(USAGE, message).at(path));
        }
        names.push(name);
    }
    Ok(names)
}

/// Refuses what cannot work before anything is read.
pub(crate) fn check_settings(args: &BakeArgs) -> Result<(), Failure> {
    let refuse = |message: String| Err(Failure::new(USAGE, message));
    args.lattice.map_or(Ok(()), check_lattice)?;
    if args.backend != BackendArg::Cpu && args.solver != SolverArg::Auto {
        let message = "--solver chooses among the solvers of the CPU, and --backend gpu (or auto) has its own: leave one of them out";
        return refuse(message.to_owned());
    }
    if args.gpus.is_some() && args.backend == BackendArg::Cpu {
        return refuse("--gpus is for --backend gpu or auto; this bake is on the CPU".to_owned());
    }
    let (names, meshes) = (args.name.len(), args.meshes.len());
    if names != 0 && names != meshes {
        return refuse(format!(
            "found --name {names} times for {meshes} meshes, expected it once for each, in their order, or not at all"
        ));
    }
    let mut inputs: Vec<&Path> = args.meshes.iter().map(|path| path.as_path()).collect();
    inputs.extend(args.mesh.species.as_deref());
    inputs.extend(args.plan.as_deref());
    for output in [Some(&args.output), args.keep_fields.as_ref()].into_iter().flatten() {
        check_output(output, &inputs, args.existing)?;
    }
    match &args.keep_fields {
        Some(fields) => Ok(flb_files::check_distinct(&args.output, fields)?),
        None => Ok(()),
    }
}

/// Refuses to judge what has no light of suns and sky in red, green and blue, before the long work.
pub(crate) fn check_judge(args: &BakeArgs, reader: &MeshReader) -> Result<(), Failure> {
    let refuse = |found: &str| {
        let expected = "--judge expects --model physical, --field scattered and the bands R, G and B";
        Err(Failure::new(USAGE, format!("found {found}, and {expected}")))
    };
    if !args.judge {
        return Ok(());
    }
    if let Some(setting) = recipe(args).without_scattered_light() {
        return refuse(&format!("--{setting}"));
    }
    let surfaces = reader.plants.surfaces();
    let bands: Vec<&str> = surfaces.bands.iter().map(|band| band.name.as_str()).collect();
    if color_bands(bands.iter().copied()).is_none() {
        return refuse(&format!("the bands {}", bands.join(", ")));
    }
    if args.plan.is_some() {
        return refuse("--plan, which leaves out light");
    }
    Ok(())
}

/// Names that meshes of one file name may have: their folders', else numbered ones. Words that need no quotes.
fn suggested(meshes: &[PathBuf]) -> Vec<String> {
    const MAX_NAMES: usize = 8;
    let is_plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    let of_folder = |path: &PathBuf| {
        let folder = path.parent()?.file_name()?.to_str()?;
        folder.chars().all(is_plain).then(|| folder.to_owned())
    };
    let folders: Option<Vec<String>> = meshes.iter().map(of_folder).collect();
    let folders = folders.filter(|all| (1..all.len()).all(|at| !all[..at].contains(&all[at])));
    let numbered = || (1..=meshes.len()).map(|number| format!("plant{number}")).collect();
    let mut names: Vec<String> = folders.unwrap_or_else(numbered);
    if names.len() > MAX_NAMES {
        names.truncate(MAX_NAMES);
        names.push("...".to_owned());
    }
    names
}

/// The flag's name, or the one that the reader gives. One name cannot serve several species: each is named after its
/// file.
fn species_name(index: usize, args: &BakeArgs, reader: &MeshReader) -> Result<String, Failure> {
    let path = &args.meshes[index];
    let name = args.name.get(index).cloned().or_else(|| match args.meshes.len() {
        1 => reader.plants.name(path),
        _ => file_name(path),
    });
    name.filter(|name| !name.is_empty()).ok_or_else(|| Failure::new(USAGE, "the file has no name").at(path))
}
