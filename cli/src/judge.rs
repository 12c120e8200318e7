//! `flb judge`: the light of a file against paths traced on the mesh.

use std::path::Path;

use flb_eval::figures::OPENNESS;
use flb_eval::{
    ClassJudgement, Figures, JudgePicture, MeshJudge, MeshJudgement, judged_points, judged_surfaces,
};
use flb_files::{Existing, check_unread};
use flb_format::provenance::IGNORE_ALPHA;
use flb_runtime::SpeciesLight;
use flb_scene::Step;
use flb_stage::plant::PlantLight;
use flb_transport::monte_carlo::judge::suns;
use serde::Serialize;

use crate::args::JudgeArgs;
use crate::exit::Failure;
use crate::folder::{check_folder, publish_all};
use crate::inputs::{choose_species, open};
use crate::memory::{check, sampler_bytes};
use crate::mesh_of_light::{MeshOfLight, mesh_of_species};
use crate::print::{self, line, table};
use crate::stages::{Stage, Stages};

/// Under the sky, and under the first sun.
const PICTURES: [&str; 2] = ["judge-sky.png", "judge-sun.png"];

/// A picture that was written.
#[derive(Serialize)]
struct Pictured {
    file: String,
    /// Number of the source, as in the figures: the first sun, or the sky.
    source: usize,
    /// Difference of radiance, in the mean of the bands, from which red or blue is full.
    full: f32,
}

impl Pictured {
    /// What is said of it.
    fn text(&self) -> String {
        let Pictured { file, source, full } = self;
        let of = if *source == 0 { "the first sun" } else { "the sky" };
        line!(
            "{file}: baked, path traced and difference under {of}; red: baked is brighter, blue: darker, full from \
             {full:.2e}, the plant's mean radiance in truth"
        )
    }
}

/// What `--json` prints (cli/schema/judge.json).
#[derive(Serialize)]
struct Report {
    file: String,
    species: String,
    mesh: String,
    /// Points of the plant's surface that light was compared at.
    points: usize,
    /// Paths from each side of each.
    samples: u32,
    /// Unit vectors towards the suns, model space.
    suns: Vec<[f64; 3]>,
    /// Where each group of `by_openness` ends.
    openness: [f32; 4],
    #[serde(flatten)]
    judged: MeshJudgement,
    /// With `--picture`.
    pictures: Vec<Pictured>,
    stages: Vec<Stage>,
}

/// Reads file and mesh, traces the truth, compares, draws, prints.
pub(crate) fn run(args: &JudgeArgs) -> Result<u8, Failure> {
    if let Some(folder) = &args.picture {
        check_folder(folder, &PICTURES, &[&args.file, &args.mesh], args.existing)?;
    }
    let library = open(&args.file)?;
    let stem = args.mesh.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let index = choose_species(&library, args.species.as_deref(), stem.as_deref())?;
    let library = PlantLight::shown(library, index, &args.bands.show_bands)?.library;
    let species = &library.container().species()[index];
    let meta = &species.meta;
    let surfaces = judged_surfaces(meta).map_err(|error| Failure::from(error).at(library.path()))?;
    check(&library, &format!("the bases of species {:?}", meta.name), sampler_bytes(species), &args.memory)?;
    let stages = Stages::default();
    let MeshOfLight { mesh: classed, .. } = stages.run(Step::Import, &meta.name, |_| {
        mesh_of_species(&args.mesh, meta, args.gltf_mesh.as_deref(), args.mesh_differs)
    })?;
    if let Some(folder) = &args.picture {
        // Textures and buffers are known only now.
        PICTURES.iter().try_for_each(|name| check_unread(&folder.join(name)))?;
    }
    let ignore_alpha = meta.recorded(&IGNORE_ALPHA) == Some(true);
    let points = judged_points(&classed, args.points, ignore_alpha)
        .map_err(|error| Failure::from(error).at(&args.mesh))?;
    let suns = suns(args.suns as usize);
    let light = SpeciesLight::load_for(&library, index, suns.iter().copied(), true)?;
    let judge = MeshJudge::new(&light, surfaces, points, suns, &stages)
        .map_err(|error| Failure::from(error).at(library.path()))?;
    let mut drawn = Vec::new();
    if args.picture.is_some() {
        for source in [judge.suns().len(), 0] {
            drawn.push(judge.picture(&classed, source, args.size.unwrap_or([512; 2]), &stages)?);
        }
    }
    let judged = judge
        .judge(&classed, args.samples, &meta.name, &stages)
        .map_err(|error| Failure::from(error).at(&args.mesh))?;
    let pictures = match &args.picture {
        None => Vec::new(),
        Some(folder) => publish(folder, drawn, args.existing)?,
    };
    let report = Report {
        file: args.file.display().to_string(),
        species: meta.name.clone(),
        mesh: args.mesh.display().to_string(),
        points: judge.points().len(),
        samples: args.samples,
        suns: judge.suns().to_vec(),
        openness: OPENNESS,
        judged,
        pictures,
        stages: stages.list(),
    };
    match args.json {
        true => print::json(&report)?,
        false => print::out(&text(&report))?,
    }
    Ok(0)
}

/// Writes the pictures, all or none.
fn publish(folder: &Path, drawn: Vec<JudgePicture>, existing: Existing) -> Result<Vec<Pictured>, Failure> {
    let (mut files, mut pictures) = (Vec::new(), Vec::new());
    for (name, JudgePicture { source, full, png }) in PICTURES.into_iter().zip(drawn) {
        files.push((name, png));
        pictures.push(Pictured { file: folder.join(name).display().to_string(), source, full });
    }
    publish_all(folder, &files, existing)?;
    Ok(pictures)
}

/// What is said without `--json`.
fn text(report: &Report) -> String {
    let Report { file, species, mesh, points, samples, suns, judged, .. } = report;
    let head = line!(
        "{file}: {species} on {mesh}, {points} points, {} suns and the sky, {samples} paths a side",
        suns.len()
    );
    let mut rows = vec![
        ["", "pairs", "truth", "+-", "baked/truth R", "G", "B", "rms R", "G", "B", "99 %"]
            .map(str::to_owned)
            .to_vec(),
    ];
    let mut worst = String::new();
    for (class, judged) in [("leaf", &judged.leaf), ("wood", &judged.wood)] {
        let Some(judged) = judged else { continue };
        for (name, figures) in groups(judged) {
            rows.push(row(&format!("{class}, {name}"), figures));
        }
        let most = [&judged.suns, &judged.sky].into_iter().flatten().max_by(|a, b| off(a).total_cmp(&off(b)));
        if let Some(Figures { worst: pair, .. }) = most {
            let [x, y, z] = pair.point_m;
            let of =
                if pair.source == suns.len() { "the sky".to_owned() } else { format!("sun {}", pair.source) };
            worst += &line!(
                "worst of {class}: at {x:.3}, {y:.3}, {z:.3} m, material {}, of {of}: {:.4} where {:.4} is true (G)",
                pair.material,
                pair.found[1],
                pair.truth[1]
            );
        }
    }
    let pictures: String = report.pictures.iter().map(Pictured::text).collect();
    head + &table(&rows) + &worst + &pictures
}

fn off(figures: &Figures) -> f64 {
    (figures.worst.found[1] - figures.worst.truth[1]).abs()
}

fn groups(judged: &ClassJudgement) -> Vec<(String, &Figures)> {
    let named =
        [("suns", &judged.suns), ("sky", &judged.sky)].map(|(name, figures)| (name.to_owned(), figures));
    let depths = judged.by_openness.iter().enumerate().map(|(group, figures)| {
        let from = if group == 0 { 0.0 } else { OPENNESS[group - 1] };
        (format!("{:.0} to {:.0} % of the sky seen", 100.0 * from, 100.0 * OPENNESS[group]), figures)
    });
    let sides = [
        ("each side", &judged.sides),
        ("as either side is seen", &judged.seen),
        ("so, if sides were told apart", &judged.seen_with_sides),
    ];
    let sides = sides.map(|(name, figures)| (name.to_owned(), figures));
    let all = named.into_iter().chain(depths).chain(sides);
    all.filter_map(|(name, figures)| figures.as_ref().map(|figures| (name, figures))).collect()
}

fn row(name: &str, figures: &Figures) -> Vec<String> {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let [_, truth, _] = figures.truth;
    let mut cells = vec![name.to_owned(), figures.count.to_string(), format!("{truth:.4}")];
    cells.push(percent(figures.truth_error[1] / truth));
    cells.extend(figures.ratio.map(|ratio| format!("{ratio:.3}")));
    cells.extend(figures.rms.map(percent));
    cells.push(percent(figures.percentile_99));
    cells
}
