//! Container files, damaged in one place, with every digest made to fit: what a fuzzer needs to get past the digests.

use flb_format::Container;
use flb_format::records::{Header, PageEntry, STORED_PLAIN, SectionEntry};

use crate::forge::Parts;
use crate::forge::content::relayout;

/// Changes bytes at random: libFuzzer's own mutation, in the fuzz targets. The length may change.
pub type Change<'a> = dyn FnMut(&mut Vec<u8>) + 'a;

/// A damaged copy of a file; `None` if the file does not even open, and so cannot be taken apart. `seed` decides
/// where: mostly in the bytes of a page, which move what follows if their length changes, else in header or tables.
pub fn damage(file: &[u8], seed: u32, change: &mut Change) -> Option<Vec<u8>> {
    let container = Container::open(&file.to_vec()).ok()?;
    let inside = |page: &PageEntry| page.offset + u64::from(page.stored_bytes) <= file.len() as u64;
    if !(0..container.sections().len()).all(|section| container.pages(section).iter().all(inside)) {
        return None;
    }
    let mut parts = Parts::of(file);
    let mut pick = Pick(seed);
    let section = pick.below(parts.sections.len());
    let page = pick.below(parts.tables[section].len());
    match pick.below(16) {
        0 => {
            let mut record = parts.header.to_bytes().to_vec();
            change(&mut record);
            record.resize(128, 0);
            parts.header = Header::from_bytes(record.as_slice().try_into().expect("a header's length")).0;
        }
        1 => {
            let mut record = parts.sections[section].to_bytes().to_vec();
            let length = record.len();
            change(&mut record);
            record.resize(length, 0);
            parts.sections[section] =
                SectionEntry::from_bytes(record.as_slice().try_into().expect("resized"));
        }
        2 => {
            let mut record = parts.tables[section][page].to_bytes().to_vec();
            let length = record.len();
            change(&mut record);
            record.resize(length, 0);
            parts.tables[section][page] =
                PageEntry::from_bytes(record.as_slice().try_into().expect("resized"));
        }
        3 => {
            drop((parts.sections.remove(section), parts.tables.remove(section)));
            relayout(&mut parts);
        }
        4 if parts.tables[section].len() > 1 => {
            parts.tables[section].remove(page);
            relayout(&mut parts);
        }
        5 => {
            let other = pick.below(parts.sections.len());
            parts.tables.swap(section, other);
            relayout(&mut parts);
        }
        _ => change_page(&mut parts, section, page, change),
    }
    Some(parts.join())
}

/// Changes a page's stored bytes, and what tables say of their length.
fn change_page(parts: &mut Parts, section: usize, page: usize, change: &mut Change) {
    let mut stored = parts.stored(section, page).to_vec();
    let before = stored.len();
    change(&mut stored);
    if stored.len() == before {
        parts.stored(section, page).copy_from_slice(&stored);
        return;
    }
    let entry = &mut parts.tables[section][page];
    let owner = &mut parts.sections[section];
    entry.offset = parts.bytes.len() as u64;
    entry.stored_bytes = stored.len() as u32;
    if entry.compression == STORED_PLAIN {
        owner.raw_bytes = owner.raw_bytes - before as u64 + stored.len() as u64;
        if u64::from(entry.raw_bytes) == owner.units {
            // Metadata: a unit is a byte.
            owner.units = stored.len() as u64;
            entry.count = stored.len() as u32;
        }
        entry.raw_bytes = stored.len() as u32;
    }
    parts.bytes.extend(stored);
    relayout(parts);
}

/// Numbers from a seed: a linear congruential generator (Numerical Recipes' constants).
struct Pick(u32);

impl Pick {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as usize % limit.max(1)
    }
}

#[cfg(test)]
mod tests {
    use flb_inspector::Level;
    use flb_inspector::validate::check;

    use super::*;

    fn golden(name: &str) -> Vec<u8> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../format-spec/golden");
        std::fs::read(format!("{folder}/{name}.flb")).expect("a golden file")
    }

    #[test]
    fn damage_gets_past_every_digest() {
        let mut codes = std::collections::BTreeSet::new();
        for name in ["raw-f32", "haar-paper", "haar-paper-zstd"] {
            let file = golden(name);
            for seed in 0..400 {
                let mut at = seed as usize;
                let mut change = |bytes: &mut Vec<u8>| {
                    at = at * 31 % bytes.len();
                    bytes[at] ^= 1 << (seed % 8);
                    if seed % 3 == 0 {
                        bytes.truncate(bytes.len() - 1);
                    }
                };
                let damaged = damage(&file, seed, &mut change).expect("a golden file opens");
                if let Err(error) = check(&damaged, Level::Decode) {
                    codes.insert(error.code());
                }
            }
        }
        for digest in [1005, 2002, 3002, 4001, 4005] {
            assert!(!codes.contains(&digest), "FLB-{digest} is a digest that was not made to fit: {codes:?}");
        }
        assert!(codes.len() >= 12, "the checks behind the digests are reached: {codes:?}");
    }

    #[test]
    fn what_does_not_open_is_left_alone() {
        assert!(damage(b"", 1, &mut |_| ()).is_none());
        let mut file = golden("raw-f32");
        file[200] ^= 1;
        assert!(damage(&file, 1, &mut |_| ()).is_none());
    }
}
