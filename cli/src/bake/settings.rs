//! From the flags of `flb bake` to its settings.

use flb_baker::bake::{BakeSettings, ModelSettings, PaperSettings, PhysicalSettings, Wanted};
use flb_baker::crown::LeafAngleChoice;
use flb_baker::plan::Plan;
use flb_baker::voxelise::MAX_VOXELS;
use flb_format::FieldKind;
use flb_transport::SolverKind;
use flb_transport::ordinates::{MAX_RAYS, NamedSuns, Ordinates};

use crate::args::{BackendArg, BakeArgs, FieldArg, LeafAnglesArg, ModelArg, SolverArg};
use crate::exit::{Failure, USAGE};
use crate::plan::check_known;

/// Of every species. Refuses, before a mesh is read, a plan that is not for these species, and lattices that cannot be.
pub(crate) fn settings_of(
    args: &BakeArgs,
    plan: Option<&Plan>,
    names: &[String],
) -> Result<Vec<BakeSettings>, Failure> {
    if let Some((plan, path)) = plan.zip(args.plan.as_deref()) {
        check_known(plan, names).map_err(|failure| failure.at(path))?;
    }
    names.iter().map(|name| bake_settings(args, plan, name)).collect()
}

/// What the flags ask for, the plan where they do not, and else the preset.
pub(crate) fn bake_settings(
    args: &BakeArgs,
    plan: Option<&Plan>,
    species: &str,
) -> Result<BakeSettings, Failure> {
    let planned = plan.map(|plan| plan.share(species)).transpose()?.and_then(|share| share.lattice);
    let wanted = plan.map(|plan| Wanted::by_plan(plan, species)).transpose()?;
    Ok(BakeSettings {
        lattice: lattice(args, planned, species)?,
        voxels: args.voxels,
        ignore_alpha: args.ignore_alpha,
        wanted: wanted.unwrap_or_default(),
        model: model_settings(args)?,
    })
}

/// The flag's, the plan's, or the preset's; not two of them, and a divisor of `--voxels`.
fn lattice(args: &BakeArgs, planned: Option<u32>, species: &str) -> Result<u32, Failure> {
    if let (Some(planned), Some(asked)) = (planned, args.lattice) {
        let message = format!(
            "the plan bakes species {species:?} at lattice {planned}; --lattice {asked} cannot be given with it"
        );
        let failure = Failure::new(USAGE, message);
        return Err(args.plan.iter().fold(failure, |failure, path| failure.at(path)));
    }
    let lattice = args.lattice.or(planned).unwrap_or(BakeSettings::of(args.quality()).lattice);
    if !(args.voxels.is_multiple_of(lattice) && (1..=MAX_VOXELS).contains(&args.voxels)) {
        let message = format!(
            "--voxels is {}, expected a multiple of the lattice, {lattice}, up to {MAX_VOXELS}",
            args.voxels
        );
        return Err(Failure::new(USAGE, message));
    }
    Ok(lattice)
}

/// Model and solve. Refuses flags of the other model.
pub(crate) fn model_settings(args: &BakeArgs) -> Result<ModelSettings, Failure> {
    Ok(match args.model.model {
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
    Ok(PaperSettings {
        solver: match args.solver {
            SolverArg::Auto if args.backend == BackendArg::Gpu => SolverKind::Gpu,
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
    if args.solver != SolverArg::Auto || args.backend == BackendArg::Gpu {
        let message =
            "--solver and --backend gpu are for --model paper; the physical model has one solver, on the CPU";
        return refuse(message.to_owned());
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
        suns: flags.suns.map_or(preset.suns, NamedSuns::basis),
        ordinates,
        rays: flags.rays,
        parts: flags.cut_sites.map_or(preset.parts, |cut| if cut { 2 } else { 1 }),
        field: match flags.field {
            None => preset.field,
            Some(FieldArg::Scattered) => FieldKind::Scattered,
            Some(FieldArg::Total) => FieldKind::Total,
        },
        leaf_angles: match flags.leaf_angles {
            None => preset.leaf_angles,
            Some(LeafAnglesArg::Measured) => LeafAngleChoice::Measured,
            Some(LeafAnglesArg::Spherical) => LeafAngleChoice::Spherical,
            Some(LeafAnglesArg::Planophile) => LeafAngleChoice::Planophile,
            Some(LeafAnglesArg::Erectophile) => LeafAngleChoice::Erectophile,
        },
        tolerance,
        max_passes: args.max_sweeps,
        monte_carlo_suns: flags.monte_carlo.into(),
        keep_cloud: false,
    })
}

/// The directions of `--ordinates`.
pub(crate) fn ordinates_of(count: u32) -> Result<Ordinates, Failure> {
    let refuse = || Failure::new(USAGE, format!("--ordinates is {count}, expected 18, 50 or 110"));
    Ordinates::of_count(count).ok_or_else(refuse)
}

/// Refuses a solve that would never end, or never begin.
pub(crate) fn check_end(tolerance: f64, max_sweeps: u32) -> Result<(), Failure> {
    let refuse = |message: String| Err(Failure::new(USAGE, message));
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return refuse(format!("--tolerance is {tolerance}, expected a number between 0 and 1"));
    }
    if max_sweeps == 0 {
        return refuse("--max-sweeps is 0, expected 1 or more".to_owned());
    }
    Ok(())
}
