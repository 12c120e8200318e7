//! The papers' scenes in size on a GPU and on the CPU side by side: prints a table of milliseconds to trace and to
//! relight one tree of 316,000 triangles, and 424 plants of 5 species, 109 million triangles.
//!
//! ```text
//! cargo bench -p flb-render-gpu --bench forest [-- [tree|forest] [ways|devices] [BEST_OF]]
//! ```
//!
//! Light comes from a coded file of the `paper` model at lattice 64, the same for all species: a blend of four bases
//! for each fragment. Each time is the shortest of so many (by default three), waiting included; the scene is sent and
//! compiled before. `FLB_BENCH_HD=1` adds 1920 x 1080. Below, or alone with `ways`, the ways in which the GPU's rays
//! can find what they meet, at 512 x 512 with one ray a pixel; times include the grids that a view or a sun needs.
//! Alone with `devices`, what several GPUs take together, or several devices on the one that is there.

mod plants;

use std::time::Instant;

use flb_fixtures::PlantKind;
use flb_format::sun::{self, towards_sun};
use flb_format::{Placement, Transform};
use flb_gpu::Gpu;
use flb_render::forest::{Eye, Forest, Ground, InstanceSearch, Land, ModelSearch, Search, View};
use flb_render::{Lighting, Look, Shading, Species};
use flb_render_gpu::{FEATURES, Fleet, ForestSettings, GpuForest, LightSet, LightSource};
use flb_runtime::samplers::SpeciesSampler;
use flb_scene::Mesh;

use plants::{CLASSES, library, mesh, stand};

const SUN: [f64; 2] = [135.0, 35.0];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let best_of = words.iter().find_map(|word| word.parse().ok()).unwrap_or(3);
    let is_wanted = |name: &str| {
        let mut names = words.iter().filter(|word| ["tree", "forest"].contains(&word.as_str())).peekable();
        names.peek().is_none() || names.any(|word| word == name)
    };
    let gpu = Gpu::open(FEATURES).unwrap_or_else(|error| panic!("{error}"));
    println!(
        "GPU: {}; CPU: {} threads\n",
        gpu.name,
        std::thread::available_parallelism().map_or(1, usize::from)
    );
    if is_wanted("tree") {
        let tree = [mesh(PlantKind::Oak, 1, 316_000)];
        let alone = [Placement {
            species: 0,
            transform: Transform { position_m: [0.0; 3], scale: 1.0, ..stand(1, 1, 1.0)[0].transform },
        }];
        let eye = Eye { position_m: [0.0, 6.0, 18.0], look_at_m: [0.0, 5.0, 0.0], fov_deg: 45.0 };
        scene("tree", &gpu, &tree, &alone, eye, best_of);
    }
    if is_wanted("forest") {
        let species = [
            (PlantKind::Oak, 1),
            (PlantKind::Oak, 2),
            (PlantKind::Spruce, 1),
            (PlantKind::Spruce, 2),
            (PlantKind::Shrub, 1),
        ];
        let meshes: Vec<Mesh> = species.iter().map(|(kind, seed)| mesh(*kind, *seed, 257_000)).collect();
        let eye = Eye { position_m: [0.0, 22.0, 75.0], look_at_m: [0.0, 2.0, 0.0], fov_deg: 45.0 };
        scene("forest", &gpu, &meshes, &stand(424, meshes.len(), 120.0), eye, best_of);
    }
}

fn scene(name: &str, gpu: &Gpu, meshes: &[Mesh], instances: &[Placement], eye: Eye, best_of: usize) {
    let species: Vec<Species> =
        meshes.iter().map(|mesh| Species { mesh, classes: &CLASSES, shading: Shading::Paper }).collect();
    let ground = Ground { land: Land::Plane { height_m: 0.0 }, color: [0.2; 3], fades_at_m: None };
    let forest =
        Forest::prepare(&species, instances, Some(ground), Search::default()).expect("a sound scene");
    let library = library();
    let sources: Vec<LightSource> =
        meshes.iter().map(|_| LightSource::Library { library: &library, species: 0 }).collect();
    let mut lights = LightSet::load(gpu, &sources, instances.len()).unwrap_or_else(|error| panic!("{error}"));
    let mut on_gpu = GpuForest::new(gpu, &forest, &lights, ForestSettings::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let view = View { eye, width: 512, height: 512, samples: 1, sky_rays: 0, time_s: 0.0 };
    if std::env::args().any(|word| word == "devices") {
        return devices(name, &forest, &sources, view, best_of);
    }
    let bases: Vec<u8> = (0..19).collect();
    let sampler = SpeciesSampler::load(&library, 0, &bases).expect("a sound file");
    let triangles: usize = instances.iter().map(|one| meshes[one.species].triangles.len()).sum();
    println!(
        "{name}: {} instances of {} species, {triangles} triangles; on the GPU {:.1} MB of forest, {:.1} MB of light",
        instances.len(),
        meshes.len(),
        on_gpu.size_bytes()[0] as f64 / 1e6,
        lights.size_bytes() as f64 / 1e6,
    );
    println!(
        "| size | rays | GPU trace ms | GPU relight ms | CPU trace ms | CPU relight ms | fragments MB |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    let daylight = Lighting::towards(towards_sun(SUN[0], SUN[1]));
    let blends: Vec<_> = instances.iter().map(|one| blend(one, daylight.daylight.towards_sun)).collect();
    let light = |asked: flb_render::LightQuery, phi: &mut [f32; 3]| {
        sampler.indirect(&blends[asked.instance as usize], 1.0, daylight.daylight.sky, asked.point, phi);
    };
    let only_ways = std::env::args().any(|word| word == "ways");
    let hd = std::env::var_os("FLB_BENCH_HD").map(|_| [1920, 1080]);
    for [width, height] in [[512, 512]].into_iter().chain(hd).filter(|_| !only_ways) {
        for samples in [1, 4] {
            let view = View { eye, width, height, samples, sky_rays: 0, time_s: 0.0 };
            let ok = "it did so before";
            on_gpu.trace(&view).unwrap_or_else(|error| panic!("{error}"));
            on_gpu
                .relight(&mut lights, &daylight, &Look::default())
                .unwrap_or_else(|error| panic!("{error}"));
            on_gpu.wait().unwrap_or_else(|error| panic!("{error}"));
            let gpu_trace = shortest(best_of, || {
                on_gpu.trace(&view).expect(ok);
                on_gpu.wait().expect(ok);
            });
            let gpu_relight = shortest(best_of, || {
                on_gpu.relight(&mut lights, &daylight, &Look::default()).expect(ok);
                on_gpu.wait().expect(ok);
            });
            let mut fragments = None;
            let trace = shortest(best_of, || fragments = Some(forest.trace(&view, &|_| Ok(())).expect(ok)));
            let fragments = fragments.expect(ok);
            let relight = shortest(best_of, || {
                forest
                    .relight(&fragments, &daylight, &Look::default(), &light, &|_| Ok(()))
                    .expect("a finite light");
            });
            println!(
                "| {width} x {height} | {samples} | {gpu_trace:.1} | {gpu_relight:.1} | {trace:.1} | {relight:.1} | {:.1} |",
                on_gpu.size_bytes()[1] as f64 / 1e6
            );
        }
    }
    println!();
    ways(gpu, &forest, &mut lights, view, best_of);
}

/// Prints what one, two and four devices take for a picture: one on each GPU, and further ones on the first.
fn devices(name: &str, forest: &Forest, sources: &[LightSource], view: View, best_of: usize) {
    let found = Gpu::open_up_to(FEATURES, 4).unwrap_or_else(|error| panic!("{error}"));
    println!("{name}: GPUs {}", found.iter().map(|gpu| gpu.name.as_str()).collect::<Vec<_>>().join(", "));
    println!("| devices | on GPUs | trace ms | relight ms | relight, times as fast |");
    println!("|---:|---:|---:|---:|---:|");
    let daylight = Lighting::towards(towards_sun(SUN[0], SUN[1]));
    let mut of_one = None;
    for count in [1, 2, 4] {
        let member = |index: usize| {
            let further;
            let gpu = match found.get(index) {
                Some(gpu) => gpu,
                None => {
                    further = Gpu::open(FEATURES).unwrap_or_else(|error| panic!("{error}"));
                    &further
                }
            };
            let lights = LightSet::load(gpu, sources, forest.placements().len())
                .unwrap_or_else(|error| panic!("{error}"));
            let on_gpu = GpuForest::new(gpu, forest, &lights, ForestSettings::default());
            (on_gpu.unwrap_or_else(|error| panic!("{error}")), lights)
        };
        let mut fleet = Fleet::new((0..count).map(member)).unwrap_or_else(|error| panic!("{error}"));
        let trace = |fleet: &mut Fleet| fleet.trace(&view).unwrap_or_else(|error| panic!("{error}"));
        let relight = |fleet: &mut Fleet| {
            fleet.relight(&daylight, &Look::default()).unwrap_or_else(|error| panic!("{error}"))
        };
        trace(&mut fleet);
        relight(&mut fleet);
        let traced = shortest(best_of, || trace(&mut fleet));
        let relit = shortest(best_of, || drop(relight(&mut fleet)));
        let first = *of_one.get_or_insert(relit);
        println!(
            "| {count} | {} | {traced:.1} | {relit:.1} | {:.2} |",
            count.min(found.len()),
            first / relit
        );
    }
    println!();
}

/// Prints a table of all ways to find what rays meet.
fn ways(gpu: &Gpu, forest: &Forest, lights: &mut LightSet, view: View, best_of: usize) {
    println!("| model | camera's rays | shadow rays | GPU trace ms | GPU relight ms | forest MB |");
    println!("|---|---|---|---:|---:|---:|");
    let daylight = Lighting::towards(towards_sun(SUN[0], SUN[1]));
    let both = [InstanceSearch::Tree, InstanceSearch::Grid];
    for model in [ModelSearch::Tree, ModelSearch::Grid] {
        // A trace knows nothing of shadow rays, and a relight nothing of the camera's.
        for instances in both {
            let search = Search { model, primary: instances, shadow: instances };
            let settings = ForestSettings { search, ..ForestSettings::default() };
            let mut on_gpu =
                GpuForest::new(gpu, forest, lights, settings).unwrap_or_else(|error| panic!("{error}"));
            let trace = |on_gpu: &mut GpuForest| {
                on_gpu.trace(&view).unwrap_or_else(|error| panic!("{error}"));
                on_gpu.wait().unwrap_or_else(|error| panic!("{error}"));
            };
            let mut relight = |on_gpu: &mut GpuForest| {
                on_gpu.relight(lights, &daylight, &Look::default()).unwrap_or_else(|error| panic!("{error}"));
                on_gpu.wait().unwrap_or_else(|error| panic!("{error}"));
            };
            trace(&mut on_gpu);
            relight(&mut on_gpu);
            let times =
                [shortest(best_of, || trace(&mut on_gpu)), shortest(best_of, || relight(&mut on_gpu))];
            println!(
                "| {model:?} | {instances:?} | {instances:?} | {:.1} | {:.1} | {:.1} |",
                times[0],
                times[1],
                on_gpu.size_bytes()[0] as f64 / 1e6
            );
        }
    }
    println!();
}

fn blend(instance: &Placement, sun: [f64; 3]) -> sun::SunBlend {
    let rows = &instance.transform.rotation;
    let in_model = std::array::from_fn(|column| (0..3).map(|row| rows[row][column] * sun[row]).sum());
    sun::blend(in_model).expect("a direction")
}

/// Milliseconds of the shortest of some runs.
fn shortest(best_of: usize, mut work: impl FnMut()) -> f64 {
    let mut run = || {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..best_of.max(1)).map(|_| run()).fold(f64::INFINITY, f64::min)
}
