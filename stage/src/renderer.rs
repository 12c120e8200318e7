//! Frames of a stage in the light of whole files.

use std::sync::Arc;

use flb_format::progress::Progress;
use flb_render::forest::{Forest, Fragments, View};
use flb_render::{LightQuery, Lighting, Picture};
use flb_runtime::SpeciesLight;
use flb_runtime::light::{LightCursors, SkyBeams};
use flb_scene::{Observer, Step};

use crate::fleet::Fleet;
use crate::frames::subject;
use crate::neighbours::Neighbours;
use crate::parts::Part;
use crate::show::Shows;
use crate::{Backend, SceneFrame, SceneLook, SceneShow, Stage, StageError, light, suns};

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
        let backend = match (Shows(&look.shows).needs_cpu(), backend) {
            (false, backend) => backend,
            (true, Backend::Gpu(_)) => return Err(StageError::OnCpuAlone),
            (true, Backend::Cpu | Backend::Auto(_)) => Backend::Cpu,
        };
        let forest = Step::Prepare.run(observer, "", |_| stage.forest(look.search))?;
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

    /// The picture of a frame, linear, of the first content of its look. What the camera sees and what plants do to
    /// each other's light is kept for the next one.
    ///
    /// # Errors
    /// [`StageError::Render`], [`StageError::Runtime`]; of GPUs, when the last one was lost.
    pub fn picture(&mut self, frame: &SceneFrame, observer: &dyn Observer) -> Result<Picture, StageError> {
        self.layer(frame, self.look.shows[0], observer)
    }

    /// The pictures of a frame, one of each content of its look.
    ///
    /// # Errors
    /// As [`SceneRenderer::picture`].
    pub fn layers(
        &mut self,
        frame: &SceneFrame,
        observer: &dyn Observer,
    ) -> Result<Vec<(SceneShow, Picture)>, StageError> {
        let shows = self.look.shows.clone();
        shows.into_iter().map(|show| Ok((show, self.layer(frame, show, observer)?))).collect()
    }

    fn layer(
        &mut self,
        frame: &SceneFrame,
        show: SceneShow,
        observer: &dyn Observer,
    ) -> Result<Picture, StageError> {
        let (view, look) = (self.look.view(frame), show.look(&self.look.look));
        if show.is_light() {
            let parts = self.look.parts(frame.sun_deg, &look)?;
            return parts.sum(|part| self.part(&view, part, observer));
        }
        let lighting = self.look.lighting(frame.sun_deg)?;
        let subject = subject(frame.sun_deg);
        if show == SceneShow::Global {
            self.turn(&lighting, observer)?;
        }
        let shade = self.neighbours.as_ref().and_then(Neighbours::shade);
        let On::Cpu(cpu) = &mut self.on else { return Err(StageError::OnCpuAlone) };
        let fragments = seen(&mut cpu.camera, &self.forest, &view, observer)?;
        if show == SceneShow::Alpha {
            return Ok(self.forest.coverage(fragments, &lighting, &look)?);
        }
        let placements = &self.stage.scene.instances;
        if let SceneShow::Base(base) = show {
            let light = |LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]| {
                if let Some(light) = &cpu.light[placements[instance as usize].species] {
                    light.base_at(usize::from(base), point, phi);
                }
            };
            let relight =
                |progress: &Progress<'_>| self.forest.relight(fragments, &lighting, &look, &light, progress);
            return Ok(Step::Relight.run(observer, &subject, relight)?);
        }
        let find = |dome| Step::Sky.run(observer, &subject, |_| light::skies(&cpu.beams, placements, dome));
        let skies = lighting.dome.as_ref().map(find).transpose()?;
        let of_plants =
            |shade| light::of_plants(&cpu.light, skies.as_ref(), placements, &lighting, shade, view.samples);
        let (among, alone) = (of_plants(shade)?, of_plants(None)?);
        let [among, alone] = [&among, &alone].map(|lit| LightCursors::new(lit));
        let show = |LightQuery { instance, point, facing }: LightQuery, color: &mut [f32; 3]| {
            let [mut all, mut own] = [[0.0; 3]; 2];
            among.at_facing(instance as usize, point, facing, &mut all);
            alone.at_facing(instance as usize, point, facing, &mut own);
            *color = [share(all, own); 3];
        };
        Step::Relight.run(observer, &subject, |_| Ok(self.forest.marked(fragments, &show)))
    }

    /// The picture of a part of the light.
    fn part(&mut self, view: &View, part: &Part, observer: &dyn Observer) -> Result<Picture, StageError> {
        let Part { lighting, look, sun_deg, .. } = part;
        self.turn(lighting, observer)?;
        let shade = self.neighbours.as_ref().and_then(Neighbours::shade);
        let subject = subject(*sun_deg);
        let OnCpu { light, beams, camera } = match &mut self.on {
            On::Gpus(fleet) => return fleet.picture(view, (lighting, look), shade, (&subject, observer)),
            On::Cpu(cpu) => &mut **cpu,
        };
        let fragments = seen(camera, &self.forest, view, observer)?;
        let placements = &self.stage.scene.instances;
        let find = |dome| Step::Sky.run(observer, &subject, |_| light::skies(beams, placements, dome));
        let skies = lighting.dome.as_ref().map(find).transpose()?;
        let lit = Step::Prepare.run(observer, &subject, |_| {
            suns::of_picture(light, skies.as_ref(), placements, lighting, shade, fragments)
        })?;
        let cursors = LightCursors::new(&lit);
        let light = |LightQuery { instance, point, facing }: LightQuery, phi: &mut [f32; 3]| {
            cursors.at_facing(instance as usize, point, facing, phi);
        };
        let relight =
            |progress: &Progress<'_>| self.forest.relight(fragments, lighting, look, &light, progress);
        Ok(Step::Relight.run(observer, &subject, relight)?)
    }

    /// Finds what plants do to each other's light, if the sun has moved.
    fn turn(&mut self, lighting: &Lighting, observer: &dyn Observer) -> Result<(), StageError> {
        if let Some(neighbours) = self.neighbours.as_mut().filter(|one| !one.is_at(&lighting.daylight)) {
            Step::Shade.run(observer, "", |_| neighbours.turn(&lighting.daylight))?;
        }
        Ok(())
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

/// What the camera sees, traced unless it is known.
fn seen<'k>(
    camera: &'k mut Kept,
    forest: &Forest<'_>,
    view: &View,
    observer: &dyn Observer,
) -> Result<&'k Fragments, StageError> {
    camera.fragments(view, || Ok(Step::Trace.run(observer, "", |progress| forest.trace(view, progress))?))
}

/// Light among neighbours over that of a plant alone; 0 where there is neither.
fn share(among: [f32; 3], alone: [f32; 3]) -> f32 {
    let [among, alone] = [among, alone].map(|light| light.iter().sum::<f32>().max(0.0));
    if alone > 0.0 { among / alone } else { 0.0 }
}
