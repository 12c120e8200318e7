//! Coded bases to the buffers that light.wgsl reads, within a budget of bytes.
//!
//! Four buffers, made once, so that bind groups never change: species (uniform), bases, words and terms (storage).
//! Words are dealt out by a [`Pool`]: a block map for each species and its extinction where it has a near beam; for
//! each base its records and coarse averages; for each page of detail its nibbles. What is sent is exactly what
//! changed. Uploads go through the queue, in order, so that a submission sees a page whole or not at all, and a record
//! never points at words that are another's: nibbles are written before the records that point at them, and words that
//! were given back are written again only by a later call.

use std::collections::BTreeMap;
use std::sync::Arc;

use flb_format::Grid;
use flb_format::blocks::{CodedBase, Head, Shared};

use super::layout::{self, BASE_BYTES, COLORS, MAX_SPECIES, SPECIES_BYTES, SpeciesPlaces, TERM_BYTES, Term};
use super::pack::{PLACE_BITS, pack_page};
use super::pool::{Pool, Span};
use super::{GpuError, GpuSpeciesId, bindings};
use crate::extinction::Extinction;

/// Bytes of a word.
const WORD: u64 = 4;
/// Blocks that are sent together where a base is sent whole.
const BLOCKS_AT_ONCE: u32 = 1024;

/// Room in the buffers of a [`GpuLight`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LightSettings {
    /// Bytes of all four buffers; up to 128 MiB of words, what WebGPU can bind everywhere.
    pub budget_bytes: u64,
    /// Bases of all species together.
    pub most_bases: u32,
    /// Terms of all instances together.
    pub most_terms: u32,
}

impl Default for LightSettings {
    fn default() -> LightSettings {
        LightSettings { budget_bytes: 32 << 20, most_bases: 1024, most_terms: 65_536 }
    }
}

/// Light of species on a GPU.
pub struct GpuLight {
    queue: wgpu::Queue,
    species_buffer: wgpu::Buffer,
    bases_buffer: wgpu::Buffer,
    words_buffer: wgpu::Buffer,
    terms_buffer: wgpu::Buffer,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    settings: LightSettings,
    pub(super) words: Pool,
    /// `[species]`; `None` where it was removed.
    species: Vec<Option<Species>>,
    /// `[base index]` whether it is taken.
    taken: Vec<bool>,
}

pub(super) struct Species {
    pub(super) grid: Grid,
    shared: Arc<Shared>,
    map: Span,
    pub(super) extinction: Option<Span>,
    /// Whether the near beam needs light scattered once.
    single: bool,
    /// Beams of skies, and how many means they are of.
    pub(super) sky: Option<(Span, u32)>,
    bases: BTreeMap<u8, Base>,
}

struct Base {
    index: u32,
    head: Head,
    records: Span,
    coarse: Option<Span>,
    /// First block to blocks and nibbles.
    pages: BTreeMap<u32, (u32, Option<Span>)>,
}

impl Base {
    fn words(&self) -> u32 {
        let spans = self.pages.values().filter_map(|(_, span)| span.as_ref()).chain(&self.coarse);
        self.records.count() + spans.map(Span::count).sum::<u32>()
    }

    fn spans(self) -> impl Iterator<Item = Span> {
        [Some(self.records), self.coarse]
            .into_iter()
            .chain(self.pages.into_values().map(|(_, s)| s))
            .flatten()
    }
}

impl GpuLight {
    /// Buffers of the budget, with nothing in them.
    ///
    /// # Errors
    /// [`GpuError::Budget`].
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        settings: LightSettings,
    ) -> Result<GpuLight, GpuError> {
        let species_bytes = u64::from(MAX_SPECIES) * SPECIES_BYTES;
        let bases_bytes = u64::from(settings.most_bases.max(1)) * BASE_BYTES;
        let terms_bytes = u64::from(settings.most_terms.max(1)) * TERM_BYTES;
        let tables = species_bytes + bases_bytes + terms_bytes;
        let limits = device.limits();
        let largest =
            limits.max_storage_buffer_binding_size.min(limits.max_buffer_size).min(WORD << PLACE_BITS);
        let (least, most) = (tables + WORD, tables + largest);
        let found = settings.budget_bytes;
        if !(least..=most).contains(&found) || bases_bytes.max(terms_bytes) > largest {
            return Err(GpuError::Budget { found, least, most });
        }
        let words = ((found - tables) / WORD) as u32;
        let buffer = |label, size, kind| {
            let usage = kind | wgpu::BufferUsages::COPY_DST;
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let storage = wgpu::BufferUsages::STORAGE;
        let species_buffer = buffer("flb species", species_bytes, wgpu::BufferUsages::UNIFORM);
        let bases_buffer = buffer("flb bases", bases_bytes, storage);
        let words_buffer = buffer("flb words", WORD * u64::from(words), storage);
        let terms_buffer = buffer("flb terms", terms_bytes, storage);
        let layout = bindings::layout(device);
        let buffers = [&species_buffer, &bases_buffer, &words_buffer, &terms_buffer];
        let group = bindings::group(device, &layout, buffers);
        Ok(GpuLight {
            queue: queue.clone(),
            species_buffer,
            bases_buffer,
            words_buffer,
            terms_buffer,
            layout,
            group,
            settings,
            words: Pool::new(words),
            species: Vec::new(),
            taken: vec![false; settings.most_bases as usize],
        })
    }

    /// Layout of the bind group, for the pipelines that include light.wgsl; visible to compute and fragment shaders.
    pub fn bind_group_layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// The bind group. It stays the same whatever is streamed.
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// Sends what a species' bases share, and tells its number for `flb_sample`.
    ///
    /// # Errors
    /// [`GpuError::NoRoom`], [`GpuError::Full`].
    pub fn add_species(&mut self, grid: &Grid, shared: &Arc<Shared>) -> Result<GpuSpeciesId, GpuError> {
        let number = self.species.iter().position(Option::is_none).unwrap_or(self.species.len());
        if number >= MAX_SPECIES as usize {
            return Err(GpuError::NoRoom { what: "species", most: MAX_SPECIES });
        }
        let map = self.place(&layout::map_words(&shared.map))?;
        self.species.resize_with(self.species.len().max(number + 1), || None);
        self.species[number] = Some(Species {
            grid: *grid,
            shared: Arc::clone(shared),
            map,
            extinction: None,
            single: false,
            sky: None,
            bases: BTreeMap::new(),
        });
        let id = GpuSpeciesId(number as u32);
        self.write_species(id)?;
        Ok(id)
    }

    /// Sends the extinction of a species, in place of what was there of it and of beams of skies, for `flb_near`;
    /// `single` says whether its fields need light scattered once. 16 bytes per block that holds matter and 4 per site
    /// that does.
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`]; [`GpuError::OtherExtinction`] for one of another lattice; [`GpuError::Full`]; nothing
    /// has changed then.
    pub fn set_extinction(
        &mut self,
        species: GpuSpeciesId,
        extinction: &Extinction,
        single: bool,
    ) -> Result<(), GpuError> {
        let expected = self.known(species)?.grid;
        if expected != *extinction.grid() {
            return Err(GpuError::OtherExtinction { species });
        }
        let span = self.place(&layout::extinction_words(extinction))?;
        let known = self.known_mut(species)?;
        known.single = single;
        let before = [known.extinction.replace(span), known.sky.take().map(|(span, _)| span)];
        self.write_species(species)?;
        before.into_iter().flatten().for_each(|span| self.words.give_back(span));
        Ok(())
    }

    /// Forgets the extinction of a species, and the beams of skies, which follow its order; `flb_near` then takes half
    /// of it to be lit.
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`].
    pub fn remove_extinction(&mut self, species: GpuSpeciesId) -> Result<(), GpuError> {
        let known = self.known_mut(species)?;
        let before = [known.extinction.take(), known.sky.take().map(|(span, _)| span)];
        self.write_species(species)?;
        before.into_iter().flatten().for_each(|span| self.words.give_back(span));
        Ok(())
    }

    pub(super) fn write_species(&self, species: GpuSpeciesId) -> Result<(), GpuError> {
        let known = self.known(species)?;
        let places = SpeciesPlaces {
            map: known.map.first(),
            extinction: known.extinction.as_ref().map_or(layout::NONE, Span::first),
            single: known.single,
            sky: known.sky.as_ref().map_or([layout::NONE, 0], |(span, means)| [span.first(), *means]),
        };
        let words = layout::species_words(&known.grid, &known.shared, places);
        let place = SPECIES_BYTES * u64::from(species.word());
        self.queue.write_buffer(&self.species_buffer, place, bytemuck::cast_slice(&words));
        Ok(())
    }

    /// Forgets a species and all its bases.
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`].
    pub fn remove_species(&mut self, species: GpuSpeciesId) -> Result<(), GpuError> {
        let slot = self.species.get_mut(species.index());
        let Species { map, bases, extinction, sky, .. } =
            slot.and_then(Option::take).ok_or(GpuError::NoSpecies { species })?;
        self.words.give_back(map);
        let spans = extinction.into_iter().chain(sky.map(|(span, _)| span));
        spans.for_each(|span| self.words.give_back(span));
        bases.into_values().for_each(|base| self.forget(base));
        Ok(())
    }

    /// Sends a base, as far as its detail was added, in place of what was there of it. Tells its index for [`Term`].
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`], [`GpuError::Bands`], [`GpuError::OtherBase`], [`GpuError::NoRoom`], [`GpuError::Full`];
    /// then nothing of the base is left.
    pub fn set_base(&mut self, species: GpuSpeciesId, base: u8, coded: &CodedBase) -> Result<u32, GpuError> {
        self.set_averages(species, base, coded)?;
        let blocks = coded.shared().map.len() as u32;
        for first in (0..blocks).step_by(BLOCKS_AT_ONCE as usize) {
            let count = BLOCKS_AT_ONCE.min(blocks - first);
            if (first..first + count).any(|rank| coded.is_detailed(rank as usize))
                && let Err(error) = self.update_page(species, base, first, count, coded)
            {
                self.remove_base(species, base)?;
                return Err(error);
            }
        }
        self.base(species, base).ok_or(GpuError::NoBase { species, base })
    }

    /// Sends a base's averages alone, in place of what was there of it: the start of streaming. Tells its index for
    /// [`Term`].
    ///
    /// # Errors
    /// As [`GpuLight::set_base`].
    pub fn set_averages(
        &mut self,
        species: GpuSpeciesId,
        base: u8,
        coded: &CodedBase,
    ) -> Result<u32, GpuError> {
        let shared = Arc::clone(&self.known(species)?.shared);
        check_shared(&shared, species, base, coded)?;
        let head = coded.head();
        // Of bands that were chosen among more, there may be more components than bands.
        let found = head.bands.max(head.components() as u32);
        if found as usize > COLORS {
            return Err(GpuError::Bands { base, found });
        }
        if self.base(species, base).is_some() {
            self.remove_base(species, base)?;
        }
        let most = self.settings.most_bases;
        let index = self.taken.iter().position(|taken| !taken);
        let index = index.ok_or(GpuError::NoRoom { what: "bases", most })?;
        let coarse = match &layout::coarse_words(coded)[..] {
            [] => None,
            words => Some(self.place(words)?),
        };
        let records = average_records(coded);
        let records = match self.place(&records) {
            Ok(records) => records,
            Err(error) => {
                coarse.into_iter().for_each(|span| self.words.give_back(span));
                return Err(error);
            }
        };
        let words = layout::base_words(coded, records.first(), coarse.as_ref().map_or(0, Span::first));
        self.queue.write_buffer(&self.bases_buffer, BASE_BYTES * index as u64, bytemuck::cast_slice(&words));
        self.taken[index] = true;
        let index = index as u32;
        let made = Base { index, head: head.clone(), records, coarse, pages: BTreeMap::new() };
        self.known_mut(species)?.bases.insert(base, made);
        Ok(index)
    }

    /// Sends the detail of a page that holds `count` blocks from rank `first` on, in place of what was there of the
    /// same page. Where `coded` lacks the detail of these blocks, as after an eviction, their averages stay and their
    /// words are free again.
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`], [`GpuError::NoBase`], [`GpuError::OtherBase`], [`GpuError::NoPage`],
    /// [`GpuError::Full`]; nothing has changed then.
    pub fn update_page(
        &mut self,
        species: GpuSpeciesId,
        base: u8,
        first: u32,
        count: u32,
        coded: &CodedBase,
    ) -> Result<(), GpuError> {
        let known = self.known(species)?;
        check_shared(&known.shared, species, base, coded)?;
        let held = known.bases.get(&base).ok_or(GpuError::NoBase { species, base })?;
        if held.head != *coded.head() {
            return Err(GpuError::OtherBase { species, base, what: "head" });
        }
        check_page(held, coded.shared().map.len() as u32, first, count)?;
        let components = coded.head().components();
        let records = held.records.first() + first * (1 + components as u32);
        let mut page = pack_page(coded, first as usize, count as usize);
        let nibbles = if page.nibbles.is_empty() { None } else { Some(self.take(&page.nibbles)?) };
        if let Some(span) = &nibbles {
            page.place(components, span.first());
            self.write_words(span.first(), &page.nibbles);
        }
        self.write_words(records, &page.records);
        let held = self.known_mut(species)?.bases.get_mut(&base).ok_or(GpuError::NoBase { species, base })?;
        let before = match nibbles {
            None => held.pages.remove(&first),
            Some(_) => held.pages.insert(first, (count, nibbles)),
        };
        before.and_then(|(_, span)| span).into_iter().for_each(|span| self.words.give_back(span));
        Ok(())
    }

    /// Forgets a base.
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`], [`GpuError::NoBase`].
    pub fn remove_base(&mut self, species: GpuSpeciesId, base: u8) -> Result<(), GpuError> {
        let held = self.known_mut(species)?.bases.remove(&base);
        self.forget(held.ok_or(GpuError::NoBase { species, base })?);
        Ok(())
    }

    /// Index of a base for [`Term`]; `None` where it is not on the GPU.
    pub fn base(&self, species: GpuSpeciesId, base: u8) -> Option<u32> {
        self.species.get(species.index())?.as_ref()?.bases.get(&base).map(|held| held.index)
    }

    /// Sends terms, from number `first` on.
    ///
    /// # Errors
    /// [`GpuError::NoRoom`].
    pub fn set_terms(&mut self, first: u32, terms: &[Term]) -> Result<(), GpuError> {
        let most = self.settings.most_terms;
        if u64::from(first) + terms.len() as u64 > u64::from(most) {
            return Err(GpuError::NoRoom { what: "terms", most });
        }
        let words: Vec<u32> =
            terms.iter().flat_map(|t| layout::term_fields(*t).map(|(_, word)| word)).collect();
        self.queue.write_buffer(
            &self.terms_buffer,
            TERM_BYTES * u64::from(first),
            bytemuck::cast_slice(&words),
        );
        Ok(())
    }

    /// Bytes that a species' light takes: block map, extinction, beams of skies, records, coarse averages, nibbles.
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`].
    pub fn species_bytes(&self, species: GpuSpeciesId) -> Result<u64, GpuError> {
        let known = self.known(species)?;
        let words = known.map.count()
            + known.extinction.as_ref().map_or(0, Span::count)
            + known.sky.as_ref().map_or(0, |(span, _)| span.count())
            + known.bases.values().map(Base::words).sum::<u32>();
        Ok(WORD * u64::from(words) + SPECIES_BYTES + BASE_BYTES * known.bases.len() as u64)
    }

    /// Bytes of words that are free.
    pub fn free_bytes(&self) -> u64 {
        WORD * u64::from(self.words.free())
    }

    /// Bytes of all buffers, which is at most the budget.
    pub fn size_bytes(&self) -> u64 {
        let buffers = [&self.species_buffer, &self.bases_buffer, &self.words_buffer, &self.terms_buffer];
        buffers.iter().map(|buffer| buffer.size()).sum()
    }

    /// Block map and detail coding that the bases of a species share.
    ///
    /// # Errors
    /// [`GpuError::NoSpecies`].
    pub fn shared(&self, species: GpuSpeciesId) -> Result<&Arc<Shared>, GpuError> {
        Ok(&self.known(species)?.shared)
    }

    pub(super) fn known(&self, species: GpuSpeciesId) -> Result<&Species, GpuError> {
        self.species.get(species.index()).and_then(Option::as_ref).ok_or(GpuError::NoSpecies { species })
    }

    pub(super) fn known_mut(&mut self, species: GpuSpeciesId) -> Result<&mut Species, GpuError> {
        self.species.get_mut(species.index()).and_then(Option::as_mut).ok_or(GpuError::NoSpecies { species })
    }

    fn forget(&mut self, base: Base) {
        self.taken[base.index as usize] = false;
        base.spans().for_each(|span| self.words.give_back(span));
    }

    /// Takes words and sends them.
    pub(super) fn place(&mut self, words: &[u32]) -> Result<Span, GpuError> {
        let span = self.take(words)?;
        self.write_words(span.first(), words);
        Ok(span)
    }

    /// Takes room for words.
    fn take(&mut self, words: &[u32]) -> Result<Span, GpuError> {
        let span = u32::try_from(words.len()).ok().and_then(|count| self.words.take(count));
        span.ok_or_else(|| GpuError::Full {
            needed: WORD * words.len() as u64,
            free: self.free_bytes(),
            largest: WORD * u64::from(self.words.largest()),
            budget: WORD * u64::from(self.words.words()),
        })
    }

    fn write_words(&self, first: u32, words: &[u32]) {
        self.queue.write_buffer(&self.words_buffer, WORD * u64::from(first), bytemuck::cast_slice(words));
    }
}

/// Records of all blocks without detail.
fn average_records(coded: &CodedBase) -> Vec<u32> {
    let average = |rank, component| u32::from(coded.average(rank, component) as u16);
    let components = coded.head().components();
    let record = |rank| std::iter::once(0).chain((0..components).map(move |c| average(rank, c)));
    (0..coded.shared().map.len()).flat_map(record).collect()
}

fn check_shared(
    shared: &Arc<Shared>,
    species: GpuSpeciesId,
    base: u8,
    coded: &CodedBase,
) -> Result<(), GpuError> {
    if std::ptr::eq(&**shared, coded.shared()) || **shared == *coded.shared() {
        return Ok(());
    }
    Err(GpuError::OtherBase { species, base, what: "block map or class tables" })
}

/// A page lies within the map, and is one that is held or overlaps none.
fn check_page(held: &Base, stored: u32, first: u32, count: u32) -> Result<(), GpuError> {
    let fault = |reason: String| Err(GpuError::NoPage { first, count, reason });
    if count == 0 || u64::from(first) + u64::from(count) > u64::from(stored) {
        return fault(format!("expected at least 1, of {stored} stored ones"));
    }
    let last = held.pages.range(..first + count).next_back();
    match last {
        Some((&other, &(blocks, _))) if (other, blocks) != (first, count) && other + blocks > first => {
            fault(format!("they overlap the page of {blocks} blocks from {other} on"))
        }
        _ => Ok(()),
    }
}
