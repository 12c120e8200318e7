//! `flb bake-scene`: from a scene and its species' libraries to one library of scene light.

use flb_baker::bake::{self, LightSource, error_of, solve_light, unsolved_light};
use flb_baker::crown::Crown;
use flb_baker::scene_light::{self, Entry, Ground, Plant, Scenery, Stand, entry};
use flb_files::check_unread;
use flb_format::scene_light::{PLANT, Role};
use flb_format::{BandSurfaces, BaseSet, Codec, Light, Turbid};
use flb_packer::rate::Target;
use flb_packer::{EncodeSettings, EncodedSpecies, SpeciesFields, encode_species, write_library};
use flb_scene::scene::{Instance, Scene, SceneSpecies};
use flb_transport::ordinates::{self, FieldKind, OrdinatesSettings, OrdinatesSolution};
use flb_transport::turbid::scatter;
use serde::Serialize;
use serde_json::json;

use crate::args::BakeSceneArgs;
use crate::bake::checks::check_lattice;
use crate::bake::settings::{check_end, ordinates_of};
use crate::cache::Cache;
use crate::exit::{Failure, LOSS, USAGE};
use crate::forest::{hash_turbid, plant_digest, scene_species};
use crate::inputs::{check_local, check_output_of, open, read_scene_to_light};
use crate::memory::check_bytes;
use crate::print::{self, line};
use crate::stages::{Stage, Stages};
use crate::summary::stage_table;

/// Error of the coding. Quotients are taken of what is stored, so it is held far below that of light that is looked at.
const CODING: Target = Target::Both { psnr_db: 60.0, relative: 0.01 };

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

/// A species that stands in the scene, as its library has it.
struct Loaded {
    name: String,
    turbid: Turbid,
    surfaces: BandSurfaces,
    field: FieldKind,
    /// [`plant_digest`]
    digest: String,
}

/// Reads, merges, solves, writes.
pub fn run(args: &BakeSceneArgs) -> Result<u8, Failure> {
    check_output_of(&args.output, &[&args.scene], args.force)?;
    let at_scene = |failure: Failure| failure.at(&args.scene);
    let scene = read_scene_to_light(&args.scene, &[&args.output])?;
    let stages = Stages::default();
    let (plants_in_all, digest) = (scene.instances.len(), scene_light::digest(&scene));
    let ground = scene.ground.as_ref().map(Ground::of).transpose()?;
    let (loaded, instances) = stages.run("load", "", |_| load(scene, args))?;
    check_unread(&args.output)?;
    let settings = settings(args, field(&loaded).map_err(at_scene)?)?;
    check_memory(args, &settings)?;
    let plants: Vec<Plant> = loaded.iter().map(Loaded::as_plant).collect();
    args.cache.as_deref().map_or(Ok(()), check_local)?;
    let cache = Cache::open(args.cache.as_deref());
    let mut bake = Bake { settings, cache, stages, coded: Vec::new(), suns_rms: 0.0, converged: true };

    let scenery = bake
        .stages
        .run("merge", "", |_| Scenery::new(&plants, &instances, ground.as_ref(), args.lattice))
        .map_err(|error| at_scene(error.into()))?;
    let mut factors = vec![1.0; plants.len()];
    let mut species = Vec::new();
    for (index, plant) in plants.iter().enumerate() {
        let alone = bake.stages.run("merge", plant.name, |_| scenery.alone(index));
        let crown = alone.map_err(|error| at_scene(error.into()))?;
        factors[index] = crown.factor;
        let cached = bake.alone(plant, &crown, &loaded[index].digest)?;
        species.push(SpeciesSummary {
            name: plant.name.to_owned(),
            instances: instances.iter().filter(|one| one.species == index).count(),
            lattice: crown.turbid.grid.lattice,
            spacing_m: crown.turbid.grid.spacing_m,
            sites_nonempty: crown.turbid.sites().len(),
            factor: crown.factor,
            cached,
        });
    }
    let stand = bake.stages.run("merge", "", |_| scenery.stand(&factors));
    bake.stand(&digest, &stand)?;

    let Bake { stages, coded, suns_rms, converged, .. } = bake;
    let bytes = stages.run("write", &args.output.display().to_string(), |_| {
        write_library(&args.output, &coded.iter().collect::<Vec<_>>(), args.force)
    })?;
    let ground_sites = stand.is_ground.iter().filter(|is_ground| **is_ground).count();
    let summary = Summary {
        output: args.output.display().to_string(),
        bytes,
        digest,
        instances: plants_in_all,
        lattice: args.lattice,
        spacing_m: scenery.grid().spacing_m,
        sites_nonempty: stand.turbid.sites().len() - ground_sites,
        ground_sites,
        suns_rms,
        converged,
        species,
        stages: stages.list(),
    };
    match args.json {
        true => print::json(&summary)?,
        false => print::out(&text(&summary))?,
    }
    Ok(if converged { 0 } else { LOSS })
}

/// The species that stand somewhere, and the instances with their numbers among these.
fn load(scene: Scene, args: &BakeSceneArgs) -> Result<(Vec<Loaded>, Vec<Instance>), Failure> {
    let mut instances = scene.instances;
    let mut stands = vec![false; scene.species.len()];
    instances.iter().for_each(|instance| stands[instance.species] = true);
    let (mut loaded, mut numbers) = (Vec::new(), Vec::new());
    for (species, stands) in scene.species.iter().zip(stands) {
        numbers.push(loaded.len());
        if stands {
            loaded.push(Loaded::read(species, args)?);
        }
    }
    instances.iter_mut().for_each(|instance| instance.species = numbers[instance.species]);
    Ok((loaded, instances))
}

impl Loaded {
    fn read(species: &SceneSpecies, args: &BakeSceneArgs) -> Result<Loaded, Failure> {
        let name = species.name.clone();
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
        let turbid = library
            .container()
            .read_turbid(library.source(), index)
            .map_err(|error| at_file(error.into()))?;
        let digest = plant_digest(surfaces, light.field, &turbid).map_err(at_file)?;
        let surfaces = scene_light::luminance(&name, surfaces).map_err(|error| at_file(error.into()))?;
        Ok(Loaded { name, turbid, surfaces, field: light.field, digest })
    }

    fn as_plant(&self) -> Plant<'_> {
        Plant { name: &self.name, turbid: &self.turbid, surfaces: self.surfaces.clone() }
    }
}

/// What the fields of all species hold.
fn field(loaded: &[Loaded]) -> Result<FieldKind, Failure> {
    let Some(first) = loaded.first() else { return Ok(FieldKind::Scattered) };
    match loaded.iter().find(|one| one.field != first.field) {
        None => Ok(first.field),
        Some(other) => {
            let message = format!(
                "the light of {:?} is {}, that of {:?} {}: bake them with one --field",
                first.name,
                first.field.name(),
                other.name,
                other.field.name()
            );
            Err(Failure::new(USAGE, message))
        }
    }
}

fn settings(args: &BakeSceneArgs, field: FieldKind) -> Result<OrdinatesSettings, Failure> {
    let ordinates = ordinates_of(args.ordinates)?;
    check_lattice(args.lattice)?;
    check_end(args.tolerance, args.max_sweeps)?;
    Ok(OrdinatesSettings {
        ordinates,
        rays: ordinates::rays_for(args.lattice, 1),
        parts: 1,
        suns: args.suns.suns(),
        bases: BaseSet::ALL,
        field,
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

/// A bake on its way.
struct Bake {
    settings: OrdinatesSettings,
    cache: Cache,
    stages: Stages,
    coded: Vec<EncodedSpecies>,
    /// The largest.
    suns_rms: f64,
    /// Whether all did.
    converged: bool,
}

impl Bake {
    /// Solves and codes a species alone; whether the cache had it.
    fn alone(&mut self, plant: &Plant, crown: &Crown, digest: &str) -> Result<bool, Failure> {
        let role = Role::Alone { species: plant.name.to_owned() };
        let rays = ordinates::rays_for(crown.turbid.grid.lattice, 1);
        let settings = OrdinatesSettings { rays, ..self.settings.clone() };
        let digest_of_crown = bake::digest(&self.cache, crown)?;
        let source = LightSource { turbid: &crown.turbid, digest: digest_of_crown, surroundings: None };
        let scatter = [scatter(&plant.surfaces)];
        let (solution, cached) =
            solve_light(&role.name(), &source, &scatter, &settings, &self.cache, &self.stages)?;
        let said = [("scene.factor", json!(crown.factor)), (PLANT, json!(digest))];
        let said = said.map(|(key, value)| (key.to_owned(), value));
        self.code(&role, &crown.turbid, &[], plant.surfaces.clone(), solution, &settings, said)?;
        Ok(cached)
    }

    /// Solves and codes the whole scene.
    fn stand(&mut self, digest: &str, stand: &Stand) -> Result<(), Failure> {
        let role = Role::Scene { digest: digest.to_owned() };
        let settings = self.settings.clone();
        let source = LightSource {
            turbid: &stand.turbid,
            digest: digest_of(stand),
            surroundings: Some(stand.surroundings()),
        };
        let (solution, _) =
            solve_light(&role.name(), &source, &[stand.scatter()], &settings, &self.cache, &self.stages)?;
        let said = [("scene.below".to_owned(), json!(f64::from(stand.below)))];
        self.code(&role, &stand.turbid, &stand.is_ground, stand.surfaces.clone(), solution, &settings, said)
    }

    #[allow(clippy::too_many_arguments)] // all of an entry
    fn code(
        &mut self,
        role: &Role,
        turbid: &Turbid,
        is_ground: &[bool],
        surfaces: BandSurfaces,
        solution: OrdinatesSolution,
        settings: &OrdinatesSettings,
        said: impl IntoIterator<Item = (String, serde_json::Value)>,
    ) -> Result<(), Failure> {
        let error = error_of(&solution);
        self.suns_rms = self.suns_rms.max(error.suns_rms);
        let converged = solution.reports.iter().all(|report| report.converged);
        self.converged &= converged;
        let light = Light { error, ..unsolved_light(settings) };
        let solve = [
            ("solve.tolerance", json!(settings.tolerance)),
            ("solve.max_sweeps", json!(settings.max_passes)),
            ("solve.parts", json!(settings.parts)),
            ("solve.converged", json!(converged)),
        ];
        let said = said.into_iter().chain(solve.map(|(key, value)| (key.to_owned(), value)));
        let Entry { meta, medium } = entry(role, turbid, is_ground, surfaces, light, said);
        let fields = SpeciesFields { meta, medium, turbid: Some(turbid.clone()), bases: solution.fields };
        let coding = EncodeSettings {
            codec: Codec::Classed,
            target: CODING,
            compress: true,
            ..EncodeSettings::default()
        };
        let name = role.name();
        let coded =
            self.stages.run("encode", &name, |progress| encode_species(&fields, &coding, progress))?;
        self.coded.push(coded);
        Ok(())
    }
}

/// Of all that a stand's light depends on.
fn digest_of(stand: &Stand) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hash_turbid(&mut hasher, &stand.turbid);
    for value in stand.albedos.as_flattened().iter().chain([&stand.below]) {
        hasher.update(&value.to_le_bytes());
    }
    *hasher.finalize().as_bytes()
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
