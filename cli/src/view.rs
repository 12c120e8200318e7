//! `flb view SCENE.toml`: a window on a scene, or what it would show as a picture.

use std::path::Path;
use std::time::Duration;

use flb_files::{check_unread, publish};
use flb_gpu::Gpu;
use flb_render::forest::Eye;
use flb_render::picture::png_of;
use flb_scene::scene::{Scene, Suns};
use flb_stage::plant::ScenePlant;
use flb_stage::stream::{Painted, Painter, Shot, Show};
use flb_stage::{LookSettings, SceneLook, Stage, StageError};
use flb_view::screen::Screen;
use flb_view::{Controls, ViewError, window};
use serde::Serialize;

use crate::args::{RenderBackendArg, ViewArgs};
use crate::exit::{Failure, LOSS, USAGE};
use crate::forest;
use crate::inputs::{check_output_of, read_scene};
use crate::memory::check_plants;
use crate::picture::expect_png;
use crate::print::{self, line, say};
use crate::sky::read_sky;

/// Where the sun stands by default.
const SUN_DEG: [f64; 2] = [135.0, 40.0];
/// The same where an image lights the scene by itself.
const NO_SUN_DEG: [f64; 2] = [135.0, -90.0];
/// Of a camera that was not placed.
const FOV_DEG: f64 = 40.0;
/// Longest wait for the light of a screenshot.
const LONGEST: Duration = Duration::from_secs(300);

/// What `--json` prints (cli/schema/view.json).
#[derive(Serialize)]
struct Viewed {
    scene: String,
    instances: usize,
    /// `null` for a window.
    screenshot: Option<String>,
    width: u32,
    height: u32,
    loaded_bytes: u64,
    budget_bytes: u64,
    quality: f32,
    is_final: bool,
    failures: Vec<String>,
    /// What the light is not complete without and the budget has no room for.
    lacks: Vec<String>,
    /// Name of the GPU that painted.
    adapter: Option<String>,
    species: Vec<SpeciesViewed>,
}

#[derive(Serialize)]
struct SpeciesViewed {
    name: String,
    /// Whether its light is of its mesh; `null` without light.
    mesh_match: Option<&'static str>,
}

/// Reads the scene and shows it.
pub(crate) fn run(args: &ViewArgs) -> Result<u8, Failure> {
    if let Some(output) = &args.screenshot {
        check_output_of(output, &[&args.scene], args.existing)?;
        expect_png(output, "a screenshot is a PNG: expected OUT.png")?;
    }
    let outputs: Vec<&Path> = args.screenshot.iter().map(|path| path.as_path()).collect();
    let scene = read_scene(&args.scene, &outputs)?;
    let read = |species| {
        forest::read_plant(species, &args.scene, (&args.memory, &args.bands), None, args.mesh_differs)
    };
    let plants = scene.species.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    outputs.iter().try_for_each(|output| check_unread(output))?;
    check_base(args.show, &plants)?;
    let sky = read_sky(&args.sky, &scene.sky, scene.backdrop.as_deref())?;
    let (needs_sun, is_even) = (sky.needs_sun(), sky.is_even());
    let plant_bytes = Stage::PLANT_BYTES + if is_even { 0 } else { Stage::SKY_BYTES };
    check_plants(&args.scene, scene.instances.len(), plant_bytes, &args.memory)?;
    let stage = forest::on_stage(scene, plants, &args.scene, &args.scene_light)?;
    let scene = &stage.scene;
    let settings = LookSettings {
        size: None,
        samples: args.samples,
        ambient: args.ambient,
        irradiance: args.sunlight.sun_irradiance,
        added_suns: args.sunlight.added(),
        highlight: args.highlight.choice(),
        ..LookSettings::default()
    };
    let look =
        SceneLook::new(&stage, &settings, sky).map_err(|error| Failure::from(error).at(&args.scene))?;
    for name in stage.under_even_sky().filter(|_| !is_even) {
        say!("warning: {name}: shown under an even sky: its light is of single directions of the sun");
    }
    let painter = Painter::new(&stage, look, (args.budget * 1e6) as u64)?;
    let sun_deg = sun(scene, args, needs_sun);
    let shot = Shot { eye: eye(scene, painter.bounds_m()), sun_deg, show: args.show };
    let controls = Controls::new(shot, args.exposure.unwrap_or(stage.default_exposure()));
    let painter = on_backend(args.backend, painter)?;
    let seen = match &args.screenshot {
        Some(output) => Some(screenshot(args, output, controls, painter)?),
        None => {
            let title = format!("flb view {}", args.scene.display());
            let close = args.seconds.map(|seconds| Duration::from_secs_f64(seconds.clamp(0.0, 1e6)));
            window::run(&title, args.size, args.samples, close, controls, painter)?
        }
    };
    let viewed = Viewed::of(args, &stage, seen.as_ref());
    if let Some(reason) = seen.as_ref().and_then(|painted| painted.progress.left_gpu.as_ref()) {
        say!("painted on the CPU: {reason}");
    }
    match args.json {
        true => print::json(&viewed)?,
        false => print::out(&viewed.text())?,
    }
    for given_up in &viewed.failures {
        say!("{}: given up: {given_up}", viewed.scene);
    }
    Ok(if viewed.failures.is_empty() { 0 } else { LOSS })
}

/// On a GPU, if the flags ask for it; or if they leave it open, there is one that is no software, and it can take the
/// scene.
fn on_backend(backend: RenderBackendArg, painter: Painter<'_>) -> Result<Painter<'_>, Failure> {
    let is_open = match backend {
        RenderBackendArg::Cpu => return Ok(painter),
        RenderBackendArg::Gpu => false,
        RenderBackendArg::Auto if flb_gpu::find().is_ok_and(|found| !found.is_software) => true,
        RenderBackendArg::Auto => return Ok(painter),
    };
    let mut painter = painter;
    let sent = Gpu::open(flb_render_gpu::FEATURES)
        .map_err(StageError::from)
        .and_then(|gpu| painter.send(&gpu, !is_open));
    match sent {
        Err(error) if is_open => say!("painting on the CPU: {error}"),
        sent => sent?,
    }
    Ok(painter)
}

fn screenshot(
    args: &ViewArgs,
    output: &Path,
    mut controls: Controls,
    mut painter: Painter,
) -> Result<Painted, Failure> {
    let gpu = Gpu::open(Default::default()).map_err(ViewError::from)?;
    let mut screen = Screen::offscreen(gpu);
    screen.bases = painter.bases();
    // The first frame tells how large the picture's place is.
    let (_, drawn) = screen.shot(args.size, Vec::new(), &mut controls)?;
    let painted = painter.paint_whole(&controls.shot, drawn.picture_px, LONGEST)?;
    screen.set(painted.clone());
    let (rgb, _) = screen.shot(args.size, Vec::new(), &mut controls)?;
    let png = png_of(args.size, &rgb)?;
    publish(output, args.existing, |file| file.write_all(&png))?;
    Ok(painted)
}

/// Refuses to show a base that no species has.
fn check_base(show: Show, plants: &[ScenePlant]) -> Result<(), Failure> {
    let counts = plants
        .iter()
        .filter_map(ScenePlant::library)
        .map(|(library, index)| library.container().species()[index].bases.len());
    match (show, counts.max()) {
        (Show::Base(base), Some(count)) if usize::from(base) >= count => {
            Err(Failure::new(USAGE, format!("--show base:{base}: the species have bases 0 to {}", count - 1)))
        }
        _ => Ok(()),
    }
}

fn sun(scene: &Scene, args: &ViewArgs, needs_sun: bool) -> [f64; 2] {
    let first = match &scene.suns {
        Suns::Fixed(suns) => suns.first().copied(),
        _ => None,
    };
    args.sun.or(first).unwrap_or(if needs_sun { SUN_DEG } else { NO_SUN_DEG })
}

/// The scene's camera where its path begins; without one, from the south, so far off that all is seen.
fn eye(scene: &Scene, [low, high]: [[f64; 3]; 2]) -> Eye {
    let camera = scene.camera.as_ref();
    if let Some((camera, look_at_m)) = camera.and_then(|c| c.look_at_m.as_ref().map(|at| (c, at)))
        && let (Some(position_m), Some(look_at_m)) = (camera.path_m.first(), look_at_m.first())
    {
        return Eye { position_m: *position_m, look_at_m: *look_at_m, fov_deg: camera.fov_deg };
    }
    let middle: [f64; 3] = std::array::from_fn(|axis| (low[axis] + high[axis]) / 2.0);
    let edge = (0..3).map(|axis| high[axis] - low[axis]).fold(0.1, f64::max);
    let position_m = [middle[0], middle[1] + 0.3 * edge, middle[2] + 1.8 * edge];
    Eye { position_m, look_at_m: middle, fov_deg: FOV_DEG }
}

impl Viewed {
    fn of(args: &ViewArgs, Stage { scene, plants, .. }: &Stage, seen: Option<&Painted>) -> Viewed {
        let of_species = scene.species.iter().zip(plants).map(|(species, plant)| SpeciesViewed {
            name: species.name.clone(),
            mesh_match: plant.matched.map(|matched| matched.name()),
        });
        let progress = seen.map(|painted| painted.progress.clone()).unwrap_or_default();
        Viewed {
            scene: args.scene.display().to_string(),
            instances: scene.instances.len(),
            screenshot: args.screenshot.as_ref().map(|output| output.display().to_string()),
            width: args.size[0],
            height: args.size[1],
            loaded_bytes: progress.loaded_bytes,
            budget_bytes: (args.budget * 1e6) as u64,
            quality: progress.quality,
            is_final: progress.is_final,
            failures: progress.failures,
            lacks: progress.lacks,
            adapter: progress.adapter,
            species: of_species.collect(),
        }
    }

    fn text(&self) -> String {
        let what = self.screenshot.as_deref().unwrap_or(&self.scene);
        let lacks: String = self.lacks.iter().map(|lack| line!("{lack}")).collect();
        let light = line!(
            "{what}: {} instances, {} of light in memory, {:.1} % of what the picture could use{}",
            self.instances,
            print::bytes(self.loaded_bytes),
            100.0 * self.quality,
            if self.is_final { "" } else { ", still loading" },
        );
        light + &lacks
    }
}
