//! Pictures of a scene on a GPU, where one is asked for and every species can be lit on it.

use flb_gpu::Gpu;
use flb_render::forest::{Forest, View};
use flb_render::{Indirect, Picture};
use flb_render_gpu::{ForestError, ForestSettings, GpuForest, LampSource, Lamps, Met, can_light};
use flb_runtime::scene_light::Shade;

use super::suns::Shot;
use super::{Loaded, Look};
use crate::args::RenderBackendArg;
use crate::exit::Failure;
use crate::stages::Stages;

/// A scene on a GPU, and what its camera saw last.
pub struct OnGpu {
    forest: GpuForest,
    lamps: Lamps,
    view: Option<View>,
    name: String,
}

/// Sends the scene to a GPU, if the flags ask for it; or if they leave it open, there is one that is no software, and it can show the
/// scene. What is done instead is said on stderr.
pub fn send(
    backend: RenderBackendArg,
    forest: &Forest,
    loaded: &[Loaded],
    look: &Look,
    stages: &mut Stages,
) -> Result<Option<OnGpu>, Failure> {
    match backend {
        RenderBackendArg::Cpu => Ok(None),
        RenderBackendArg::Gpu => OnGpu::new(forest, loaded, look, stages).map(Some).map_err(Failure::from),
        RenderBackendArg::Auto => {
            let reason = match flb_gpu::find() {
                Err(error) => error.to_string(),
                Ok(found) if found.is_software => format!("{} is software", found.name),
                Ok(_) => match OnGpu::new(forest, loaded, look, stages) {
                    Ok(on_gpu) => return Ok(Some(on_gpu)),
                    Err(error) => error.to_string(),
                },
            };
            eprintln!("flb: rendering on the CPU: {reason}");
            Ok(None)
        }
    }
}

impl OnGpu {
    fn new(
        forest: &Forest,
        loaded: &[Loaded],
        look: &Look,
        stages: &mut Stages,
    ) -> Result<OnGpu, ForestError> {
        // Before anything is opened, so that a species is refused where there is no GPU as well.
        for (library, species) in loaded.iter().filter_map(|loaded| loaded.light.as_ref()) {
            let entry = &library.container().species()[*species];
            can_light(entry)
                .map_err(|found| ForestError::Unlit { species: entry.meta.name.clone(), found })?;
        }
        let gpu = Gpu::open(flb_render_gpu::FEATURES)?;
        let sources: Vec<LampSource> = loaded
            .iter()
            .map(|loaded| match &loaded.light {
                Some((library, species)) if look.indirect != Indirect::Off => {
                    LampSource::Library { library, species: *species }
                }
                _ => LampSource::Even([0.0; 3]),
            })
            .collect();
        let instances = forest.flat_instances().len();
        let lamps = stages.run("load", &gpu.name, |_| Lamps::load(&gpu, &sources, instances))?;
        let forest = stages
            .run("prepare", &gpu.name, |_| GpuForest::new(&gpu, forest, &lamps, ForestSettings::default()))?;
        eprintln!("flb: rendering on {}", gpu.name);
        Ok(OnGpu { forest, lamps, view: None, name: gpu.name })
    }

    /// Name of the GPU.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// A picture, of plants that do this to each other's light. What the camera sees is found again only when it has moved.
    pub fn picture(
        &mut self,
        shot: &Shot,
        shade: Option<&Shade>,
        look: &Look,
        stages: &mut Stages,
    ) -> Result<Picture, Failure> {
        let view = look.view(shot);
        if self.view != Some(view) {
            self.view = None;
            stages.run("trace", "", |_| {
                self.forest.trace(&view)?;
                self.forest.wait()
            })?;
            self.view = Some(view);
        }
        let picture = stages.run("relight", &shot.subject(), |_| {
            self.forest.set_shade(shade)?;
            self.forest.relight(&mut self.lamps, &look.daylight(shot.sun))?;
            self.forest.picture()
        })?;
        Ok(picture)
    }

    /// Rays of the last picture that met a plant, the ground, nothing, and water.
    pub fn rays(&self) -> Result<[usize; 4], Failure> {
        let mut counts = [0; 4];
        for met in self.forest.fragments()? {
            counts[match met {
                Met::Plant { .. } => 0,
                Met::Ground { .. } => 1,
                Met::Sky => 2,
                Met::Water { .. } => 3,
            }] += 1;
        }
        Ok(counts)
    }

    /// Memory of light on the GPU.
    pub fn light_bytes(&self) -> usize {
        self.lamps.size_bytes() as usize
    }
}
