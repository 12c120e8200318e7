//! Container files, damaged in one place, with every digest made to fit: what a fuzzer needs to get past the digests.

use super::{Dice, Digests, Parts};
use crate::Container;
use crate::container::records::{
    HEADER_BYTES, Header, MAGIC, PAGE_ENTRY_BYTES, PageEntry, SECTION_ENTRY_BYTES, STORED_PLAIN, SectionEntry,
};

/// Changes bytes at random: libFuzzer's own mutation, in the fuzz targets. The length may change.
pub type Change<'a> = dyn FnMut(&mut Vec<u8>) + 'a;

/// A damaged copy of a file; `None` if the file does not even open. `seed` decides where: mostly in the bytes of a
/// page, which move what follows if their length changes, else in header or tables.
pub fn damage(file: &[u8], seed: u32, change: &mut Change) -> Option<Vec<u8>> {
    let container = Container::open(&file.to_vec()).ok()?;
    let mut dice = Dice(seed.into());
    let section = dice.below(container.sections().len());
    let page = dice.below(container.pages(section).len());
    let mut parts = Parts::of(file);
    match dice.below(16) {
        0 => {
            let record: [u8; HEADER_BYTES as usize] = changed(&parts.header.to_bytes(), change);
            parts.header = Header::from_bytes(&record).0;
            let mut damaged = parts.seal(Digests::Pages);
            damaged[..MAGIC.len()].copy_from_slice(&record[..MAGIC.len()]);
            return Some(damaged);
        }
        1 => {
            let record: [u8; SECTION_ENTRY_BYTES as usize] =
                changed(&parts.sections[section].to_bytes(), change);
            parts.sections[section] = SectionEntry::from_bytes(&record);
            return Some(parts.seal(Digests::Pages));
        }
        2 => {
            let record: [u8; PAGE_ENTRY_BYTES as usize] =
                changed(&parts.tables[section][page].to_bytes(), change);
            parts.tables[section][page] = PageEntry::from_bytes(&record);
            return Some(parts.seal(Digests::Pages));
        }
        3 => parts.remove(section),
        4 if parts.tables[section].len() > 1 => drop(parts.tables[section].remove(page)),
        5 => parts.tables.swap(section, dice.below(container.sections().len())),
        _ => change_page(&mut parts, section, page, change),
    }
    parts.lay_out();
    Some(parts.seal(Digests::Pages))
}

/// A record, changed; its length is kept.
fn changed<const LENGTH: usize>(record: &[u8; LENGTH], change: &mut Change) -> [u8; LENGTH] {
    let mut changed = record.to_vec();
    change(&mut changed);
    changed.resize(LENGTH, 0);
    changed.try_into().expect("it was made to fit")
}

/// Changes a page's stored bytes, and what tables say of their length.
fn change_page(parts: &mut Parts, section: usize, page: usize, change: &mut Change) {
    let mut stored = parts.stored(section, page).to_vec();
    change(&mut stored);
    parts.store(section, page, &stored);
    let entry = &mut parts.tables[section][page];
    if entry.compression == STORED_PLAIN {
        // Where a unit is a byte, as in metadata.
        entry.count = if entry.count == entry.raw_bytes { entry.stored_bytes } else { entry.count };
        entry.raw_bytes = entry.stored_bytes;
    }
}
