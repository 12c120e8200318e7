//! `flb plan`: from a scene, a sun path or an upright plant to a plan.

use std::path::Path;

use flb_baker::plan::{Need, Outline, Plan, plan};
use flb_files::publish;
use flb_format::bases::BaseSet;
use flb_format::meta::Bounds;
use flb_runtime::Library;
use flb_scene::scene::{HighlightChoice, Scene, SceneSky, SceneSpecies, Sunlight, Suns};
use serde::Serialize;

use crate::args::PlanArgs;
use crate::classes::MeshReader;
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_output, choose_species, read_scene};
use crate::print::{self, line, say};
use flb_baker::bake::{base_list, paper_solves};

/// What `--json` prints (cli/schema/plan.json).
#[derive(Serialize)]
struct Planned {
    output: String,
    reason: String,
    /// Whether some sun of the scene ever shines.
    has_sun: bool,
    /// Bands to bake; null: all.
    bands: Option<Vec<String>>,
    /// For every species, where the plan names none; else null.
    every_species: Option<Bases>,
    species: Vec<PlannedSpecies>,
}

/// Bases and what leaving out the others saves.
#[derive(Serialize)]
struct Bases {
    bases: BaseSet,
    left_out: BaseSet,
    /// Solves per band with the `paper` model, where a bake of everything has 18.
    solves_per_band: u32,
}

#[derive(Serialize)]
struct PlannedSpecies {
    name: String,
    instances: usize,
    #[serde(flatten)]
    bases: Bases,
    /// Null: the bake decides.
    lattice: Option<u32>,
    /// Before the limits of 16 and 256; null too where the camera comes inside the bounds.
    lattice_wanted: Option<u64>,
    /// Largest size of its longest edge; null as above.
    size_px: Option<f64>,
    /// From the camera, there.
    distance_m: Option<f64>,
}

impl Bases {
    fn of(bases: BaseSet) -> Bases {
        Bases { bases, left_out: bases.missing(), solves_per_band: paper_solves(bases) }
    }
}

impl PlannedSpecies {
    fn of(need: &Need) -> PlannedSpecies {
        let seen = need.on_screen;
        PlannedSpecies {
            name: need.name.clone(),
            instances: need.instances,
            bases: Bases::of(need.bases),
            lattice: seen.map(|seen| seen.lattice),
            lattice_wanted: seen.map(|seen| seen.wanted).filter(|wanted| *wanted > 0),
            size_px: seen.map(|seen| seen.size_px).filter(|size| size.is_finite()),
            distance_m: seen.map(|seen| seen.distance_m),
        }
    }
}

/// Reads the scene and the sizes of its species, plans, writes the plan, prints what was found.
pub(crate) fn run(args: &PlanArgs) -> Result<u8, Failure> {
    let inputs: Vec<&Path> = args.scene.as_deref().into_iter().collect();
    check_output(&args.output, &inputs, args.existing)?;
    let json = is_json(&args.output)?;
    let scene = scene(args)?;
    let bounds = match scene.camera {
        Some(_) => scene.species.iter().map(bounds_of).collect::<Result<Vec<_>, _>>()?,
        None => vec![None; scene.species.len()],
    };
    let outline = plan(&scene, &bounds);
    say_what_is_odd(&outline);
    for need in outline.species.iter().filter(|need| need.instances == 0 && scene.camera.is_some()) {
        say!("{}: no instance says how near it comes: its lattice is left to the bake", need.name);
    }
    let plan = Plan::of(&outline)?;
    let bytes = if json { plan.to_json() } else { plan.to_toml().into_bytes() };
    publish(&args.output, args.existing, |file| file.write_all(&bytes))?;
    let planned = Planned {
        output: args.output.display().to_string(),
        reason: outline.reason.clone(),
        has_sun: outline.has_sun,
        bands: outline.bands.clone(),
        every_species: plan.bases.map(Bases::of),
        species: outline.species.iter().map(PlannedSpecies::of).collect(),
    };
    match args.json {
        true => print::json(&planned)?,
        false => print::out(&text(&planned))?,
    }
    Ok(0)
}

/// The scene of the file, or one without species; the flags win.
fn scene(args: &PlanArgs) -> Result<Scene, Failure> {
    let mut scene = match &args.scene {
        Some(path) => read_scene(path, &[&args.output])?,
        None => Scene {
            bands: None,
            light: None,
            ambient: None,
            sky: SceneSky::Even,
            backdrop: None,
            suns: Suns::Sky,
            sunlight: Sunlight::default(),
            highlight: HighlightChoice::default(),
            camera: None,
            ground: None,
            water: None,
            species: Vec::new(),
            instances: Vec::new(),
        },
    };
    if let Some(path) = args.sun_path {
        if scene.suns != Suns::Sky {
            say!("--sun-path takes the place of the suns of the scene");
        }
        scene.suns = Suns::Path(path);
    }
    if args.upright {
        if let Some(i) = scene.instances.iter().position(|instance| !instance.transform.is_upright()) {
            let name = &scene.species[scene.instances[i].species].name;
            let message =
                format!("--upright: instance {} of the scene, of species {name:?}, is tilted", i + 1);
            return Err(Failure::new(USAGE, message));
        }
        scene.species.iter_mut().for_each(|species| species.upright = true);
    }
    if args.no_ambient {
        scene.ambient = Some(0.0);
    }
    Ok(scene)
}

/// The bounds of a species' plant, from its library or its mesh; says so if it has neither.
fn bounds_of(species: &SceneSpecies) -> Result<Option<Bounds>, Failure> {
    let Some(path) = &species.file else {
        say!("species {:?} has no file in the scene: its lattice is left to the bake", species.name);
        return Ok(None);
    };
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("flb")) {
        let library = Library::open(path)?;
        let index = choose_species(&library, Some(&species.name), None)?;
        return Ok(Some(library.container().species()[index].meta.bounds_m));
    }
    let reader = MeshReader::of_scene(species)?;
    let classed = reader.read_classed(path)?;
    reader.measure(path, &classed);
    Ok(classed.bounds())
}

fn say_what_is_odd(outline: &Outline) {
    if !outline.has_sun {
        say!("warning: no sun of the scene is ever above the horizon: only ambient light is left");
    }
    for need in &outline.species {
        let name = &need.name;
        let Some(seen) = need.on_screen else { continue };
        match seen.wanted {
            0 => say!(
                "{name}: the camera comes inside its bounds, so no lattice is fine enough: {} is the limit",
                seen.lattice
            ),
            wanted if wanted != u64::from(seen.lattice) => say!(
                "{name}: {wanted} sites along each edge would suit its {:.1} pixels: {} is the limit",
                seen.size_px,
                seen.lattice
            ),
            _ => {}
        }
    }
}

fn text(planned: &Planned) -> String {
    let head = ["species", "instances", "bases", "solves per band", "lattice", "pixels", "nearest"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    let number = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
    let solves = |bases: &Bases| format!("{} of 18", bases.solves_per_band);
    rows.extend(planned.every_species.iter().map(|bases| {
        let name = "every species".to_owned();
        vec![
            name,
            "-".into(),
            bases.bases.len().to_string(),
            solves(bases),
            "-".into(),
            "-".into(),
            "-".into(),
        ]
    }));
    rows.extend(planned.species.iter().map(|species| {
        vec![
            species.name.clone(),
            species.instances.to_string(),
            species.bases.bases.len().to_string(),
            solves(&species.bases),
            number(species.lattice.map(|lattice| lattice.to_string())),
            number(species.size_px.map(|size| format!("{size:.0}"))),
            number(species.distance_m.map(|distance| format!("{distance:.2} m"))),
        ]
    }));
    let mut text = format!("{}\n{}\n", line!("{}", planned.reason), print::table(&rows));
    let named = planned.species.iter().map(|species| (species.name.as_str(), &species.bases));
    let all = planned.every_species.iter().map(|bases| ("every species", bases)).chain(named);
    for (name, bases) in all {
        text += &line!("{name} does without bases: {}", base_list(bases.left_out));
    }
    text + &line!("{}", planned.output)
}

/// Refuses a plan that does not know some of these species, naming all of them.
pub(crate) fn check_known(plan: &Plan, names: &[String]) -> Result<(), Failure> {
    let mut unknown = names.iter().filter_map(|name| plan.share(name).err().map(|error| (name, error)));
    let Some((_, first)) = unknown.next() else { return Ok(()) };
    let others: Vec<String> = unknown.map(|(name, _)| format!("{name:?}")).collect();
    match others.is_empty() {
        true => Err(first.into()),
        false => Err(Failure::new(USAGE, format!("{first}; nor is {}", others.join(", nor ")))),
    }
}

fn is_json(output: &Path) -> Result<bool, Failure> {
    match output.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("toml") => Ok(false),
        Some("json") => Ok(true),
        found => {
            let found = found.map_or("no extension".to_owned(), |e| format!(".{e}"));
            Err(Failure::new(USAGE, format!("found {found}, expected .toml or .json")).at(output))
        }
    }
}
