//! Frames on GPUs, where they are asked for and every species can be lit on them.

use std::collections::BTreeSet;
use std::sync::Arc;

use flb_format::progress::Progress;
use flb_gpu::Gpu;
use flb_render::forest::{Forest, View};
use flb_render::{Lighting, Look, Picture};
use flb_render_gpu::{
    self as on_gpu, ForestError, ForestSettings, GpuForest, LightSet, LightSource, can_light,
};
use flb_runtime::light::SkyBeams;
use flb_runtime::scene_light::SceneLightAtSun;
use flb_runtime::{RuntimeError, SpeciesLight};
use flb_scene::{Observer, Step};

use crate::backend::GpuCount;
use crate::{Backend, SceneLook, Stage, StageError, neighbours};

/// A stage on GPUs, and what its camera saw last.
pub(crate) struct Fleet {
    fleet: on_gpu::Fleet,
    view: Option<View>,
    /// Of which sun the shade was sent, which may be none.
    shaded: Option<Option<[f64; 3]>>,
    names: Vec<String>,
    /// GPUs whose loss was told, by their numbers.
    told: BTreeSet<usize>,
}

impl Fleet {
    /// Sends a stage to GPUs, if the backend asks for it; or if it leaves it open, there is one that is no software,
    /// and they can show the scene. What is done instead is told.
    pub(crate) fn send(
        backend: Backend,
        stage: &Stage,
        forest: &Forest<'_>,
        look: &SceneLook,
        observer: &dyn Observer,
    ) -> Result<Option<Fleet>, StageError> {
        let count = match backend {
            Backend::Cpu => return Ok(None),
            Backend::Gpu(count) => return Fleet::new(count, stage, forest, look, observer).map(Some),
            Backend::Auto(count) => count,
        };
        let reason = match flb_gpu::find() {
            Err(error) => error.to_string(),
            Ok(found) if found.is_software => format!("{} is software", found.name),
            Ok(_) => match Fleet::new(count, stage, forest, look, observer) {
                Ok(fleet) => return Ok(Some(fleet)),
                Err(error) => error.to_string(),
            },
        };
        observer.note(&format!("rendering on the CPU: {reason}"));
        Ok(None)
    }

    fn new(
        count: GpuCount,
        stage: &Stage,
        forest: &Forest<'_>,
        look: &SceneLook,
        observer: &dyn Observer,
    ) -> Result<Fleet, StageError> {
        // Before anything is opened, so that a species is refused where there is no GPU as well.
        for (library, species) in stage.plants.iter().filter_map(|plant| plant.library()) {
            let entry = &library.container().species()[species];
            can_light(entry)
                .map_err(|found| ForestError::Unlit { species: entry.meta.name.clone(), found })?;
        }
        let gpus = open(count)?;
        let sources: Vec<LightSource> = stage
            .plants
            .iter()
            .map(|plant| match plant.library().filter(|_| look.has_fields()) {
                Some((library, species)) => LightSource::Library { library, species },
                None => LightSource::Even([0.0; 3]),
            })
            .collect();
        let beams = match look.sky.is_even() {
            true => Vec::new(),
            false => Step::Prepare.run(observer, "sky", |_| beams(stage, look))?,
        };
        let mut members = Vec::new();
        for gpu in &gpus {
            let plants = forest.placements().len();
            let load = |_: &Progress<'_>| LightSet::load_for_skies(gpu, &sources, &beams, plants);
            let lights = Step::Load.run(observer, &gpu.name, load)?;
            let settings = ForestSettings { search: look.search, ..ForestSettings::default() };
            let send = |_: &Progress<'_>| GpuForest::new(gpu, forest, &lights, settings);
            let sent = Step::Prepare.run(observer, &gpu.name, send)?;
            members.push((sent, lights));
        }
        let names = names(&gpus);
        observer.note(&format!("rendering on {}", names.join(", ")));
        Ok(Fleet {
            fleet: on_gpu::Fleet::new(members)?,
            view: None,
            shaded: None,
            names,
            told: BTreeSet::new(),
        })
    }

    /// Names of the GPUs.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// A picture, of plants that do this to each other's light. What the camera sees is found again only when it has
    /// moved.
    pub(crate) fn picture(
        &mut self,
        view: &View,
        (lighting, look): (&Lighting, &Look),
        shade: Option<&SceneLightAtSun<'_>>,
        (subject, observer): (&str, &dyn Observer),
    ) -> Result<Picture, StageError> {
        if self.view != Some(*view) {
            self.view = None;
            Step::Trace.run(observer, "", |_| self.fleet.trace(view))?;
            self.view = Some(*view);
        }
        let sun = neighbours::sun(&lighting.daylight);
        if shade.is_some() && self.shaded != Some(sun) {
            self.shaded = None;
            self.fleet.set_scene_light(shade)?;
            self.shaded = Some(sun);
        }
        let relight = |_: &Progress<'_>| self.fleet.relight(lighting, look);
        let picture = Step::Relight.run(observer, subject, relight)?;
        for (_, error) in self.fleet.lost().filter(|(number, _)| self.told.insert(*number)) {
            observer.note(&format!("warning: {error}: the other GPUs do its part"));
        }
        Ok(picture)
    }

    /// Rays of the last picture that met a plant, the ground, nothing, and water.
    pub(crate) fn rays(&mut self) -> Result<[usize; 4], StageError> {
        Ok(self.fleet.counts()?)
    }

    /// Memory of light on all GPUs.
    pub(crate) fn light_bytes(&self) -> usize {
        self.fleet.light_bytes() as usize
    }
}

/// The GPUs that were asked for.
fn open(count: GpuCount) -> Result<Vec<Gpu>, StageError> {
    let gpus = Gpu::open_up_to(on_gpu::FEATURES, count.most()).map_err(ForestError::from)?;
    match count.missed_by(gpus.len()) {
        Some(expected) => Err(StageError::GpuCount { found: names(&gpus), expected }),
        None => Ok(gpus),
    }
}

fn names(gpus: &[Gpu]) -> Vec<String> {
    gpus.iter().map(|gpu| gpu.name.clone()).collect()
}

/// `[species]`: what the skies over its plants share, where the light of files is shown.
fn beams(stage: &Stage, look: &SceneLook) -> Result<Vec<Option<Arc<SkyBeams>>>, RuntimeError> {
    let of_plant = |plant: &crate::plant::ScenePlant| {
        let Some((library, species)) = plant.library().filter(|_| look.has_fields()) else {
            return Ok(None);
        };
        Ok(Some(Arc::new(SpeciesLight::load(library, species)?.sky_beams()?)))
    };
    stage.plants.iter().map(of_plant).collect()
}
