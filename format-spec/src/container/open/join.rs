//! Sections to species: metadata are read, and what belongs to a species is checked against them and for gaps.

use std::ops::RangeInclusive;

use crate::error::{FormatError, Place};
use crate::model::Model;
use crate::{Source, room};

use super::super::records::*;
use super::super::{BaseEntry, BlockSections, Species, metadata, page};

/// Groups the sections by species, reads their metadata and checks that nothing is missing.
pub(super) fn join_species(
    source: &dyn Source,
    kinds: RangeInclusive<u32>,
    sections: &[SectionEntry],
    tables: &[Vec<PageEntry>],
) -> Result<Vec<Species>, FormatError> {
    let entry_place =
        |i: usize| Place::contents(HEADER_BYTES + i as u64 * SECTION_ENTRY_BYTES, Some(sections[i].key));
    let mut species: Vec<Species> = Vec::new();
    for (i, section) in sections.iter().enumerate() {
        let SectionKey { kind, species: owner, item } = section.key;
        if !kinds.contains(&kind) {
            // Kinds that are not known come last.
            if owner != NO_SPECIES && owner as usize >= species.len() {
                let (found, expected) =
                    (owner.to_string(), "a species of the file, or 4294967295".to_owned());
                return Err(FormatError::SectionField {
                    place: entry_place(i),
                    what: "species",
                    found,
                    expected,
                });
            }
            continue;
        }
        if kind == KIND_METADATA {
            if owner as usize != species.len() {
                let (place, missing) = (entry_place(i), "metadata".to_owned());
                return Err(FormatError::SectionMissing { place, species: species.len() as u32, missing });
            }
            let place = Place::section(tables[i][0].offset, section.key);
            let bytes = read_section(source, section, &tables[i])?;
            let meta = metadata::from_bytes(&bytes, place)?;
            if let Some(other) = species.iter().position(|other| other.meta.name == meta.name) {
                let (name, other) = (meta.name, other as u32);
                return Err(FormatError::SpeciesName { place, name, other });
            }
            let bytes = stored_bytes(&tables[i]);
            species.push(Species {
                meta,
                bases: Vec::new(),
                medium: [usize::MAX; 4],
                extinction: None,
                blocks: None,
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
        if matches!(kind, KIND_BASE | KIND_AVERAGES | KIND_DETAIL) {
            agree.push(("bands", section.bands, owner_entry.meta.band_count() as u32));
        }
        for (what, found, expected) in agree {
            if found != expected {
                let (found, expected) = (found.to_string(), format!("{expected}, as in the metadata"));
                let place = entry_place(i);
                return Err(FormatError::SectionField { place, what, found, expected });
            }
        }
        let bytes = stored_bytes(&tables[i]);
        owner_entry.bytes += bytes;
        match kind {
            KIND_MEDIUM if item >= MEDIUM_EXTINCTION => {
                let extinction = owner_entry.extinction.get_or_insert([usize::MAX; 2]);
                extinction[(item - MEDIUM_EXTINCTION) as usize] = i;
            }
            KIND_MEDIUM => owner_entry.medium[item as usize] = i,
            KIND_BASE | KIND_AVERAGES => add_base(owner_entry, section, i, bytes, entry_place(i))?,
            KIND_DETAIL => add_detail(owner_entry, (i, bytes), sections, entry_place(i))?,
            _ => add_blocks(owner_entry, section, i, entry_place(i))?,
        }
    }
    check_complete(&species)?;
    Ok(species)
}

/// A base of kind 3, or the averages of one, whose codec and detail come later.
fn add_base(
    owner: &mut Species,
    section: &SectionEntry,
    index: usize,
    bytes: u64,
    place: Place,
) -> Result<(), FormatError> {
    let SectionKey { kind, species, item } = section.key;
    let left_out = owner.meta.left_out.as_ref();
    if let Some(left_out) = left_out.filter(|left_out| left_out.bases.contains(item as u8)) {
        return Err(FormatError::LeftOutPresent { place, base: item as u8, reason: left_out.reason.clone() });
    }
    let codec = match (kind, owner.blocks) {
        (KIND_BASE, _) => Codec::from_number(section.codec).expect("check_section knows a base's codecs"),
        (_, Some(BlockSections { classes: Some(_), .. })) => Codec::Classed,
        (_, Some(_)) => Codec::Haar,
        (_, None) => {
            return Err(FormatError::SectionMissing { place, species, missing: "block map".to_owned() });
        }
    };
    owner.bases.push(BaseEntry {
        base: item as u8,
        codec,
        threshold: section.threshold,
        bytes,
        raw_bytes: section.raw_bytes,
        section: index,
        detail: None,
    });
    Ok(())
}

/// The block map of a species without bases of kind 3, then its class tables.
fn add_blocks(
    owner: &mut Species,
    section: &SectionEntry,
    index: usize,
    place: Place,
) -> Result<(), FormatError> {
    let SectionKey { kind, species, item } = section.key;
    if !owner.bases.is_empty() {
        let (found, expected) = (kind.to_string(), "3, as of the species' bases".to_owned());
        return Err(FormatError::SectionField { place, what: "kind", found, expected });
    }
    match (&mut owner.blocks, item) {
        (blocks, BLOCKS_MAP) => *blocks = Some(BlockSections { map: index, classes: None }),
        (Some(blocks), _) => blocks.classes = Some(index),
        (None, _) => {
            return Err(FormatError::SectionMissing { place, species, missing: "block map".to_owned() });
        }
    }
    Ok(())
}

/// The detail of a base whose averages are there, coded as the class tables say, for as many blocks as every other
/// base's.
fn add_detail(
    owner: &mut Species,
    (index, bytes): (usize, u64),
    sections: &[SectionEntry],
    place: Place,
) -> Result<(), FormatError> {
    let section = &sections[index];
    let SectionKey { species, item, .. } = section.key;
    let first = owner.bases.iter().find_map(|base| base.detail);
    let Some(base) = owner.bases.iter_mut().find(|b| u32::from(b.base) == item && b.codec.is_near_geometry())
    else {
        let missing = format!("averages of base {item}");
        return Err(FormatError::SectionMissing { place, species, missing });
    };
    let field = |holds: bool, what, found: u64, expected: u64, why: &str| {
        let (found, expected) = (found.to_string(), format!("{expected}, as {why}"));
        if holds { Ok(()) } else { Err(FormatError::SectionField { place, what, found, expected }) }
    };
    let (found, expected) = (section.codec, base.codec.number());
    field(found == expected, "codec", found.into(), expected.into(), "the species' class tables say")?;
    let blocks = first.map_or(section.units, |first| sections[first].units);
    field(section.units == blocks, "number of units", section.units, blocks, "in the species' first base")?;
    base.detail = Some(index);
    base.bytes += bytes;
    base.raw_bytes += section.raw_bytes;
    Ok(())
}

/// Not every model has an extinction; how many bases there can be is up to the model and its suns.
fn check_item(section: &SectionEntry, model: &Model, place: Place) -> Result<(), FormatError> {
    let SectionKey { kind, item, .. } = section.key;
    let items = match kind {
        KIND_MEDIUM if model.has_extinction() => MEDIUM_ITEMS.len() as u32,
        KIND_MEDIUM => MEDIUM_EXTINCTION,
        KIND_BLOCKS => return Ok(()),
        _ => model.items().into(),
    };
    if item < items {
        return Ok(());
    }
    let expected = format!("0 to {}, as the metadata say", items - 1);
    Err(FormatError::SectionField { place, what: "item", found: item.to_string(), expected })
}

/// Bytes that a section's pages store, whether they share them or not.
pub(in super::super) fn stored_bytes(table: &[PageEntry]) -> u64 {
    table.iter().map(|page| u64::from(page.stored_bytes)).sum()
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
        let extinction = match model.has_extinction() {
            true => entry.extinction.unwrap_or([usize::MAX; 2]),
            false => [0; 2],
        };
        let mut medium = entry.medium.iter().chain(&extinction);
        if let Some(item) = medium.position(|section| *section == usize::MAX) {
            return missing(i, MEDIUM_ITEMS[item]);
        }
        if entry.bases.is_empty() {
            return missing(i, "base");
        }
        if let Some(base) = entry.bases.iter().find(|b| b.codec.is_near_geometry() && b.detail.is_none()) {
            return missing(i, &format!("detail of base {}", base.base));
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
pub(crate) fn read_section(
    source: &dyn Source,
    section: &SectionEntry,
    table: &[PageEntry],
) -> Result<Vec<u8>, FormatError> {
    let place = Place::section(section.data_offset, section.key);
    let all = table.iter().map(|page| page.raw_bytes as usize).sum();
    let mut bytes = room::empty(place, "a section", all)?;
    for (i, entry) in table.iter().enumerate() {
        bytes.extend(page::read(source, section.key, i as u32, entry)?);
    }
    Ok(bytes)
}
