//! How far the `physical` model is from Monte Carlo in the same medium: `cargo bench -p flb-baker --bench gates --
//! [spheres] [quick] [uncut] [lattice=N] [albedo=A] [only=SUNS] [FILE[@METRES] ...]`. Spheres, and the plants of the
//! mesh files (the built-in oak without any) at lattice 32 and 64, under an axial, a diagonal and 20 random suns. The
//! noise of Monte Carlo is removed by two seeds.

use std::path::Path;
use std::time::Instant;

use flb_baker::crown::{CrownSettings, LeafAngleChoice, measure_crown};
use flb_baker::{VoxelSettings, downsample, voxelise};
use flb_fixtures::{PlantKind, grow};
use flb_format::Grid;
use flb_format::beam::BEAM_RAYS;
use flb_scene::classify::classify;
use flb_scene::import::import;
use flb_scene::{ClassRules, ImportSettings, MaterialClass, Mesh};
use flb_transport::monte_carlo::judge::{Judgement, MAX_SUNS, Truth, suns};
use flb_transport::ordinates::{self, Ordinates, OrdinatesSettings, SunBasis, ico12, ico42, rays_for};
use flb_transport::turbid::{BandScatter, LeafAngles, Phase, Scatter, TurbidMedium};

/// What is judged.
fn presets() -> Vec<(&'static str, OrdinatesSettings)> {
    let only: Vec<String> =
        std::env::args().filter_map(|word| word.strip_prefix("only=").map(str::to_owned)).collect();
    let sh = |degree| SunBasis::Harmonics { degree, single: false, leaning: true };
    let single = |degree| SunBasis::Harmonics { degree, single: true, leaning: true };
    let of =
        |suns, ordinates, parts| OrdinatesSettings { suns, ordinates, parts, ..OrdinatesSettings::default() };
    let (fine, fair, coarse) = (Ordinates::Lebedev110, Ordinates::Lebedev50, Ordinates::Lattice18);
    let all = vec![
        ("lattice18, 18", of(SunBasis::Lattice18, coarse, 1)),
        ("lattice18, 110", of(SunBasis::Lattice18, fine, 1)),
        ("ico12, 110", of(ico12(), fine, 1)),
        ("ico42, 110", of(ico42(), fine, 1)),
        ("sh1, 50", of(sh(1), fair, 1)),
        ("sh1, 110", of(sh(1), fine, 1)),
        ("sh1s, 50", of(single(1), fair, 1)),
        ("sh1s, 110", of(single(1), fine, 1)),
        ("sh2, 110", of(sh(2), fine, 1)),
        ("sh2s, 110", of(single(2), fine, 1)),
        ("sh3, 110", of(sh(3), fine, 1)),
        ("sh3s, 110", of(single(3), fine, 1)),
        ("sh1s, 110, cut", of(single(1), fine, 2)),
        ("sh2s, 110, cut", of(single(2), fine, 2)),
        ("sh3, 110, cut", of(sh(3), fine, 2)),
        ("sh3s, 110, cut", of(single(3), fine, 2)),
    ];
    let wanted = |name: &str| only.is_empty() || only.iter().any(|only| name.starts_with(only));
    let uncut = std::env::args().any(|word| word == "uncut");
    all.into_iter().filter(|(name, settings)| wanted(name) && (!uncut || settings.parts == 1)).collect()
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let quick = words.iter().any(|word| word == "quick");
    let files: Vec<&String> = words
        .iter()
        .filter(|word| !["quick", "spheres", "uncut"].contains(&word.as_str()) && !word.contains('='))
        .collect();
    let wanted = |key: &str, value: f64| {
        let mut values = words.iter().filter_map(|word| word.strip_prefix(key)?.strip_prefix('=')).peekable();
        values.peek().is_none() || values.any(|word| word.parse() == Ok(value))
    };
    let suns = suns(if quick { 5 } else { MAX_SUNS });
    println!(
        "rms and bias in % of the mean total fluence over the non-empty sites, all suns; worst sun in brackets\n"
    );
    if words.iter().any(|word| word == "spheres") {
        for depth in [1.0, 3.0, 10.0] {
            let medium = sphere(depth);
            for albedo in [0.9, 0.3] {
                for g in [0.0, 0.5] {
                    let phase = Phase::HenyeyGreenstein { g };
                    let name = format!("sphere, depth {depth}, albedo {albedo}, g {g}");
                    judge(
                        &name,
                        &medium,
                        Scatter { albedo, phase },
                        &suns,
                        if quick { 1 << 18 } else { 1 << 20 },
                    );
                }
            }
        }
    }
    let mut plants: Vec<(String, Mesh)> = files.iter().map(|file| read(file)).collect();
    if plants.is_empty() && !words.iter().any(|word| word == "spheres") {
        plants.push(built_in());
    }
    for (name, mesh) in &plants {
        for lattice in [32, 64].into_iter().filter(|lattice| wanted("lattice", f64::from(*lattice))) {
            let medium = crown(mesh, lattice);
            for albedo in [0.9, 0.3].into_iter().filter(|albedo| wanted("albedo", *albedo)) {
                let scatter = Scatter { albedo, phase: Phase::ISOTROPIC };
                let title = format!("{name}, lattice {lattice}, albedo {albedo}");
                judge(&title, &medium, scatter, &suns, if quick { 1 << 17 } else { 1 << 18 });
            }
        }
    }
}

fn judge(name: &str, medium: &TurbidMedium, scatter: Scatter, suns: &[[f64; 3]], photons: u64) {
    let sites = medium.sites();
    let scatter = BandScatter { leaf: scatter, wood: scatter };
    let start = Instant::now();
    let near = [false, true].map(|single| ordinates::near(medium, &sites, single));
    let trace = |sun: &[f64; 3]| {
        Truth::trace(medium, &near, &[scatter], None, *sun, photons, &|_| Ok(()))
            .expect("the medium is valid")
    };
    let truth: Vec<Truth> = suns.iter().map(trace).collect();
    println!("## {name}: {} sites, Monte Carlo {:.0} s", sites.len(), start.elapsed().as_secs_f64());
    let direct = suns.iter().flat_map(|sun| near[0].beam(*sun, BEAM_RAYS).beam.mean);
    let direct = direct.map(f64::from).sum::<f64>() / (suns.len() * sites.len()) as f64;
    for (preset, settings) in presets() {
        let rays = rays_for(medium.grid.lattice, settings.parts);
        let settings = OrdinatesSettings { rays, ..settings };
        let start = Instant::now();
        let solution =
            ordinates::solve(medium, &[scatter], &settings, &|_| Ok(())).expect("the medium is valid");
        let seconds = start.elapsed().as_secs_f64();
        let of_sun =
            |truth: &Truth| truth.difference(&solution, &settings, 0, &sites).expect("fields are finite");
        let differences: Vec<_> = truth.iter().map(of_sun).collect();
        let Judgement { rms, worst, bias, .. } = Judgement::over(&differences).expect("there are suns");
        let held_out = solution.reports[0]
            .suns_rms
            .map_or(String::new(), |rms| format!(", held out {:.2}", 100.0 * rms));
        // The sky is the mean over all suns.
        let sky = solution.fields[0].1.band(0);
        let total = sites.iter().map(|&site| f64::from(sky[site as usize])).sum::<f64>() / sites.len() as f64;
        let of_scattered = rms * total / (total - direct);
        println!(
            "{preset:16} rms {:5.2} ({:5.2}) bias {:+.2}{held_out}; rms in % of the scattered light {:.1}; {} fields, {seconds:.2} s",
            100.0 * rms,
            100.0 * worst,
            100.0 * bias,
            100.0 * of_scattered,
            solution.fields.len()
        );
    }
    println!();
}

/// A ball of 27 sites across in the middle of 32^3.
fn sphere(depth: f64) -> TurbidMedium {
    let grid = Grid { lattice: 32, origin_m: [0.0; 3], spacing_m: 1.0 };
    let inside = |i: usize| {
        let from_middle = grid.site(i).map(|c| f64::from(c) + 0.5 - 16.0);
        from_middle.iter().map(|c| c * c).sum::<f64>() < 13.5 * 13.5
    };
    let extinction = |i| if inside(i) { (depth / 27.0) as f32 } else { 0.0 };
    let leaf_per_m: Vec<f32> = (0..grid.sites()).map(extinction).collect();
    TurbidMedium {
        grid,
        wood_per_m: vec![0.0; leaf_per_m.len()],
        leaf_per_m,
        angles: LeafAngles::spherical(),
    }
}

fn classes(mesh: &Mesh) -> Vec<MaterialClass> {
    let classified = classify(mesh, &ClassRules::default()).expect("the materials' names tell");
    classified.iter().map(|c| c.class).collect()
}

fn crown(mesh: &Mesh, lattice: u32) -> TurbidMedium {
    let classes = classes(mesh);
    let voxels = VoxelSettings { voxels: 512, lattice, ignore_alpha: false };
    let occupancy = voxelise(mesh, &classes, &voxels, &|_| Ok(())).expect("the mesh has triangles");
    let medium = downsample(&occupancy).expect("an occupancy downsamples");
    let crown = measure_crown(
        mesh,
        &classes,
        &medium,
        &CrownSettings { ignore_alpha: false, angles: LeafAngleChoice::Measured },
        &|_| Ok(()),
    );
    crown.expect("the mesh has leaves").turbid
}

/// `FILE` or `FILE@METRES`, metres per unit.
fn read(word: &str) -> (String, Mesh) {
    let (file, unit_m) = match word.rsplit_once('@') {
        Some((file, unit)) => (file, Some(unit.parse().expect("metres per unit"))),
        None => (word, None),
    };
    let mesh = import(Path::new(file), &ImportSettings { unit_m, ..ImportSettings::default() });
    let name =
        Path::new(file).file_stem().map_or(word.to_owned(), |stem| stem.to_string_lossy().into_owned());
    (name, mesh.unwrap_or_else(|error| panic!("{error}")))
}

fn built_in() -> (String, Mesh) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("oak.glb");
    let oak = grow(PlantKind::Oak, 1, 80_000).expect("the count is within the limits");
    std::fs::write(&path, oak.to_glb()).expect("a temporary file");
    read(&path.display().to_string())
}
