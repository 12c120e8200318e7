//! `flb render SCENE.toml`: a scene of many plants, each with the light of its file, under one sun after the other.

use std::path::{Path, PathBuf};

use flb_files::check_unread;
use flb_render::{Look, Shading};
use flb_runtime::Library;
use flb_runtime::scene_light::SceneLight;
use flb_scene::Step;
use flb_scene::extents::Mend;
use flb_scene::scene::{Scene, SceneSpecies};
use flb_stage::backend::GpuCount;
use flb_stage::open::{self, mesh_file};
use flb_stage::plant::{PlantLight, ScenePlant};
use flb_stage::{
    Backend, FrameSettings, LookSettings, OpenSettings, SceneLook, SceneRenderer, SceneShow, Stage, frames,
};
use serde::Serialize;

use crate::args::{BandArgs, MemoryArgs, RenderArgs, RenderBackendArg, SceneLightArgs};
use crate::exit::{Failure, USAGE};
use crate::inputs::{check_local, check_output_of, open, read_scene};
use crate::memory::{check, check_plants, sampler_bytes};
use crate::mesh_of_light::Said;
use crate::picture::{Rendered, check_layers, picture_format, sheet, write};
use crate::print::{self, line};
use crate::size::Measured;
use crate::sky::read_sky;
use crate::stages::Stages;

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

/// Reads the scene, its meshes and their light, and takes its pictures.
pub(crate) fn run(args: &RenderArgs) -> Result<u8, Failure> {
    refuse_flags_of_a_plant(args)?;
    check_output_of(&args.output, &[&args.file], args.existing)?;
    let format = picture_format(&args.output)?;
    check_layers(&args.output, format, &args.show)?;
    let outputs = match args.frames {
        Some(frames) => frame_files(&args.output, frames),
        None => vec![args.output.clone()],
    };
    for output in outputs.iter().filter(|_| args.frames.is_some()) {
        check_output_of(output, &[&args.file], args.existing)?;
    }
    let scene = read_scene(&args.file, &outputs.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
    let sky = read_sky(&args.sky, &scene.sky, scene.backdrop.as_deref())?;
    let at_scene = |failure: Failure| failure.at(&args.file);
    let which = FrameSettings {
        suns_deg: args.sun.clone(),
        sun_path: args.sun_path,
        count: args.frames,
        needs_sun: sky.needs_sun(),
    };
    let frames = frames(&scene, &which).map_err(|error| at_scene(error.into()))?;
    let stages = Stages::default();
    let flags = (&args.memory, &args.bands);
    let read = |species: &SceneSpecies| {
        let read = || read_plant(species, &args.file, flags, args.indirect_scale, args.mesh_differs);
        stages.run(Step::Import, &species.name, |_| read())
    };
    let plants = scene.species.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    outputs.iter().try_for_each(|output| check_unread(output))?;
    // An uneven sky over files that cannot have one, before more is read.
    sky.over([0.0, 1.0, 0.0], None, ScenePlant::units(&plants)).map_err(|error| at_scene(error.into()))?;
    let plant_bytes = Stage::PLANT_BYTES + if sky.is_even() { 0 } else { Stage::SKY_BYTES };
    check_plants(&args.file, scene.instances.len(), plant_bytes, &args.memory)?;
    let stage = stages.run(Step::Load, "", |_| on_stage(scene, plants, &args.file, &args.scene_light))?;
    let default =
        Look::of_light(stage.plants.iter().filter_map(|plant| plant.light.as_ref()).map(PlantLight::meta));
    let settings = LookSettings {
        size: args.size,
        samples: args.samples.unwrap_or(4),
        ambient: args.ambient,
        irradiance: args.sunlight.sun_irradiance,
        added_suns: args.sunlight.added(),
        highlight: args.highlight.choice(),
        look: Look { indirect_scale: args.indirect_scale.unwrap_or(default.indirect_scale), ..default },
        shows: args.show.clone(),
        search: args.find.unwrap_or_default(),
    };
    let look = SceneLook::new(&stage, &settings, sky).map_err(|error| at_scene(error.into()))?;
    let exposure = args.exposure.unwrap_or(match args.show.contains(&SceneShow::Global) {
        false => stage.default_exposure(),
        // Shares are shown as they are.
        true => 0.0,
    });
    let look_size = look.size;
    let backend = backend(args.backend, args.gpus);
    let mut renderer = SceneRenderer::new(&stage, look, &frames, backend, &stages)?;
    let mut pictures = Vec::new();
    for (number, frame) in frames.iter().enumerate() {
        let layers = renderer.layers(frame, &stages)?;
        match args.frames {
            Some(_) => write(&outputs[number], args.existing, &layers, format, exposure)?,
            None => pictures.push(layers),
        }
    }
    let size = match args.frames {
        Some(_) => look_size,
        None => {
            let layers = sheet(pictures)?;
            write(&args.output, args.existing, &layers, format, exposure)?;
            [layers[0].1.width, layers[0].1.height]
        }
    };
    let outcome = Outcome {
        // Read back from a GPU for who asks alone.
        rays: if args.json || renderer.adapters().is_empty() { renderer.rays()? } else { [0; 4] },
        adapters: renderer.adapters().to_vec(),
        frames: outputs.iter().filter(|_| args.frames.is_some()).map(|o| o.display().to_string()).collect(),
        times: frames.iter().filter_map(|frame| frame.instant).map(|instant| instant.to_string()).collect(),
        light_bytes: renderer.light_bytes(),
        ..Outcome::of(&stage)
    };
    let rendered = Rendered {
        output: outputs[0].display().to_string(),
        species: stage.scene.species.iter().map(|one| one.name.as_str()).collect::<Vec<_>>().join(", "),
        width: size[0],
        height: size[1],
        suns: frames.iter().filter_map(|frame| frame.sun_deg).collect(),
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

/// Where the flags say that frames are made.
fn backend(backend: RenderBackendArg, gpus: Option<GpuCount>) -> Backend {
    let count = gpus.unwrap_or(GpuCount::Exactly(1));
    match backend {
        RenderBackendArg::Cpu => Backend::Cpu,
        RenderBackendArg::Gpu => Backend::Gpu(count),
        RenderBackendArg::Auto => Backend::Auto(count),
    }
}

/// The scene of a file with its plants and the scene light that a flag or the scene names.
pub(crate) fn on_stage(
    scene: Scene,
    plants: Vec<ScenePlant>,
    of: &Path,
    flags: &SceneLightArgs,
) -> Result<Stage, Failure> {
    let file = flags.scene_light.as_deref().or(scene.light.as_deref()).map(Path::to_owned);
    let stage = Stage::new(scene, plants)?;
    let Some(file) = file else {
        return match flags.scene_factor {
            None => Ok(stage),
            Some(_) => {
                let message = "--scene-factor needs scene light: a `light` of the scene, or --scene-light";
                Err(Failure::new(USAGE, message).at(of))
            }
        };
    };
    let library = open(&file)?;
    let factor = flags.scene_factor.unwrap_or_default();
    let compared = SceneLight::load(&library)?.compared_with(factor);
    let light = compared.map_err(|error| Failure::from(error).at(library.path()))?;
    stage.with_scene_light(light).map_err(|error| match error {
        flb_stage::StageError::At { .. } => error.into(),
        error => Failure::from(error).at(library.path()),
    })
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

/// A species of a scene with its mesh and its light.
pub(crate) fn read_plant(
    species: &SceneSpecies,
    scene: &Path,
    (memory, bands): (&MemoryArgs, &BandArgs),
    indirect_scale: Option<f32>,
    mesh_differs: bool,
) -> Result<ScenePlant, Failure> {
    let refuse = |message: &str| Failure::new(USAGE, message).at(scene);
    let file = mesh_file(species).map_err(|error| Failure::from(error).at(scene))?;
    let settings = OpenSettings { bands: bands.show_bands.clone(), mesh_may_differ: mesh_differs };
    let light = PlantLight::open(species, &settings)?;
    if let Some(light) = &light {
        let entry = &light.library.container().species()[light.species];
        let what = format!("the bases of species {:?}", entry.meta.name);
        check(&light.library, &what, sampler_bytes(entry), memory)?;
        if !Shading::of(&entry.meta).units().has_indirect_scale() && indirect_scale.is_some() {
            return Err(refuse("--indirect-scale is for paper files only"));
        }
    }
    check_local(file)?;
    let plant = ScenePlant::with_light(species, light, &settings, &Said)?;
    if plant.light.is_none() {
        Measured::of(&plant.mesh, &plant.read_as, Mend::SpeciesFile).say(file);
    }
    Ok(plant)
}

/// The number of a scene's species in its library: by its name, unless it is the only one there.
pub(crate) fn scene_species(library: &Library, species: &SceneSpecies) -> Result<usize, Failure> {
    open::scene_species(library, species).map_err(|error| Failure::from(error).at(library.path()))
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

impl Outcome {
    fn of(Stage { scene, plants, .. }: &Stage) -> Outcome {
        let mut counts = vec![0; scene.species.len()];
        scene.instances.iter().for_each(|instance| counts[instance.species] += 1);
        let species: Vec<SpeciesOutcome> = scene
            .species
            .iter()
            .zip(plants)
            .zip(&counts)
            .map(|((species, plant), instances)| SpeciesOutcome {
                name: species.name.clone(),
                instances: *instances,
                triangles: plant.mesh.mesh.triangles.len(),
                model: plant.model(),
                mesh_match: plant.matched.map(|matched| matched.name()),
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
