//! `flb trade`: bakes a plant under a grid of choices, measures what each costs and how far off it is, and says which
//! to choose.
//!
//! ```text
//! mesh -survey-> sites per lattice -choices, memory-> what to try
//!     -measure-> rows -front, recommend-> tables, plots, page
//! ```
//!
//! Every solve is baked once, by what `flb bake` itself does, the finest first; of each only its rows are kept.

mod choice;
mod front;
mod measure;
mod memory;
mod on_mesh;
mod page;
mod plot;
mod recommend;
mod report;
mod row;
mod sample;
mod surface;
mod truth;

use std::path::PathBuf;

use flb_baker::voxelise::{MAX_VOXELS, VoxelSettings};
use flb_baker::{downsample, voxelise};

use flb_transport::monte_carlo::judge;

use crate::args::TradeArgs;
use crate::classes::MeshReader;
use crate::exit::{Failure, LIMIT, LOSS, USAGE};
use crate::print::{self, say};
use crate::stages::Stages;
use crate::summary::sites_nonempty;
use choice::{Choice, FINEST_STORE, Skipped, Solve, Store, Transport};
use flb_scene::ClassedMesh;
use measure::{Bench, OfAll, OfLattice};
use report::{Measured, Report, Traced};
use row::Row;

/// Memory that may be used where the system does not say how much it has.
const MEMORY_UNKNOWN: u64 = 8_000_000_000;

/// Checks, measures every choice, publishes the folder, prints the table.
pub(crate) fn run(args: &TradeArgs) -> Result<u8, Failure> {
    let lattices = lattices(args)?;
    let limit_bytes = memory_limit(args)?;
    let folder = out_folder(args)?;
    let inputs: Vec<_> = [Some(&args.mesh_file), args.mesh.species.as_ref()].into_iter().flatten().collect();
    report::check_folder(&folder, &inputs, args.force)?;
    let mut reader = MeshReader::new(&args.mesh)?;
    let stages = Stages::default();
    let classed = stages.run("import", "", |_| reader.read_classed(&args.mesh_file))?;
    reader.measure(&args.mesh_file, &classed);
    reader.quiet = true;
    let ignore_alpha = args.ignore_alpha || reader.plants.species.as_ref().is_some_and(|s| s.ignore_alpha);
    let points = surface::points(&classed, args.points, ignore_alpha)
        .map_err(|failure| failure.at(&args.mesh_file))?;
    let suns = judge::suns(args.suns as usize);
    let sites = survey(&classed, args, &lattices, ignore_alpha, &stages)
        .map_err(|failure| failure.at(&args.mesh_file))?;
    drop(classed);
    let predict = Predict::new(&reader, sites);
    let (choices, skipped) = affordable(args, &lattices, &predict, limit_bytes)?;

    let bench = Bench { args, reader: &reader, points: &points, suns: &suns };
    let mut of_all = OfAll::default();
    let mut rows = Vec::new();
    let mut traced: Vec<Traced> = Vec::new();
    let mut of_lattice = OfLattice::default();
    for (at, choice) in choices.iter().enumerate() {
        let talk = format!("{} of {}:", at + 1, choices.len());
        let measured = bench.measure(choice, &mut of_lattice, &mut of_all, &talk)?;
        let lattice = choice.solve.lattice;
        let sites = predict.sites(lattice);
        rows.extend(measured.into_iter().map(|(store, row)| {
            let predicted_bytes = predict.bytes(&choice.solve, &store);
            Row { sites, predicted_bytes, ..row }
        }));
        if choices.get(at + 1).is_none_or(|next| next.solve.lattice != lattice) {
            traced.push(Traced::new(lattice, sites, of_lattice.photons()));
            of_lattice = OfLattice::default();
        }
    }
    let mean_fluence = of_all.finest.map(|finest| finest.mean_fluence()).unwrap_or_default();
    let measured = Measured { mean_fluence, limit_bytes, suns, points: points.len(), rows, skipped, traced };
    let report = Report::new(args, &folder, measured);
    report::publish_all(&report, page::page, &folder, args.force)?;
    match args.json {
        true => print::json(&report)?,
        false => print::out(&report.text())?,
    }
    Ok(if report.rows.iter().all(|row| row.converged) { 0 } else { LOSS })
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
        None => Ok(memory::available().unwrap_or_else(|| {
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

/// Lattice and its non-empty sites.
type Sites = Vec<(u32, u64)>;

/// What memory is predicted from.
struct Predict {
    sites: Sites,
    names: Names,
}

impl Predict {
    fn new(reader: &MeshReader, sites: Sites) -> Predict {
        Predict { sites, names: Names::of(reader) }
    }

    fn sites(&self, lattice: u32) -> u64 {
        self.sites.iter().find(|(of, _)| *of == lattice).map_or(0, |(_, sites)| *sites)
    }

    fn of_solve(&self, solve: &Solve) -> u64 {
        memory::of_solve(solve, self.sites(solve.lattice), self.bands())
    }

    fn bytes(&self, solve: &Solve, store: &Store) -> u64 {
        self.of_solve(solve).max(memory::of_store(solve, store, self.bands()))
    }

    fn bands(&self) -> u64 {
        self.names.physical.len().max(self.names.paper.len()) as u64
    }
}

/// Counts the non-empty sites of every lattice, which memory is predicted from.
fn survey(
    classed: &ClassedMesh,
    args: &TradeArgs,
    lattices: &[u32],
    ignore_alpha: bool,
    stages: &Stages,
) -> Result<Sites, Failure> {
    let count = |&lattice: &u32| {
        let settings = VoxelSettings { voxels: args.voxels, lattice, ignore_alpha };
        let medium = stages.run("survey", &lattice.to_string(), |progress| -> Result<_, Failure> {
            Ok(downsample(&voxelise(&classed.mesh, &classed.classes, &settings, progress)?)?)
        })?;
        Ok((lattice, sites_nonempty(&medium) as u64))
    };
    lattices.iter().map(count).collect()
}

/// The choices that fit into the memory, and those that were skipped.
fn affordable(
    args: &TradeArgs,
    lattices: &[u32],
    predict: &Predict,
    limit_bytes: u64,
) -> Result<(Vec<Choice>, Vec<Skipped>), Failure> {
    let need = |lattice: u32| predict.bytes(&choice::finest(lattice), &FINEST_STORE);
    let Some(&finest) = lattices.iter().filter(|lattice| need(**lattice) <= limit_bytes).max() else {
        let smallest = lattices.iter().min().copied().unwrap_or_default();
        let message = format!(
            "{} would need {} of memory, at most {} may be used: --memory-limit, or a coarser lattice of --lattices",
            choice::finest(smallest),
            print::bytes(need(smallest)),
            print::bytes(limit_bytes)
        );
        return Err(Failure::new(LIMIT, message));
    };
    let (all, mut skipped) = choice::choices(lattices, args.quick);
    let too_much = |bytes: u64| {
        let (need, limit) = (print::bytes(bytes), print::bytes(limit_bytes));
        format!("it would need about {need} of memory, at most {limit} may be used (--memory-limit)")
    };
    let mut kept = Vec::new();
    for mut choice in all {
        let solve = choice.solve;
        if predict.of_solve(&solve) > limit_bytes {
            skipped.push(Skipped::new(&solve, None, too_much(predict.of_solve(&solve))));
            continue;
        }
        if solve.lattice > finest {
            // There is nothing as fine that it could be compared with.
            let reason = format!("the finest solve that fits into memory is of lattice {finest}");
            skipped.push(Skipped::new(&solve, None, reason));
            continue;
        }
        let is_too_much = |store: &mut Store| predict.bytes(&solve, store) > limit_bytes;
        skipped.extend(
            choice
                .stores
                .extract_if(.., is_too_much)
                .map(|store| Skipped::new(&solve, Some(&store), too_much(predict.bytes(&solve, &store)))),
        );
        if !choice.stores.is_empty() {
            kept.push(choice);
        }
    }
    let names = &predict.names;
    if names.physical != names.paper {
        let is_paper = |choice: &mut Choice| matches!(choice.solve.transport, Transport::Paper { .. });
        let (paper, physical) = (names.paper.join(" "), names.physical.join(" "));
        let reason =
            format!("its bands are {paper}, those of the physical model {physical}: they cannot be compared");
        skipped.extend(
            kept.extract_if(.., is_paper).map(|choice| Skipped::new(&choice.solve, None, reason.clone())),
        );
    }
    Ok((kept, skipped))
}

/// Names of the bands of both models.
struct Names {
    paper: Vec<String>,
    physical: Vec<String>,
}

impl Names {
    fn of(reader: &MeshReader) -> Names {
        let (optics, surfaces) = (reader.plants.optics(), reader.plants.surfaces());
        Names {
            paper: optics.bands.into_iter().map(|band| band.name).collect(),
            physical: surfaces.bands.into_iter().map(|band| band.name).collect(),
        }
    }
}
