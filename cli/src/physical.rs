//! The `physical` model's part of a bake: from the medium to extinction and fields.

use flb_baker::crown::{CrownSettings, LeafAngleChoice, measure_crown};
use flb_baker::leaf;
use flb_baker::ordinates::{self, BandReport, FieldKind, Ordinates, OrdinatesSettings, Suns};
use flb_format::turbid::Turbid;
use flb_format::{Field, Light, LightError, Medium, Surfaces};

use crate::args::{BackendArg, BakeArgs, FieldArg, LeafAnglesArg, ModelArg, SolverArg, SunsArg};
use crate::classes::ClassedMesh;
use crate::exit::{Failure, USAGE};
use crate::solving::SolveSummary;
use crate::stages::Stages;

/// How to bake with the `physical` model.
pub struct Physical {
    pub solve: OrdinatesSettings,
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
        if args.plan.is_some() {
            let message = "--plan is for --model paper: it leaves out lattice directions, and every sun needs all fields of the physical model";
            return refuse(message.to_owned());
        }
        let default = OrdinatesSettings::default();
        let ordinates = match flags.ordinates {
            None => default.ordinates,
            Some(count) => match Ordinates::of_count(count) {
                Some(ordinates) => ordinates,
                None => return refuse(format!("--ordinates is {count}, expected 18, 50 or 110")),
            },
        };
        let rays = flags.rays.unwrap_or(default.rays);
        if !(1..=ordinates::MOST_RAYS).contains(&rays) {
            return refuse(format!("--rays is {rays}, expected 1 to {}", ordinates::MOST_RAYS));
        }
        let tolerance = args.tolerance.unwrap_or(default.tolerance);
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return refuse(format!("--tolerance is {tolerance}, expected a number between 0 and 1"));
        }
        if args.max_sweeps == 0 {
            return refuse("--max-sweeps is 0, expected 1 or more".to_owned());
        }
        let suns = match flags.suns {
            None => default.suns,
            Some(SunsArg::Lattice18) => Suns::Lattice18,
            Some(SunsArg::Sh1) => Suns::Harmonics { degree: 1 },
            Some(SunsArg::Sh2) => Suns::Harmonics { degree: 2 },
            Some(SunsArg::Sh3) => Suns::Harmonics { degree: 3 },
        };
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
        let parts = if flags.cut_sites { 2 } else { 1 };
        let solve =
            OrdinatesSettings { ordinates, rays, parts, suns, field, tolerance, max_passes: args.max_sweeps };
        Ok(Some(Physical { solve, angles }))
    }

    /// What a file says of light that nobody has solved yet.
    pub fn light(&self) -> Light {
        Light {
            field: self.solve.field,
            ordinates: self.solve.ordinates.count(),
            rays: self.solve.rays,
            suns: self.solve.suns,
            leaf_angles: flb_format::turbid::LeafAngles::spherical(),
            error: LightError { suns_rms: 0.0, held_out: 0, solver: 0.0, monte_carlo: None },
        }
    }
}

/// What the model made of a species.
pub struct PhysicalFields {
    pub turbid: Turbid,
    pub bases: Vec<(u8, Field)>,
    pub light: Light,
    /// Factor that makes the crown as open as its mesh.
    pub crown_factor: f64,
    /// Share of light that passes the crown, in the mean over directions.
    pub crown_gap: f64,
    pub converged: bool,
}

/// Measures the extinction of the plant and solves its light.
pub fn solve(
    name: &str,
    classed: &ClassedMesh,
    medium: &Medium,
    surfaces: &Surfaces,
    physical: &Physical,
    ignore_alpha: bool,
    stages: &mut Stages,
) -> Result<PhysicalFields, Failure> {
    let crown = stages.run("crown", name, |progress| {
        let settings = CrownSettings { ignore_alpha, angles: physical.angles };
        measure_crown(&classed.mesh, &classed.classes, medium, &settings, progress)
    })?;
    let bands: Vec<_> = surfaces.bands.iter().map(leaf::scatter).collect();
    let solution = stages
        .run("solve", name, |progress| ordinates::solve(&crown.turbid, &bands, &physical.solve, progress))?;
    let reports = &solution.reports;
    let converged = reports.iter().all(|report| report.converged);
    let worst = |of: &dyn Fn(&BandReport) -> f64| reports.iter().map(of).fold(0.0, f64::max);
    let solver = worst(&|report| report.error_estimate);
    if !converged {
        eprintln!(
            "flb: warning: {name}: the light of {} of {} bands did not converge; estimated error {solver:.1e}, tolerance {:.1e}",
            reports.iter().filter(|report| !report.converged).count(),
            reports.len(),
            physical.solve.tolerance
        );
    }
    stages.add_solve(SolveSummary {
        species: name.to_owned(),
        solver: "ordinates",
        cached: false,
        solves: reports.iter().map(|report| report.solves as usize).sum(),
        converged: reports
            .iter()
            .filter(|report| report.converged)
            .map(|report| report.solves as usize)
            .sum(),
        sweeps: reports.iter().map(|report| report.passes).max(),
        residual: None,
        error_estimate: Some(solver),
    });
    let suns_rms = worst(&|report| report.suns_rms.unwrap_or(0.0));
    let error = LightError { suns_rms, held_out: solution.held_out, solver, monte_carlo: None };
    let light = Light { leaf_angles: crown.turbid.angles.clone(), error, ..physical.light() };
    Ok(PhysicalFields {
        turbid: crown.turbid,
        bases: solution.fields,
        light,
        crown_factor: crown.factor,
        crown_gap: crown.gap,
        converged,
    })
}
