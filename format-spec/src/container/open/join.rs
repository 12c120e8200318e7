//! Sections to species: metadata are read, and what belongs to a species is checked against them and for gaps.

use crate::error::{FormatError, Place};
use crate::{Model, Source};

use super::super::records::*;
use super::super::{BaseEntry, Species, metadata, page};

/// Groups the sections by species, reads their metadata and checks that nothing is missing.
pub fn join_species(
    source: &dyn Source,
    sections: &[SectionEntry],
    tables: &[Vec<PageEntry>],
) -> Result<Vec<Species>, FormatError> {
    let entry_place =
        |i: usize| Place::contents(HEADER_BYTES + i as u64 * SECTION_ENTRY_BYTES, Some(sections[i].key));
    let mut species: Vec<Species> = Vec::new();
    for (i, section) in sections.iter().enumerate() {
        let SectionKey { kind, species: owner, item } = section.key;
        if !(KIND_METADATA..=KIND_BASE).contains(&kind) {
            continue;
        }
        if kind == KIND_METADATA {
            if owner as usize != species.len() {
                let (place, missing) = (entry_place(i), "metadata".to_owned());
                return Err(FormatError::SectionMissing { place, species: species.len() as u32, missing });
            }
            let place = Place::section(section.data_offset, section.key);
            let bytes = read_section(source, section, &tables[i])?;
            let meta = metadata::from_bytes(&bytes, place)?;
            if let Some(other) = species.iter().position(|other| other.meta.name == meta.name) {
                let (name, other) = (meta.name, other as u32);
                return Err(FormatError::SpeciesName { place, name, other });
            }
            let bytes = section.data_bytes;
            species.push(Species {
                meta,
                bases: Vec::new(),
                medium: [usize::MAX; 4],
                extinction: None,
                bytes,
            });
            continue;
        }
        let Some(owner_entry) = species.get_mut(owner as usize) else {
            let (place, missing) = (entry_place(i), "metadata".to_owned());
            return Err(FormatError::SectionMissing { place, species: owner, missing });
        };
        check_item(section, &owner_entry.meta.model, entry_place(i))?;
        let grid = &owner_entry.meta.grid;
        let mut agree = vec![("lattice", section.lattice, grid.lattice)];
        if kind == KIND_BASE {
            agree.push(("bands", section.bands, owner_entry.meta.band_count() as u32));
        }
        for (what, found, expected) in agree {
            if found != expected {
                let (found, expected) = (found.to_string(), format!("{expected}, as in the metadata"));
                let place = entry_place(i);
                return Err(FormatError::SectionField { place, what, found, expected });
            }
        }
        owner_entry.bytes += section.data_bytes;
        if kind == KIND_MEDIUM && item >= MEDIUM_EXTINCTION {
            let extinction = owner_entry.extinction.get_or_insert([usize::MAX; 2]);
            extinction[(item - MEDIUM_EXTINCTION) as usize] = i;
        } else if kind == KIND_MEDIUM {
            owner_entry.medium[item as usize] = i;
        } else {
            let left_out = owner_entry.meta.left_out.as_ref();
            if let Some(left_out) = left_out.filter(|left_out| left_out.bases.contains(item as u8)) {
                let (place, base, reason) = (entry_place(i), item as u8, left_out.reason.clone());
                return Err(FormatError::LeftOutPresent { place, base, reason });
            }
            owner_entry.bases.push(BaseEntry {
                base: item as u8,
                codec: Codec::from_number(section.codec).expect("check_section knows a base's codecs"),
                threshold: section.threshold,
                bytes: section.data_bytes,
                raw_bytes: section.raw_bytes,
                section: i,
            });
        }
    }
    check_complete(&species)?;
    Ok(species)
}

/// Extinction belongs to `physical`; how many bases there can be is up to the model and its suns.
fn check_item(section: &SectionEntry, model: &Model, place: Place) -> Result<(), FormatError> {
    let SectionKey { kind, item, .. } = section.key;
    let items = match (kind, model) {
        (KIND_MEDIUM, Model::Paper { .. }) => MEDIUM_EXTINCTION,
        (KIND_MEDIUM, Model::Physical { .. }) => MEDIUM_ITEMS.len() as u32,
        _ => model.items().into(),
    };
    if item < items {
        return Ok(());
    }
    let expected = format!("0 to {}, as the metadata say", items - 1);
    Err(FormatError::SectionField { place, what: "item", found: item.to_string(), expected })
}

fn check_complete(species: &[Species]) -> Result<(), FormatError> {
    let place = Place::contents(HEADER_BYTES, None);
    let missing = |species: usize, missing: &str| {
        let (species, missing) = (species as u32, missing.to_owned());
        Err(FormatError::SectionMissing { place, species, missing })
    };
    if species.is_empty() {
        return missing(0, "metadata");
    }
    for (i, entry) in species.iter().enumerate() {
        let model = &entry.meta.model;
        let extinction = match model {
            Model::Paper { .. } => [0; 2],
            Model::Physical { .. } => entry.extinction.unwrap_or([usize::MAX; 2]),
        };
        let mut medium = entry.medium.iter().chain(&extinction);
        if let Some(item) = medium.position(|section| *section == usize::MAX) {
            return missing(i, MEDIUM_ITEMS[item]);
        }
        if entry.bases.is_empty() {
            return missing(i, "base");
        }
        // Bases ascend, each once, within the model's items.
        if model.needs_all_items() && entry.bases.len() < usize::from(model.items()) {
            let gap = (0..).zip(&entry.bases).find(|(item, base)| *item != base.base);
            return missing(i, &format!("base {}", gap.map_or(entry.bases.len() as u8, |(item, _)| item)));
        }
    }
    Ok(())
}

/// The payloads of all pages of a metadata section, which is small, one after another.
pub fn read_section(
    source: &dyn Source,
    section: &SectionEntry,
    table: &[PageEntry],
) -> Result<Vec<u8>, FormatError> {
    let mut bytes = Vec::new();
    for (i, entry) in table.iter().enumerate() {
        bytes.extend(page::read(source, section.key, i as u32, entry)?);
    }
    Ok(bytes)
}
