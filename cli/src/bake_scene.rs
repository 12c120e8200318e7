//! `flb bake-scene`: from a scene and its species' libraries to one library of scene light.

use flb_baker::BakeError;
use flb_baker::bake::{BakedScene, PlantedScene, ScenePlant, SceneSettings, bake_scene};
use flb_files::check_unread;
use flb_format::SpeciesFields;
use flb_packer::{EncodeSettings, encode_species, write_library};
use flb_scene::Step;
use flb_scene::scene::SceneSpecies;
use flb_transport::ordinates::OrdinatesSettings;
use serde::Serialize;

use crate::args::BakeSceneArgs;
use crate::bake::limits::{check_end, check_lattice, ordinates_of};
use crate::cache::Cache;
use crate::exit::{Failure, LOSS, USAGE};
use crate::forest::scene_species;
use crate::inputs::{check_local, check_output_of, open, read_scene_to_light};
use crate::memory::check_bytes;
use crate::print::{self, line};
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
    /// Root mean square error of the fit over the suns that were held out, of the mean total fluence.
    suns_rms: f64,
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
    let field = scene.field().map_err(|error| at_scene(error.into()))?;
    let settings = settings(args)?;
    check_memory(args, &settings.solve(args.lattice, field))?;
    args.cache.as_deref().map_or(Ok(()), check_local)?;
    let cache = Cache::open(args.cache.as_deref());

    let baked = bake_scene(&scene, &settings, &cache, &stages).map_err(|error| match error {
        BakeError::Scene(error) => at_scene(error.into()),
        error => error.into(),
    })?;
    let coding = EncodeSettings::scene_light();
    let encode = |entry: &SpeciesFields| {
        stages.run(Step::Encode, &entry.meta.name, |progress| encode_species(entry, &coding, progress))
    };
    let coded = baked.entries().map(encode).collect::<Result<Vec<_>, _>>()?;
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
    let Some((surfaces, light)) = meta.physical() else {
        let message = format!(
            "species {name:?} is of the model paper, whose plants are as dense as their lattice makes them: bake it with --model physical"
        );
        return Err(at_file(Failure::new(USAGE, message)));
    };
    let turbid =
        library.container().read_turbid(library.source(), index).map_err(|error| at_file(error.into()))?;
    ScenePlant::new(name, turbid, surfaces, light.field).map_err(|error| at_file(error.into()))
}

fn settings(args: &BakeSceneArgs) -> Result<SceneSettings, Failure> {
    let ordinates = ordinates_of(args.ordinates)?;
    check_lattice(args.lattice)?;
    check_end(args.tolerance, args.max_sweeps)?;
    Ok(SceneSettings {
        lattice: args.lattice,
        suns: args.suns.basis(),
        ordinates,
        tolerance: args.tolerance,
        max_passes: args.max_sweeps,
    })
}

/// Refuses a lattice over the limit before anything is made.
fn check_memory(args: &BakeSceneArgs, settings: &OrdinatesSettings) -> Result<(), Failure> {
    let sites = u64::from(args.lattice).pow(3);
    let needed = sites * (BYTES_PER_SITE + 4 * settings.items().len() as u64);
    check_bytes(&format!("a lattice of {} sites along each edge", args.lattice), needed, &args.memory)
        .map_err(|failure| failure.at(&args.scene))
}

fn summary(
    args: &BakeSceneArgs,
    scene: PlantedScene,
    baked: &BakedScene,
    bytes: u64,
    stages: Vec<Stage>,
) -> Summary {
    let sites_nonempty =
        |entry: &SpeciesFields| entry.turbid.as_ref().map_or(0, |turbid| turbid.sites().len());
    let species = baked.species.iter().zip(&scene.plants).enumerate().map(|(index, (alone, plant))| {
        let grid = &alone.fields.meta.grid;
        SpeciesSummary {
            name: plant.name().to_owned(),
            instances: scene.instances.iter().filter(|one| one.species == index).count(),
            lattice: grid.lattice,
            spacing_m: grid.spacing_m,
            sites_nonempty: sites_nonempty(&alone.fields),
            factor: alone.factor,
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
        converged: baked.converged,
        stages,
    }
}

fn text(summary: &Summary) -> String {
    let mut text = format!("{}\n", stage_table(&summary.stages));
    for species in &summary.species {
        text += &line!(
            "{}: {} instances; alone on {} sites of {:.3} m, {} with matter, extinction times {:.3}{}",
            species.name,
            species.instances,
            species.lattice,
            species.spacing_m,
            species.sites_nonempty,
            species.factor,
            if species.cached { ", from the cache" } else { "" },
        );
    }
    text += &line!(
        "scene: {} instances on {} sites of {:.3} m, {} with matter, {} of ground; suns off by {:.1} %",
        summary.instances,
        summary.lattice,
        summary.spacing_m,
        summary.sites_nonempty,
        summary.ground_sites,
        100.0 * summary.suns_rms,
    );
    text + &line!("{}: {}", summary.output, print::bytes(summary.bytes))
}
