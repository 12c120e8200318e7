//! The tables of Steele and Geist with ours beside them: `cargo bench -p flb-tests --bench papers`.
//!
//! Prints what `docs/papers.md` holds: the optics, the solves, the bytes of each species by the papers' codec and by
//! ours, what a tree and a forest take to trace and to relight by each, what a sample costs, and what blocks without
//! their forward neighbours would take. The tree has 316,000 triangles and the forest 424 plants of 5 species and 109
//! million, each with real light of 128^3 sites, at 512 x 512. A quarter of an hour and 8 GB. `-- quick` takes coarse
//! plants, lattices of 32 and four suns: a minute. Words behind `--` choose parts: `optics`, `solve`, `bytes`, `tree`,
//! `forest`, `neighbours`.

mod light;
mod neighbours;
mod solves;
mod species;
mod stands;

use flb_format::matter::{BandOptics, Optics};
use species::Plant;

/// Size of everything that is measured.
pub(crate) struct Scale {
    pub lattice: u32,
    pub voxels: u32,
    /// Share of the papers' triangles and plants.
    pub share: f64,
    pub suns: usize,
    /// Pixels of an edge where a picture is timed, and where samples are.
    pub edges: [u32; 2],
}

const FULL: Scale = Scale { lattice: 128, voxels: 1024, share: 1.0, suns: 24, edges: [512, 1024] };
const QUICK: Scale = Scale { lattice: 32, voxels: 256, share: 0.05, suns: 4, edges: [128, 128] };
const PARTS: [&str; 6] = ["optics", "solve", "bytes", "tree", "forest", "neighbours"];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let is_known = |word: &&String| *word == "quick" || PARTS.contains(&word.as_str());
    if let Some(word) = words.iter().find(|word| !is_known(word)) {
        panic!("found {word:?}, expected quick or some of {PARTS:?}");
    }
    let scale = if words.iter().any(|word| word == "quick") { QUICK } else { FULL };
    let is_any = words.iter().any(|word| PARTS.contains(&word.as_str()));
    let is_wanted = |part: &str| !is_any || words.iter().any(|word| word == part);
    println!("{} threads, lattice {}\n", rayon::current_num_threads(), scale.lattice);
    if is_wanted("optics") {
        optics();
    }
    if is_wanted("solve") {
        solves::table(&scale);
    }
    let parts = ["bytes", "tree", "forest", "neighbours"].map(is_wanted);
    let [bytes, tree, forest, neighbours] = parts;
    if !parts.contains(&true) {
        return;
    }
    // The medium Catalpa of the papers' forest is their tree as well, and stands last.
    let first = if bytes || forest { 0 } else { species::FOREST.len() - 1 };
    let last = species::FOREST.len() - 1;
    let bake = |number: usize| {
        let (plant, fields) = Plant::bake(&species::FOREST[number], &scale);
        if neighbours && number == last {
            neighbours::table(&fields);
        }
        plant
    };
    let plants: Vec<Plant> = (first..=last).map(bake).collect();
    if bytes {
        species::table(&plants);
    }
    let catalpa = plants.last().expect("a tree");
    if tree {
        stands::tree(catalpa, &scale);
    }
    if forest {
        stands::forest(&plants, &scale);
    }
}

/// Table 6.1.
fn optics() {
    println!("Table 6.1, of the optics that `--model paper` takes by default:\n");
    println!("| | R | G | B | theirs |\n|---|---:|---:|---:|---|");
    let bands = Optics::paper().bands;
    let row = |name: &str, of: fn(&BandOptics) -> f64, theirs: &str| {
        let [r, g, b] = [0, 1, 2].map(|band| of(&bands[band]));
        println!("| {name} | {r:.3} | {g:.3} | {b:.3} | {theirs} |");
    };
    row("sigma_a", |band| band.leaf.sigma_a, "0.109, 0.091, 0.118");
    row("sigma_s", |band| 1.0 - band.leaf.sigma_a, "0.891, 0.909, 0.882");
    row("g", |band| band.leaf.g, "-0.120, 0.091, -0.333");
    println!();
}
