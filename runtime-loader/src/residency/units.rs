//! The catalogue of what can be loaded by itself, from a container's tables alone.
//!
//! ```text
//! Shared (block map, class tables)  <- Averages of a base <- Detail: a page of it
//! Extinction, for the near beam     <- nothing
//! ```

use std::ops::Range;

use flb_format::blocks::{BlockMap, EDGE};
use flb_format::container::Species;
use flb_format::{Codec, Container};

use crate::RuntimeError;
use crate::extinction::{BLOCK_BYTES, DEPTHS_BYTES};

/// Place of a unit in the catalogue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UnitId(pub(super) u32);

impl UnitId {
    /// Number of the unit, from 0.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Content of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum UnitKind {
    /// Block map and class tables of a species.
    Shared,
    /// Extinction by leaves and wood of a species whose suns need a near beam.
    Extinction,
    /// Head and averages of a base.
    Averages {
        /// Place in the species' bases.
        base: u16,
    },
    /// A page of a base's detail.
    Detail {
        /// Place in the species' bases.
        base: u16,
        /// Page of its section.
        page: u32,
    },
}

/// Part of a library that is loaded and dropped as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Index of the species.
    pub species: u32,
    /// Content of the unit.
    pub kind: UnitKind,
    /// Bytes of the unit in the file.
    pub stored_bytes: u64,
    /// Largest amount of memory of the unit once it is loaded, bytes.
    pub memory_bytes: u64,
    /// Squared error that the unit removes, relative to the square of its base's peak (SPEC.md, section 5.1).
    pub priority: f32,
    /// Rank of the first block of a page, and number of blocks.
    pub blocks: [u32; 2],
}

/// Tier of averages; block maps are before it.
pub(super) const AVERAGES_TIER: u8 = 1;

impl Unit {
    /// Of units that were of use as long ago, those of a higher tier are evicted first.
    pub(super) fn tier(&self) -> u8 {
        match self.kind {
            UnitKind::Shared => 0,
            UnitKind::Averages { .. } => AVERAGES_TIER,
            UnitKind::Extinction => 2,
            UnitKind::Detail { .. } => 3,
        }
    }
}

/// Memory of a class in class tables, at most: eight groups of fields, and its widths.
const CLASS_MEMORY_BYTES: u64 = 8 * 96 + 12 + 63 + 64;
/// Bytes of a class in a file, and those before the first.
const CLASS_BYTES: u64 = 32;
/// Stored blocks that share a box, and the box's memory.
const RUN: usize = 64;
const RUN_BYTES: u64 = 12;
/// Memory of a base whatever its size: head and lists.
const BASE_BYTES: u64 = 1024;
/// Memory of a page whatever its size.
const PAGE_BYTES: u64 = 64;

/// All units of a library. Order: by species; in each `Shared`, `Extinction`, then each base's averages and pages.
#[derive(Debug)]
pub struct Units {
    units: Vec<Unit>,
    species: Vec<SpeciesUnits>,
}

#[derive(Debug)]
struct SpeciesUnits {
    units: Range<u32>,
    bases: Vec<BaseUnits>,
    /// Texels of the stored blocks of a base.
    texels: f32,
    origin_m: [f32; 3],
    block_m: f32,
}

/// A base in the catalogue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BaseUnits {
    /// Item of the base.
    pub item: u8,
    /// Section of the base's averages.
    pub averages: usize,
    /// Section of the base's detail.
    pub detail: usize,
    /// Unit of its averages; its pages follow.
    first: u32,
    pages: u32,
}

impl Units {
    /// Reads the tables. Work and memory grow with the number of pages.
    ///
    /// # Errors
    /// [`RuntimeError::NotStreamed`] for the first species that is not of blocks near geometry.
    pub fn new(container: &Container, path: &std::path::Path) -> Result<Units, RuntimeError> {
        let mut all = Units { units: Vec::new(), species: Vec::new() };
        for (index, species) in container.species().iter().enumerate() {
            let Some(entry) = all.species_units(container, index as u32, species) else {
                return Err(RuntimeError::NotStreamed {
                    path: path.to_owned(),
                    species: species.meta.name.clone(),
                    codec: species.bases.first().map_or("none", |base| base.codec.name()),
                });
            };
            all.species.push(entry);
        }
        Ok(all)
    }

    fn species_units(
        &mut self,
        container: &Container,
        index: u32,
        species: &Species,
    ) -> Option<SpeciesUnits> {
        let shared = species.blocks?;
        let grid = &species.meta.grid;
        // All that are coded: components are of those, whichever bands are asked for.
        let bands = species.bases.first().map_or(0, |base| container.sections()[base.section].bands.into());
        let bases: Vec<_> =
            species.bases.iter().map(|base| Some((base, base.detail?))).collect::<Option<_>>()?;
        let blocks = bases.first().map_or(0, |(_, detail)| container.sections()[*detail].units);
        let stored = |section: usize| container.stored_bytes(section);
        let start = self.units.len() as u32;
        let mut push = |kind, stored_bytes, memory_bytes, priority, blocks| {
            self.units.push(Unit { species: index, kind, stored_bytes, memory_bytes, priority, blocks });
            self.units.len() as u32 - 1
        };
        let classes = shared.classes.map_or(0, |s| container.sections()[s].raw_bytes / CLASS_BYTES + 1);
        let words = u64::from(grid.lattice).pow(3) / (EDGE * EDGE * EDGE) as u64 / 32 * 8;
        let shared_memory =
            words + 4 * blocks + RUN_BYTES * blocks.div_ceil(RUN as u64) + classes * CLASS_MEMORY_BYTES;
        let shared_stored = stored(shared.map) + shared.classes.map_or(0, stored);
        push(UnitKind::Shared, shared_stored, shared_memory, 1.0, [0; 2]);
        let needs_beam = species.meta.model.suns().has_near_beam();
        if let (true, Some([leaf, wood])) = (needs_beam, species.extinction) {
            // A payload is a bit for each site, and the values of those that have one (SPEC.md, section 8.3).
            let masks = u64::from(grid.lattice).pow(3) / 8;
            let values = |section: usize| container.sections()[section].raw_bytes.saturating_sub(masks) / 4;
            let memory = words + (BLOCK_BYTES + 4) * blocks + DEPTHS_BYTES * (values(leaf) + values(wood));
            push(UnitKind::Extinction, stored(leaf) + stored(wood), memory, 1.0, [0; 2]);
        }
        let coarse = (u64::from(grid.lattice) / 16).pow(3);
        let mut entries = Vec::with_capacity(bases.len());
        for (i, (base, detail)) in (0u16..).zip(&bases) {
            let haar = if base.codec == Codec::Haar { 8 * bands } else { 0 };
            let memory =
                blocks * (4 * (1 + bands) + 1 + haar) + 2 * bands * coarse + 8 * bands * bands + BASE_BYTES;
            let averages = container.pages(base.section);
            let priority = averages.first().map_or(0.0, |page| page.priority);
            let first = push(UnitKind::Averages { base: i }, stored(base.section), memory, priority, [0; 2]);
            let pages = container.pages(*detail);
            for (page, entry) in (0..).zip(pages) {
                // Of `classed`, the fields of a block's component begin with a byte.
                let memory = u64::from(entry.raw_bytes) + u64::from(entry.count) * bands + PAGE_BYTES;
                let kind = UnitKind::Detail { base: i, page };
                let blocks = [entry.first as u32, entry.count]; // a lattice has up to 2^18 blocks
                push(kind, u64::from(entry.stored_bytes), memory, entry.priority, blocks);
            }
            entries.push(BaseUnits {
                item: base.base,
                averages: base.section,
                detail: *detail,
                first,
                pages: pages.len() as u32,
            });
        }
        Some(SpeciesUnits {
            units: start..self.units.len() as u32,
            bases: entries,
            texels: (blocks.max(1) * (EDGE * EDGE * EDGE) as u64) as f32,
            origin_m: grid.origin_m.map(|c| c as f32),
            block_m: (grid.spacing_m * EDGE as f64) as f32,
        })
    }

    /// Number of units.
    pub fn len(&self) -> usize {
        self.units.len()
    }

    /// Whether the library has no species.
    pub fn is_empty(&self) -> bool {
        self.units.is_empty()
    }

    /// Species in the library.
    pub fn species(&self) -> usize {
        self.species.len()
    }

    /// A unit.
    pub fn get(&self, unit: UnitId) -> &Unit {
        &self.units[unit.index()]
    }

    /// All units.
    pub fn all(&self) -> impl Iterator<Item = UnitId> + use<> {
        (0..self.units.len() as u32).map(UnitId)
    }

    /// Units of a species.
    pub fn of_species(&self, species: usize) -> impl Iterator<Item = UnitId> + use<> {
        self.species[species].units.clone().map(UnitId)
    }

    /// Those of a species but for pages of detail.
    pub(super) fn coarse(&self, species: usize) -> impl Iterator<Item = UnitId> + '_ {
        let SpeciesUnits { units, bases, .. } = &self.species[species];
        let averages = bases.iter().map(|base| UnitId(base.first));
        [UnitId(units.start)].into_iter().chain(self.extinction(species)).chain(averages)
    }

    /// The extinction, of a species of harmonics: its suns have a near beam.
    pub(super) fn extinction(&self, species: usize) -> Option<UnitId> {
        let second = UnitId(self.species[species].units.start + 1);
        let is_extinction = |unit: &UnitId| {
            self.units.get(unit.index()).is_some_and(|unit| unit.kind == UnitKind::Extinction)
        };
        Some(second).filter(is_extinction)
    }

    /// The bases of a species, ascending by item.
    pub fn bases(&self, species: usize) -> &[BaseUnits] {
        &self.species[species].bases
    }

    /// Texels that a base of a species stores.
    pub(super) fn texels(&self, species: usize) -> f32 {
        self.species[species].texels
    }

    /// Box in model space that holds all that a page can change; the blocks are those of `runs`.
    pub fn box_m(&self, unit: UnitId, runs: &Runs) -> [[f32; 3]; 2] {
        let Unit { species, blocks: [first, count], .. } = *self.get(unit);
        let species = &self.species[species as usize];
        let (first, end) = (first as usize / RUN, (first + count) as usize);
        let runs = &runs.0[first..end.div_ceil(RUN).min(runs.0.len())];
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for [low, high] in runs {
            for axis in 0..3 {
                // Samples reach half a site beyond the texels of a block; a quarter of a block is a whole site.
                let place = |block: f32| species.origin_m[axis] + species.block_m * block;
                min[axis] = min[axis].min(place(f32::from(low[axis]) - 0.25));
                max[axis] = max[axis].max(place(f32::from(high[axis]) + 0.25));
            }
        }
        [min, max]
    }

    /// Unit that must be loaded for a unit to be of use.
    pub fn stands_on(&self, unit: UnitId) -> Option<UnitId> {
        let Unit { species, kind, .. } = *self.get(unit);
        let species = &self.species[species as usize];
        match kind {
            UnitKind::Shared | UnitKind::Extinction => None,
            UnitKind::Averages { .. } => Some(UnitId(species.units.start)),
            UnitKind::Detail { base, .. } => Some(UnitId(species.bases[base as usize].first)),
        }
    }

    /// Units that are of no use once a unit is gone, itself left out: of `Shared` averages, of averages pages.
    pub fn standing_on(&self, unit: UnitId) -> Vec<UnitId> {
        let Unit { species, kind, .. } = *self.get(unit);
        let bases = &self.species[species as usize].bases;
        match kind {
            UnitKind::Shared => bases.iter().map(|base| UnitId(base.first)).collect(),
            UnitKind::Averages { base } => {
                let BaseUnits { first, pages, .. } = bases[base as usize];
                (first + 1..first + 1 + pages).map(UnitId).collect()
            }
            UnitKind::Extinction | UnitKind::Detail { .. } => Vec::new(),
        }
    }

    /// Sections and pages of the file that a unit is made of.
    pub fn pages_of(&self, container: &Container, unit: UnitId) -> Vec<(usize, Range<u32>)> {
        let Unit { species, kind, .. } = *self.get(unit);
        let entry = &container.species()[species as usize];
        let whole = |section: usize| (section, 0..container.pages(section).len() as u32);
        let bases = &self.species[species as usize].bases;
        match kind {
            UnitKind::Shared => {
                let shared = entry.blocks.expect("the catalogue holds species of blocks alone");
                [Some(shared.map), shared.classes].into_iter().flatten().map(whole).collect()
            }
            UnitKind::Extinction => entry.extinction.into_iter().flatten().map(whole).collect(),
            UnitKind::Averages { base } => vec![whole(bases[base as usize].averages)],
            UnitKind::Detail { base, page } => vec![(bases[base as usize].detail, page..page + 1)],
        }
    }
}

/// The boxes of runs of a map's blocks, by which pages are known to lie outside a view.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Runs(Vec<[[u16; 3]; 2]>);

impl Runs {
    /// Computes the boxes of runs of a map's blocks.
    pub fn of(map: &BlockMap) -> Runs {
        let of_run = |first: usize| {
            let (mut min, mut max) = ([u16::MAX; 3], [0; 3]);
            for rank in first..(first + RUN).min(map.len()) {
                let block = map.block(rank).map(|b| b as u16);
                min = std::array::from_fn(|i| block[i].min(min[i]));
                max = std::array::from_fn(|i| (block[i] + 1).max(max[i]));
            }
            [min, max]
        };
        Runs((0..map.len()).step_by(RUN).map(of_run).collect())
    }
}
