//! Tables 6.2, 6.3, 6.6 and 6.7, and what a sample costs: a tree and a forest in the light of files.

use flb_format::sun::towards_sun;
use flb_format::{Placement, Transform};
use flb_render::Indirect;
use flb_render::forest::Eye;
use flb_runtime::SpeciesLight;
use flb_tests::portrait::distance;
use rayon::ThreadPoolBuilder;

use crate::Scale;
use crate::light::{Lit, suns};
use crate::species::{Plant, WAYS};

/// Edge of the square that the papers' number of plants stands in, metres.
const EDGE_M: f64 = 120.0;

/// What the papers say of a scene, milliseconds.
struct Theirs {
    scene: &'static str,
    tables: &'static str,
    /// `[workers: 1, 2, 4]`: to render with 1 and 4 rays a pixel, to relight with 1 and 4.
    times: [[u32; 4]; 3],
    /// Primary rays, shadow rays, uncoded light: 4 rays a pixel, one GPU.
    parts: [u32; 3],
    /// Of uncoded and of coded light, at 1024 x 1024.
    samples: [u32; 2],
    /// Rays a pixel of those; of the tree they do not say how many.
    sample_rays: u32,
    rms: &'static str,
}

const TREE: Theirs = Theirs {
    scene: "tree",
    tables: "6.2 and 6.3",
    times: [[140, 477, 72, 258], [76, 244, 40, 150], [43, 154, 23, 96]],
    parts: [217, 162, 51],
    samples: [23, 53],
    sample_rays: 1,
    rms: "0.0136",
};
const FOREST: Theirs = Theirs {
    scene: "forest",
    tables: "6.6 and 6.7",
    times: [[628, 2000, 259, 858], [337, 1003, 132, 432], [176, 540, 73, 247]],
    parts: [1175, 613, 191],
    samples: [60, 120],
    sample_rays: 4,
    rms: "0.00843",
};

pub(crate) fn tree(plant: &Plant, scale: &Scale) {
    let alone = Placement { species: 0, transform: Transform::IDENTITY };
    let eye = Eye { position_m: [0.0, 6.0, 18.0], look_at_m: [0.0, 5.0, 0.0], fov_deg: 45.0 };
    tables(&TREE, &[plant], vec![alone], eye, scale);
}

pub(crate) fn forest(plants: &[Plant], scale: &Scale) {
    let eye = Eye { position_m: [0.0, 22.0, 75.0], look_at_m: [0.0, 2.0, 0.0], fov_deg: 45.0 };
    tables(&FOREST, &plants.iter().collect::<Vec<_>>(), stand(plants), eye, scale);
}

fn tables(theirs: &Theirs, plants: &[&Plant], instances: Vec<Placement>, eye: Eye, scale: &Scale) {
    let triangles: usize = instances.iter().map(|one| plants[one.species].triangles()).sum();
    let Theirs { scene, tables, .. } = theirs;
    let [edge, wide] = scale.edges;
    println!("Tables {tables}: {scene}, {} plants, {triangles} triangles.\n", instances.len());
    let lit = Lit::new(plants, instances, eye);
    let load = |way: usize| -> Vec<SpeciesLight> {
        plants.iter().map(|plant| SpeciesLight::load(&plant.files[way], 0).expect("a sound file")).collect()
    };
    let lights = [0, 1, 2].map(load);
    let suns = suns(scale.suns);
    println!("Milliseconds, mean of {} suns, {edge} x {edge}:\n", suns.len());
    println!(
        "| workers | rays | trace | relight, {} | relight, {} | relight, {} | theirs, trace and relight | theirs, relight |",
        WAYS[0], WAYS[1], WAYS[2]
    );
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|");
    let mut parts = String::new();
    for (row, workers) in [1, 2, 4].into_iter().enumerate() {
        if workers > rayon::current_num_threads() {
            let [whole_1, whole_4, relit_1, relit_4] = theirs.times[row];
            println!("| {workers} | 1 | - | - | - | - | {whole_1} | {relit_1} |");
            println!("| {workers} | 4 | - | - | - | - | {whole_4} | {relit_4} |");
            continue;
        }
        let pool = ThreadPoolBuilder::new().num_threads(workers).build().expect("threads");
        for (which, samples) in [1, 4].into_iter().enumerate() {
            let mean = |way: usize, fragments: &_, indirect| {
                let seconds = suns.iter().map(|sun| lit.relight(fragments, &lights[way], *sun, indirect).1);
                1e3 * seconds.sum::<f64>() / suns.len() as f64
            };
            let (traced, relit, apart) = pool.install(|| {
                let (fragments, traced) = lit.trace(edge, samples);
                let relit = [0, 1, 2].map(|way| mean(way, &fragments, Indirect::On));
                // What the papers split into parts.
                let apart = (workers == 1 && samples == 4)
                    .then(|| [Indirect::Off, Indirect::Only].map(|part| mean(0, &fragments, part)));
                (1e3 * traced, relit, apart)
            });
            let [floats, theirs_coded, ours] = relit;
            let (whole, again) = (theirs.times[row][which], theirs.times[row][2 + which]);
            println!(
                "| {workers} | {samples} | {traced:.0} | {floats:.0} | {theirs_coded:.0} | {ours:.0} | {whole} | {again} |"
            );
            if let Some([shadow, light]) = apart {
                let [primary, their_shadow, their_light] = theirs.parts;
                parts = format!(
                    "| {scene} | {traced:.0} | {shadow:.0} | {light:.0} | {primary} | {their_shadow} | {their_light} |"
                );
            }
        }
    }
    println!("\nIn parts: 4 rays, one worker, light as floats.\n");
    println!("| scene | primary | shadow, direct | light | theirs: primary | shadow | light, direct |");
    println!("|---|---:|---:|---:|---:|---:|---:|\n{parts}\n");
    let prepared = suns.iter().map(|sun| lit.prepare(edge, &lights[2], *sun));
    let [picture, sun, light] =
        prepared.fold([0.0; 3], |sum, one| std::array::from_fn(|at| sum[at] + one[at]));
    let mean = |seconds: f64| 1e3 * seconds / suns.len() as f64;
    println!(
        "To prepare for a frame, one thread, ms: {:.2} for the grid over the picture, {:.2} for the one across the sun's \
         rays, {:.2} for the light of all plants ({}).\n",
        mean(picture),
        mean(sun),
        mean(light),
        WAYS[2]
    );
    samples(theirs, &lit, &lights, wide);
}

/// What light costs where nothing else is done, and how far coded light is off.
fn samples(theirs: &Theirs, lit: &Lit<'_>, lights: &[Vec<SpeciesLight<'_>>; 3], edge: u32) {
    let rays = theirs.sample_rays;
    let (fragments, _) = lit.trace(edge, rays);
    let sun = [135.0, 50.0];
    let best = |way: usize| {
        let seconds = (0..3).map(|_| lit.relight(&fragments, &lights[way], sun, Indirect::Only).1);
        seconds.fold(f64::INFINITY, f64::min)
    };
    let seconds = [0, 1, 2].map(best);
    let picture = |way: usize| lit.relight(&fragments, &lights[way], sun, Indirect::On).0.tone_mapped(0.0);
    let eight_bits = [0, 1, 2].map(picture);
    let [plain, coded] = theirs.samples;
    println!(
        "Light alone, {edge} x {edge}, {rays} rays, all threads; rms of whole pictures, 8 bits, of 1:\n"
    );
    println!("| light | ms | times floats | rms | theirs: ms | times floats | rms |");
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for (way, name) in WAYS.iter().enumerate() {
        let their = match way {
            0 => format!("{plain} | 1 | 0"),
            1 => format!("{coded} | {:.1} | {}", f64::from(coded) / f64::from(plain), theirs.rms),
            _ => "- | - | -".to_owned(),
        };
        println!(
            "| {name} | {:.0} | {:.2} | {:.5} | {their} |",
            1e3 * seconds[way],
            seconds[way] / seconds[0],
            distance(&eight_bits[way], &eight_bits[0]).rms / 255.0
        );
    }
    println!();
}

/// Evenly spread (the additive sequence of the plastic number), species mixed.
fn stand(plants: &[Plant]) -> Vec<Placement> {
    let share = |i: usize, step: f64| (0.5 + step * i as f64).fract();
    let mut species: Vec<usize> =
        plants.iter().enumerate().flat_map(|(number, plant)| vec![number; plant.instances]).collect();
    let count = species.len();
    // As far apart as the papers' number of plants.
    let edge_m = EDGE_M * libm::sqrt(count as f64 / 424.0);
    for i in (1..count).rev() {
        species.swap(i, (share(i, 0.618_033_988_75) * (i + 1) as f64) as usize);
    }
    let place = |(i, species): (usize, usize)| {
        let [sin, _, minus_cos] = towards_sun(360.0 * share(i, 0.618_033_988_75), 0.0);
        let rotation = [[-minus_cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, -minus_cos]];
        let [x, z] = [share(i, 0.754_877_666_25), share(i, 0.569_840_290_99)].map(|at| (at - 0.5) * edge_m);
        let scale = 0.8 + 0.4 * share(i, 0.819_172_513_4);
        Placement { species, transform: Transform { rotation, position_m: [x, 0.0, z], scale } }
    };
    species.into_iter().enumerate().map(place).collect()
}
