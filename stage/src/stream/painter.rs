//! Paints a stage with what has come of its light.

use std::sync::Arc;
use std::time::{Duration, Instant};

use flb_format::Daylight;
use flb_format::Placement;
#[cfg(feature = "gpu")]
use flb_format::light::SunBasis;
use flb_format::sun::towards_sun;
#[cfg(feature = "gpu")]
use flb_gpu::Gpu;
use flb_render::forest::{Eye, Forest, Fragments, Search, View};
use flb_render::{Indirect, LightQuery, Lighting, Look, Picture};
use flb_runtime::light::{LightCursors, SkyBeams};
use flb_runtime::residency::{Need, NeedFinder, Placed, ResidencySettings};
use flb_runtime::resident::ResidentSpecies;
use flb_runtime::stream::{StreamSettings, Streamer};
use flb_runtime::view::Camera;
use flb_runtime::{InstanceLight, Library, SpeciesLight};

use super::on_gpu::{self, OnGpu};
use super::{Shot, Show, marks};
use crate::frames::water_plane;
use crate::light::Skies;
use crate::look::SKY_RAYS;
use crate::neighbours::Neighbours;
use crate::parts::Part;
use crate::renderer::Kept;
use crate::{SceneLook, Stage, StageError, light, suns};

/// Bytes that the light of a whole file may take, where it is asked for to compare with.
const WHOLE_BYTES: u64 = 4 << 30;
/// How far above water an eye stays.
const ABOVE_WATER_M: f64 = 0.05;
/// Longest wait for the whole light before the next picture.
const WHOLE_WAIT: Duration = Duration::from_millis(500);

/// A picture, and how it came about.
#[derive(Debug, Clone)]
pub struct Painted {
    /// Picture in linear light; of false colours, already as they are to be seen.
    pub picture: Picture,
    /// Shot that was painted.
    pub shot: Shot,
    /// Rays per pixel.
    pub samples: u32,
    /// State of the light that is loaded.
    pub progress: Progress,
    /// Seconds that the camera's rays took, 0 where they were there, and those of shadows and light.
    pub seconds: [f64; 2],
}

/// State of the light that is loaded.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Progress {
    /// Memory that is taken.
    pub loaded_bytes: u64,
    /// Memory that may be.
    pub budget_bytes: u64,
    /// Share of what the picture could use that is loaded, by the error that it removes; of the library that has least.
    pub quality: f32,
    /// Whether nothing is missing that fits.
    pub is_final: bool,
    /// Units that were given up, each once.
    pub failures: Vec<String>,
    /// Memory that the light is not complete without and the budget has no room for.
    pub lacks: Vec<String>,
    /// Name of the GPU that paints.
    pub adapter: Option<String>,
    /// Reason why a GPU no longer paints.
    pub left_gpu: Option<String>,
}

/// A library that is streamed for its species' instances.
struct Streamed {
    streamer: Streamer,
    finder: NeedFinder,
    placed: Placed,
}

/// Draws a stage.
pub struct Painter<'s> {
    stage: &'s Stage,
    forest: Forest<'s>,
    /// `[species of the scene]`: which library, and the number there.
    lights: Vec<Option<(usize, usize)>>,
    libraries: Vec<Arc<Library>>,
    streamed: Vec<Streamed>,
    /// The same with all light there is, once it was asked for.
    whole: Option<Vec<Streamed>>,
    /// `[species of the scene]`: what the skies over its plants share, once there is enough of it.
    beams: Vec<Option<Arc<SkyBeams>>>,
    /// Rays per pixel are those of a picture that has come to rest.
    look: SceneLook,
    /// Memory that the light may take, all libraries together.
    budget_bytes: u64,
    neighbours: Option<Neighbours<'s>>,
    on_gpu: Option<OnGpu>,
    /// Whether nothing but the GPU will do.
    needs_gpu: bool,
    left_gpu: Option<String>,
    camera: Kept,
    failures: Vec<String>,
}

impl<'s> Painter<'s> {
    /// Opens the streams of a stage's libraries, which share a budget of bytes evenly. Scene light is beside the
    /// budget, and so is what an uneven sky shares over the plants of a species.
    ///
    /// # Errors
    /// [`StageError::Import`], [`StageError::Render`] for a scene that cannot be drawn; [`StageError::Runtime`] for a
    /// library that cannot be streamed.
    pub fn new(stage: &'s Stage, look: SceneLook, budget_bytes: u64) -> Result<Painter<'s>, StageError> {
        let mut libraries: Vec<Arc<Library>> = Vec::new();
        let mut place = |light: &crate::plant::PlantLight| {
            let known = libraries.iter().position(|library| Arc::ptr_eq(library, &light.library));
            let at = known.unwrap_or_else(|| {
                libraries.push(Arc::clone(&light.library));
                libraries.len() - 1
            });
            (at, light.species)
        };
        let lights = stage.plants.iter().map(|plant| plant.light.as_ref().map(&mut place)).collect();
        let mut painter = Painter {
            stage,
            forest: stage.forest(Search::default())?,
            lights,
            libraries,
            streamed: Vec::new(),
            whole: None,
            look,
            budget_bytes,
            beams: stage.plants.iter().map(|_| None).collect(),
            neighbours: Neighbours::of(stage),
            on_gpu: None,
            needs_gpu: false,
            left_gpu: None,
            camera: Kept::default(),
            failures: Vec::new(),
        };
        painter.streamed = painter.open(budget_bytes)?;
        Ok(painter)
    }

    /// The box around all plants: its lowest and its highest coordinates.
    pub fn bounds_m(&self) -> [[f64; 3]; 2] {
        self.forest.bounds_m()
    }

    /// Lets a GPU paint from now on, but for the false colours, which say what the CPU has. Where it fails, the CPU
    /// goes on, unless the GPU is needed.
    ///
    /// # Errors
    /// [`StageError::Unlit`] without any light, [`StageError::Libraries`] unless all is of one library;
    /// [`StageError::Forest`] for a scene that the GPU cannot take.
    #[cfg(feature = "gpu")]
    pub fn send(&mut self, gpu: &Gpu, is_needed: bool) -> Result<(), StageError> {
        let [streamed] = &self.streamed[..] else {
            return Err(match self.streamed.len() {
                0 => StageError::Unlit,
                files => StageError::Libraries(files),
            });
        };
        let species = self.lights.iter().map(|light| light.map(|(_, species)| species)).collect();
        let units = streamed.streamer.residency().units();
        let suns: Vec<&SunBasis> = match self.look.sky.is_even() {
            true => Vec::new(),
            false => self.stage.plants.iter().filter_map(crate::plant::ScenePlant::suns).collect(),
        };
        self.on_gpu = Some(OnGpu::new(gpu, &self.forest, units, (species, &suns), self.budget_bytes)?);
        self.needs_gpu = is_needed;
        Ok(())
    }

    /// After an error of a GPU that is not needed: whether the CPU goes on.
    fn leave_gpu(&mut self, error: &StageError) -> bool {
        let may_leave = self.on_gpu.is_some() && !self.needs_gpu && on_gpu::is_of_gpu(error);
        if may_leave {
            self.on_gpu = None;
            self.left_gpu = Some(error.to_string());
        }
        may_leave
    }

    /// Bases of the species that has most.
    pub fn bases(&self) -> u16 {
        let count = |(library, species): &(usize, usize)| {
            self.libraries[*library].container().species()[*species].bases.len()
        };
        self.lights.iter().flatten().map(count).max().unwrap_or(0) as u16
    }

    /// Streamers of all libraries, which share a budget evenly.
    fn open(&self, budget_bytes: u64) -> Result<Vec<Streamed>, StageError> {
        let each = budget_bytes / self.libraries.len().max(1) as u64;
        let open = |(number, library): (usize, &Arc<Library>)| {
            let residency = ResidencySettings { budget_bytes: each, ..ResidencySettings::default() };
            let streamer = Streamer::new(
                Arc::clone(library),
                StreamSettings { residency, ..StreamSettings::default() },
            )?;
            let container = library.container();
            let finder = NeedFinder::new(container, streamer.residency().units());
            let placed =
                self.stage.scene.instances.iter().filter_map(|plant| match self.lights[plant.species] {
                    Some((at, species)) if at == number => Some(Placement { species, ..*plant }),
                    _ => None,
                });
            Ok(Streamed { streamer, finder, placed: Placed::new(container, placed) })
        };
        self.libraries.iter().enumerate().map(open).collect()
    }

    /// A picture. What the camera's rays meet is kept for the next one.
    ///
    /// # Errors
    /// [`StageError::Render`]; [`StageError::Runtime`] for scene light that lacks what the sun needs;
    /// [`StageError::Forest`] of a GPU that is needed.
    pub fn paint(&mut self, shot: &Shot, size: [u32; 2], samples: u32) -> Result<Painted, StageError> {
        match self.paint_once(shot, size, samples) {
            Err(error) if self.leave_gpu(&error) => self.paint_once(shot, size, samples),
            painted => painted,
        }
    }

    fn paint_once(&mut self, shot: &Shot, size: [u32; 2], samples: u32) -> Result<Painted, StageError> {
        let mut progress = self.stream(shot, size)?;
        if shot.show == Show::Error {
            self.load_whole(shot, size)?;
        }
        let parts = self.look.parts(Some(shot.sun_deg), &self.shown(shot))?;
        self.find_beams(&parts.first.lighting);
        let start = Instant::now();
        let [width, height] = size;
        let time_s = self.stage.scene.start_s();
        let view =
            View { eye: self.above_water(shot.eye), width, height, samples, sky_rays: SKY_RAYS, time_s };
        let is_mark = !matches!(shot.show, Show::Whole | Show::Indirect | Show::Direct);
        let (picture, traced) = match &mut self.on_gpu {
            Some(on_gpu) if !is_mark => {
                on_gpu.trace(&view)?;
                let traced = start.elapsed().as_secs_f64();
                let resident = self.streamed[0].streamer.resident();
                let picture = parts.sum(|Part { lighting, look, .. }| {
                    turn(&mut self.neighbours, lighting)?;
                    let shade = self.neighbours.as_ref().and_then(Neighbours::shade);
                    on_gpu.lit(resident, (lighting, look), shade)
                });
                (picture?, traced)
            }
            _ => {
                let mut camera = std::mem::take(&mut self.camera);
                let forest = &self.forest;
                let fragments = camera.fragments(&view, || forest.trace(&view, &|_| Ok(())))?;
                let traced = start.elapsed().as_secs_f64();
                let picture = match is_mark {
                    true => self.marked(fragments, shot, &parts.first),
                    false => parts.sum(|part| self.relit(fragments, part)),
                };
                self.camera = camera;
                (picture?, traced)
            }
        };
        let seconds = [traced, start.elapsed().as_secs_f64() - traced];
        progress.adapter = self.on_gpu.as_ref().map(|on_gpu| on_gpu.name().to_owned());
        progress.left_gpu = self.left_gpu.clone();
        Ok(Painted { picture, shot: *shot, samples, progress, seconds })
    }

    /// Who flies on into water sees it from just above: nothing is seen through it.
    fn above_water(&self, eye: Eye) -> Eye {
        let sunk =
            self.forest.water().map_or(0.0, |water| water.height_m + ABOVE_WATER_M - eye.position_m[1]);
        let lifted = |[x, y, z]: [f64; 3]| [x, y + sunk.max(0.0), z];
        Eye { position_m: lifted(eye.position_m), look_at_m: lifted(eye.look_at_m), ..eye }
    }

    /// Paints until nothing is missing that fits, or so long.
    ///
    /// # Errors
    /// As [`Painter::paint`].
    pub fn paint_whole(
        &mut self,
        shot: &Shot,
        size: [u32; 2],
        most: Duration,
    ) -> Result<Painted, StageError> {
        let end = Instant::now() + most;
        while Instant::now() < end {
            match self.stream(shot, size) {
                Ok(progress) if progress.is_final => break,
                Err(error) if !self.leave_gpu(&error) => return Err(error),
                _ => {}
            }
            self.streamed.iter_mut().for_each(|one| one.streamer.wait(Duration::from_millis(20)));
        }
        self.paint(shot, size, self.look.samples)
    }

    fn strength(&self, shot: &Shot) -> f32 {
        self.look.strength(Some(shot.sun_deg))
    }

    /// A frame of every streamer.
    fn stream(&mut self, shot: &Shot, size: [u32; 2]) -> Result<Progress, StageError> {
        let mut progress =
            Progress { budget_bytes: self.budget_bytes, quality: 1.0, is_final: true, ..Progress::default() };
        let mut all = std::mem::take(&mut self.streamed);
        let followed = all.iter_mut().try_for_each(|one| self.follow(one, shot, size, &mut progress));
        self.streamed = all;
        followed?;
        progress.failures = self.failures.clone();
        Ok(progress)
    }

    /// A frame of a streamer.
    fn follow(
        &mut self,
        one: &mut Streamed,
        shot: &Shot,
        size: [u32; 2],
        progress: &mut Progress,
    ) -> Result<(), StageError> {
        let need = self.need(one, shot, size);
        let frame = one.streamer.frame(&need);
        progress.loaded_bytes += one.streamer.residency().loaded_bytes();
        progress.quality = progress.quality.min(frame.quality);
        progress.is_final &= frame.is_final;
        progress.lacks.extend(one.streamer.describe(&frame.lacks));
        self.failures.extend(frame.failures.iter().map(|failure| failure.error.to_string()));
        if let Some(on_gpu) = &mut self.on_gpu {
            let units = one.streamer.residency().units();
            progress.is_final &= on_gpu.follow(&frame, units, one.streamer.resident())?;
        }
        Ok(())
    }

    fn shown(&self, shot: &Shot) -> Look {
        let indirect = match shot.show {
            Show::Whole => Indirect::On,
            Show::Direct => Indirect::Off,
            _ => Indirect::Only,
        };
        Look { indirect, ..self.look.look }
    }

    /// What a shot needs of a library: of its sun and its sky, and of the further suns.
    fn need(&self, one: &mut Streamed, shot: &Shot, size: [u32; 2]) -> Need {
        let camera = Camera::of(&self.above_water(shot.eye), size);
        let water = water_plane(&self.stage.scene);
        let mut find = |[azimuth_deg, elevation_deg]: [f64; 2], sun: f32, sky: f32| {
            let daylight = Daylight { towards_sun: towards_sun(azimuth_deg, elevation_deg), sun, sky };
            one.finder.find_over_water(&one.placed, &camera, water, &daylight)
        };
        let mut need = find(shot.sun_deg, self.strength(shot), self.look.ambient);
        for sun_deg in self.look.suns_of(None) {
            need.add(&find(sun_deg, 1.0, 0.0));
        }
        need
    }

    /// Loads what the shot needs of the whole light, as far as it comes soon.
    fn load_whole(&mut self, shot: &Shot, size: [u32; 2]) -> Result<(), StageError> {
        let mut whole = match self.whole.take() {
            Some(whole) => whole,
            None => self.open(WHOLE_BYTES)?,
        };
        let end = Instant::now() + WHOLE_WAIT;
        for one in &mut whole {
            let need = self.need(one, shot, size);
            while !one.streamer.frame(&need).is_final && Instant::now() < end {
                one.streamer.wait(Duration::from_millis(20));
            }
        }
        self.whole = Some(whole);
        Ok(())
    }

    /// Finds what an uneven sky needs of each species, once its extinction and averages of all of its harmonics have
    /// come. Until then an even sky stands in, and so it does for [`Stage::under_even_sky`].
    fn find_beams(&mut self, lighting: &Lighting) {
        if lighting.dome.is_none() {
            return;
        }
        for (number, plant) in self.stage.plants.iter().enumerate() {
            if let (None, Some((library, species))) = (&self.beams[number], self.lights[number])
                && plant.is_of_harmonics()
            {
                let resident = self.streamed[library].streamer.resident().species(species);
                let beams = SpeciesLight::streamed(resident).sky_beams().ok().map(Arc::new);
                if let (Some(on_gpu), Some(beams)) = (&mut self.on_gpu, &beams) {
                    on_gpu.set_sky_beams(number, Arc::clone(beams));
                }
                self.beams[number] = beams;
            }
        }
    }

    /// What streamers have loaded: `[species of the scene]`.
    fn resident<'p>(&self, streamed: &'p [Streamed]) -> Vec<Option<&'p ResidentSpecies>> {
        let species =
            |(library, species): (usize, usize)| streamed[library].streamer.resident().species(species);
        self.lights.iter().map(|light| light.map(species)).collect()
    }

    /// What an uneven sky gives each plant.
    fn skies(&self, lighting: &Lighting) -> Result<Option<Skies<'_>>, StageError> {
        let find = |dome| light::skies(&self.beams, &self.stage.scene.instances, dome);
        Ok(lighting.dome.as_ref().map(find).transpose()?)
    }

    /// The picture of a part of the light.
    fn relit(&mut self, fragments: &Fragments, part: &Part) -> Result<Picture, StageError> {
        let Part { lighting, look, .. } = part;
        turn(&mut self.neighbours, lighting)?;
        let resident = self.resident(&self.streamed);
        let lights = streamed(&resident);
        let shade = self.neighbours.as_ref().and_then(Neighbours::shade);
        let placements = &self.stage.scene.instances[..];
        let skies = self.skies(lighting)?;
        let now = suns::of_picture(&lights, skies.as_ref(), placements, lighting, shade, fragments)?;
        let cursors = LightCursors::new(&now);
        let light = |LightQuery { instance, point, facing }: LightQuery, phi: &mut [f32; 3]| {
            cursors.at_facing(instance as usize, point, facing, phi);
        };
        Ok(self.forest.relight(fragments, lighting, look, &light, &|_| Ok(()))?)
    }

    /// A picture of something else than light, of what the first part of it needs.
    fn marked(&mut self, fragments: &Fragments, shot: &Shot, part: &Part) -> Result<Picture, StageError> {
        let Part { lighting, look, .. } = part;
        turn(&mut self.neighbours, lighting)?;
        let resident = self.resident(&self.streamed);
        let lights = streamed(&resident);
        let shade = self.neighbours.as_ref().and_then(Neighbours::shade);
        let placements = &self.stage.scene.instances[..];
        let rays = fragments.view().samples;
        let skies = self.skies(lighting)?;
        let skies = skies.as_ref();
        let now = light::of_plants(&lights, skies, placements, lighting, shade, rays)?;
        let cursors = LightCursors::new(&now);
        let species = |instance: u32| resident[placements[instance as usize].species];
        match shot.show {
            Show::Whole | Show::Indirect | Show::Direct => unreachable!("pictures of light are sums"),
            Show::Base(base) => {
                let light = |LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]| {
                    *phi = species(instance).map_or([0.0; 3], |one| marks::base(one, base, point));
                };
                Ok(self.forest.relight(fragments, lighting, look, &light, &|_| Ok(()))?)
            }
            Show::Level => Ok(self.forest.marked(fragments, &|LightQuery { instance, .. }, color| {
                *color = marks::level(now[instance as usize].as_ref().map(InstanceLight::level));
            })),
            Show::Residency => {
                Ok(self.forest.marked(fragments, &|LightQuery { instance, point, .. }, color| {
                    let terms = now[instance as usize].as_ref().map(InstanceLight::terms);
                    *color = marks::residency(species(instance), terms, point);
                }))
            }
            Show::Error => {
                let whole = self.whole.as_ref().map(|whole| streamed(&self.resident(whole)));
                let whole = match &whole {
                    Some(whole) => Some(light::of_plants(whole, skies, placements, lighting, shade, rays)?),
                    None => None,
                };
                let whole = whole.as_deref().map(LightCursors::new);
                let outside = self.strength(shot) + self.look.ambient;
                Ok(self.forest.marked(fragments, &|LightQuery { instance, point, .. }, color| {
                    let [mut found, mut expected] = [[0.0; 3]; 2];
                    cursors.at(instance as usize, point, &mut found);
                    if let Some(whole) = &whole {
                        whole.at(instance as usize, point, &mut expected);
                    }
                    *color = marks::error(found, expected, outside);
                }))
            }
        }
    }
}

/// Ready for any sun.
fn streamed<'p>(resident: &[Option<&'p ResidentSpecies>]) -> Vec<Option<SpeciesLight<'p>>> {
    resident.iter().map(|species| species.map(SpeciesLight::streamed)).collect()
}

fn turn(neighbours: &mut Option<Neighbours<'_>>, lighting: &Lighting) -> Result<(), StageError> {
    match neighbours {
        Some(neighbours) => Ok(neighbours.turn(&lighting.daylight)?),
        None => Ok(()),
    }
}
