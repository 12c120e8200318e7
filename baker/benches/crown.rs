//! How much light passes a crown: its mesh, the medium by the formula, and the measured one; and how long measuring
//! takes.
//!
//! `cargo bench -p flb-baker --bench crown -- [MESH [METRES_PER_UNIT]]`, by default the built-in oak of 150,000
//! triangles. Percentages are relative to the mesh's gap fraction, in the mean over all directions and along the
//! one that is furthest off; "measured angles" are leaf angles, not extinctions.

use std::path::Path;
use std::time::Instant;

use flb_baker::crown::{CrownSettings, GapRays, LeafAngleChoice, measure_crown, unclumped};
use flb_baker::downsample;
use flb_baker::voxelise::{VoxelSettings, voxelise};
use flb_fixtures::PlantKind;
use flb_scene::classify::classify;
use flb_scene::import::import;
use flb_scene::{ClassRules, ImportSettings, MaterialClass, Mesh};
use flb_transport::turbid::{LeafAngles, TurbidMedium};

/// Rays over the plant's longest extent by which crowns are judged.
const RAYS: u32 = 256;

fn built_in_oak() -> Mesh {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("oak.glb");
    let plant = flb_fixtures::grow(PlantKind::Oak, 1, 150_000).expect("enough triangles");
    std::fs::write(&path, plant.to_glb()).expect("room for the plant");
    import(&path, &ImportSettings::default()).expect("a good mesh")
}

fn main() {
    // Cargo adds --bench.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let unit_m = arguments.get(1).map(|unit| unit.parse().expect("metres per unit of the mesh"));
    let mesh = match arguments.first() {
        Some(path) => import(Path::new(path), &ImportSettings { unit_m, ..ImportSettings::default() })
            .expect("a mesh that can be read"),
        None => built_in_oak(),
    };
    let classes: Vec<MaterialClass> = classify(&mesh, &ClassRules::default())
        .expect("materials that tell")
        .iter()
        .map(|decision| decision.class)
        .collect();
    let rays = GapRays::new(&mesh, &classes, false, RAYS).expect("a good mesh");
    let truth = rays.of_mesh();
    println!("{} triangles, gap fraction {:.4}", mesh.triangles.len(), truth.mean());
    println!(
        "lattice  formula  mean   worst    measured  mean   worst    factor  seconds  measured angles  worst"
    );
    for lattice in [32, 64, 128, 256] {
        let settings = VoxelSettings { voxels: 1024, lattice, ignore_alpha: false };
        let occupancy = voxelise(&mesh, &classes, &settings, &|_| Ok(())).expect("a good mesh");
        let medium = downsample(&occupancy).expect("a good occupancy");
        let errors = |turbid: &TurbidMedium| {
            let gap = rays.of_turbid(turbid);
            let percent = |error: f64| 100.0 * error;
            (gap.mean(), percent(gap.error(&truth)), percent(gap.worst_error(&truth)))
        };
        let measured = |angles| {
            let settings = CrownSettings { ignore_alpha: false, angles };
            let start = Instant::now();
            let crown =
                measure_crown(&mesh, &classes, &medium, &settings, &|_| Ok(())).expect("a good medium");
            (crown, start.elapsed().as_secs_f64())
        };
        let formula = errors(&unclumped(&medium, LeafAngles::spherical()).expect("a good medium"));
        let (crown, seconds) = measured(LeafAngleChoice::Spherical);
        let own = errors(&crown.turbid);
        let with_angles = errors(&measured(LeafAngleChoice::Measured).0.turbid);
        println!(
            "{lattice:7} {:8.4} {:+6.1}% {:+6.1}% {:10.4} {:+6.1}% {:+6.1}% {:9.3} {seconds:8.2} {:16.4} {:+6.1}%",
            formula.0, formula.1, formula.2, own.0, own.1, own.2, crown.factor, with_angles.0, with_angles.2
        );
    }
}
