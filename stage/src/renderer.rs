//! Frames of a stage in the light of whole files.

use std::sync::Arc;

use flb_format::progress::Progress;
use flb_render::forest::{Forest, Fragments, Search, View};
use flb_render::{LightQuery, Picture};
use flb_runtime::SpeciesLight;
use flb_runtime::light::{LightCursors, SkyBeams};
use flb_scene::{Observer, Step};

use crate::fleet::Fleet;
use crate::frames::subject;
use crate::look::SceneShow;
use crate::neighbours::Neighbours;
use crate::parts::Part;
use crate::{Backend, SceneFrame, SceneLook, Stage, StageError, light};

/// Makes frames of a stage in the light of whole files.
pub struct SceneRenderer<'s> {
    stage: &'s Stage,
    look: SceneLook,
    forest: Forest<'s>,
    neighbours: Option<Neighbours<'s>>,
    on: On,
}

enum On {
    Gpus(Box<Fleet>),
    Cpu(Box<OnCpu>),
}

struct OnCpu {
    /// `[species]`
    light: Vec<Option<SpeciesLight<'static>>>,
    /// `[species]`
    beams: Vec<Option<Arc<SkyBeams>>>,
    camera: Kept,
}

/// What the camera saw last: it is found again only when the camera has moved.
#[derive(Default)]
pub(crate) struct Kept {
    view: Option<View>,
    fragments: Option<Fragments>,
}

impl Kept {
    /// What a camera sees, traced by `trace` unless it is known.
    pub(crate) fn fragments<E>(
        &mut self,
        view: &View,
        trace: impl FnOnce() -> Result<Fragments, E>,
    ) -> Result<&Fragments, E> {
        if self.view != Some(*view) {
            self.fragments = None;
        }
        self.view = Some(*view);
        match &mut self.fragments {
            Some(fragments) => Ok(fragments),
            none => Ok(none.insert(trace()?)),
        }
    }
}

impl<'s> SceneRenderer<'s> {
    /// Loads what frames show of the light, and makes the scene ready for rays.
    ///
    /// # Errors
    /// [`StageError`]: of the scene's files, its light, and of GPUs that are needed.
    pub fn new(
        stage: &'s Stage,
        look: SceneLook,
        frames: &[SceneFrame],
        backend: Backend,
        observer: &dyn Observer,
    ) -> Result<SceneRenderer<'s>, StageError> {
        let backend = match (look.show, backend) {
            (SceneShow::Light, backend) => backend,
            (SceneShow::Global, Backend::Gpu(_)) => return Err(StageError::OnCpuAlone),
            (SceneShow::Global, Backend::Cpu | Backend::Auto(_)) => Backend::Cpu,
        };
        let forest = Step::Prepare.run(observer, "", |_| stage.forest(Search::default()))?;
        let on = match Fleet::send(backend, stage, &forest, &look, observer)? {
            Some(fleet) => On::Gpus(Box::new(fleet)),
            None => {
                let light = Step::Load.run(observer, "", |_| light::load(stage, frames, &look))?;
                let beams = match look.sky.is_even() {
                    true => light.iter().map(|_| None).collect(),
                    false => Step::Prepare.run(observer, "sky", |_| light::beams(&light))?,
                };
                On::Cpu(Box::new(OnCpu { light, beams, camera: Kept::default() }))
            }
        };
        Ok(SceneRenderer { stage, look, forest, neighbours: Neighbours::of(stage), on })
    }

    /// The picture of a frame, linear. What the camera sees and what plants do to each other's light is kept for the
    /// next one.
    ///
    /// # Errors
    /// [`StageError::Render`], [`StageError::Runtime`]; of GPUs, when the last one was lost.
    pub fn picture(&mut self, frame: &SceneFrame, observer: &dyn Observer) -> Result<Picture, StageError> {
        let view = self.look.view(frame);
        self.look.parts(frame.sun_deg, &self.look.look)?.sum(|part| self.part(&view, part, observer))
    }

    /// The picture of a part of the light.
    fn part(&mut self, view: &View, part: &Part, observer: &dyn Observer) -> Result<Picture, StageError> {
        let Part { lighting, look, sun_deg, .. } = part;
        if let Some(neighbours) = self.neighbours.as_mut().filter(|one| !one.is_at(&lighting.daylight)) {
            Step::Shade.run(observer, "", |_| neighbours.turn(&lighting.daylight))?;
        }
        let shade = self.neighbours.as_ref().and_then(Neighbours::shade);
        let subject = subject(*sun_deg);
        let OnCpu { light, beams, camera } = match &mut self.on {
            On::Gpus(fleet) => return fleet.picture(view, (lighting, look), shade, (&subject, observer)),
            On::Cpu(cpu) => &mut **cpu,
        };
        let forest = &self.forest;
        let trace = || Step::Trace.run(observer, "", |progress| forest.trace(view, progress));
        let fragments = camera.fragments(view, trace)?;
        let placements = &self.stage.scene.instances;
        let find = |dome| Step::Sky.run(observer, &subject, |_| light::skies(beams, placements, dome));
        let skies = lighting.dome.as_ref().map(find).transpose()?;
        let lit = light::of_plants(light, skies.as_ref(), placements, lighting, shade, self.look.samples)?;
        let cursors = LightCursors::new(&lit);
        if self.look.show == SceneShow::Global {
            let bare =
                light::of_plants(light, skies.as_ref(), placements, lighting, None, self.look.samples)?;
            let bare = LightCursors::new(&bare);
            let show = |LightQuery { instance, point, facing }: LightQuery, color: &mut [f32; 3]| {
                let [mut among, mut alone] = [[0.0; 3]; 2];
                cursors.at_facing(instance as usize, point, facing, &mut among);
                bare.at_facing(instance as usize, point, facing, &mut alone);
                *color = [share(among, alone); 3];
            };
            return Step::Relight.run(observer, &subject, |_| Ok(forest.marked(fragments, &show)));
        }
        let light = |LightQuery { instance, point, facing }: LightQuery, phi: &mut [f32; 3]| {
            cursors.at_facing(instance as usize, point, facing, phi);
        };
        let relight = |progress: &Progress<'_>| forest.relight(fragments, lighting, look, &light, progress);
        Ok(Step::Relight.run(observer, &subject, relight)?)
    }

    /// Rays of the last frame that met a plant, the ground, nothing, and water.
    ///
    /// # Errors
    /// Of GPUs, from which they are read back.
    pub fn rays(&mut self) -> Result<[usize; 4], StageError> {
        match &mut self.on {
            On::Gpus(fleet) => fleet.rays(),
            On::Cpu(cpu) => Ok(cpu.camera.fragments.as_ref().map_or([0; 4], Fragments::counts)),
        }
    }

    /// Memory of the light that was loaded.
    pub fn light_bytes(&self) -> usize {
        match &self.on {
            On::Gpus(fleet) => fleet.light_bytes(),
            On::Cpu(cpu) => light::size_bytes(&cpu.light, &cpu.beams),
        }
    }

    /// Names of the GPUs that draw; none on the CPU.
    pub fn adapters(&self) -> &[String] {
        match &self.on {
            On::Gpus(fleet) => fleet.names(),
            On::Cpu(_) => &[],
        }
    }
}

/// Light among neighbours over that of a plant alone; 0 where there is neither.
fn share(among: [f32; 3], alone: [f32; 3]) -> f32 {
    let [among, alone] = [among, alone].map(|light| light.iter().sum::<f32>().max(0.0));
    if alone > 0.0 { among / alone } else { 0.0 }
}
