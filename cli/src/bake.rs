//! `flb bake`: from mesh files to one published library.

use std::path::Path;

use flb_baker::artefact;
use flb_baker::lattice::{DEFAULT_TOLERANCE, find_gpu};
use flb_baker::leaf::knapp_carter;
use flb_baker::plan::{Plan, PlanError};
use flb_baker::voxelise::{MAX_VOXELS, plant_bounds};
use flb_baker::{SolveSettings, SolverKind, VoxelSettings, downsample, voxelise};
use flb_format::container::metadata;
use flb_format::meta::{Bounds, SourceFile};
use flb_format::{BaseSet, Codec, Grid, Medium, Model, Optics, Place, SpeciesMeta};
use flb_packer::leave_out::record;
use flb_packer::{EncodeSettings, SpeciesFields, encode_species, write_library};
use serde::Serialize;
use serde_json::json;

use crate::args::{BackendArg, BakeArgs, SolverArg};
use crate::cache::Cache;
use crate::classes::{ClassedMesh, MeshReader};
use crate::exit::{Failure, LOSS, USAGE};
use crate::inputs::{check_distinct, check_output};
use crate::physical::{self, Physical};
use crate::plan::check_known;
use crate::print;
use crate::saving::{Saving, saving_lines};
use crate::solving::{fields, solver_name};
use crate::stages::{Stage, Stages};
use crate::summary::{SpeciesSummary, sites_nonempty, species_table, stage_table};

/// The summary of a bake; `--json` prints it (cli/schema/bake.json).
#[derive(Serialize)]
struct Summary {
    output: String,
    bytes: u64,
    /// Whether every solve reached its tolerance.
    converged: bool,
    stages: Vec<Stage>,
    species: Vec<SpeciesSummary>,
}

/// Checks, bakes every mesh, writes the library (and the fields, if they are kept), prints the summary.
pub fn run(args: &BakeArgs) -> Result<u8, Failure> {
    check_settings(args)?;
    let physical = Physical::of(args)?;
    let mut reader = MeshReader::new(&args.mesh)?;
    let names = check_names(args, &reader)?;
    let plan = args.plan.as_deref().map(Plan::read).transpose()?;
    check_plan(args, plan.as_ref(), &names)?;
    if args.meshes.len() > 1 {
        reader.rehearse(&args.meshes)?;
    }
    let gpu = match args.backend {
        BackendArg::Cpu => None,
        BackendArg::Gpu => Some(find_gpu()?),
    };
    if let Some(name) = &gpu {
        eprintln!("flb: solving on {name}");
    }
    let cache = Cache::open(args.cache.as_deref())?;
    let mut stages = Stages::default();
    let mut coded = Vec::new();
    let mut kept = Vec::new();
    let mut summaries = Vec::new();
    let mut converged = true;
    for path in &args.meshes {
        let baked = match &physical {
            Some(physical) => bake_physical(path, args, &reader, physical, &cache, &mut stages)?,
            None => bake_species(path, args, &reader, gpu.as_deref(), plan.as_ref(), &cache, &mut stages)?,
        };
        converged &= baked.converged;
        let settings = EncodeSettings {
            codec: Codec::HaarPaper,
            threshold: args.coding.threshold(),
            compress: args.coding.compress,
            ..EncodeSettings::default()
        };
        let name = baked.fields.meta.name.clone();
        let species =
            stages.run("encode", &name, |progress| encode_species(&baked.fields, &settings, progress))?;
        let saving = plan.is_some().then(|| Saving::of_bake(&species, baked.bands));
        summaries.push(SpeciesSummary::new(&species, sites_nonempty(&baked.fields.medium), saving));
        coded.push(species);
        if args.keep_fields.is_some() {
            let raw = EncodeSettings { codec: Codec::RawF32, threshold: 0.0, ..settings };
            kept.push(stages.run("encode", &name, |progress| encode_species(&baked.fields, &raw, progress))?);
        }
    }
    let bytes = stages.run("write", &args.output.display().to_string(), |_| -> Result<u64, Failure> {
        if let Some(fields) = &args.keep_fields {
            write_library(fields, &kept.iter().collect::<Vec<_>>(), args.force)?;
        }
        Ok(write_library(&args.output, &coded.iter().collect::<Vec<_>>(), args.force)?)
    })?;
    let summary = Summary {
        output: args.output.display().to_string(),
        bytes,
        converged,
        stages: stages.list().to_vec(),
        species: summaries,
    };
    match args.json {
        true => print::json(&summary)?,
        false => print::out(&format!(
            "{}\n{}{}\n{}: {}\n",
            stage_table(&summary.stages),
            species_table(&summary.species),
            saving_lines(&summary.species),
            summary.output,
            print::bytes(summary.bytes)
        ))?,
    }
    Ok(if converged { 0 } else { LOSS })
}

/// A species before coding.
struct Baked {
    fields: SpeciesFields,
    converged: bool,
    /// Bands that it could have.
    bands: usize,
}

/// Import to solve for one mesh.
fn bake_species(
    path: &Path,
    args: &BakeArgs,
    reader: &MeshReader,
    gpu: Option<&str>,
    plan: Option<&Plan>,
    cache: &Cache,
    stages: &mut Stages,
) -> Result<Baked, Failure> {
    let name = species_name(path, args, reader)?;
    let share = plan.map(|plan| plan.share(&name)).transpose()?;
    let classed = stages.run("import", &name, |_| reader.read_classed(path))?;
    let all = reader.species.as_ref().and_then(|s| s.optics.clone()).unwrap_or_else(Optics::paper);
    let (optics, bands_left_out) =
        planned_bands(&all, plan, &name).map_err(|error| Failure::from(error).at(path))?;
    let lattice = args.lattice.or(share.and_then(|share| share.lattice)).unwrap_or(DEFAULT_LATTICE);
    let voxel_settings = voxel_settings(args, reader, lattice);
    let solve_settings = SolveSettings {
        solver: match args.solver {
            SolverArg::Auto if gpu.is_some() => SolverKind::Gpu,
            SolverArg::Auto | SolverArg::Sweep => SolverKind::Sweep,
            SolverArg::Explicit => SolverKind::Explicit,
            SolverArg::Literal => SolverKind::Literal,
        },
        tolerance: args.tolerance.unwrap_or(DEFAULT_TOLERANCE),
        max_sweeps: args.max_sweeps,
        bases: share.map_or(BaseSet::ALL, |share| share.bases),
    };
    let model = Model::Paper { optics: optics.clone() };
    let mut meta = describe(name, &classed, reader, &voxel_settings, model);
    meta.settings.insert("solve.solver".to_owned(), json!(solver_name(solve_settings.solver)));
    meta.settings.insert("solve.tolerance".to_owned(), json!(solve_settings.tolerance));
    meta.settings.insert("solve.max_sweeps".to_owned(), json!(solve_settings.max_sweeps));
    if let Some(plan) = plan {
        record(&mut meta, solve_settings.bases.missing(), &bands_left_out, &plan.reason);
    }
    check_storable(&meta).map_err(|failure| failure.at(path))?;
    let medium = medium(&classed, &voxel_settings, &shape(&meta), cache, stages)
        .map_err(|failure| failure.at(path))?;
    drop(classed);
    meta.grid = medium.grid;

    let digest = blake3::hash(&artefact::to_bytes(&medium)?);
    let settings = json!([
        optics,
        meta.settings["solve.solver"],
        solve_settings.tolerance,
        args.max_sweeps,
        gpu,
        solve_settings.bases
    ])
    .to_string();
    let (bases, converged) =
        fields(&meta.name, &medium, &optics, &solve_settings, (digest.as_bytes(), &settings), cache, stages)
            .map_err(|failure| failure.at(path))?;
    meta.settings.insert("solve.converged".to_owned(), json!(converged));
    Ok(Baked {
        fields: SpeciesFields { meta, medium, turbid: None, bases },
        converged,
        bands: all.bands.len(),
    })
}

/// Import to solve for one mesh, with the `physical` model.
fn bake_physical(
    path: &Path,
    args: &BakeArgs,
    reader: &MeshReader,
    physical: &Physical,
    cache: &Cache,
    stages: &mut Stages,
) -> Result<Baked, Failure> {
    let name = species_name(path, args, reader)?;
    let classed = stages.run("import", &name, |_| reader.read_classed(path))?;
    let surfaces = reader.species.as_ref().and_then(|s| s.surfaces.clone()).unwrap_or_else(knapp_carter);
    let voxel_settings = voxel_settings(args, reader, args.lattice.unwrap_or(DEFAULT_LATTICE));
    let model = Model::Physical { surfaces: surfaces.clone(), light: physical.light() };
    let mut meta = describe(name, &classed, reader, &voxel_settings, model);
    meta.settings.insert("solve.tolerance".to_owned(), json!(physical.solve.tolerance));
    meta.settings.insert("solve.max_sweeps".to_owned(), json!(physical.solve.max_passes));
    meta.settings.insert("solve.parts".to_owned(), json!(physical.solve.parts));
    check_storable(&meta).map_err(|failure| failure.at(path))?;
    let medium = medium(&classed, &voxel_settings, &shape(&meta), cache, stages)
        .map_err(|failure| failure.at(path))?;
    meta.grid = medium.grid;
    let ignore_alpha = voxel_settings.ignore_alpha;
    let made = physical::solve(&meta.name, &classed, &medium, &surfaces, physical, ignore_alpha, stages)
        .map_err(|failure| failure.at(path))?;
    let bands = surfaces.bands.len();
    meta.model = Model::Physical { surfaces, light: made.light };
    meta.settings.insert("crown.factor".to_owned(), json!(made.crown_factor));
    meta.settings.insert("crown.gap".to_owned(), json!(made.crown_gap));
    meta.settings.insert("solve.converged".to_owned(), json!(made.converged));
    let fields = SpeciesFields { meta, medium, turbid: Some(made.turbid), bases: made.bases };
    Ok(Baked { fields, converged: made.converged, bands })
}

/// What a plant's voxels depend on, besides the settings of the voxeliser.
fn shape(meta: &SpeciesMeta) -> [Vec<u8>; 2] {
    let shape = json!([meta.sources, meta.settings["import.up"], meta.settings["import.unit_m"]]).to_string();
    [shape.into_bytes(), meta.settings["classify.materials"].to_string().into_bytes()]
}

/// Voxelise and downsample, or what an earlier bake kept of them.
fn medium(
    classed: &ClassedMesh,
    settings: &VoxelSettings,
    shape: &[Vec<u8>; 2],
    cache: &Cache,
    stages: &mut Stages,
) -> Result<Medium, Failure> {
    let key = artefact::key("occupancy", &[&shape[0], &shape[1]], &format!("{settings:?}"));
    let occupancy = stages.run("voxelise", "", |progress| {
        let make = || Ok(voxelise(&classed.mesh, &classed.classes, settings, progress)?);
        cache.reuse_or_make(
            "occupancy",
            &key,
            make,
            |o| Ok(artefact::to_bytes(o)?),
            |b| Ok(artefact::from_bytes(b)?),
        )
    })?;
    let key = artefact::key("medium", &[key.as_bytes()], "");
    stages.run("downsample", "", |_| {
        let make = || Ok(downsample(&occupancy)?);
        cache.reuse_or_make(
            "medium",
            &key,
            make,
            |m| Ok(artefact::to_bytes(m)?),
            |b| Ok(artefact::from_bytes(b)?),
        )
    })
}

/// What the file says about the species; the grid is the downsampled medium's, set later.
fn describe(
    name: String,
    classed: &ClassedMesh,
    reader: &MeshReader,
    voxels: &VoxelSettings,
    model: Model,
) -> SpeciesMeta {
    let bounds = plant_bounds(&classed.mesh, &classed.classes).or_else(|| classed.mesh.bounds());
    let mut sources = classed.mesh.sources.clone();
    if let Some(species) = &reader.species {
        sources.push(SourceFile { name: species.file.clone(), blake3: species.blake3.clone() });
    }
    let mut settings: std::collections::BTreeMap<_, _> = reader.record(classed).into_iter().collect();
    settings.insert("voxelise.voxels".to_owned(), json!(voxels.voxels));
    settings.insert("voxelise.ignore_alpha".to_owned(), json!(voxels.ignore_alpha));
    SpeciesMeta {
        name,
        model,
        grid: Grid { lattice: voxels.lattice, origin_m: [0.0; 3], spacing_m: 1.0 },
        bounds_m: bounds.unwrap_or(Bounds { min: [0.0; 3], max: [0.0; 3] }),
        triangles: classed.triangle_counts(),
        sources,
        settings,
        tool: concat!("flb ", env!("CARGO_PKG_VERSION")).to_owned(),
        left_out: None,
        extra: Default::default(),
    }
}

fn voxel_settings(args: &BakeArgs, reader: &MeshReader, lattice: u32) -> VoxelSettings {
    let by_file = reader.species.as_ref().is_some_and(|species| species.ignore_alpha);
    VoxelSettings { voxels: args.voxels, lattice, ignore_alpha: args.ignore_alpha || by_file }
}

/// The flag's name, the species file's, or the mesh file's without its extension.
fn species_name(path: &Path, args: &BakeArgs, reader: &MeshReader) -> Result<String, Failure> {
    let stem = || path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let of_file = || reader.species.as_ref().and_then(|species| species.name.clone());
    // One name cannot serve several species.
    let name = if args.meshes.len() == 1 { args.name.clone().or_else(of_file).or_else(stem) } else { stem() };
    name.filter(|name| !name.is_empty()).ok_or_else(|| Failure::new(USAGE, "the file has no name").at(path))
}

/// The names of the species; refuses two meshes that would make species of one name.
fn check_names(args: &BakeArgs, reader: &MeshReader) -> Result<Vec<String>, Failure> {
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

/// Refuses, before anything is read, a plan that is not for these species, and lattices that cannot be.
fn check_plan(args: &BakeArgs, plan: Option<&Plan>, names: &[String]) -> Result<(), Failure> {
    let planned = plan.zip(args.plan.as_deref());
    if let Some((plan, path)) = planned {
        check_known(plan, names).map_err(|failure| failure.at(path))?;
    }
    for name in names {
        let lattice = match planned {
            Some((plan, path)) => match (plan.share(name)?.lattice, args.lattice) {
                (Some(planned), Some(asked)) => {
                    let message = format!(
                        "the plan bakes species {name:?} at lattice {planned}; --lattice {asked} cannot be given with it"
                    );
                    return Err(Failure::new(USAGE, message).at(path));
                }
                (planned, asked) => asked.or(planned),
            },
            None => args.lattice,
        };
        let lattice = lattice.unwrap_or(DEFAULT_LATTICE);
        if !(args.voxels.is_multiple_of(lattice) && (1..=MAX_VOXELS).contains(&args.voxels)) {
            let message = format!(
                "--voxels is {}, expected a multiple of the lattice, {lattice}, up to {MAX_VOXELS}",
                args.voxels
            );
            return Err(Failure::new(USAGE, message));
        }
    }
    Ok(())
}

/// The bands that a plan asks for, in the optics' order, and the names of the others.
fn planned_bands(
    all: &Optics,
    plan: Option<&Plan>,
    species: &str,
) -> Result<(Optics, Vec<String>), PlanError> {
    let Some(wanted) = plan.and_then(|plan| plan.bands.as_ref()) else {
        return Ok((all.clone(), Vec::new()));
    };
    let known = || all.bands.iter().map(|band| band.name.clone());
    if let Some(unknown) = wanted.iter().find(|name| known().all(|band| band != **name)) {
        let (name, species, known) = (unknown.clone(), species.to_owned(), known().collect());
        return Err(PlanError::UnknownBand { name, species, known });
    }
    let bands = all.bands.iter().filter(|band| wanted.contains(&band.name)).cloned().collect();
    Ok((Optics { bands }, known().filter(|name| !wanted.contains(name)).collect()))
}

/// Sites along each edge where nobody says otherwise.
const DEFAULT_LATTICE: u32 = 128;

/// Smallest and largest plants, metres along the longest axis.
const EXTENT_M: [f64; 2] = [1e-5, 1e5];

/// Refuses, before the long work, metadata that no file can hold: a name, a digest, a size.
fn check_storable(meta: &SpeciesMeta) -> Result<(), Failure> {
    let Bounds { min, max } = meta.bounds_m;
    let extent_m = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
    if !(EXTENT_M[0]..=EXTENT_M[1]).contains(&extent_m) {
        let [low, high] = EXTENT_M;
        let message = format!(
            "the plant is {extent_m} m long, expected {low} to {high} m; --unit sets metres per unit"
        );
        return Err(Failure::new(USAGE, message));
    }
    let place = Place::file(0);
    metadata::to_bytes(meta, place)
        .map(drop)
        .map_err(|error| Failure::new(USAGE, format!("the species cannot be stored: {error}")))
}

/// Refuses what cannot work before anything is read.
fn check_settings(args: &BakeArgs) -> Result<(), Failure> {
    let refuse = |message: String| Err(Failure::new(USAGE, message));
    if let Some(lattice) = args.lattice.filter(|l| !l.is_power_of_two() || !(16..=256).contains(l)) {
        return refuse(format!("--lattice is {lattice}, expected a power of two, 16 to 256"));
    }
    if args.backend == BackendArg::Gpu && args.solver != SolverArg::Auto {
        let message = "--solver chooses among the solvers of the CPU, and --backend gpu has its own: leave one of them out";
        return refuse(message.to_owned());
    }
    let threshold = args.coding.threshold();
    if !(threshold.is_finite() && threshold >= 0.0) {
        return refuse(format!("--threshold is {threshold}, expected a number from 0 up"));
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
    match &args.keep_fields {
        Some(fields) => check_distinct(&args.output, fields),
        None => Ok(()),
    }
}
