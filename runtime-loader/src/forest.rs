//! A forest for an engine: plants come and go, the sun moves, and any thread asks for light.
//!
//! ```text
//! Forest: add, set, remove
//!    └─ frame(camera, daylight, run) -> Report      never waits, reads or computes for long
//!          ├─ Work -run()-> on any thread of the engine, in any order
//!          └─ snapshot() -> Arc<Snapshot> -at(plant, point)-> light, from any thread, while the next frame goes on
//! ```
//!
//! A frame hands out work: to read a page, or to add up a species' light for the sun as it is ([`LightVolume`], one for
//! each of a few yaws, and for some suns beside it where plants are tilted). It starts no thread and looks at no clock.
//! What work has done is there a frame later, and takes the place of what was there over some frames.
//!
//! A plant has light from the first frame on: the mean light of its species, which its file says before its first page.
//! Between the yaws of [`ForestSettings::yaws`] light is blended. A plant that is tilted sees the sun at another height
//! above itself, so that its light is a blend of four volumes. On a GPU, a [`ForestBuffer`] follows the snapshots.
//!
//! [`LightVolume`]: crate::light::LightVolume

pub mod buffer;
mod plants;
mod room;
mod snapshot;
mod species;
mod stand;
mod suns;
mod volumes;
mod work;

use std::sync::Arc;

use crate::residency::{Lack, NeedFinder, Placed, ResidencySettings};
use crate::resident::Resident;
use crate::stream::{Failure, Frame, Stage};
use crate::sun_terms::unit;
use crate::view::Camera;
use crate::{Daylight, Library, Placement, RuntimeError};

pub use buffer::{BufferSettings, Followed, ForestBuffer};
pub use plants::PlantId;
pub use snapshot::{Parts, Snapshot};
pub use work::Work;

use plants::{Plant, Plants};
use room::{Wish, chosen, stride};
use species::Lit;
use work::{Done, Inbox};

/// Most yaws: a tenth of a degree.
const MAX_YAWS: u32 = 3600;

/// Least step of the sun, degrees: of less, rounding makes volumes anew for a sun that stands still.
const MIN_STEP_DEG: f64 = 0.01;

/// Frames that more yaws must fit before they are made.
const REFINE_FRAMES: u32 = 120;

/// Most units that a frame puts in their place.
const MAX_UNITS: usize = 64;

/// Budgets and fineness of a forest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForestSettings {
    /// Budgets of memory and of requests of what is read; volumes are beside it.
    pub residency: ResidencySettings,
    /// Most memory of volumes, with those that are faded out: where it is too little, fewer yaws and heights of the sun
    /// have one each, and then fewer species.
    pub max_volume_bytes: u64,
    /// Yaws of which each species has a volume, from north clockwise; 1 to 3600. Upright plants at these yaws have its
    /// exact light, others a blend of two. For tilted ones there are as many degrees from one height of the sun to the
    /// next as from yaw to yaw, 5 to 15.
    pub yaws: u32,
    /// Degrees that the sun moves before volumes are made anew, 0.01 or more. Plants that are tilted by less stand
    /// upright.
    pub step_deg: f64,
    /// Frames over which light that came takes the place of what was there, 1 or more.
    pub blend_frames: u16,
    /// Frames that a species is not seen before its volumes are dropped.
    pub keep_frames: u32,
}

impl Default for ForestSettings {
    /// 32 MiB, 256 MiB, 16 yaws, 1 degree, 48 and 600 frames.
    fn default() -> ForestSettings {
        ForestSettings {
            residency: ResidencySettings::default(),
            max_volume_bytes: 256 << 20,
            yaws: 16,
            step_deg: 1.0,
            blend_frames: 48,
            keep_frames: 600,
        }
    }
}

/// Work and state of a frame.
#[derive(Debug, Default)]
pub struct Report {
    /// Units of the file that were put in place.
    pub loaded: usize,
    /// Units that were given up, each once.
    pub failures: Vec<Failure>,
    /// Units that failed for the first time and will be asked for again: a file that was cut, a server that is down.
    pub retries: Vec<Failure>,
    /// Memory that is lacking.
    pub lacks: Vec<Lack>,
    /// Share of what the frame could use of the file that is loaded, 0 to 1.
    pub quality: f32,
    /// Work that was handed out and is not done.
    pub in_flight: usize,
    /// Memory of what is loaded of the file, bytes.
    pub loaded_bytes: usize,
    /// Memory of volumes, bytes.
    pub volume_bytes: usize,
    /// Yaws of which volumes are kept while the sun shines: fewer than [`ForestSettings::yaws`] where there is no room
    /// for all.
    pub yaws: u32,
    /// Species that are seen and have their mean light, as there is no room for a volume.
    pub species_left_out: u32,
    /// Whether all that is seen has the light of this daylight, whole, and nothing more would come.
    pub is_final: bool,
}

/// Plants, and the light that is there of them.
pub struct Forest {
    stage: Stage,
    finder: NeedFinder,
    settings: ForestSettings,
    plants: Plants,
    placed: Placed,
    species: Vec<Lit>,
    /// Of which nothing is ever loaded: it has the mean light of each species.
    outside: Resident,
    inbox: Arc<Inbox>,
    in_flight: usize,
    /// Every how-manieth yaw and row has a volume.
    stride: u32,
    /// Frames in which more would have fitted.
    fitting_frames: u32,
    snapshot: Arc<Snapshot>,
}

impl Forest {
    /// Makes a forest without plants. Nothing is read yet.
    ///
    /// # Errors
    /// [`RuntimeError::NotStreamed`] for a species that is not coded near geometry.
    pub fn new(library: Arc<Library>, settings: ForestSettings) -> Result<Forest, RuntimeError> {
        let settings = ForestSettings {
            yaws: settings.yaws.clamp(1, MAX_YAWS),
            blend_frames: settings.blend_frames.max(1),
            // What is no number is the least step, too.
            step_deg: if settings.step_deg > MIN_STEP_DEG {
                settings.step_deg.min(180.0)
            } else {
                MIN_STEP_DEG
            },
            ..settings
        };
        let stage = Stage::new(Arc::clone(&library), settings.residency)?;
        let container = library.container();
        let species: Vec<Lit> = container.species().iter().map(|_| Lit::new(&settings)).collect();
        Ok(Forest {
            outside: Resident::new(container, stage.units()),
            finder: NeedFinder::new(container, stage.residency().units()),
            placed: Placed::new(container, []),
            plants: Plants::default(),
            snapshot: Arc::new(Snapshot::default()),
            inbox: Arc::default(),
            in_flight: 0,
            stride: 1,
            fitting_frames: 0,
            species,
            stage,
            settings,
        })
    }

    /// The library.
    pub fn library(&self) -> &Arc<Library> {
        self.stage.library()
    }

    /// Number of plants.
    pub fn len(&self) -> usize {
        self.placed.len()
    }

    /// Whether there are no plants.
    pub fn is_empty(&self) -> bool {
        self.placed.is_empty()
    }

    /// Adds a plant. Its species is a number in the library ([`Library::find_species`]).
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`].
    pub fn add(&mut self, plant: &Placement) -> Result<PlantId, RuntimeError> {
        self.check(plant)?;
        self.placed.push(self.stage.library().container(), plant);
        let id = self.plants.add(plant, &self.settings);
        self.count(id, 1);
        Ok(id)
    }

    /// Moves, turns or replaces a plant; whether there is such a plant.
    ///
    /// # Errors
    /// [`RuntimeError::NoSuchSpecies`].
    pub fn set(&mut self, id: PlantId, plant: &Placement) -> Result<bool, RuntimeError> {
        self.check(plant)?;
        let Some(index) = self.count(id, -1) else { return Ok(false) };
        self.placed.set(self.stage.library().container(), index, plant);
        self.plants.set(id, plant, &self.settings);
        self.count(id, 1);
        Ok(true)
    }

    /// Takes a plant away; whether there was such a plant.
    pub fn remove(&mut self, id: PlantId) -> bool {
        let Some(index) = self.count(id, -1) else { return false };
        self.placed.swap_remove(index);
        self.plants.remove(id);
        true
    }

    /// Counts a plant that comes (1) or goes (-1) with its species. Its place among all.
    fn count(&mut self, id: PlantId, plants: i32) -> Option<usize> {
        let Plant { index, species, stand, .. } = self.plants.get(id)?;
        self.species[species as usize].count(stand, plants);
        Some(index as usize)
    }

    fn check(&self, plant: &Placement) -> Result<(), RuntimeError> {
        let (index, count) = (plant.species, self.species.len());
        if index >= count {
            let path = self.library().path().to_owned();
            return Err(RuntimeError::NoSuchSpecies { path, index, count });
        }
        Ok(())
    }

    /// Does a frame's own work, and hands out the rest of it by `run`: takes what came, finds what is seen, drops and
    /// asks, and publishes a snapshot. A sun without a direction shines on nothing.
    ///
    /// Work that is dropped without being run is asked for again.
    pub fn frame(&mut self, camera: &Camera, daylight: &Daylight, mut run: impl FnMut(Work)) -> Report {
        let mut frame = Frame::default();
        let daylight = &known(daylight);
        self.take(&mut frame);
        let need = self.finder.find(&self.placed, camera, daylight);
        self.stage.plan(&need, &mut frame);
        let mut work = Vec::new();
        for job in self.stage.jobs(&frame.requests) {
            work.push(Work::read(Arc::clone(self.stage.library()), self.stage.units(), job, &self.inbox));
        }
        let mut is_lit = true;
        let pixels: Vec<f32> = need.species.iter().map(|species| species.pixels).collect();
        let mut is_other = Vec::new();
        for (lit, pixels) in self.species.iter_mut().zip(&pixels) {
            lit.pass(*pixels > 0.0, &self.settings);
            is_other.push(*pixels > 0.0 && lit.aim(daylight, &self.settings));
        }
        if is_other.contains(&true) {
            for plant in self.plants.tilted().filter(|plant| is_other[plant.species as usize]) {
                self.species[plant.species as usize].count(plant.stand, 1);
            }
        }
        let strides = self.strides(&pixels);
        for (number, lit) in self.species.iter_mut().enumerate() {
            if let Some(stride) = strides[number] {
                let resident = self.stage.resident();
                let wanted = lit.wanted(resident.species(number), daylight, &self.settings, stride);
                is_lit &= wanted.is_none() && lit.is_shown();
                if let Some(wanted) = wanted.filter(|wanted| !wanted.cells.is_empty()) {
                    lit.is_awaited = true;
                    let species = resident.shared(number);
                    work.push(Work::light(number, species, wanted, &self.inbox));
                }
            }
        }
        self.in_flight += work.len();
        work.into_iter().for_each(&mut run);
        self.publish(daylight);
        Report {
            loaded: frame.loaded.len(),
            failures: frame.failures,
            retries: frame.retries,
            lacks: frame.lacks,
            quality: frame.quality,
            in_flight: self.in_flight,
            loaded_bytes: self.stage.resident().size_bytes(),
            volume_bytes: self.species.iter().map(Lit::size_bytes).sum(),
            yaws: self.settings.yaws.div_ceil(self.stride),
            species_left_out: strides
                .iter()
                .zip(&pixels)
                .filter(|(stride, pixels)| stride.is_none() && **pixels > 0.0)
                .count() as u32,
            is_final: frame.is_final && is_lit,
        }
    }

    /// Of each species that is seen, every how-manieth yaw and row has a volume; `None` of others, and where there is
    /// no room. What is over drops at once. Those that were seen lately keep their room, and more yaws come only after
    /// a while in which they would have fitted, so that nothing comes and goes with each turn of the camera.
    fn strides(&mut self, pixels: &[f32]) -> Vec<Option<u32>> {
        let (yaws, room) = (self.settings.yaws, self.settings.max_volume_bytes);
        let counts: Vec<usize> = (0..pixels.len())
            .filter(|number| pixels[*number] > 0.0 || self.species[*number].has_volumes())
            .collect();
        let mut wishes: Vec<Wish> = Vec::new();
        for number in &counts {
            let lit = &mut self.species[*number];
            // What is whole takes no more room than what is asked for.
            if lit.has_volumes() {
                lit.keep(Some(self.stride));
            }
            wishes.push(lit.wish(self.stage.resident().species(*number), pixels[*number]));
        }
        let found = stride(&wishes, yaws, room);
        self.fitting_frames =
            if found.is_some_and(|found| found < self.stride) { self.fitting_frames + 1 } else { 0 };
        if found.is_none_or(|found| found > self.stride) || self.fitting_frames > REFINE_FRAMES {
            (self.stride, self.fitting_frames) = (found.unwrap_or(yaws), 0);
        }
        let have_room = match found {
            Some(_) => vec![true; wishes.len()],
            None => chosen(&wishes, room),
        };
        let mut all = vec![None; pixels.len()];
        for (number, has_room) in counts.into_iter().zip(have_room) {
            let stride = has_room.then_some(self.stride);
            self.species[number].keep(stride);
            all[number] = stride.filter(|_| pixels[number] > 0.0);
        }
        all
    }

    /// The light as the last frame left it; any thread may ask it, however many frames go on meanwhile.
    pub fn snapshot(&self) -> Arc<Snapshot> {
        Arc::clone(&self.snapshot)
    }

    /// Loaded units.
    pub fn resident(&self) -> &Resident {
        self.stage.resident()
    }

    /// Puts what work has done in its place.
    fn take(&mut self, frame: &mut Frame) {
        let mut units = 0;
        while units < MAX_UNITS {
            let Some(done) = self.inbox.next() else { break };
            self.in_flight -= usize::from(!matches!(done, Done::Some(..)));
            match done {
                Done::Read(outcomes) => {
                    units += outcomes.len();
                    for (unit, outcome) in outcomes {
                        self.stage.take(unit, outcome, frame);
                    }
                }
                Done::Some(number, made) => self.species[number].take(Some(made), false),
                Done::Light(number, made) => self.species[number].take(made, true),
            }
        }
    }

    fn publish(&mut self, daylight: &Daylight) {
        let species = self.species.iter().enumerate();
        let species = species.map(|(number, lit)| lit.shown(self.outside.species(number), daylight));
        self.snapshot = Arc::new(Snapshot { plants: self.plants.shared(), species: species.collect() });
    }
}

/// The daylight with nothing in it that is no number: no sun where it has no direction.
fn known(day: &Daylight) -> Daylight {
    let finite = |light: f32| if light.is_finite() { light } else { 0.0 };
    let sky = finite(day.sky);
    match unit(day.towards_sun) {
        Some(_) => Daylight { sun: finite(day.sun), sky, ..*day },
        None => Daylight { towards_sun: [0.0, 1.0, 0.0], sun: 0.0, sky },
    }
}

#[cfg(test)]
mod tests;
