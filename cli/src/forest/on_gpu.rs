//! Pictures of a scene on GPUs, where they are asked for and every species can be lit on them.

use std::collections::BTreeSet;

use flb_gpu::Gpu;
use flb_render::forest::{Forest, View};
use flb_render::{Indirect, Picture};
use flb_render_gpu::{Fleet, ForestError, ForestSettings, GpuForest, LightSet, LightSource, can_light};
use flb_runtime::scene_light::SceneLightAtSun;

use super::suns::Shot;
use super::{Loaded, PictureOptions};
use crate::args::{GpuCount, RenderBackendArg};
use crate::exit::{Failure, UNSUPPORTED};
use crate::print::say;
use crate::stages::Stages;

/// A scene on GPUs, and what its camera saw last.
pub(super) struct OnGpu {
    fleet: Fleet,
    view: Option<View>,
    names: Vec<String>,
    /// GPUs whose loss was told, by their numbers.
    told: BTreeSet<usize>,
}

/// Sends the scene to GPUs, if the flags ask for it; or if they leave it open, there is one that is no software, and
/// they can show the scene. What is done instead is said on stderr.
pub(super) fn send(
    backend: RenderBackendArg,
    count: Option<GpuCount>,
    forest: &Forest,
    loaded: &[Loaded],
    look: &PictureOptions,
    stages: &Stages,
) -> Result<Option<OnGpu>, Failure> {
    let count = count.unwrap_or(GpuCount::Exactly(1));
    match backend {
        RenderBackendArg::Cpu => Ok(None),
        RenderBackendArg::Gpu => OnGpu::new(count, forest, loaded, look, stages).map(Some),
        RenderBackendArg::Auto => {
            let reason = match flb_gpu::find() {
                Err(error) => error.to_string(),
                Ok(found) if found.is_software => format!("{} is software", found.name),
                Ok(_) => match OnGpu::new(count, forest, loaded, look, stages) {
                    Ok(on_gpu) => return Ok(Some(on_gpu)),
                    Err(failure) => failure.message,
                },
            };
            say!("rendering on the CPU: {reason}");
            Ok(None)
        }
    }
}

/// The GPUs that were asked for.
fn open(count: GpuCount) -> Result<Vec<Gpu>, Failure> {
    let most = match count {
        GpuCount::All => usize::MAX,
        GpuCount::Exactly(count) => count,
    };
    let gpus = Gpu::open_up_to(flb_render_gpu::FEATURES, most).map_err(ForestError::from)?;
    match count {
        GpuCount::Exactly(count) if gpus.len() < count => {
            let message = format!("--gpus {count}: found {}: {}", gpus.len(), names(&gpus).join(", "));
            Err(Failure::new(UNSUPPORTED, message))
        }
        _ => Ok(gpus),
    }
}

fn names(gpus: &[Gpu]) -> Vec<String> {
    gpus.iter().map(|gpu| gpu.name.clone()).collect()
}

impl OnGpu {
    fn new(
        count: GpuCount,
        forest: &Forest,
        loaded: &[Loaded],
        look: &PictureOptions,
        stages: &Stages,
    ) -> Result<OnGpu, Failure> {
        if !look.sky.is_even() {
            return Err(ForestError::UnevenSky.into());
        }
        // Before anything is opened, so that a species is refused where there is no GPU as well.
        for (library, species) in loaded.iter().filter_map(|loaded| loaded.light.as_ref()) {
            let entry = &library.container().species()[*species];
            can_light(entry)
                .map_err(|found| ForestError::Unlit { species: entry.meta.name.clone(), found })?;
        }
        let gpus = open(count)?;
        let sources: Vec<LightSource> = loaded
            .iter()
            .map(|loaded| match &loaded.light {
                Some((library, species)) if look.look.indirect != Indirect::Off => {
                    LightSource::Library { library, species: *species }
                }
                _ => LightSource::Even([0.0; 3]),
            })
            .collect();
        let instances = forest.placements().len();
        let mut members = Vec::new();
        for gpu in &gpus {
            let lights = stages.run("load", &gpu.name, |_| LightSet::load(gpu, &sources, instances))?;
            let settings = ForestSettings::default();
            let sent =
                stages.run("prepare", &gpu.name, |_| GpuForest::new(gpu, forest, &lights, settings))?;
            members.push((sent, lights));
        }
        let names = names(&gpus);
        say!("rendering on {}", names.join(", "));
        Ok(OnGpu { fleet: Fleet::new(members)?, view: None, names, told: BTreeSet::new() })
    }

    /// Names of the GPUs.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// A picture, of plants that do this to each other's light. What the camera sees is found again only when it has
    /// moved.
    pub(super) fn picture(
        &mut self,
        shot: &Shot,
        shade: Option<&SceneLightAtSun>,
        look: &PictureOptions,
        stages: &Stages,
    ) -> Result<Picture, Failure> {
        let view = look.view(shot);
        if self.view != Some(view) {
            self.view = None;
            stages.run("trace", "", |_| self.fleet.trace(&view))?;
            self.view = Some(view);
        }
        let lighting = look.lighting(shot.sun)?;
        let relight = |_: &(dyn Fn(f64) + Sync)| self.fleet.relight(&lighting, &look.look, shade);
        let picture = stages.run("relight", &shot.subject(), relight)?;
        for (_, error) in self.fleet.lost().filter(|(number, _)| self.told.insert(*number)) {
            say!("warning: {error}: the other GPUs do its part");
        }
        Ok(picture)
    }

    /// Rays of the last picture that met a plant, the ground, nothing, and water.
    pub(super) fn rays(&mut self) -> Result<[usize; 4], Failure> {
        Ok(self.fleet.counts()?)
    }

    /// Memory of light on all GPUs.
    pub(super) fn light_bytes(&self) -> usize {
        self.fleet.light_bytes() as usize
    }
}
