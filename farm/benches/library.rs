//! Libraries of species: how long it takes to see that nothing changed, to plan a hundred thousand, what two at once
//! gain, what scheduler and store take beside the bakes, and how much memory a bake takes of what was expected.
//!
//! `cargo bench -p flb-farm --bench library -- [plan|unchanged|jobs|memory]...`, by default all. Ratios are of
//! runs side by side.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use flb_baker::bake::NoStore;
use flb_farm::build::{BuildObserver, BuildSettings, OnFailure, build};
use flb_farm::cache::{Cache, Place, Tell};
use flb_farm::digests::{Digests, Trust};
use flb_farm::job::Job;
use flb_farm::make::{Listener, make};
use flb_farm::{Manifest, Plan};
use flb_fixtures::{PlantKind, grow};

/// Species of which none changed.
const UNCHANGED: usize = 500;
/// Species that are planned alone.
const PLANNED: usize = 100_000;
/// Species that are baked, and sites along the edges of their lattices.
const BAKED: u64 = 12;
const LATTICE: u32 = 64;
const TRIANGLES: u32 = 4_000;

/// Time after which digests of a file are kept.
const SETTLED: Duration = Duration::from_secs(3);

struct Quiet;
impl BuildObserver for Quiet {}
impl Listener for Quiet {}

fn settings(jobs: usize, threads: usize) -> BuildSettings {
    let memory_bytes = 16 << 30;
    BuildSettings { jobs, threads, memory_bytes, only: Vec::new(), on_failure: OnFailure::Stop }
}

fn cache_of<'t>(folder: &Path, tell: Tell<'t>) -> Cache<'t> {
    Cache::open(Some(&Place::Folder(folder.join("cache"))), tell).expect("a cache")
}

/// Builds a folder's library; returns the seconds.
fn run(folder: &Path, settings: &BuildSettings, trust: Trust) -> f64 {
    let begin = Instant::now();
    let manifest = Manifest::read(&folder.join("library.toml")).expect("a manifest");
    let tell = |told: &str| println!("{told}");
    let store = cache_of(folder, &tell);
    let summary = build(&manifest, settings, (&store, trust), &Quiet).expect("a library");
    assert_eq!(summary.failed().count(), 0);
    begin.elapsed().as_secs_f64()
}

fn clear(folder: &Path) {
    for name in ["library", "cache"] {
        if folder.join(name).exists() {
            fs::remove_dir_all(folder.join(name)).expect("our own folder");
        }
    }
}

/// Largest memory of this process so far, in bytes, where the system tells.
fn peak_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes << 10)
}

fn plan_many(folder: &Path) {
    let mut text = "[bake]\nquality = 'draft'\n".to_owned();
    for number in 0..PLANNED {
        let _ = write!(text, "[[species]]\nname = 'oak-{number}'\nmesh = 'card.glb'\n");
    }
    fs::write(folder.join("library.toml"), text).expect("a file");
    let begin = Instant::now();
    let manifest = Manifest::read(&folder.join("library.toml")).expect("a manifest");
    let tell = |told: &str| println!("{told}");
    let store = cache_of(folder, &tell);
    let digests = Digests::open(&store, Trust::SizeAndTime);
    let plan = Plan::of(&manifest, &store, &digests);
    assert_eq!(plan.species.len(), PLANNED);
    let peak = peak_bytes().map_or("?".to_owned(), |bytes| format!("{:.2}", bytes as f64 / 1e9));
    println!("{PLANNED} species planned in {:.2} s, {peak} GB at most", begin.elapsed().as_secs_f64());
}

fn unchanged(folder: &Path) {
    let mut text = "[bake]\nquality = 'draft'\nlattice = 16\nvoxels = 64\n".to_owned();
    for number in 0..UNCHANGED {
        fs::copy(folder.join("card.glb"), folder.join(format!("{number}.glb"))).expect("room");
        let _ = write!(text, "[[species]]\nmesh = '{number}.glb'\n");
    }
    fs::write(folder.join("library.toml"), text).expect("a file");
    let built_s = run(folder, &settings(2, 2), Trust::SizeAndTime);
    std::thread::sleep(SETTLED);
    run(folder, &settings(2, 2), Trust::SizeAndTime);
    let again_s = run(folder, &settings(2, 2), Trust::SizeAndTime);
    let read_s = run(folder, &settings(2, 2), Trust::Nothing);
    println!(
        "{UNCHANGED} tiny species built in {built_s:.1} s; none changed: {again_s:.2} s; every file read: {read_s:.2} s"
    );
}

fn two_at_once(folder: &Path) {
    clear(folder);
    let mut text = format!("[bake]\nlattice = {LATTICE}\n");
    for seed in 0..BAKED {
        let plant = grow(PlantKind::Shrub, seed + 1, TRIANGLES).expect("enough triangles");
        fs::write(folder.join(format!("shrub-{seed}.glb")), plant.to_glb()).expect("room");
        let _ = write!(text, "[[species]]\nmesh = 'shrub-{seed}.glb'\n");
    }
    fs::write(folder.join("library.toml"), text).expect("a file");
    let one_s = run(folder, &settings(1, 1), Trust::SizeAndTime);
    clear(folder);
    let two_s = run(folder, &settings(2, 2), Trust::SizeAndTime);
    let manifest = Manifest::read(&folder.join("library.toml")).expect("a manifest");
    let nothing = Cache::none(&|_| {});
    let digests = Digests::open(&nothing, Trust::Nothing);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let begin = Instant::now();
    for entry in &manifest.species {
        let job = Job::new(entry, &digests).expect("a job");
        pool.install(|| make(&job, &NoStore, &Quiet)).expect("a species");
    }
    let bare_s = begin.elapsed().as_secs_f64();
    println!(
        "{BAKED} species at lattice {LATTICE}: one at a time {one_s:.1} s, two at once {two_s:.1} s: {:.2} times as fast",
        one_s / two_s
    );
    println!(
        "scheduler and store over the bare bakes ({bare_s:.1} s): {:+.1} %",
        100.0 * (one_s / bare_s - 1.0)
    );
}

/// Word by which this program bakes the library of a folder, in a process of its own, and prints its largest memory.
const ALONE: &str = "alone";

/// Largest memory of a process that bakes the library of a folder, in bytes.
fn taken_bytes(folder: &Path) -> u64 {
    let this = std::env::current_exe().expect("the path of this program");
    let output = std::process::Command::new(this).arg(ALONE).arg(folder).output().expect("this program runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.trim().parse().unwrap_or_else(|_| panic!("{text}{}", String::from_utf8_lossy(&output.stderr)))
}

/// Memory that was expected, before and after a first bake, and that was taken.
fn memory(folder: &Path) {
    println!("plant   lattice  quality    expected MB  known sites MB  taken MB  taken over known");
    for (kind, triangles) in
        [(PlantKind::Shrub, 4_000), (PlantKind::Oak, 80_000), (PlantKind::Spruce, 40_000)]
    {
        for (lattice, quality) in
            [(32, "standard"), (64, "standard"), (128, "standard"), (64, "draft"), (64, "papers")]
        {
            clear(folder);
            let plant = grow(kind, 1, triangles).expect("enough triangles");
            fs::write(folder.join("plant.glb"), plant.to_glb()).expect("room");
            let text = format!(
                "[[species]]\nmesh = 'plant.glb'\nbake = {{ quality = '{quality}', lattice = {lattice} }}\n"
            );
            fs::write(folder.join("library.toml"), text).expect("a file");
            let expected = || {
                let manifest = Manifest::read(&folder.join("library.toml")).expect("a manifest");
                let nothing = Cache::none(&|_| {});
                let plan = Plan::of(&manifest, &nothing, &Digests::open(&nothing, Trust::Nothing));
                plan.species[0].memory_bytes as f64 / 1e6
            };
            let before = expected();
            let taken = taken_bytes(folder) as f64 / 1e6;
            let known = expected();
            println!(
                "{kind:<7?} {lattice:>7}  {quality:<9} {before:>12.0} {known:>15.0} {taken:>9.0} {:>17.2}",
                taken / known
            );
        }
    }
}

/// Name of what is measured, and how.
type Part = (&'static str, fn(&Path));

fn main() {
    // Cargo adds --bench.
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if let [word, folder] = &wanted[..]
        && word == ALONE
    {
        run(Path::new(folder), &settings(1, 2), Trust::SizeAndTime);
        println!("{}", peak_bytes().unwrap_or(0));
        return;
    }
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    let card = grow(PlantKind::LeafCard, 1, 2).expect("enough triangles");
    fs::write(folder.join("card.glb"), card.to_glb()).expect("room");
    // Digests of files that were written just now are not kept.
    std::thread::sleep(SETTLED);
    let parts: [Part; 4] =
        [("plan", plan_many), ("unchanged", unchanged), ("jobs", two_at_once), ("memory", memory)];
    for (name, part) in parts {
        if wanted.is_empty() || wanted.iter().any(|word| word == name) {
            part(folder);
        }
    }
}
