//! What follows from the model that `flb bake` is asked for: its settings, the flags that it refuses, and what is said.

use flb_baker::bake::{ModelSettings, PaperSettings, PhysicalSettings, SunChoice};
use flb_format::Quality;
use flb_format::light::FieldKind;
use flb_stage::backend::GpuCount;
use flb_transport::gpu::find_gpus;
use flb_transport::lattice::{SolverKind, Steps, find_gpu};
use flb_transport::ordinates::{Backend, MAX_RAYS, OrdinatesError};

use super::limits::{check_end, ordinates_of};
use crate::args::{BackendArg, BakeArgs, ModelArg, SolverArg};
use crate::classes::MeshReader;
use crate::exit::{Failure, UNSUPPORTED, USAGE};
use crate::print::say;

/// The model of `--model`, else of `--quality`.
fn model_of(args: &BakeArgs) -> ModelArg {
    args.model.model.unwrap_or(match ModelSettings::of(args.quality()) {
        ModelSettings::Physical(_) => ModelArg::Physical,
        ModelSettings::Paper(_) => ModelArg::Paper,
    })
}

/// Model and solve. Refuses flags of the other model.
pub(crate) fn settings(args: &BakeArgs) -> Result<ModelSettings, Failure> {
    Ok(match model_of(args) {
        ModelArg::Physical => ModelSettings::Physical(physical(args)?),
        ModelArg::Paper => ModelSettings::Paper(paper(args)?),
    })
}

fn paper(args: &BakeArgs) -> Result<PaperSettings, Failure> {
    if let Some(flag) = args.model.physical_flag() {
        let message = format!("{flag} is for --model physical; the paper model has no such choice");
        return Err(Failure::new(USAGE, message));
    }
    let preset = PaperSettings::of(args.quality());
    // A tolerance, a GPU or sweeps end a solve in another way than the papers'.
    let is_ended = args.tolerance.is_some() || on_gpu(args) || args.solver == SolverArg::Sweep;
    let steps = args.steps.map(Steps::Count).or(preset.steps.filter(|_| !is_ended));
    if args.steps == Some(0) {
        return Err(Failure::new(USAGE, "--steps is 0, expected 1 or more"));
    }
    if args.steps.is_some() && is_ended {
        let found = if on_gpu(args) { "--backend gpu" } else { "--solver sweep" };
        let message = format!(
            "--steps with {found}, which goes until the tolerance is met: expected --solver explicit or literal"
        );
        return Err(Failure::new(USAGE, message));
    }
    Ok(PaperSettings {
        steps,
        solver: match args.solver {
            SolverArg::Auto if on_gpu(args) => SolverKind::Gpu { most: gpu_count(args).most() },
            SolverArg::Auto if steps.is_some() => SolverKind::Explicit,
            SolverArg::Auto | SolverArg::Sweep => SolverKind::Sweep,
            SolverArg::Explicit => SolverKind::Explicit,
            SolverArg::Literal => SolverKind::Literal,
        },
        tolerance: args.tolerance.unwrap_or(preset.tolerance),
        max_sweeps: args.max_sweeps,
    })
}

fn physical(args: &BakeArgs) -> Result<PhysicalSettings, Failure> {
    let refuse = |message: String| Err(Failure::new(USAGE, message));
    let flags = &args.model;
    if args.solver != SolverArg::Auto {
        let message = "--solver is for --model paper; the physical model has one solver";
        return refuse(message.to_owned());
    }
    if args.steps.is_some() {
        return refuse(
            "--steps is for --model paper; the physical model goes until its tolerance is met".to_owned(),
        );
    }
    if args.quality == Some(Quality::Papers) {
        return refuse("--quality papers is of the papers' model, not of --model physical".to_owned());
    }
    let preset = PhysicalSettings::of(args.quality());
    let ordinates = match flags.ordinates {
        None => preset.ordinates,
        Some(count) => ordinates_of(count)?,
    };
    if let Some(rays) = flags.rays.filter(|rays| !(1..=MAX_RAYS).contains(rays)) {
        return refuse(format!("--rays is {rays}, expected 1 to {MAX_RAYS}"));
    }
    let tolerance = args.tolerance.unwrap_or(preset.tolerance);
    check_end(tolerance, args.max_sweeps)?;
    Ok(PhysicalSettings {
        suns: flags.suns.map_or(preset.suns, |suns| SunChoice::Fixed(suns.basis())),
        ordinates,
        rays: flags.rays,
        parts: flags.cut_sites.map_or(preset.parts, |cut| if cut { 2 } else { 1 }),
        field: flags.field.unwrap_or(preset.field),
        leaf_angles: flags.leaf_angles.unwrap_or(preset.leaf_angles),
        tolerance,
        max_passes: args.max_sweeps,
        monte_carlo_suns: flags.monte_carlo.into(),
        backend: if on_gpu(args) { Backend::Gpu { most: gpu_count(args).most() } } else { Backend::Cpu },
        keep_cloud: false,
    })
}

/// The flag that asks for light without a part that was scattered alone, if one does.
pub(crate) fn without_scattered_light(args: &BakeArgs) -> Option<&'static str> {
    match model_of(args) {
        ModelArg::Paper => Some("--model paper"),
        ModelArg::Physical => (args.model.field == Some(FieldKind::Total)).then_some("--field total"),
    }
}

/// Whether a GPU solves. Where that is left open, one that is hardware does: software is slower than the cores that it
/// runs on.
fn on_gpu(args: &BakeArgs) -> bool {
    match args.backend {
        BackendArg::Cpu => false,
        BackendArg::Gpu => true,
        #[cfg(feature = "gpu")]
        BackendArg::Auto => flb_gpu::find().is_ok_and(|found| !found.is_software),
        #[cfg(not(feature = "gpu"))]
        BackendArg::Auto => false,
    }
}

/// GPUs that share a solve.
fn gpu_count(args: &BakeArgs) -> GpuCount {
    args.gpus.unwrap_or(GpuCount::Exactly(1))
}

/// Says on stderr which GPUs solve, where they are asked for, and where none that is hardware was found.
pub(crate) fn say_device(args: &BakeArgs) -> Result<(), Failure> {
    if on_gpu(args) {
        let gpus = find_gpus(gpu_count(args).most()).map_err(OrdinatesError::Gpu)?;
        if let Some(count) = gpu_count(args).missed_by(gpus.len()) {
            let message = format!("--gpus {count}: found {} of one kind: {}", gpus.len(), gpus.join(", "));
            return Err(Failure::new(UNSUPPORTED, message));
        }
        say!("solving on {}", gpus.join(", "));
    } else if args.backend == BackendArg::Auto {
        match find_gpu() {
            Ok(software) => say!("solving on the CPU: {software} is software"),
            Err(error) => say!("solving on the CPU: {error}"),
        }
    }
    Ok(())
}

/// Whether the light depends on the colours of the plant's textures.
pub(crate) fn follows_colors(args: &BakeArgs) -> bool {
    match model_of(args) {
        ModelArg::Physical => true,
        ModelArg::Paper => false,
    }
}

/// Says where the species file describes leaves for the other model only.
pub(crate) fn say_other_model(args: &BakeArgs, reader: &MeshReader) {
    let Some((species, path)) = reader.plants.species.as_ref().zip(args.mesh.species.as_deref()) else {
        return;
    };
    let found = match model_of(args) {
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
