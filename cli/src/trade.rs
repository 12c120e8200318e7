//! `flb trade`: bakes a plant under a grid of choices, measures what each costs and how far off it is, and says which
//! to choose.

mod page;
mod plot;
mod report;

use std::cell::Cell;
use std::path::PathBuf;

use flb_baker::voxelise::MAX_VOXELS;
use flb_eval::trade::{Heap, TradeSettings, available_bytes, trade};
use flb_scene::{Plant, Step};

use crate::HEAP;
use crate::args::TradeArgs;
use crate::classes::MeshReader;
use crate::exit::{Failure, LOSS, USAGE};
use crate::print::{self, say};
use crate::stages::Stages;
use report::Report;

/// Memory that may be used where the system does not say how much it has.
const MEMORY_UNKNOWN: u64 = 8_000_000_000;

/// The heap of this program.
struct Counted;

impl Heap for Counted {
    fn used_bytes(&self) -> u64 {
        HEAP.current_usage() as u64
    }

    fn peak_bytes(&self) -> u64 {
        HEAP.peak_usage() as u64
    }

    fn reset_peak(&self) {
        HEAP.reset_peak_usage();
    }
}

/// Checks, measures every choice, publishes the folder, prints the table.
pub(crate) fn run(args: &TradeArgs) -> Result<u8, Failure> {
    let lattices = lattices(args)?;
    let limit_bytes = memory_limit(args)?;
    let folder = out_folder(args)?;
    let inputs: Vec<_> = [Some(&args.mesh_file), args.mesh.species.as_ref()].into_iter().flatten().collect();
    report::check_folder(&folder, &inputs, args.existing)?;
    let mut reader = MeshReader::new(&args.mesh)?;
    let settings = TradeSettings {
        lattices,
        quick: args.quick,
        voxels: args.voxels,
        ignore_alpha: args.ignore_alpha || reader.plants.species.as_ref().is_some_and(|s| s.ignore_alpha),
        suns: args.suns as usize,
        points: args.points,
        limit_bytes,
    };
    let name = reader.plants.name(&args.mesh_file).unwrap_or_default();
    // What is odd about the mesh is said once; what it names is known only then.
    let stages = Stages::noting_on_terminals();
    let first = stages.run(Step::Import, "", |_| reader.read_classed(&args.mesh_file))?;
    report::check_unread(&folder)?;
    reader.measure(&args.mesh_file, &first);
    reader.quiet = true;
    let first = Cell::new(Some(first));
    let plants = || -> Result<Plant, Failure> {
        let classed = first.take().map_or_else(|| reader.read_classed(&args.mesh_file), Ok)?;
        Ok(reader.plants.plant(name.clone(), classed))
    };
    let mut measured =
        trade(&plants, &settings, &Counted, &stages).map_err(|failure| failure.at(&args.mesh_file))?;
    for skipped in measured.skipped.iter_mut().filter(|skipped| skipped.is_of_memory) {
        skipped.reason += " (--memory-limit)";
    }
    let report = Report::new(args, &folder, measured);
    report::publish_all(&report, page::page, &folder, args.existing)?;
    match args.json {
        true => print::json(&report)?,
        false => print::out(&report.text())?,
    }
    Ok(if report.trade.rows.iter().all(|row| row.converged) { 0 } else { LOSS })
}

/// The lattices asked for, checked.
fn lattices(args: &TradeArgs) -> Result<Vec<u32>, Failure> {
    let refuse = |message: String| Err(Failure::new(USAGE, message));
    let lattices = match (args.lattices.is_empty(), args.quick) {
        (false, _) => args.lattices.clone(),
        (true, true) => vec![32, 64],
        (true, false) => vec![32, 64, 128, 256],
    };
    for (at, lattice) in lattices.iter().enumerate() {
        if !lattice.is_power_of_two() || !(16..=256).contains(lattice) {
            return refuse(format!("--lattices names {lattice}, expected powers of two, 16 to 256"));
        }
        if lattices[..at].contains(lattice) {
            return refuse(format!("--lattices names {lattice} twice, expected each lattice once"));
        }
        if !(args.voxels.is_multiple_of(*lattice) && (1..=MAX_VOXELS).contains(&args.voxels)) {
            return refuse(format!(
                "--voxels is {}, expected a multiple of every lattice, {lattice} among them, up to {MAX_VOXELS}",
                args.voxels
            ));
        }
    }
    Ok(lattices)
}

/// In bytes.
fn memory_limit(args: &TradeArgs) -> Result<u64, Failure> {
    match args.memory_limit {
        Some(gigabytes) if gigabytes > 0.0 && gigabytes <= 1e6 => Ok((gigabytes * 1e9) as u64),
        Some(found) => Err(Failure::new(USAGE, format!("--memory-limit is {found}, expected more than 0 and at most 1e6"))),
        None => Ok(available_bytes().unwrap_or_else(|| {
            say!(
                "the system does not say how much memory is available: {} are used at most; --memory-limit sets another number",
                print::bytes(MEMORY_UNKNOWN)
            );
            MEMORY_UNKNOWN
        })),
    }
}

/// The folder asked for, or one beside the user named after the mesh file.
fn out_folder(args: &TradeArgs) -> Result<PathBuf, Failure> {
    if let Some(folder) = &args.out {
        return Ok(folder.clone());
    }
    let stem = args.mesh_file.file_stem().filter(|stem| !stem.is_empty());
    let stem = stem.ok_or_else(|| Failure::new(USAGE, "the file has no name").at(&args.mesh_file))?;
    Ok(PathBuf::from(format!("{}-trade", stem.to_string_lossy())))
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use flb_eval::trade::choices;

    use crate::args::{Cli, Command};
    use crate::bake::settings::bake_settings;

    #[test]
    fn every_choice_is_a_bake() {
        for quick in [false, true] {
            for choice in choices(&[32, 64, 128, 256], quick).0 {
                let flags = choice.solve.flags();
                let words = ["flb", "bake", "mesh", "-o", "out"].into_iter().chain(flags.split(' '));
                let Ok(Command::Bake(args)) = Cli::try_parse_from(words).map(|cli| cli.command) else {
                    panic!("{flags}: not flags of a bake");
                };
                let spelled = bake_settings(&args, None, "oak").expect("settings that are allowed");
                assert_eq!(spelled, choice.solve.settings(1024, false), "{flags}");
            }
        }
    }
}
