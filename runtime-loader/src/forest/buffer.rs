//! A forest's light in one buffer of a GPU, for any engine: which words to write where, and no call of a GPU.
//!
//! | word | content |
//! |---|---|
//! | 0 | [`VERSION`] |
//! | 1 | where the plants begin |
//! | 2 | how many plants there is room for |
//! | 3 | 0 |
//! | 4.. | the species, then the plants, then volumes as [`volume_words`](crate::light::volume_words) has them |
//!
//! | word of a species | content |
//! |---|---|
//! | 0 | yaws |
//! | 1, 2 | factors of the light that is shown, and of that before it, f32 |
//! | 3..6 | light beside them, three f32 |
//! | 6, 7 | 0 |
//! | 8.. | of each yaw where its volume begins, and where that before it does; 0: none |
//!
//! | word of a plant | content |
//! |---|---|
//! | 0 | where its species begins; 0: no such plant |
//! | 1 | the yaw before its own; in the upper 16 bits the share of the next one, in 65536 parts |
//!
//! Places are in words from word 0, so that it may lie anywhere in a buffer. Plants and species change few words; a
//! volume is written once.

use std::collections::BTreeMap;
use std::sync::{Arc, Weak};

use super::PlantId;
use super::plants::Plant;
use super::snapshot::{Shown, Snapshot};
use crate::light::LightVolume;

/// First word: the version of the layout.
pub const VERSION: u32 = 1;

const HEAD: u32 = 4;
/// Words of a species before those of its yaws.
const SPECIES: u32 = 8;
const PLANT: u32 = 2;
const RGB: usize = 3;

/// Sizes of a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BufferSettings {
    /// All of it, bytes; a multiple of 4.
    pub bytes: u64,
    /// Most plants at a time.
    pub max_plants: u32,
    /// Frames that a GPU may be behind, 1 or more: volumes that they read are not written over. Tables are, so that
    /// writes must be copies in the order of the GPU's queue.
    pub frames_in_flight: u32,
    /// Bytes of volumes that a frame writes, but for one volume that may always be written.
    pub max_upload_bytes: u64,
}

impl Default for BufferSettings {
    /// 128 MiB, the most that every device of WebGPU binds; 16,384 plants, 3 frames, 4 MiB.
    fn default() -> BufferSettings {
        BufferSettings {
            bytes: 128 << 20,
            max_plants: 1 << 14,
            frames_in_flight: 3,
            max_upload_bytes: 4 << 20,
        }
    }
}

/// Work of a frame on a buffer, and what is left.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Followed {
    /// Bytes that were written.
    pub written_bytes: u64,
    /// Whether the buffer has the light of the snapshot; else more comes with the next frames, or there is no room.
    pub is_complete: bool,
    /// Bytes of volumes that found no room, or have more than three bands: species keep the light that they had while
    /// it is faded out, and have their mean light then.
    pub lacking_bytes: u64,
    /// Plants beyond [`BufferSettings::max_plants`], which have no light.
    pub plants_left_out: u32,
}

/// Places of a forest's light in a buffer; another forest takes another one.
pub struct ForestBuffer {
    settings: BufferSettings,
    frame: u64,
    /// Of the last frame.
    plants: Arc<Vec<Plant>>,
    /// `[species]`: as written.
    species: Vec<Record>,
    /// By the address of the volume.
    places: BTreeMap<usize, Place>,
    /// Where the plants begin, as written.
    written: Option<u32>,
}

/// A species as it is in the buffer.
#[derive(Debug, Clone, PartialEq)]
struct Record {
    words: Vec<u32>,
    /// Addresses of its volumes.
    volumes: Vec<usize>,
}

/// Where a volume lies.
struct Place {
    /// So that no other volume has its address.
    _volume: Weak<LightVolume>,
    first: u32,
    words: u32,
    /// Frame that read it last.
    used: u64,
}

/// What became of a volume that is to be placed.
enum Room {
    At(u32),
    /// There is room, with the next frames.
    Later,
    None(u64),
}

impl ForestBuffer {
    /// Plans an empty buffer.
    pub fn new(settings: BufferSettings) -> ForestBuffer {
        ForestBuffer {
            settings: BufferSettings { frames_in_flight: settings.frames_in_flight.max(1), ..settings },
            frame: 0,
            plants: Arc::default(),
            species: Vec::new(),
            places: BTreeMap::new(),
            written: None,
        }
    }

    /// Makes the buffer follow a snapshot of the forest: calls `write` with an offset in bytes and the words to be
    /// written there, of the machine's byte order, before what draws the frame. The first frame writes all tables.
    pub fn follow(&mut self, snapshot: &Snapshot, mut write: impl FnMut(u64, &[u32])) -> Followed {
        self.frame += 1;
        if snapshot.species.is_empty() {
            // Before the forest's first frame.
            return Followed::default();
        }
        let mut followed = Followed { is_complete: true, ..Followed::default() };
        let mut put = |followed: &mut Followed, first: u32, words: &[u32]| {
            if !words.is_empty() {
                followed.written_bytes += 4 * words.len() as u64;
                write(4 * u64::from(first), words);
            }
        };
        let firsts = firsts(snapshot);
        let plants = firsts.last().copied().unwrap_or(HEAD);
        let tables = u64::from(plants) + u64::from(PLANT) * u64::from(self.settings.max_plants);
        let Some(volumes) = u32::try_from(tables).ok().filter(|words| *words <= self.end()) else {
            // Not even the tables have room: nothing is written.
            let lacking_bytes = 4 * (tables - u64::from(self.end()).min(tables));
            let plants_left_out = snapshot.plants.iter().filter(|plant| plant.is_there()).count() as u32;
            return Followed { lacking_bytes, plants_left_out, ..Followed::default() };
        };
        if self.written != Some(plants) {
            self.species.clear();
            self.places.clear();
            self.plants = Arc::default();
            put(&mut followed, 0, &[VERSION, plants, self.settings.max_plants, 0]);
            put(&mut followed, plants, &vec![0; (PLANT * self.settings.max_plants) as usize]);
        }
        let mut budget = Some(self.settings.max_upload_bytes);
        for (number, shown) in snapshot.species.iter().enumerate() {
            let placed = self.place(shown, volumes, &mut budget, &mut followed, &mut put);
            let known = self.species.get(number);
            let record = match (placed, known) {
                (Ok(record), _) => record,
                // While it is faded, or more comes, what was there goes on; without room it would stay for ever.
                (Err(has_room), Some(known)) if has_room || shown.is_fading() => known.clone(),
                (Err(_), _) => Record { words: beside(shown, 1.0), volumes: Vec::new() },
            };
            for volume in &record.volumes {
                self.places.get_mut(volume).expect("it was placed").used = self.frame;
            }
            if known != Some(&record) {
                put(&mut followed, firsts[number], &record.words);
            }
            match self.species.get_mut(number) {
                Some(known) => *known = record,
                None => self.species.push(record),
            }
        }
        self.write_plants(snapshot, &firsts, &mut followed, &mut put);
        self.written = Some(plants);
        followed.is_complete &= followed.plants_left_out == 0;
        followed
    }

    /// Writes the plants that have changed.
    fn write_plants(
        &mut self,
        snapshot: &Snapshot,
        firsts: &[u32],
        followed: &mut Followed,
        put: &mut impl FnMut(&mut Followed, u32, &[u32]),
    ) {
        let room = self.settings.max_plants as usize;
        let there = |plants: &[Plant]| plants.iter().skip(room).filter(|plant| plant.is_there()).count();
        followed.plants_left_out = there(&snapshot.plants) as u32;
        if Arc::ptr_eq(&self.plants, &snapshot.plants) {
            return;
        }
        let first = firsts.last().copied().unwrap_or(HEAD);
        let words = |plant: &Plant| match plant.is_there() {
            true => {
                let share = (plant.turn.share * 65_536.0).min(65_535.0) as u32;
                [firsts[plant.species as usize], plant.turn.first | share << 16]
            }
            false => [0; 2],
        };
        let now: Vec<[u32; 2]> = snapshot.plants.iter().take(room).map(words).collect();
        let old = |slot: usize| self.plants.get(slot).map_or([0; 2], words);
        let mut slot = 0;
        while slot < now.len() {
            let end = (slot..now.len()).find(|slot| now[*slot] == old(*slot)).unwrap_or(now.len());
            put(followed, first + PLANT * slot as u32, now[slot..end].as_flattened());
            slot = end + 1;
        }
        self.plants = Arc::clone(&snapshot.plants);
    }

    /// A species with all of its volumes in their places; else whether there is room for all of them.
    fn place(
        &mut self,
        shown: &Shown,
        begin: u32,
        budget: &mut Option<u64>,
        followed: &mut Followed,
        put: &mut impl FnMut(&mut Followed, u32, &[u32]),
    ) -> Result<Record, bool> {
        let (mut volumes, mut is_whole, mut has_room) = (Vec::new(), true, true);
        let yaws = shown.yaws;
        let mut words = beside(shown, shown.rest());
        words[0] = yaws;
        words.resize((SPECIES + 2 * yaws) as usize, 0);
        for (place, (light, factor)) in shown.both().into_iter().enumerate() {
            words[1 + place] = factor.to_bits();
            let Some(light) = light.filter(|_| factor != 0.0) else { continue };
            for yaw in 0..yaws {
                let Some(volume) = light.at_yaw(yaw) else { continue };
                match self.room(volume, begin, budget, followed, put) {
                    Room::At(first) => {
                        words[(SPECIES + 2 * yaw) as usize + place] = first;
                        volumes.push(Arc::as_ptr(volume).addr());
                    }
                    Room::Later => is_whole = false,
                    Room::None(bytes) => {
                        followed.lacking_bytes += bytes;
                        (is_whole, has_room) = (false, false);
                    }
                }
            }
        }
        followed.is_complete &= is_whole;
        if is_whole { Ok(Record { words, volumes }) } else { Err(has_room) }
    }

    /// Where a volume lies, written there if it does not yet.
    fn room(
        &mut self,
        volume: &Arc<LightVolume>,
        begin: u32,
        budget: &mut Option<u64>,
        followed: &mut Followed,
        put: &mut impl FnMut(&mut Followed, u32, &[u32]),
    ) -> Room {
        let address = Arc::as_ptr(volume).addr();
        if let Some(place) = self.places.get_mut(&address) {
            place.used = self.frame;
            return Room::At(place.first);
        }
        // The first one of a frame always goes.
        let is_first = *budget == Some(self.settings.max_upload_bytes);
        let bytes = 4 * volume.word_count() as u64;
        if !is_first && budget.is_none_or(|left| left < bytes) {
            return Room::Later;
        }
        let count = volume.word_count() as u32;
        let Some(first) = self.gap(begin, count) else { return Room::None(bytes) };
        let Some(words) = volume.words() else { return Room::None(bytes) };
        *budget = budget.and_then(|left| left.checked_sub(bytes));
        put(followed, first, &words);
        let place = Place { _volume: Arc::downgrade(volume), first, words: count, used: self.frame };
        self.places.insert(address, place);
        Room::At(first)
    }

    /// The first gap of so many words; what no frame reads any more makes room.
    fn gap(&mut self, begin: u32, words: u32) -> Option<u32> {
        let kept = self.frame.saturating_sub(u64::from(self.settings.frames_in_flight));
        self.places.retain(|_, place| place.used >= kept);
        let mut taken: Vec<(u32, u32)> =
            self.places.values().map(|place| (place.first, place.words)).collect();
        taken.sort_unstable();
        let end = self.end();
        let mut first = begin;
        for (other, count) in taken {
            if other.checked_sub(first).is_some_and(|gap| gap >= words) {
                break;
            }
            first = other + count;
        }
        first.checked_add(words).is_some_and(|behind| behind <= end).then_some(first)
    }

    /// Words of the buffer.
    fn end(&self) -> u32 {
        u32::try_from(self.settings.bytes / 4).unwrap_or(u32::MAX)
    }

    /// Bytes that volumes take.
    pub fn volume_bytes(&self) -> u64 {
        self.places.values().map(|place| 4 * u64::from(place.words)).sum()
    }
}

impl PlantId {
    /// Number of the plant for `flb_light`: once the plant has gone, another one takes it.
    pub fn number(self) -> u32 {
        self.slot
    }
}

/// Where species begin, and last where they end.
fn firsts(snapshot: &Snapshot) -> Vec<u32> {
    let mut first = HEAD;
    let mut firsts = vec![first];
    for shown in &snapshot.species {
        first += SPECIES + 2 * shown.yaws;
        firsts.push(first);
    }
    firsts
}

/// Head of a species with a share of its mean light.
fn beside(shown: &Shown, share: f32) -> Vec<u32> {
    let mut words = vec![0; SPECIES as usize];
    words[0] = shown.yaws;
    for (word, mean) in words[3..3 + RGB].iter_mut().zip(&shown.mean) {
        *word = (share * mean).to_bits();
    }
    words.resize((SPECIES + 2 * shown.yaws) as usize, 0);
    words
}

#[cfg(test)]
mod tests;
