//! `flb bake-scene`: from a scene and its species' libraries to one library of scene light.

use flb_baker::BakeError;
use flb_baker::bake::{BakedScene, PlantedScene, ScenePlant, SceneSettings, SceneTransport, bake_scene};
use flb_farm::cache::Cache;
use flb_farm::recipe::{check_end, check_lattice, ordinates_of};
use flb_files::check_unread;
use flb_format::SpeciesFields;
use flb_packer::{EncodeSettings, encode_all, write_library};
use flb_scene::Step;
use flb_scene::scene::SceneSpecies;
use serde::Serialize;

use crate::args::BakeSceneArgs;
use crate::exit::{Failure, LOSS, USAGE};
use crate::forest::scene_species;
use crate::inputs::{check_output_of, open, read_scene_to_light};
use crate::memory::check_bytes;
use crate::print::{self, line, say};
use crate::stages::{Stage, Stages};
use crate::summary::stage_table;

/// Bytes per site of the sums over all instances, of media and of lists.
const BYTES_PER_SITE: u64 = 80;

/// What `--json` prints (cli/schema/bake-scene.json).
#[derive(Serialize)]
struct Summary {
    output: String,
    bytes: u64,
    /// Of plants and ground.
    digest: String,
    instances: usize,
    lattice: u32,
    spacing_m: f64,
    sites_nonempty: usize,
    ground_sites: usize,
    /// Root mean square error of the fit over the suns that were held out, of the mean total fluence; `null` of plants
    /// of the model `paper`, which fits none.
    suns_rms: Option<f64>,
    /// Whether the scene has a ground that its light leaves out.
    ground_left_out: bool,
    converged: bool,
    species: Vec<SpeciesSummary>,
    stages: Vec<Stage>,
}

/// A species alone.
#[derive(Serialize)]
struct SpeciesSummary {
    name: String,
    instances: usize,
    lattice: u32,
    spacing_m: f64,
    sites_nonempty: usize,
    /// Of the extinction, so that it is as open as its fine medium.
    factor: f64,
    /// Edge of a site, in widths of the crown.
    site_widths: f64,
    /// Whether an earlier bake solved it.
    cached: bool,
}

/// Reads, bakes, codes, writes.
pub(crate) fn run(args: &BakeSceneArgs) -> Result<u8, Failure> {
    check_output_of(&args.output, &[&args.scene], args.existing)?;
    let at_scene = |failure: Failure| failure.at(&args.scene);
    let scene = read_scene_to_light(&args.scene, &[&args.output])?;
    let stages = Stages::default();
    let scene = stages.run(Step::Load, "", |_| PlantedScene::of(scene, |species| plant(species, args)))?;
    check_unread(&args.output)?;
    let transport = scene.transport().map_err(|error| at_scene(error.into()))?;
    let settings = settings(args, transport)?;
    check_memory(args, settings.items(transport))?;
    if scene.is_ground_left_out() {
        say!(
            "warning: {}: the ground is left out of the scene's light: the model paper knows plants alone",
            args.scene.display()
        );
    }
    let tell = |told: &str| say!("{told}");
    let cache = Cache::open(args.cache.as_ref(), &tell)?;

    let baked = bake_scene(&scene, &settings, &cache, &stages).map_err(|error| match error {
        BakeError::Scene(error) => at_scene(error.into()),
        error => error.into(),
    })?;
    tell_of_large_sites(&scene, &baked, args.lattice);
    let coding = EncodeSettings::scene_light();
    let entries: Vec<&SpeciesFields> = baked.entries().collect();
    let coded = stages.run(Step::Encode, "", |progress| encode_all(&entries, &coding, progress))?;
    let bytes = stages.run(Step::Write, &args.output.display().to_string(), |_| {
        write_library(&args.output, &coded.iter().collect::<Vec<_>>(), args.existing)
    })?;
    let summary = summary(args, scene, &baked, bytes, stages.list());
    match args.json {
        true => print::json(&summary)?,
        false => print::out(&text(&summary))?,
    }
    Ok(if baked.converged { 0 } else { LOSS })
}

/// A species as its library has it.
fn plant(species: &SceneSpecies, args: &BakeSceneArgs) -> Result<ScenePlant, Failure> {
    let name = &species.name;
    let Some(file) = &species.light else {
        let message =
            format!("species {name:?} has no light: its plants shade others by what its library holds");
        return Err(Failure::new(USAGE, message).at(&args.scene));
    };
    let library = open(file)?;
    let index = scene_species(&library, species)?;
    let meta = &library.container().species()[index].meta;
    let at_file = |failure: Failure| failure.at(library.path());
    let (container, source) = (library.container(), library.source());
    if let Some(optics) = meta.optics() {
        let medium = container.read_medium(source, index).map_err(|error| at_file(error.into()))?;
        return ScenePlant::of_paper(name, &medium, optics).map_err(|error| at_file(error.into()));
    }
    let (surfaces, light) = meta.physical().expect("a species is of one of two models");
    let turbid = container.read_turbid(source, index).map_err(|error| at_file(error.into()))?;
    ScenePlant::new(name, turbid, surfaces, light.field).map_err(|error| at_file(error.into()))
}

fn settings(args: &BakeSceneArgs, transport: SceneTransport) -> Result<SceneSettings, Failure> {
    let default = SceneSettings::default();
    let given = [("--suns", args.suns.is_some()), ("--ordinates", args.ordinates.is_some())];
    if let (SceneTransport::Lattice, Some((flag, _))) = (transport, given.iter().find(|(_, given)| *given)) {
        let message = format!("{flag} is of the model physical: the species' light is of the model paper");
        return Err(Failure::new(USAGE, message).at(&args.scene));
    }
    check_lattice(args.lattice)?;
    check_end(args.tolerance, args.max_sweeps)?;
    Ok(SceneSettings {
        lattice: args.lattice,
        suns: args.suns.map_or(default.suns, |suns| suns.basis()),
        ordinates: args.ordinates.map_or(Ok(default.ordinates), ordinates_of)?,
        tolerance: args.tolerance,
        max_passes: args.max_sweeps,
    })
}

/// Refuses a lattice over the limit before anything is made.
fn check_memory(args: &BakeSceneArgs, items: usize) -> Result<(), Failure> {
    let sites = u64::from(args.lattice).pow(3);
    let needed = sites * (BYTES_PER_SITE + 4 * items as u64);
    check_bytes(&format!("a lattice of {} sites along each edge", args.lattice), needed, &args.memory)
        .map_err(|failure| failure.at(&args.scene))
}

/// Warns of species whose crowns are smaller than a site: nothing is known of light within one.
fn tell_of_large_sites(scene: &PlantedScene, baked: &BakedScene, lattice: u32) {
    for (plant, alone) in scene.plants.iter().zip(&baked.species) {
        if alone.site_widths > 1.0 {
            say!(
                "warning: species {:?}: a site of the scene's lattice is {:.1} times as wide as the crown, expected a tenth of it: the shade that neighbours cast is lost in it. Take more sites than --lattice {lattice}, or bake a smaller scene",
                plant.name(),
                alone.site_widths
            );
        }
    }
}

fn summary(
    args: &BakeSceneArgs,
    scene: PlantedScene,
    baked: &BakedScene,
    bytes: u64,
    stages: Vec<Stage>,
) -> Summary {
    let sites_nonempty = |entry: &SpeciesFields| entry.medium.nonempty_sites();
    let ground_left_out = scene.is_ground_left_out();
    let species = baked.species.iter().zip(&scene.plants).enumerate().map(|(index, (alone, plant))| {
        let grid = &alone.fields.meta.grid;
        SpeciesSummary {
            name: plant.name().to_owned(),
            instances: scene.instances.iter().filter(|one| one.species == index).count(),
            lattice: grid.lattice,
            spacing_m: grid.spacing_m,
            sites_nonempty: sites_nonempty(&alone.fields),
            factor: alone.factor,
            site_widths: alone.site_widths,
            cached: alone.cached,
        }
    });
    Summary {
        output: args.output.display().to_string(),
        bytes,
        species: species.collect(),
        instances: scene.instances.len(),
        digest: scene.digest,
        lattice: args.lattice,
        spacing_m: baked.stand.meta.grid.spacing_m,
        sites_nonempty: sites_nonempty(&baked.stand) - baked.ground_sites,
        ground_sites: baked.ground_sites,
        suns_rms: baked.suns_rms,
        ground_left_out,
        converged: baked.converged,
        stages,
    }
}

fn text(summary: &Summary) -> String {
    let mut text = format!("{}\n", stage_table(&summary.stages));
    for species in &summary.species {
        text += &line!(
            "{}: {} instances; alone on {} sites of {:.3} m ({:.2} crown widths), {} with matter, extinction times {:.3}{}",
            species.name,
            species.instances,
            species.lattice,
            species.spacing_m,
            species.site_widths,
            species.sites_nonempty,
            species.factor,
            if species.cached { ", from the cache" } else { "" },
        );
    }
    text += &line!(
        "scene: {} instances on {} sites of {:.3} m, {} with matter, {} of ground{}",
        summary.instances,
        summary.lattice,
        summary.spacing_m,
        summary.sites_nonempty,
        summary.ground_sites,
        summary.suns_rms.map_or(String::new(), |rms| format!("; suns off by {:.1} %", 100.0 * rms)),
    );
    text + &line!("{}: {}", summary.output, print::bytes(summary.bytes))
}
