//! What the ways to find a ray's hits cost: prints a table of seconds to prepare, trace and relight a scene of the size
//! of the papers' forest, for 1 and 4 rays per pixel at 512 x 512.
//!
//! ```text
//! cargo bench -p flb-render --bench forest -- [TRIANGLES [INSTANCES]]
//! ```
//!
//! By default 5 plants of 250,000 triangles, 424 instances: 106 million triangles. The light is the same everywhere, so
//! that nothing but rays and shading is timed; each time is the shortest of three.

use std::time::{Duration, Instant};

use flb_fixtures::{PlantKind, grow};
use flb_format::sun::towards_sun;
use flb_format::{Placement, Transform};
use flb_render::forest::{Eye, Forest, Fragments, Ground, InstanceSearch, Land, ModelSearch, Search, View};
use flb_render::{Lighting, Look, Shading, Species};
use flb_scene::{MaterialClass, Mesh};
use flb_testkit::grown;

/// Edge of the square that the plants stand in.
const EDGE_M: f64 = 120.0;
const PLANTS: [(PlantKind, u64); 5] = [
    (PlantKind::Oak, 1),
    (PlantKind::Oak, 2),
    (PlantKind::Spruce, 1),
    (PlantKind::Spruce, 2),
    (PlantKind::Shrub, 1),
];
const CLASSES: [MaterialClass; 2] = [MaterialClass::Wood, MaterialClass::Leaf];

fn main() {
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let (triangles, count) = (numbers.first().map_or(250_000, |n| *n), numbers.get(1).map_or(424, |n| *n));
    let meshes: Vec<Mesh> = PLANTS
        .iter()
        .map(|(kind, seed)| {
            grown::mesh(&grow(*kind, *seed, triangles as u32).expect("a count within the limits"), [1.0; 4])
        })
        .collect();
    let instances = stand(count);
    let all: usize = instances.iter().map(|instance| meshes[instance.species].triangles.len()).sum();
    println!("{count} instances of {} species, {all} triangles, 512 x 512", meshes.len());
    println!("| models | primary | shadow | rays | prepare s | trace s | relight s |");
    println!("|---|---|---|---:|---:|---:|---:|");
    for model in [ModelSearch::Tree, ModelSearch::Grid] {
        for grid in [InstanceSearch::Tree, InstanceSearch::Grid] {
            row(&meshes, &instances, Search { model, primary: grid, shadow: grid });
        }
    }
}

fn row(meshes: &[Mesh], instances: &[Placement], search: Search) {
    let species: Vec<Species> =
        meshes.iter().map(|mesh| Species { mesh, classes: &CLASSES, shading: Shading::Paper }).collect();
    let start = Instant::now();
    let ground = Ground { land: Land::Plane { height_m: 0.0 }, color: [0.2; 3], fades_at_m: None };
    let forest = Forest::prepare(&species, instances, Some(ground), search).expect("a sound scene");
    let prepare = start.elapsed();
    for samples in [1, 4] {
        let position_m = [0.0, 22.0, EDGE_M * 0.62];
        let eye = Eye { position_m, look_at_m: [0.0, 2.0, 0.0], fov_deg: 45.0 };
        let view = View { eye, width: 512, height: 512, samples, sky_rays: 0, time_s: 0.0 };
        let (trace, fragments) = shortest(|| forest.trace(&view, &|_| Ok(())).expect("a sound view"));
        let relight = relight(&forest, &fragments);
        println!(
            "| {} | {} | {} | {samples} | {:.2} | {:.2} | {:.2} |",
            if search.model == ModelSearch::Tree { "tree" } else { "grid" },
            if search.primary == InstanceSearch::Tree { "tree" } else { "view grid" },
            if search.shadow == InstanceSearch::Tree { "tree" } else { "sun grid" },
            prepare.as_secs_f64(),
            trace.as_secs_f64(),
            relight.as_secs_f64(),
        );
    }
}

fn relight(forest: &Forest, fragments: &Fragments) -> Duration {
    let daylight = Lighting::towards(towards_sun(135.0, 35.0));
    let light = |_: flb_render::LightQuery, phi: &mut [f32; 3]| *phi = [0.3; 3];
    shortest(|| {
        forest.relight(fragments, &daylight, &Look::default(), &light, &|_| Ok(())).expect("a finite light")
    })
    .0
}

fn shortest<T>(mut work: impl FnMut() -> T) -> (Duration, T) {
    let mut run = || {
        let start = Instant::now();
        let made = work();
        (start.elapsed(), made)
    };
    let mut best = run();
    for _ in 0..2 {
        let next = run();
        if next.0 < best.0 {
            best = next;
        }
    }
    best
}

/// Evenly spread: the additive sequence of the plastic number.
fn stand(count: usize) -> Vec<Placement> {
    (0..count)
        .map(|i| {
            let share = |step: f64| (0.5 + step * i as f64).fract();
            let [sin, _, minus_cos] = towards_sun(360.0 * share(0.618_033_988_75), 0.0);
            let rotation = [[-minus_cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, -minus_cos]];
            let [x, z] = [share(0.754_877_666_25), share(0.569_840_290_99)].map(|at| (at - 0.5) * EDGE_M);
            Placement {
                species: i % PLANTS.len(),
                transform: Transform {
                    rotation,
                    position_m: [x, 0.0, z],
                    scale: 0.8 + 0.4 * share(0.819_172_513_4),
                },
            }
        })
        .collect()
}
