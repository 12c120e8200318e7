//! Species out of a file again: decoded, to be coded with other settings, or as they are, to be merged.

use std::collections::HashMap;
use std::sync::Arc;

use flb_format::container::records::*;
use flb_format::error::Place;
use flb_format::{Container, FormatError, Source, room};

use crate::encode::{EncodedPage, EncodedSection};
use crate::{EncodedSpecies, PackError, priority};
use flb_format::SpeciesFields;

/// Decodes a species in full.
///
/// # Errors
/// Everything that [`Container::read_medium`], [`Container::read_turbid`] and [`Container::read_field`] refuse.
pub fn load_species(
    container: &Container,
    source: &dyn Source,
    index: usize,
) -> Result<SpeciesFields, PackError> {
    let medium = container.read_medium(source, index)?;
    let species = &container.species()[index];
    let turbid = species.extinction.map(|_| container.read_turbid(source, index)).transpose()?;
    let mut bases = Vec::with_capacity(species.bases.len());
    for entry in &species.bases {
        bases.push((entry.base, container.read_field(source, index, entry.base)?));
    }
    Ok(SpeciesFields { meta: species.meta.clone(), medium, turbid, bases })
}

/// Takes a species over as it is coded: see [`Copier::species`].
///
/// # Errors
/// Those of [`Copier::species`].
pub fn copy_species(
    container: &Container,
    source: &dyn Source,
    index: usize,
) -> Result<EncodedSpecies, PackError> {
    Copier::new(container, source).species(index)
}

/// Takes species of a file over as they are coded. Bytes that pages share are held once.
pub struct Copier<'a> {
    container: &'a Container,
    source: &'a dyn Source,
    /// By offset.
    stored: HashMap<u64, Arc<[u8]>>,
}

impl<'a> Copier<'a> {
    /// Makes a copier of an open file.
    pub fn new(container: &'a Container, source: &'a dyn Source) -> Copier<'a> {
        Copier { container, source, stored: HashMap::new() }
    }

    /// Sections that belong to no species; their kinds are not known. They are never copied.
    pub fn of_the_file(&self) -> Vec<SectionKey> {
        let keys = self.container.sections().iter().map(|section| section.key);
        keys.filter(|key| key.species == NO_SPECIES).collect()
    }

    /// A species; its pages are checked against their digests, not decoded. Sections of unknown kinds come along where
    /// their flag allows it; the others are listed in `dropped`.
    ///
    /// # Errors
    /// [`FormatError::NoSpecies`] and what reading pages refuses.
    pub fn species(&mut self, index: usize) -> Result<EncodedSpecies, PackError> {
        let (container, source) = (self.container, self.source);
        let count = container.species().len();
        let Some(species) = container.species().get(index) else {
            return Err(FormatError::NoSpecies { found: index, count }.into());
        };
        let mut copied = EncodedSpecies {
            meta: species.meta.clone(),
            sections: Vec::new(),
            report: None,
            dropped: Vec::new(),
        };
        for (i, entry) in container.sections().iter().enumerate() {
            if entry.key.species as usize != index {
                continue;
            }
            let is_base = entry.key.kind == KIND_BASE;
            let known = container.header().kinds().contains(&entry.key.kind);
            if !known && entry.flags & FLAG_COPY == 0 {
                copied.dropped.push(entry.key);
                continue;
            }
            let place = Place::section(entry.data_offset, entry.key);
            let mut pages = room::empty(place, "pages", entry.page_count as usize)?;
            room::ask(place, "the pages as stored", entry.data_bytes)?;
            for (p, page) in (0u32..).zip(container.pages(i)) {
                // The draft has no priorities, and no bases but those of kind 3.
                let priority = match is_base && container.header().is_draft() {
                    true => priority_of(container, source, i, p)?,
                    false => page.priority,
                };
                pages.push(EncodedPage {
                    count: page.count,
                    raw_bytes: page.raw_bytes,
                    compression: page.compression,
                    priority,
                    stored: self.stored(i, p, page.offset)?,
                });
            }
            copied.sections.push(EncodedSection {
                kind: entry.key.kind,
                item: entry.key.item,
                flags: entry.flags,
                codec: entry.codec,
                threshold: entry.threshold,
                page_bytes: entry.page_bytes,
                lattice: entry.lattice,
                bands: entry.bands,
                pages,
            });
        }
        Ok(copied)
    }

    /// The bytes of a page as stored; its digest is checked even where they were read for another page.
    fn stored(&mut self, section: usize, page: u32, offset: u64) -> Result<Arc<[u8]>, PackError> {
        let bytes = self.container.read_stored(self.source, section, page)?;
        Ok(Arc::clone(self.stored.entry(offset).or_insert_with(|| bytes.into())))
    }
}

/// What reading a page of a base of kind 3 is worth.
fn priority_of(
    container: &Container,
    source: &dyn Source,
    section: usize,
    page: u32,
) -> Result<f32, PackError> {
    let entry = &container.sections()[section];
    let model = &container.species()[entry.key.species as usize].meta.model;
    let unit = model.empty_value(entry.key.item as u8);
    if entry.codec == CODEC_HAAR_PAPER {
        let blocks = container.read_block_page(source, section, page)?;
        return Ok(priority::of_blocks(&blocks, entry.bands as usize, unit));
    }
    Ok(priority::of_values(&container.read_value_page(source, section, page)?, unit))
}
