//! Keeps the light on a GPU at what a streamer has loaded: what was dropped goes at once, what came is sent as far as a
//! frame's bytes allow.
//!
//! ```text
//! Streamer::frame -Frame-> Follower::follow -set, update, remove-> GpuLight
//!                          Follower::terms  -of the bases that were sent-> GpuLight::set_terms
//! ```
//!
//! A renderer's part of it:
//!
//! ```no_run
//! # use flb_runtime::{Library, gpu::*, residency::*, stream::*};
//! # type Done = Result<(), Box<dyn std::error::Error>>;
//! # fn renderer(device: wgpu::Device, queue: wgpu::Queue, need: Need, sun: [f64; 3]) -> Done {
//! let library = std::sync::Arc::new(Library::open("forest.flb")?);
//! let oak = library.find_species("oak").ok_or("no oak")?;
//! let mut streamer = Streamer::new(library, StreamSettings::default())?;
//! let units = streamer.residency().units().clone();
//! let mut gpu = Follower::new(GpuLight::new(&device, &queue, LightSettings::default())?, &units);
//! let shader = light_wgsl(3)
//!     + "/* flb_sample(species, first_term, term_count, point_model_m), or flb_near and flb_sample_near */";
//! // Every frame, and for every instance:
//! let frame = streamer.frame(&need);
//! gpu.follow(&frame, &units, streamer.resident(), 1 << 20)?;
//! let (terms, rest) = gpu.terms(oak, streamer.resident(), sun, 1.0, 0.2);
//! gpu.light_mut().set_terms(0, &terms)?; // and to the shader: gpu.species(oak), 0, terms.len(), rest.constant()
//! # Ok(())
//! # }
//! ```

use std::collections::{HashSet, VecDeque};

use super::{GpuError, GpuLight, GpuSpeciesId, SkyOnGpu, Term};
use crate::light::SkyBeams;
use crate::residency::{Unit, UnitId, UnitKind, Units};
use crate::resident::{Resident, ResidentSpecies, Shown, Terms};
use crate::stream::Frame;

/// Units that a frame sent to the GPU.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Followed {
    /// Units that were sent.
    pub sent: usize,
    /// Bytes of the units that were sent, about.
    pub sent_bytes: u64,
    /// Units that wait for a later frame.
    pub waiting: usize,
    /// Whether a unit waits because the GPU's budget is full; it goes when something was dropped.
    pub is_full: bool,
    /// Whether a unit was sent that is not shown in full yet: terms change with each frame.
    pub is_blending: bool,
}

/// A [`GpuLight`] that follows a streamer.
pub struct Follower {
    light: GpuLight,
    /// `[species]`: its number on the GPU.
    species: Vec<Option<GpuSpeciesId>>,
    /// `[species][base]`: index of the base for terms, and the frame that sent it.
    bases: Vec<Vec<Option<(u32, u64)>>>,
    /// `[species]`: the frame that sent the extinction.
    extinctions: Vec<Option<u64>>,
    frame: u64,
    /// Units that came and were not sent, in order.
    waiting: VecDeque<UnitId>,
}

impl Follower {
    /// Makes a follower for light without species.
    pub fn new(light: GpuLight, units: &Units) -> Follower {
        let species = vec![None; units.species()];
        let bases = (0..units.species()).map(|species| vec![None; units.bases(species).len()]).collect();
        let extinctions = vec![None; units.species()];
        Follower { light, species, bases, extinctions, frame: 0, waiting: VecDeque::new() }
    }

    /// Light on the GPU.
    pub fn light(&self) -> &GpuLight {
        &self.light
    }

    /// Light on the GPU, for its terms; species and bases are the follower's.
    pub fn light_mut(&mut self) -> &mut GpuLight {
        &mut self.light
    }

    /// Number of a species on the GPU, for `flb_sample`; `None` before its block map was sent.
    pub fn species(&self, species: usize) -> Option<GpuSpeciesId> {
        self.species[species]
    }

    /// Drops what a frame dropped and sends what it loaded, of which `most_bytes` go now, but one unit at least. Call
    /// it for every frame of a streamer, in order; `resident` is the streamer's after it.
    ///
    /// # Errors
    /// [`GpuError`], but for [`GpuError::Full`], with which a unit waits: one that needs more bands than the GPU's
    /// light has, or more bases than there is room for.
    pub fn follow(
        &mut self,
        frame: &Frame,
        units: &Units,
        resident: &Resident,
        most_bytes: u64,
    ) -> Result<Followed, GpuError> {
        self.frame += 1;
        self.waiting.extend(&frame.loaded);
        let evicted: HashSet<UnitId> = frame.evictions.iter().copied().collect();
        self.waiting.retain(|unit| !evicted.contains(unit));
        for unit in &frame.evictions {
            self.drop_unit(units.get(*unit), units, resident)?;
        }
        let mut followed = Followed::default();
        let mut later = VecDeque::new();
        while let Some(id) = self.waiting.pop_front() {
            let unit = units.get(id);
            // Memory here is that of the CPU; the GPU's is of that order.
            let bytes = unit.memory_bytes;
            let is_over = followed.sent > 0 && followed.sent_bytes + bytes > most_bytes;
            if is_over || followed.is_full {
                later.push_back(id);
                continue;
            }
            match self.send(unit, units, resident) {
                Ok(()) => {
                    followed.sent += 1;
                    followed.sent_bytes += bytes;
                }
                Err(GpuError::Full { .. }) => {
                    followed.is_full = true;
                    later.push_back(id);
                }
                Err(error) => return Err(error),
            }
        }
        followed.is_blending = (0..self.species.len()).any(|species| self.is_blending(species, resident));
        followed.waiting = later.len();
        self.waiting = later;
        Ok(followed)
    }

    fn drop_unit(&mut self, unit: &Unit, units: &Units, resident: &Resident) -> Result<(), GpuError> {
        let species = unit.species as usize;
        let Some(number) = self.species[species] else { return Ok(()) };
        match unit.kind {
            UnitKind::Shared => {
                self.light.remove_species(number)?;
                self.species[species] = None;
                self.bases[species].fill(None);
                self.extinctions[species] = None;
            }
            UnitKind::Averages { base } => {
                if self.bases[species][base as usize].take().is_some() {
                    self.light.remove_base(number, units.bases(species)[base as usize].item)?;
                }
            }
            UnitKind::Detail { base, .. } => {
                let coded = resident.species(species).base(base as usize);
                // Where the base went too, it goes as a whole.
                if let (Some(coded), Some(_)) = (coded, self.bases[species][base as usize]) {
                    let item = units.bases(species)[base as usize].item;
                    self.light.update_page(number, item, unit.blocks[0], unit.blocks[1], coded)?;
                }
            }
            UnitKind::Extinction => {
                self.light.remove_extinction(number)?;
                self.extinctions[species] = None;
            }
        }
        Ok(())
    }

    fn send(&mut self, unit: &Unit, units: &Units, resident: &Resident) -> Result<(), GpuError> {
        let index = unit.species as usize;
        let species = resident.species(index);
        match (unit.kind, self.species[index]) {
            (UnitKind::Shared, None) => {
                let shared = species.shared().expect("it was loaded");
                let number = self.light.add_species(species.grid(), shared)?;
                self.species[index] = Some(number);
                // It may have come first.
                self.send_extinction(index, number, species)?;
            }
            (UnitKind::Shared | UnitKind::Extinction, Some(number)) => {
                self.send_extinction(index, number, species)?
            }
            (UnitKind::Averages { base }, Some(number)) => {
                let coded = species.base(base as usize).expect("it was loaded");
                let item = units.bases(index)[base as usize].item;
                self.bases[index][base as usize] =
                    Some((self.light.set_averages(number, item, coded)?, self.frame));
            }
            (UnitKind::Detail { base, .. }, Some(number)) if self.bases[index][base as usize].is_some() => {
                let coded = species.base(base as usize).expect("it was loaded");
                let item = units.bases(index)[base as usize].item;
                self.light.update_page(number, item, unit.blocks[0], unit.blocks[1], coded)?;
            }
            // What stands on a unit that was given up never comes.
            _ => {}
        }
        Ok(())
    }

    fn send_extinction(
        &mut self,
        index: usize,
        number: GpuSpeciesId,
        species: &ResidentSpecies,
    ) -> Result<(), GpuError> {
        let Some(extinction) = species.extinction() else { return Ok(()) };
        self.light.set_extinction(number, extinction, species.needs_single())?;
        self.extinctions[index] = Some(self.frame);
        Ok(())
    }

    /// How far what a frame sent is shown, 0..=1.
    fn shown(&self, light: &ResidentSpecies, sent: u64) -> f32 {
        light.shown(u16::try_from(1 + self.frame - sent).unwrap_or(u16::MAX))
    }

    fn is_blending(&self, species: usize, resident: &Resident) -> bool {
        let bases = self.bases[species].iter().flatten().map(|(_, sent)| *sent);
        let light = resident.species(species);
        bases.chain(self.extinctions[species]).any(|sent| self.shown(light, sent) < 1.0)
    }

    /// Sends the beams of a species that skies need, unless they are there or its block map is not: to be called after
    /// [`Follower::follow`], with which they go.
    ///
    /// # Errors
    /// As [`GpuLight::set_sky_beams`].
    pub fn send_sky_beams(&mut self, species: usize, beams: &SkyBeams) -> Result<(), GpuError> {
        match self.species[species] {
            Some(number) if !self.light.has_sky_beams(number) => self.light.set_sky_beams(number, beams),
            _ => Ok(()),
        }
    }

    /// The terms of an uneven sky over a plant, for `flb_sky`; `None` while its beams or a base are not on the GPU.
    pub fn sky_terms(&self, species: usize, resident: &Resident, sky: &SkyOnGpu) -> Option<Vec<Term>> {
        self.species[species].filter(|number| self.light.has_sky_beams(*number))?;
        let place = |item: u8| resident.species(species).place(item);
        sky.terms(|item| self.bases[species][place(item)?].map(|(index, _)| index)).ok()
    }

    /// Terms for `flb_sample_near`, of the bases that were sent, and what the shader adds to them per band: as
    /// [`ResidentSpecies::terms`](crate::resident::ResidentSpecies::terms), for a sun in the model's frame. The last
    /// ones are those of the near beam ([`Terms::near_bases`]), whose means `flb_near` finds; without any, `flb_sample`
    /// does.
    pub fn terms(
        &self,
        species: usize,
        resident: &Resident,
        towards_sun: [f64; 3],
        sun: f32,
        sky: f32,
    ) -> (Vec<Term>, Terms) {
        let (bases, light) = (&self.bases[species], resident.species(species));
        let shown = |sent: Option<u64>| sent.map_or(0.0, |sent| self.shown(light, sent));
        let base = |place: usize| shown(bases[place].map(|(_, sent)| sent));
        let shown = Shown { base: &base, extinction: shown(self.extinctions[species]) };
        let terms = light.terms_of(&shown, towards_sun, sun, sky);
        let term = |(base, factor): (u16, f32)| Term {
            base: bases[usize::from(base)].expect("terms are of bases that were sent").0,
            factor,
        };
        let (near, sun) = terms.near_bases();
        let near = near.map(|base| (base, sun));
        (terms.bases().chain(near).map(term).collect(), terms)
    }
}
