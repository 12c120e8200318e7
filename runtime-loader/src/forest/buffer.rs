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
//! | 6 | degrees from row to row of suns, f32 |
//! | 7 | rows |
//! | 8..11 | the sun of the light that is shown: its unit vector, world, three f32 |
//! | 11, 12 | its azimuth and elevation, degrees, f32 |
//! | 13, 14 | the row of plants that stand upright under it, and the highest one |
//! | 15 | every how-manieth row, counted from that of upright plants, and every how-manieth yaw has a volume |
//! | 16..24 | the same of the light before it |
//! | 24.. | of each row and yaw, `[row][yaw]`, where its volume begins, and where that before it does; 0: none |
//!
//! | word of a plant | content |
//! |---|---|
//! | 0 | where its species begins; the highest bit is 1 where it is tilted; 0: no such plant |
//! | 1 | upright: its yaw, from 0 to below the number of yaws, f32 |
//! | 1..4 | tilted: x, y and z of its rotation's unit quaternion, world from model, f32; its w is not negative |
//!
//! An upright plant has the light of the two yaws around its own, of one row. A tilted one sees the sun elsewhere: of
//! the two rows around the elevation there, in degrees, and of the two yaws around the azimuth, each with its share.
//!
//! Places are in words from word 0, so that it may lie anywhere in a buffer. Plants and species change few words; a
//! volume is written once.

use std::collections::BTreeMap;
use std::sync::{Arc, Weak};

use super::PlantId;
use super::plants::Plant;
use super::snapshot::{Shown, Snapshot};
use super::stand::Stand;
use super::suns::{Suns, row_step_deg, rows};
use crate::light::LightVolume;

/// First word: the version of the layout.
pub const VERSION: u32 = 2;

const HEAD: u32 = 4;
/// Words of a species before those of its volumes, of a sun among them, and where the suns begin.
const SPECIES: u32 = 24;
const SUN: usize = 8;
const SUNS: usize = 8;
const PLANT: u32 = 4;
/// Of a tilted plant.
const TILTED: u32 = 1 << 31;
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

/// What became of a volume, or of all of a species, that is to be placed.
enum Placed<T> {
    There(T),
    /// There is room, with the next frames.
    Later,
    NoRoom,
}

/// A frame's writes.
struct Writes<W> {
    write: W,
    followed: Followed,
    /// Bytes of volumes that may still be written.
    left_bytes: u64,
    /// Whether a volume was written: the first one may always be.
    has_volume: bool,
}

impl<W: FnMut(u64, &[u32])> Writes<W> {
    fn put(&mut self, first: u32, words: &[u32]) {
        if !words.is_empty() {
            self.followed.written_bytes += 4 * words.len() as u64;
            (self.write)(4 * u64::from(first), words);
        }
    }

    /// Writes the words from the first one to the last one that is not as it was.
    fn put_changed(&mut self, first: u32, old: &[u32], words: &[u32]) {
        if old.len() != words.len() {
            return self.put(first, words);
        }
        let is_other = |at: &usize| old[*at] != words[*at];
        let Some(begin) = (0..words.len()).find(is_other) else { return };
        let last = (begin..words.len()).rfind(is_other).unwrap_or(begin);
        self.put(first + begin as u32, &words[begin..=last]);
    }
}

impl BufferSettings {
    /// [`ForestSettings::max_volume_bytes`](super::ForestSettings::max_volume_bytes) for which the buffer has room:
    /// words take a third more than the bytes of volumes, and the tables of species some of the rest.
    pub fn max_volume_bytes(&self) -> u64 {
        let plants = 4 * u64::from(PLANT) * u64::from(self.max_plants);
        self.bytes.saturating_sub(plants) / 10 * 7
    }
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
    pub fn follow(&mut self, snapshot: &Snapshot, write: impl FnMut(u64, &[u32])) -> Followed {
        self.frame += 1;
        if snapshot.species.is_empty() {
            // Before the forest's first frame.
            return Followed::default();
        }
        let firsts = firsts(snapshot);
        let plants = firsts[firsts.len() - 1];
        let tables = plants + u64::from(PLANT) * u64::from(self.settings.max_plants);
        let has_room = plants < u64::from(TILTED) && tables <= u64::from(self.end());
        let Some(volumes) = u32::try_from(tables).ok().filter(|_| has_room) else {
            // Not even the tables have room: nothing is written.
            let lacking_bytes = 4 * (tables - u64::from(self.end()).min(tables));
            let plants_left_out = there(&snapshot.plants);
            return Followed { lacking_bytes, plants_left_out, ..Followed::default() };
        };
        let (firsts, plants) =
            (firsts.iter().map(|first| *first as u32).collect::<Vec<u32>>(), plants as u32);
        let mut writes = Writes {
            write,
            followed: Followed { is_complete: true, ..Followed::default() },
            left_bytes: self.settings.max_upload_bytes,
            has_volume: false,
        };
        if self.written != Some(plants) {
            self.species.clear();
            self.places.clear();
            self.plants = Arc::default();
            writes.put(0, &[VERSION, plants, self.settings.max_plants, 0]);
            writes.put(plants, &vec![0; (PLANT * self.settings.max_plants) as usize]);
        }
        for (number, (shown, first)) in snapshot.species.iter().zip(&firsts).enumerate() {
            let placed = self.place(shown, volumes, &mut writes);
            let known = self.species.get(number);
            let record = match (placed, known) {
                (Placed::There(record), _) => record,
                // What was there goes on until all is; without room, until it is faded out: it would stay for ever.
                (Placed::Later, Some(known)) => known.clone(),
                (Placed::NoRoom, Some(known)) if shown.is_fading() => known.clone(),
                _ => Record { words: species_words(shown, 1.0), volumes: Vec::new() },
            };
            for volume in &record.volumes {
                self.places.get_mut(volume).expect("it was placed").used = self.frame;
            }
            writes.put_changed(*first, known.map_or(&[], |known| &known.words), &record.words);
            match self.species.get_mut(number) {
                Some(known) => *known = record,
                None => self.species.push(record),
            }
        }
        self.write_plants(snapshot, &firsts, plants, &mut writes);
        self.written = Some(plants);
        writes.followed
    }

    /// Writes the plants that have changed; `first` is where they begin.
    fn write_plants<W: FnMut(u64, &[u32])>(
        &mut self,
        snapshot: &Snapshot,
        firsts: &[u32],
        first: u32,
        writes: &mut Writes<W>,
    ) {
        let room = snapshot.plants.len().min(self.settings.max_plants as usize);
        let (within, beyond) = snapshot.plants.split_at(room);
        writes.followed.plants_left_out = there(beyond);
        writes.followed.is_complete &= writes.followed.plants_left_out == 0;
        if Arc::ptr_eq(&self.plants, &snapshot.plants) {
            return;
        }
        let words = |plant: &Plant| match (plant.is_there(), plant.stand) {
            (true, Stand::Upright(turn)) => [firsts[plant.species as usize], turn.to_bits(), 0, 0],
            (true, Stand::Tilted(rotation)) => {
                let [x, y, z] = rotation.map(f32::to_bits);
                [firsts[plant.species as usize] | TILTED, x, y, z]
            }
            (false, _) => [0; PLANT as usize],
        };
        let now: Vec<[u32; PLANT as usize]> = within.iter().map(words).collect();
        let old = |slot: usize| self.plants.get(slot).map_or([0; PLANT as usize], words);
        let mut slot = 0;
        while slot < now.len() {
            let end = (slot..now.len()).find(|slot| now[*slot] == old(*slot)).unwrap_or(now.len());
            writes.put(first + PLANT * slot as u32, now[slot..end].as_flattened());
            slot = end + 1;
        }
        self.plants = Arc::clone(&snapshot.plants);
    }

    /// A species with all of its volumes in their places, which begin at a word.
    fn place<W: FnMut(u64, &[u32])>(
        &mut self,
        shown: &Shown,
        begin: u32,
        writes: &mut Writes<W>,
    ) -> Placed<Record> {
        let (mut volumes, mut is_whole, mut has_room) = (Vec::new(), true, true);
        let mut words = species_words(shown, shown.rest());
        for (age, light) in shown.both().into_iter().enumerate() {
            let Some((light, factor)) = light.filter(|(_, factor)| *factor != 0.0) else { continue };
            words[1 + age] = factor.to_bits();
            let suns = &light.suns;
            let [x, y, z] = suns.towards_sun;
            let floats = [x, y, z, suns.azimuth_deg, suns.elevation_deg].map(|c| (c as f32).to_bits());
            let sun = floats.into_iter().chain([suns.own, suns.top, light.stride]);
            words[SUNS + SUN * age..].iter_mut().zip(sun).for_each(|(word, of_sun)| *word = of_sun);
            let mut places = BTreeMap::new();
            for (cell, volume) in light.volumes() {
                match self.place_volume(volume, begin, writes) {
                    Placed::There(first) => {
                        places.insert(cell, first);
                        volumes.push(Arc::as_ptr(volume).addr());
                    }
                    Placed::Later => is_whole = false,
                    Placed::NoRoom => has_room = false,
                }
            }
            let cells = words[SPECIES as usize..].chunks_exact_mut(2);
            for (cell, nearest) in cells.zip(light.nearest()) {
                cell[age] = places.get(nearest).copied().unwrap_or_default();
            }
        }
        writes.followed.is_complete &= is_whole && has_room;
        match (has_room, is_whole) {
            (false, _) => Placed::NoRoom,
            (true, false) => Placed::Later,
            (true, true) => Placed::There(Record { words, volumes }),
        }
    }

    /// Where a volume lies, written there if it does not yet.
    fn place_volume<W: FnMut(u64, &[u32])>(
        &mut self,
        volume: &Arc<LightVolume>,
        begin: u32,
        writes: &mut Writes<W>,
    ) -> Placed<u32> {
        let address = Arc::as_ptr(volume).addr();
        if let Some(place) = self.places.get_mut(&address) {
            place.used = self.frame;
            return Placed::There(place.first);
        }
        let count = volume.word_count() as u32;
        let bytes = 4 * u64::from(count);
        if writes.has_volume && writes.left_bytes < bytes {
            return Placed::Later;
        }
        let placed = self.gap(begin, count).and_then(|first| Some((first, volume.words()?)));
        let Some((first, words)) = placed else {
            writes.followed.lacking_bytes += bytes;
            return Placed::NoRoom;
        };
        (writes.left_bytes, writes.has_volume) = (writes.left_bytes.saturating_sub(bytes), true);
        writes.put(first, &words);
        let place = Place { _volume: Arc::downgrade(volume), first, words: count, used: self.frame };
        self.places.insert(address, place);
        Placed::There(first)
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

/// Where each species begins, and where plants do behind them.
fn firsts(snapshot: &Snapshot) -> Vec<u64> {
    let mut firsts = vec![u64::from(HEAD)];
    for shown in &snapshot.species {
        firsts.push(firsts[firsts.len() - 1] + words_of(shown.yaws) as u64);
    }
    firsts
}

/// Words of a species.
fn words_of(yaws: u32) -> usize {
    SPECIES as usize + 2 * Suns::count(yaws)
}

/// Plants that are there.
fn there(plants: &[Plant]) -> u32 {
    plants.iter().filter(|plant| plant.is_there()).count() as u32
}

/// Words of a species without volumes, with a share of its mean light.
fn species_words(shown: &Shown, share: f32) -> Vec<u32> {
    let mut words = vec![0; words_of(shown.yaws)];
    words[0] = shown.yaws;
    words[6] = (row_step_deg(shown.yaws) as f32).to_bits();
    words[7] = rows(shown.yaws);
    for (word, mean) in words[3..3 + RGB].iter_mut().zip(&shown.mean) {
        *word = (share * mean).to_bits();
    }
    words
}

#[cfg(test)]
mod tests;
