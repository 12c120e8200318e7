//! Species out of a file again: decoded, to be coded with other settings, or as they are, to be merged.

use flb_format::container::Container;
use flb_format::records::*;
use flb_format::{FormatError, Source};

use crate::{EncodedPage, EncodedSection, EncodedSpecies, PackError, SpeciesFields};

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

/// Takes a species over as it is coded; its pages are checked against their digests, not decoded.
/// Sections of unknown kinds come along where their flag allows it; the others are listed in `dropped`.
///
/// # Errors
/// [`FormatError::NoSpecies`] and what reading pages refuses.
pub fn copy_species(
    container: &Container,
    source: &dyn Source,
    index: usize,
) -> Result<EncodedSpecies, PackError> {
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
        let known = KINDS.contains(&entry.key.kind);
        if !known && entry.flags & FLAG_COPY == 0 {
            copied.dropped.push(entry.key);
            continue;
        }
        let mut pages = Vec::with_capacity(entry.page_count as usize);
        for (p, page) in container.pages(i).iter().enumerate() {
            pages.push(EncodedPage {
                count: page.count,
                raw_bytes: page.raw_bytes,
                compression: page.compression,
                stored: container.read_stored(source, i, p as u32)?,
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
