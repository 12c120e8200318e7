//! Light on the mesh against paths, at rising lattices: built-in plants by the default bake, and solids.
//!
//! ```text
//! cargo bench -p flb-tests --bench mesh -- [quick] [lattice...]
//! ```
//!
//! Lattices are 32, 64 and 128, or those that are named (256 takes minutes and gigabytes). `quick` takes fewer plants,
//! points and suns. A row is a class of surface under the sky or under suns without their beams: light of the file over
//! the truth and its rms error over the mean truth, in the mean of the bands, and bytes and seconds of the bake.

use std::time::Instant;

use flb_baker::bake::BakeSettings;
use flb_eval::figures::{ClassJudgement, Figures};
use flb_fixtures::PlantKind;
use flb_scene::{MaterialClass, Mesh, Plant};
use flb_testkit::solids;
use flb_tests::default_bake::grown;
use flb_tests::mesh_light::{Fineness, judged};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let quick = words.iter().any(|word| word == "quick");
    let named: Vec<u32> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let lattices = match (named.is_empty(), quick) {
        (false, _) => named,
        (true, true) => vec![32, 64],
        (true, false) => vec![32, 64, 128],
    };
    let fineness = match quick {
        true => Fineness { suns: 4, points: 500, samples: 32 },
        false => Fineness { suns: 16, points: 2000, samples: 64 },
    };
    println!("plant, lattice: class, source: light / truth, rms; bytes; seconds with the judge");
    let kinds = [PlantKind::Oak, PlantKind::Shrub, PlantKind::Spruce];
    let plants = kinds
        .into_iter()
        .take(if quick { 1 } else { 3 })
        .map(|kind| (kind.name(), grown(kind, kind.default_triangles())));
    let wood = |name: &'static str, mesh: Mesh| (name, Plant::new(name, mesh, vec![MaterialClass::Wood]));
    let solids = [wood("ball", solids::ball()), wood("pot", solids::pot()), wood("trunk", solids::trunk())];
    for (name, plant) in plants.chain(solids) {
        for &lattice in &lattices {
            let settings = BakeSettings { lattice, ..BakeSettings::default() };
            let start = Instant::now();
            let found = judged(plant.clone(), &settings, fineness);
            let seconds = start.elapsed().as_secs_f64();
            println!("{name}, {lattice}: {} bytes, {seconds:.0} s", found.bytes);
            for (class, judged) in [("leaf", &found.mesh.leaf), ("wood", &found.mesh.wood)] {
                let Some(judged) = judged else { continue };
                rows(judged).into_iter().for_each(|(source, figures)| {
                    let mean = |values: [f64; 3]| values.iter().sum::<f64>() / 3.0;
                    println!(
                        "  {class}, {source}: {:.3}, {:.1} %",
                        mean(figures.ratio),
                        100.0 * mean(figures.rms)
                    );
                });
            }
        }
    }
}

fn rows(judged: &ClassJudgement) -> Vec<(&'static str, &Figures)> {
    let all = [("sky", &judged.sky), ("suns", &judged.suns), ("as either side is seen", &judged.seen)];
    all.into_iter().filter_map(|(name, figures)| Some((name, figures.as_ref()?))).collect()
}
