//! `flb render SCENE.toml`: a scene of many plants, each with the light of its file, under one sun after the other.

mod light;
pub(crate) mod neighbours;
#[cfg(not(feature = "gpu"))]
#[path = "forest/no_gpu.rs"]
mod on_gpu;
#[cfg(feature = "gpu")]
mod on_gpu;
mod options;
mod suns;

use std::path::{Path, PathBuf};

use flb_files::check_unread;
use flb_format::sun::towards_sun;
use flb_format::{FieldKind, MeshMatch};
use flb_render::forest::{Forest, Fragments, Ground, Land, Search, Species, View, Water};
use flb_render::{LightQuery, Picture, Shading, Surfaces, contact_sheet};
use flb_runtime::{Library, LightCursors};
use flb_scene::scene::{Ground as SceneGround, Scene, SceneSpecies, Terrain, Water as SceneWater};
use serde::Serialize;

use crate::args::{BandArgs, MemoryArgs, RenderArgs, RenderBackendArg};
use crate::classes::MeshReader;
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_output_of, choose_species, open, read_scene};
use crate::memory::{check, check_plants, sampler_bytes};
use crate::mesh_of_light::{MeshOfLight, mesh_of_species};
use crate::picture::{PictureFormat, Rendered, SHEET_GAP, picture_format, shown, write};
use crate::print::{self, line, say};
use crate::sky::SkyChoice;
use crate::stages::Stages;
use flb_scene::ClassedMesh;

use neighbours::Neighbours;
use on_gpu::OnGpu;
use options::PictureOptions;
pub(crate) use options::sky_and_exposure;
pub(crate) use suns::subject_of;
use suns::{Shot, shots};

/// Rays that look for the sky from each point of the ground that the camera sees.
const SKY_RAYS: u32 = 4;

/// Of a plant: where it stands, its place in the trees that rays find it by while they are made, and in the grids of a
/// picture and a sun.
pub(crate) const PLANT_BYTES: usize = 500;

/// What stands in the scene.
#[derive(Serialize)]
pub(crate) struct Outcome {
    instances: usize,
    /// Of all instances together.
    triangles: u64,
    /// Rays of the last picture that met a plant, the ground, nothing, and water.
    rays: [usize; 4],
    frames: Vec<String>,
    /// When each frame's sun stands there (UTC); of a sun along a path alone.
    times: Vec<String>,
    light_bytes: usize,
    /// Names of the GPUs that drew it.
    adapters: Vec<String>,
    species: Vec<SpeciesOutcome>,
}

#[derive(Serialize)]
struct SpeciesOutcome {
    name: String,
    instances: usize,
    triangles: usize,
    model: Option<&'static str>,
    /// Whether its light is of this mesh; null without light.
    mesh_match: Option<&'static str>,
}

/// A species as its files have it.
pub(crate) struct Loaded {
    pub mesh: ClassedMesh,
    /// Its library, and its number there.
    pub light: Option<(Library, usize)>,
    pub shading: Shading,
    /// How mesh and light belong together.
    pub matched: Option<MeshMatch>,
}

/// Reads the scene, its meshes and their light, and takes its pictures.
pub(crate) fn run(args: &RenderArgs) -> Result<u8, Failure> {
    refuse_flags_of_a_plant(args)?;
    check_output_of(&args.output, &[&args.file], args.force)?;
    let format = picture_format(&args.output)?;
    let outputs = match args.frames {
        Some(frames) => frame_files(&args.output, frames),
        None => vec![args.output.clone()],
    };
    for output in outputs.iter().filter(|_| args.frames.is_some()) {
        check_output_of(output, &[&args.file], args.force)?;
    }
    let scene = read_scene(&args.file, &outputs.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
    let sky = SkyChoice::read(&args.sky, &scene.sky)?;
    let shots = shots(&scene, args, !sky.is_image())?;
    let stages = Stages::default();
    let flags = (&args.memory, &args.bands);
    let loaded = scene
        .species
        .iter()
        .map(|species| {
            let read = || Loaded::read(species, &args.file, flags, args.indirect_scale, args.mesh_differs);
            stages.run("import", &species.name, |_| read())
        })
        .collect::<Result<Vec<_>, _>>()?;
    outputs.iter().try_for_each(|output| check_unread(output))?;
    let look = PictureOptions::of(&scene, &loaded, args, sky)?;
    check_plants(&args.file, scene.instances.len(), look.plant_bytes(), &args.memory)?;
    let scene_light = stages.run("load", "", |_| {
        neighbours::load(&scene, loaded.iter().map(Loaded::light), args.scene_light.as_ref())
    })?;
    let neighbours = scene_light.as_ref().map(|light| Neighbours::new(light, &scene));
    let ground = scene.ground.as_ref().map(ground).transpose()?;
    let forest = stages.run("prepare", "", |_| {
        let species: Vec<Species> = loaded.iter().map(Loaded::as_species).collect();
        let forest = Forest::prepare(&species, &scene.instances, ground, Search::default())?;
        match &scene.water {
            None => Ok(forest),
            Some(still) => forest.with_water(water(still)),
        }
    })?;
    let mut on_gpu: Option<OnGpu> = on_gpu::send(args.backend, args.gpus, &forest, &loaded, &look, &stages)?;
    let light = match on_gpu {
        Some(_) => Vec::new(),
        None => stages.run("load", "", |_| light::load(&scene, &loaded, &shots, &look))?,
    };

    let beams = match look.sky.is_even() {
        true => light.iter().map(|_| None).collect(),
        false => stages.run("prepare", "sky", |_| light::beams(&light))?,
    };

    let mut camera = CachedFragments::default();
    let mut shade = None;
    let mut pictures = Vec::new();
    for (number, shot) in shots.iter().enumerate() {
        let lighting = look.lighting(shot.sun)?;
        let daylight = lighting.daylight;
        let is_same_sun = number > 0 && shots[number - 1].sun == shot.sun;
        if let Some(neighbours) = neighbours.as_ref().filter(|_| !is_same_sun) {
            shade = Some(stages.run("shade", "", |_| neighbours.under(daylight.towards_sun, daylight.sun))?);
        }
        let picture = match &mut on_gpu {
            Some(on_gpu) => on_gpu.picture(shot, shade.as_ref(), &look, &stages)?,
            None => {
                let fragments = camera.fragments(&forest, shot, &look, &stages)?;
                let skies = match &lighting.dome {
                    None => Vec::new(),
                    Some(dome) => stages
                        .run("sky", &shot.subject(), |_| light::skies(&beams, &scene.instances, dome))?,
                };
                let lit =
                    light::under(&light, &skies, &scene.instances, &lighting, shade.as_ref(), look.samples)?;
                let cursors = LightCursors::new(&lit);
                let light = |LightQuery { instance, point, facing }: LightQuery, phi: &mut [f32; 3]| {
                    cursors.at_facing(instance as usize, point, facing, phi);
                };
                stages.run("relight", &shot.subject(), |progress| {
                    forest.relight(fragments, &lighting, &look.look, &light, progress)
                })?
            }
        };
        match args.frames {
            Some(_) => write(&outputs[number], args.force, &picture, format, look.exposure)?,
            None => pictures.push(picture),
        }
    }
    let size = match args.frames {
        Some(_) => look.size,
        None => write_sheet(pictures, args, format, look.exposure)?,
    };
    let outcome = Outcome {
        rays: match &mut on_gpu {
            // Read back for who asks alone.
            Some(on_gpu) if args.json => on_gpu.rays()?,
            Some(_) => [0; 4],
            None => camera.fragments.as_ref().map_or([0; 4], Fragments::counts),
        },
        adapters: on_gpu.as_ref().map_or(Vec::new(), |on_gpu| on_gpu.names().to_vec()),
        frames: outputs.iter().filter(|_| args.frames.is_some()).map(|o| o.display().to_string()).collect(),
        times: shots.iter().filter_map(|shot| shot.instant).map(|instant| instant.to_string()).collect(),
        light_bytes: match &on_gpu {
            Some(on_gpu) => on_gpu.light_bytes(),
            None => light::size_bytes(&light, &beams),
        },
        ..Outcome::of(&scene, &loaded)
    };
    let rendered = Rendered {
        output: outputs[0].display().to_string(),
        species: scene.species.iter().map(|species| species.name.as_str()).collect::<Vec<_>>().join(", "),
        width: size[0],
        height: size[1],
        suns: shots.iter().filter_map(|shot| shot.sun).collect(),
        mesh_match: None,
        difference: None,
        scene: Some(outcome),
        stages: stages.list(),
    };
    match (&rendered.scene, args.json) {
        (Some(outcome), false) => print::out(&text(&rendered, outcome))?,
        _ => print::json(&rendered)?,
    }
    Ok(0)
}

/// What a scene says by itself, or has not; and GPUs for the CPU.
fn refuse_flags_of_a_plant(args: &RenderArgs) -> Result<(), Failure> {
    let flags = [
        ("--mesh", args.mesh.is_some()),
        ("--species", args.species.is_some()),
        ("--against", args.against.is_some()),
        ("--path-traced", args.path_traced),
        ("--view", args.view.is_some()),
        ("--ground", args.ground),
    ];
    match flags.iter().find(|(_, is_there)| *is_there) {
        None if args.gpus.is_some() && args.backend == RenderBackendArg::Cpu => {
            let message = "--gpus is for --backend gpu or auto; this scene is drawn on the CPU";
            Err(Failure::new(USAGE, message).at(&args.file))
        }
        None => Ok(()),
        Some((flag, _)) => {
            let message = format!("{flag} is for a single plant; a scene says by itself what it shows");
            Err(Failure::new(USAGE, message).at(&args.file))
        }
    }
}

impl Loaded {
    pub(crate) fn read(
        species: &SceneSpecies,
        scene: &Path,
        (memory, bands): (&MemoryArgs, &BandArgs),
        indirect_scale: Option<f32>,
        mesh_differs: bool,
    ) -> Result<Loaded, Failure> {
        let refuse = |message: String| Failure::new(USAGE, message).at(scene);
        let is_library = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("flb"));
        let Some(file) = species.file.as_deref().filter(|file| !is_library(file)) else {
            let message =
                format!("species {:?} has no mesh as its file, which a picture needs", species.name);
            return Err(refuse(message));
        };
        let Some(light) = &species.light else {
            let reader = MeshReader::of_scene(species)?;
            let mesh = reader.read_classed(file)?;
            reader.measure(file, &mesh);
            return Ok(Loaded { mesh, light: None, shading: Shading::Paper, matched: None });
        };
        let library = open(light)?;
        let index = scene_species(&library, species)?;
        let library = shown(library, index, bands)?;
        let meta = &library.container().species()[index].meta;
        let needed = sampler_bytes(&library.container().species()[index]);
        check(&library, &format!("the bases of species {:?}", meta.name), needed, memory)?;
        let gltf_mesh = species.gltf_mesh.as_deref();
        let MeshOfLight { mesh, matched } = mesh_of_species(file, meta, gltf_mesh, mesh_differs)?;
        let shading = match meta.physical() {
            None => Shading::Paper,
            Some((surfaces, light)) => {
                if indirect_scale.is_some() {
                    return Err(refuse("--indirect-scale is for paper files only".to_owned()));
                }
                if light.field == FieldKind::Total {
                    say!(
                        "warning: {}: the fields hold the sun's beam, which shadow rays add again: the sun counts twice",
                        species.name
                    );
                }
                Shading::Physical(Surfaces::of(surfaces, meta))
            }
        };
        Ok(Loaded { mesh, light: Some((library, index)), shading, matched: Some(matched) })
    }

    pub(crate) fn as_species(&self) -> Species<'_> {
        Species { mesh: &self.mesh.mesh, classes: &self.mesh.classes, shading: self.shading }
    }

    fn is_physical(&self) -> bool {
        matches!(self.shading, Shading::Physical(_))
    }

    /// Its library, and its number there.
    pub(crate) fn light(&self) -> Option<(&Library, usize)> {
        self.light.as_ref().map(|(library, index)| (library, *index))
    }

    fn model(&self) -> Option<&'static str> {
        let (library, index) = self.light()?;
        Some(library.container().species()[index].meta.model.name())
    }
}

/// The number of a scene's species in its library: by its name, unless it is the only one there.
pub(crate) fn scene_species(library: &Library, species: &SceneSpecies) -> Result<usize, Failure> {
    let name = species.light_species.as_deref().unwrap_or(&species.name);
    let count = library.container().species().len();
    let has_name = library.find_species(name).is_some();
    let alone = count == 1 && species.light_species.is_none() && !has_name;
    choose_species(library, (!alone).then_some(name), None)
}

fn towards([azimuth_deg, elevation_deg]: [f64; 2]) -> [f64; 3] {
    towards_sun(azimuth_deg, elevation_deg)
}

pub(crate) fn ground(ground: &SceneGround) -> Result<Ground, Failure> {
    let land = match &ground.terrain {
        Terrain::Plane { height_m } => Land::Plane { height_m: *height_m },
        Terrain::Map(map) => Land::Heights(map.read()?),
    };
    Ok(Ground { land, color: ground.color.map(|share| share as f32), fades_at_m: None })
}

pub(crate) fn water(water: &SceneWater) -> Water {
    Water { height_m: water.height_m, color: water.color.map(|share| share as f32) }
}

/// What the camera saw last: it is found again only when the camera has moved.
#[derive(Default)]
struct CachedFragments {
    view: Option<View>,
    fragments: Option<Fragments>,
}

impl CachedFragments {
    fn fragments(
        &mut self,
        forest: &Forest,
        shot: &Shot,
        look: &PictureOptions,
        stages: &Stages,
    ) -> Result<&Fragments, Failure> {
        let view = look.view(shot);
        if self.view != Some(view) {
            self.fragments = None;
        }
        self.view = Some(view);
        match &mut self.fragments {
            Some(fragments) => Ok(fragments),
            none => Ok(none.insert(stages.run("trace", "", |progress| forest.trace(&view, progress))?)),
        }
    }
}

/// OUT-0001.png and so on.
fn frame_files(output: &Path, frames: u32) -> Vec<PathBuf> {
    let name = |frame: u32| {
        let mut name = output.file_stem().unwrap_or_default().to_owned();
        name.push(format!("-{frame:04}."));
        name.push(output.extension().unwrap_or_default());
        output.with_file_name(name)
    };
    (1..=frames).map(name).collect()
}

/// One picture, or all side by side; gives back the size.
fn write_sheet(
    mut pictures: Vec<Picture>,
    args: &RenderArgs,
    format: PictureFormat,
    exposure: f32,
) -> Result<[u32; 2], Failure> {
    let picture = match pictures.len() {
        1 => pictures.remove(0),
        _ => contact_sheet(&pictures, SHEET_GAP)?,
    };
    write(&args.output, args.force, &picture, format, exposure)?;
    Ok([picture.width, picture.height])
}

impl Outcome {
    fn of(scene: &Scene, loaded: &[Loaded]) -> Outcome {
        let mut counts = vec![0; scene.species.len()];
        scene.instances.iter().for_each(|instance| counts[instance.species] += 1);
        let species: Vec<SpeciesOutcome> = scene
            .species
            .iter()
            .zip(loaded)
            .zip(&counts)
            .map(|((species, loaded), instances)| SpeciesOutcome {
                name: species.name.clone(),
                instances: *instances,
                triangles: loaded.mesh.mesh.triangles.len(),
                model: loaded.model(),
                mesh_match: loaded.matched.map(|matched| matched.name()),
            })
            .collect();
        Outcome {
            instances: scene.instances.len(),
            triangles: species.iter().map(|one| one.instances as u64 * one.triangles as u64).sum(),
            rays: [0; 4],
            frames: Vec::new(),
            times: Vec::new(),
            light_bytes: 0,
            adapters: Vec::new(),
            species,
        }
    }
}

fn text(rendered: &Rendered<Outcome>, scene: &Outcome) -> String {
    let seconds = |name: &str| {
        rendered.stages.iter().filter(|stage| stage.name == name).map(|stage| stage.seconds).sum::<f64>()
    };
    let pictures = match scene.frames.len() {
        0 => format!("{} sun{}", rendered.suns.len(), if rendered.suns.len() == 1 { "" } else { "s" }),
        frames => format!("{frames} frames"),
    };
    let drawn = line!(
        "{}: {} instances of {}, {} triangles, {pictures}, {} x {} pixels",
        rendered.output,
        scene.instances,
        rendered.species,
        scene.triangles,
        rendered.width,
        rendered.height,
    );
    drawn
        + &line!(
            "trace {:.2} s, relight {:.2} s each{}",
            seconds("trace"),
            seconds("relight") / rendered.suns.len() as f64,
            if scene.adapters.is_empty() {
                String::new()
            } else {
                format!(" on {}", scene.adapters.join(", "))
            },
        )
}
