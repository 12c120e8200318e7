//! How a bake with the `physical` model is asked for: flags and preset become settings.

use flb_baker::crown::LeafAngleChoice;
use flb_format::{BaseSet, Light, LightError};
use flb_transport::ordinates::{self, FieldKind, Ordinates, OrdinatesSettings};

use crate::args::{BackendArg, BakeArgs, FieldArg, LeafAnglesArg, ModelArg, SolverArg};
use crate::exit::{Failure, USAGE};

/// How to bake with the `physical` model.
pub struct Physical {
    /// Its rays are those of a lattice of 128.
    solve: OrdinatesSettings,
    /// Rays that were asked for.
    rays: Option<u32>,
    pub angles: LeafAngleChoice,
}

impl Physical {
    /// What the flags ask for; `None` for the `paper` model. Refuses flags of the other model.
    pub fn of(args: &BakeArgs) -> Result<Option<Physical>, Failure> {
        let refuse = |message: String| Err(Failure::new(USAGE, message));
        let flags = &args.model;
        if flags.model == ModelArg::Paper {
            return match flags.physical_flag() {
                Some(flag) => {
                    refuse(format!("{flag} is for --model physical; the paper model has no such choice"))
                }
                None => Ok(None),
            };
        }
        if args.solver != SolverArg::Auto || args.backend == BackendArg::Gpu {
            let message = "--solver and --backend gpu are for --model paper; the physical model has one solver, on the CPU";
            return refuse(message.to_owned());
        }
        let preset = args.preset();
        let ordinates = match flags.ordinates {
            None => preset.ordinates,
            Some(count) => ordinates_of(count)?,
        };
        if let Some(rays) = flags.rays.filter(|rays| !(1..=ordinates::MOST_RAYS).contains(rays)) {
            return refuse(format!("--rays is {rays}, expected 1 to {}", ordinates::MOST_RAYS));
        }
        let tolerance = args.tolerance.unwrap_or(preset.tolerance);
        check_end(tolerance, args.max_sweeps)?;
        let suns = flags.suns.unwrap_or(preset.suns).suns();
        let field = match flags.field {
            None | Some(FieldArg::Scattered) => FieldKind::Scattered,
            Some(FieldArg::Total) => FieldKind::Total,
        };
        let angles = match flags.leaf_angles {
            None | Some(LeafAnglesArg::Measured) => LeafAngleChoice::Measured,
            Some(LeafAnglesArg::Spherical) => LeafAngleChoice::Spherical,
            Some(LeafAnglesArg::Planophile) => LeafAngleChoice::Planophile,
            Some(LeafAnglesArg::Erectophile) => LeafAngleChoice::Erectophile,
        };
        let parts = match flags.cut_sites {
            None => preset.parts,
            Some(false) => 1,
            Some(true) => 2,
        };
        let (bases, max_passes, rays) = (BaseSet::ALL, args.max_sweeps, ordinates::rays_for(128, parts));
        let solve = OrdinatesSettings { ordinates, rays, parts, suns, bases, field, tolerance, max_passes };
        Ok(Some(Physical { solve, rays: flags.rays, angles }))
    }

    /// How to solve on a lattice.
    pub fn solve(&self, lattice: u32) -> OrdinatesSettings {
        let by_lattice = ordinates::rays_for(lattice, self.solve.parts);
        OrdinatesSettings { rays: self.rays.unwrap_or(by_lattice), ..self.solve.clone() }
    }

    /// What a file says of light that nobody has solved yet.
    pub fn light(solve: &OrdinatesSettings) -> Light {
        Light {
            field: solve.field,
            ordinates: solve.ordinates.count(),
            rays: solve.rays,
            suns: solve.suns.clone(),
            leaf_angles: flb_format::turbid::LeafAngles::spherical(),
            error: LightError { suns_rms: 0.0, held_out: 0, solver: 0.0, monte_carlo: None },
        }
    }
}

/// The directions of `--ordinates`.
pub fn ordinates_of(count: u32) -> Result<Ordinates, Failure> {
    let refuse = || Failure::new(USAGE, format!("--ordinates is {count}, expected 18, 50 or 110"));
    Ordinates::of_count(count).ok_or_else(refuse)
}

/// Refuses a solve that would never end, or never begin.
pub fn check_end(tolerance: f64, max_sweeps: u32) -> Result<(), Failure> {
    let refuse = |message: String| Err(Failure::new(USAGE, message));
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return refuse(format!("--tolerance is {tolerance}, expected a number between 0 and 1"));
    }
    if max_sweeps == 0 {
        return refuse("--max-sweeps is 0, expected 1 or more".to_owned());
    }
    Ok(())
}
