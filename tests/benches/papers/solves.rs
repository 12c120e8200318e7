//! Table 6.5: what base solutions take.

use flb_baker::{VoxelSettings, downsample, voxelise};
use flb_fixtures::PlantKind;
use flb_format::matter::Optics;
use flb_tests::default_bake::grown;
use flb_transport::lattice::{SolveSettings, SolverKind, Steps, solve};

use crate::Scale;
use crate::light::timed;

/// Bands of base solutions.
const SOLVES: f64 = 57.0;

pub(crate) fn table(scale: &Scale) {
    println!("Table 6.5, seconds; 2N steps of the papers' iteration, and sweeps to 1e-4, of a grown oak:\n");
    println!("| lattice | a solve | all | by sweeps: a solve | all | theirs: a solve | all |");
    println!("|---:|---:|---:|---:|---:|---:|---:|");
    let theirs = [(64, "0.196 | 18.5"), (128, "2.926 | 200")];
    for (lattice, theirs) in theirs.into_iter().filter(|(lattice, _)| *lattice <= scale.lattice.max(64)) {
        let mut plant = grown(PlantKind::Oak, (316_767.0 * scale.share) as u32);
        plant.ignore_alpha = true;
        let settings = VoxelSettings { voxels: scale.voxels, lattice, ignore_alpha: true };
        let (mesh, classes) = (&plant.classed.mesh, &plant.classed.classes);
        let occupancy = voxelise(mesh, classes, &settings, &|_| Ok(())).expect("a plant has triangles");
        let medium = downsample(&occupancy).expect("an occupancy of voxelise");
        let run = |settings: SolveSettings| {
            timed(|| solve(&medium, &Optics::paper(), &settings, &|_| Ok(())).expect("a sound medium")).1
        };
        let papers = SolveSettings {
            solver: SolverKind::Explicit,
            steps: Some(Steps::PAPERS),
            ..SolveSettings::default()
        };
        // Base 0 is the sum of the others.
        let [explicit, sweeps] = [papers, SolveSettings::default()].map(run);
        println!(
            "| {lattice} | {:.3} | {explicit:.1} | {:.4} | {sweeps:.2} | {theirs} |",
            explicit / SOLVES,
            sweeps / SOLVES
        );
    }
    println!();
}
