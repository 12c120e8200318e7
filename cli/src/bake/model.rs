//! What follows from the model that `flb bake` is asked for: its settings, the flags that it refuses, and what is said.

use flb_farm::Recipe;
use flb_farm::recipe::{Machine, ModelName, SolverName};
use flb_stage::backend::GpuCount;
use flb_transport::gpu::find_gpus;
use flb_transport::lattice::find_gpu;
use flb_transport::ordinates::OrdinatesError;

use crate::args::{BackendArg, BakeArgs, ModelArg, ModelArgs, SolverArg};
use crate::classes::MeshReader;
use crate::exit::{Failure, UNSUPPORTED};
use crate::print::say;

/// The flags as settings of a bake.
pub(crate) fn recipe(args: &BakeArgs) -> Recipe {
    let ModelArgs { model, suns, ordinates, rays, cut_sites, field, leaf_angles, monte_carlo } = args.model;
    Recipe {
        model: model.map(|model| match model {
            ModelArg::Physical => ModelName::Physical,
            ModelArg::Paper => ModelName::Paper,
        }),
        lattice: args.lattice,
        voxels: args.voxels,
        ignore_alpha: args.ignore_alpha.then_some(true),
        tolerance: args.tolerance,
        steps: args.steps,
        max_sweeps: Some(args.max_sweeps),
        solver: match args.solver {
            SolverArg::Auto => None,
            SolverArg::Sweep => Some(SolverName::Sweep),
            SolverArg::Explicit => Some(SolverName::Explicit),
            SolverArg::Literal => Some(SolverName::Literal),
        },
        suns,
        ordinates,
        rays,
        cut_sites,
        field,
        leaf_angles,
        monte_carlo: Some(monte_carlo),
        purpose: args.purpose,
        ..args.coding.recipe(args.quality)
    }
}

/// Where a bake is solved.
pub(crate) fn machine(args: &BakeArgs) -> Machine {
    match on_gpu(args) {
        true => Machine::Gpu { most: gpu_count(args).most() },
        false => Machine::Cpu,
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

/// Says where the papers' preset is solved to a tolerance, in place of their steps.
pub(crate) fn say_other_end(args: &BakeArgs) {
    if let Some(found) = recipe(args).in_place_of_steps(machine(args)) {
        say!("warning: --{found} solves to a tolerance, in place of the 2N steps of --quality papers");
    }
}

/// Says where the species file describes leaves for the other model only.
pub(crate) fn say_other_model(args: &BakeArgs, reader: &MeshReader) {
    let Some((species, path)) = reader.plants.species.as_ref().zip(args.mesh.species.as_deref()) else {
        return;
    };
    let found = match recipe(args).model() {
        ModelName::Physical if species.surfaces.is_none() && species.optics.is_some() => {
            "its [[optics]] are for --model paper, and it has no [[surfaces]]: baking with those of common leaves and bark"
        }
        ModelName::Paper if species.optics.is_none() && species.surfaces.is_some() => {
            "its surfaces are for --model physical, and it has no [[optics]]: baking with the papers'"
        }
        _ => return,
    };
    say!("warning: {}: {found}", path.display());
}
