//! The checked parse of a `.flb` file: bytes of a [`Source`] to species, fields and media.
//!
//! [`Container::open`] verifies header, table of contents, page tables and metadata once; what it
//! returns cannot be wrong about them. Pages are verified one by one as they are read. The BLAKE3 root
//! and the padding need the whole file: [`verify`] checks them.

mod content;
pub mod digest;
pub mod metadata;
mod near;
mod open;
mod page;
pub mod payload;
pub mod records;
pub mod verify;

use crate::error::{FormatError, Place};
use crate::medium::Class;
use crate::turbid::TurbidMedium;
use crate::{Field, Medium, Source, SpeciesMeta, block, room};

use self::payload::{BlockPage, PageContext};
use self::records::{Codec, Header, KIND_METADATA, PageEntry, SectionEntry};

pub use self::open::read_header;

/// A file whose header, tables and metadata were found to keep every promise of `SPEC.md`.
///
/// Invariant: `tables[i]` belongs to `sections[i]`; all offsets lie in the file; species own every
/// section that [`Species`] names.
#[derive(Debug, Clone)]
pub struct Container {
    header: Header,
    sections: Vec<SectionEntry>,
    /// `[section][page]`
    tables: Vec<Vec<PageEntry>>,
    species: Vec<Species>,
    /// `[species]`: places in the file of the bands that it is read with; `None` is all of them.
    chosen: Vec<Option<Vec<usize>>>,
}

/// One species of a file.
#[derive(Debug, Clone)]
pub struct Species {
    /// Metadata of the species.
    pub meta: SpeciesMeta,
    /// Bases of the species, ascending.
    pub bases: Vec<BaseEntry>,
    /// Sections of its medium: density, class, leaf area density, wood area density.
    pub medium: [usize; 4],
    /// Sections of its extinction by leaves and by wood; `None` for `paper`.
    pub extinction: Option<[usize; 2]>,
    /// Sections that the bases share, if only blocks near geometry are stored; then no base is of kind 3.
    pub blocks: Option<BlockSections>,
    /// Stored bytes of the species' pages, those included that it shares with sections before it.
    pub bytes: u64,
}

/// Sections that the bases of a species share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockSections {
    /// Index of the section of the block map.
    pub map: usize,
    /// Index of the section of class tables: of `classed`, and of no other codec.
    pub classes: Option<usize>,
}

/// One base of a species.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseEntry {
    /// Item of the base: 0 ambient light or sky; from 1 on lattice directions, or coefficients of harmonics and of the
    /// near beam.
    pub base: u8,
    /// Codec of the base.
    pub codec: Codec,
    /// Threshold relative to the base's value in empty space; 0 for codecs without one.
    pub threshold: f32,
    /// Stored bytes of the base's pages, shared ones included.
    pub bytes: u64,
    /// Bytes of its pages before compression.
    pub raw_bytes: u64,
    /// Index of its section; of blocks near geometry that of its averages.
    pub section: usize,
    /// Index of the section of its detail; of blocks near geometry.
    pub detail: Option<usize>,
}

impl Container {
    /// Restricts a species to these bands, in this order: metadata and light read from the container are of them alone.
    ///
    /// # Panics
    /// If there is no such species or band, or no band at all.
    #[must_use]
    pub fn with_bands(mut self, species: usize, bands: &[usize]) -> Container {
        assert!(!bands.is_empty(), "one band at least");
        let owner = &mut self.species[species];
        owner.meta = owner.meta.with_bands(bands);
        let in_file = |&band: &usize| self.chosen[species].as_ref().map_or(band, |chosen| chosen[band]);
        self.chosen[species] = Some(bands.iter().map(in_file).collect());
        self
    }

    /// Places in the file of the bands that [`Container::with_bands`] chose of a species; `None` if all are read.
    pub fn chosen_bands(&self, species: usize) -> Option<&[usize]> {
        self.chosen.get(species)?.as_deref()
    }

    /// Reads and verifies header, table of contents, page tables and metadata.
    ///
    /// # Errors
    /// Every broken promise of SPEC.md sections 3 to 5 and 9, and of section 7 for metadata pages.
    pub fn open(source: &dyn Source) -> Result<Container, FormatError> {
        open::open(source)
    }

    /// The verified header.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Major and minor version of the format.
    pub fn format_version(&self) -> (u16, u16) {
        self.header.version
    }

    /// The BLAKE3 root as the header states it: the identity of the file.
    pub fn root(&self) -> &[u8; 32] {
        &self.header.root
    }

    /// All species, in the file's order.
    pub fn species(&self) -> &[Species] {
        &self.species
    }

    /// All sections, ascending by key.
    pub fn sections(&self) -> &[SectionEntry] {
        &self.sections
    }

    /// The page table of a section.
    ///
    /// # Panics
    /// If there is no such section.
    pub fn pages(&self, section: usize) -> &[PageEntry] {
        &self.tables[section]
    }

    /// Bytes that the pages of a section store, whether they share them or not.
    ///
    /// # Panics
    /// If there is no such section.
    pub fn stored_bytes(&self, section: usize) -> u64 {
        open::stored_bytes(&self.tables[section])
    }

    /// The content of a section, which starts with its first page, whether that is its own or a shared one.
    fn section_place(&self, section: usize) -> Place {
        let entry = &self.sections[section];
        Place::section(self.tables[section].first().map_or(entry.data_offset, |page| page.offset), entry.key)
    }

    /// Index of the species of this name.
    pub fn find_species(&self, name: &str) -> Option<usize> {
        self.species.iter().position(|species| species.meta.name == name)
    }

    /// A base of a species, where the file holds it.
    pub fn find_base(&self, species: usize, base: u8) -> Option<&BaseEntry> {
        self.species.get(species)?.bases.iter().find(|entry| entry.base == base)
    }

    /// Why a species does not have a base that [`Container::find_base`] did not find: a plan left it out, or the reason
    /// is unknown.
    fn no_base(&self, species: usize, base: u8) -> FormatError {
        let left_out = self.species.get(species).and_then(|owner| owner.meta.left_out.as_ref());
        match left_out.filter(|left_out| left_out.bases.contains(base)) {
            Some(left_out) => FormatError::BaseLeftOut { species, base, reason: left_out.reason.clone() },
            None => FormatError::NoBase { species, base },
        }
    }

    /// The payload of a page: read, digest-checked, decompressed.
    ///
    /// # Errors
    /// [`FormatError::NoPage`], read errors, and the promises of SPEC.md section 7.
    pub fn read_page(&self, source: &dyn Source, section: usize, page: u32) -> Result<Vec<u8>, FormatError> {
        let entry = self.page_entry(section, page)?;
        page::read(source, self.sections[section].key, page, entry)
    }

    /// The bytes of a page as they are stored: read, digest-checked, not decompressed.
    ///
    /// # Errors
    /// As [`Container::read_page`], less those of a zstd frame.
    pub fn read_stored(
        &self,
        source: &dyn Source,
        section: usize,
        page: u32,
    ) -> Result<Vec<u8>, FormatError> {
        let entry = self.page_entry(section, page)?;
        page::read_stored(source, self.sections[section].key, page, entry)
    }

    fn page_entry(&self, section: usize, page: u32) -> Result<&PageEntry, FormatError> {
        let entry = self.tables.get(section).and_then(|table| table.get(page as usize));
        entry.ok_or(FormatError::NoPage { section, page })
    }

    /// The page of a section that holds a unit (block, value or byte), or `None` past its end.
    pub fn page_of_unit(&self, section: usize, unit: u64) -> Option<u32> {
        let table = &self.tables[section];
        let page = table.partition_point(|entry| entry.first + u64::from(entry.count) <= unit);
        (page < table.len()).then_some(page as u32)
    }

    /// A page of a `haar-paper` base, checked, as typed blocks.
    ///
    /// # Errors
    /// As [`Container::read_page`]; [`FormatError::NoBlocks`] for another codec; the promises of SPEC.md
    /// section 8.2.
    pub fn read_block_page(
        &self,
        source: &dyn Source,
        section: usize,
        page: u32,
    ) -> Result<BlockPage, FormatError> {
        let bytes = self.read_page(source, section, page)?;
        let entry = &self.sections[section];
        let context = self.page_context(section, page);
        if entry.codec != records::CODEC_HAAR_PAPER {
            let codec = Codec::from_number(entry.codec).map_or("none of a base", Codec::name);
            return Err(FormatError::NoBlocks { place: context.place, codec });
        }
        let model = &self.species[entry.key.species as usize].meta.model;
        let threshold = payload::absolute_threshold(model.empty_value(entry.key.item as u8), entry.threshold);
        let page = BlockPage::from_bytes(&bytes, context, entry.bands, threshold)?;
        Ok(match self.chosen_bands(entry.key.species as usize) {
            Some(bands) => page.with_bands(entry.bands as usize, bands),
            None => page,
        })
    }

    /// A page of a `raw-f32` or `raw-f16` base, checked, as values, of all bands that the file has.
    ///
    /// # Errors
    /// As [`Container::read_page`]; [`FormatError::NoBlocks`] for another codec; the promises of SPEC.md section 8.1.
    pub fn read_value_page(
        &self,
        source: &dyn Source,
        section: usize,
        page: u32,
    ) -> Result<Vec<f32>, FormatError> {
        let bytes = self.read_page(source, section, page)?;
        let context = self.page_context(section, page);
        let decode: payload::DecodeRaw = match Codec::from_number(self.sections[section].codec) {
            Some(Codec::RawF32) => payload::decode_raw,
            Some(Codec::RawF16) => payload::decode_raw_f16,
            other => {
                let codec = other.map_or("none of a base", Codec::name);
                return Err(FormatError::NoBlocks { place: context.place, codec });
            }
        };
        let mut values = room::filled(context.place, "values of a page", 0.0, context.count as usize)?;
        decode(&bytes, context, &mut values)?;
        Ok(values)
    }

    /// A whole base, decoded to its texels.
    ///
    /// # Errors
    /// [`FormatError::NoSpecies`], [`FormatError::BaseLeftOut`], [`FormatError::NoBase`]; as [`Container::read_page`];
    /// the promises of SPEC.md sections 8.1 and 8.2.
    pub fn read_field(&self, source: &dyn Source, species: usize, base: u8) -> Result<Field, FormatError> {
        let owner = self.known_species(species)?;
        let entry = self.find_base(species, base).ok_or_else(|| self.no_base(species, base))?;
        let lattice = owner.meta.grid.lattice;
        // Pages of raw values run through all bands of the file.
        let bands = match entry.codec {
            Codec::RawF32 | Codec::RawF16 => self.sections[entry.section].bands,
            _ => owner.meta.band_count() as u32,
        };
        let place = self.section_place(entry.section);
        let sites = (lattice as usize).pow(3);
        let count = sites * bands as usize;
        if entry.codec.is_near_geometry() {
            let shared = self.read_shared(source, species)?;
            let coded = self.read_coded_base(source, species, base, &shared)?;
            room::ask(place, "a field", (count * size_of::<f32>()) as u64)?;
            return Ok(coded.field());
        }
        let mut field = Field::new(lattice, bands, room::filled(place, "a field", 0.0, count)?);
        for page in 0..self.tables[entry.section].len() as u32 {
            match entry.codec {
                Codec::RawF32 | Codec::RawF16 => {
                    let values = self.read_value_page(source, entry.section, page)?;
                    let first = self.tables[entry.section][page as usize].first as usize;
                    field.values_mut()[first..][..values.len()].copy_from_slice(&values);
                }
                Codec::HaarPaper => {
                    expand_blocks(&self.read_block_page(source, entry.section, page)?, &mut field);
                }
                Codec::Classed | Codec::Haar => unreachable!("read above"),
            }
        }
        if let Some(chosen) = self.chosen_bands(species).filter(|_| entry.codec != Codec::HaarPaper) {
            let mut values = room::empty(place, "a field", sites * chosen.len())?;
            chosen.iter().for_each(|&band| values.extend_from_slice(&field.band(band as u32)));
            field = Field::new(lattice, chosen.len() as u32, values);
        }
        Ok(field)
    }

    /// The medium of a species.
    ///
    /// # Errors
    /// [`FormatError::NoSpecies`]; as [`Container::read_page`]; the promises of SPEC.md sections 8.3 and
    /// 10.1.
    pub fn read_medium(&self, source: &dyn Source, species: usize) -> Result<Medium, FormatError> {
        let owner = self.known_species(species)?;
        let [density, class, leaf, wood] = owner.medium;
        let sites = owner.meta.grid.sites();
        let density_section = density;
        let density: Vec<f32> = self.read_sparse(source, density, sites)?;
        let class: Vec<u8> = self.read_sparse(source, class, sites)?;
        let class = self.join_class(density_section, &density, &class)?;
        Ok(Medium {
            grid: owner.meta.grid,
            density,
            class,
            leaf_area_density: self.read_sparse(source, leaf, sites)?,
            wood_area_density: self.read_sparse(source, wood, sites)?,
        })
    }

    /// The turbid medium of a `physical` species.
    ///
    /// # Errors
    /// [`FormatError::NoSpecies`]; [`FormatError::NoExtinction`] for a species of the model `paper`; as
    /// [`Container::read_page`]; the promises of SPEC.md section 8.3.
    pub fn read_turbid(&self, source: &dyn Source, species: usize) -> Result<TurbidMedium, FormatError> {
        let owner = self.known_species(species)?;
        let (Some([leaf, wood]), Some((_, light))) = (owner.extinction, owner.meta.physical()) else {
            return Err(FormatError::NoExtinction { species });
        };
        let sites = owner.meta.grid.sites();
        Ok(TurbidMedium {
            grid: owner.meta.grid,
            leaf_per_m: self.read_sparse(source, leaf, sites)?,
            wood_per_m: self.read_sparse(source, wood, sites)?,
            angles: light.leaf_angles.clone(),
        })
    }

    /// The canonical JSON of a species' metadata, as stored.
    ///
    /// # Errors
    /// [`FormatError::NoSpecies`]; as [`Container::read_page`].
    pub fn read_metadata(&self, source: &dyn Source, species: usize) -> Result<Vec<u8>, FormatError> {
        self.known_species(species)?;
        let is_it = |s: &SectionEntry| s.key.kind == KIND_METADATA && s.key.species as usize == species;
        let section = self.sections.iter().position(is_it).expect("open found metadata of every species");
        open::read_section(source, &self.sections[section], &self.tables[section])
    }

    fn known_species(&self, species: usize) -> Result<&Species, FormatError> {
        let count = self.species.len();
        self.species.get(species).ok_or(FormatError::NoSpecies { found: species, count })
    }

    fn page_context(&self, section: usize, page: u32) -> PageContext {
        let entry = &self.tables[section][page as usize];
        let place = Place::page(entry.offset, self.sections[section].key, page);
        PageContext { place, first: entry.first, count: entry.count }
    }

    fn read_sparse<T: payload::SparseValue>(
        &self,
        source: &dyn Source,
        section: usize,
        sites: usize,
    ) -> Result<Vec<T>, FormatError> {
        let place = self.section_place(section);
        let mut values = room::filled(place, "a value for each site", T::default(), sites)?;
        for page in 0..self.tables[section].len() as u32 {
            let bytes = self.read_page(source, section, page)?;
            let context = self.page_context(section, page);
            let part = &mut values[context.first as usize..][..context.count as usize];
            payload::decode_sparse(&bytes, context, part)?;
        }
        Ok(values)
    }

    /// Class is empty exactly where the density is 0, and no density exceeds 1.
    fn join_class(&self, section: usize, density: &[f32], class: &[u8]) -> Result<Vec<Class>, FormatError> {
        let mut classes = room::empty(self.section_place(section), "classes of sites", class.len())?;
        for (site, (&density, &class)) in density.iter().zip(class).enumerate() {
            let fault = |expected| FormatError::Class {
                place: self.section_place(section),
                site: site as u64,
                class,
                density,
                expected,
            };
            if density > 1.0 {
                return Err(fault("a density of at most 1"));
            }
            classes.push(match (class, density > 0.0) {
                (0, false) => Class::Empty,
                (1, true) => Class::Leaf,
                (2, true) => Class::Wood,
                _ => return Err(fault("class 0 exactly where the density is 0")),
            });
        }
        Ok(classes)
    }
}

/// Writes the texels of a page's blocks into a field; texel owners as in SPEC.md section 8.2.
pub fn expand_blocks(page: &BlockPage, field: &mut Field) {
    let bands = field.bands as usize;
    let per_axis = block::blocks_per_axis(field.lattice);
    let mut texels = vec![0.0; block::TEXELS * bands];
    for i in 0..page.masks.len() {
        let (mask, coefficients) = page.block(i, bands);
        block::decode(mask, coefficients, bands, &mut texels);
        let b = page.first_block + i as u32;
        let at = [b % per_axis, b / per_axis % per_axis, b / (per_axis * per_axis)];
        block::scatter(field, at, &texels);
    }
}
