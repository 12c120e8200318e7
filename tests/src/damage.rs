//! Container files, damaged in one place, with every digest made to fit: what a fuzzer needs to get past the digests.

use flb_format::Container;
use flb_format::records::{HEADER_BYTES, PAGE_ENTRY_BYTES, SECTION_ENTRY_BYTES, STORED_PLAIN};
use flb_inspector::torture::draft::{Digests, Draft, Image, PageDraft, page};

/// Changes bytes at random: libFuzzer's own mutation, in the fuzz targets. The length may change.
pub type Change<'a> = dyn FnMut(&mut Vec<u8>) + 'a;

/// A damaged copy of a file; `None` if the file does not even open, or a page cannot be read of one that is to be
/// taken apart. `seed` decides where: mostly in the bytes of a page, which move what follows if their length changes,
/// else in header or tables.
pub fn damage(file: &[u8], seed: u32, change: &mut Change) -> Option<Vec<u8>> {
    let source = file.to_vec();
    let container = Container::open(&source).ok()?;
    let mut pick = Pick(seed);
    let section = pick.below(container.sections().len());
    let page = pick.below(container.pages(section).len());
    let what = pick.below(16);
    if what < 3 {
        let mut image = Image::of(&container, source);
        let (at, bytes) = match what {
            0 => (0, HEADER_BYTES),
            1 => (image.section(section), SECTION_ENTRY_BYTES),
            _ => (image.page(section, page), PAGE_ENTRY_BYTES),
        };
        change_record(&mut image, at, bytes as usize, change);
        return Some(image.bytes);
    }
    let mut draft = Draft::of(&container, &source).ok()?;
    match what {
        3 => drop(draft.sections.remove(section)),
        4 if draft.sections[section].pages.len() > 1 => drop(draft.sections[section].pages.remove(page)),
        5 => {
            let other = pick.below(draft.sections.len());
            if let Ok([a, b]) = draft.sections.get_disjoint_mut([section, other]) {
                std::mem::swap(&mut a.pages, &mut b.pages);
            }
        }
        _ => change_page(&mut draft.sections[section].pages[page], change),
    }
    Some(draft.build().bytes)
}

/// Changes a record in place, which keeps its length.
fn change_record(image: &mut Image, at: usize, length: usize, change: &mut Change) {
    let mut record = image.bytes[at..][..length].to_vec();
    change(&mut record);
    record.resize(length, 0);
    image.put(at, &record);
    image.seal(Digests::Pages);
}

/// Changes a page's stored bytes, and what tables say of their length.
fn change_page(page: &mut PageDraft, change: &mut Change) {
    change(&mut page.stored);
    let raw_bytes = page.u32(page::RAW_BYTES);
    if page.u32(page::COMPRESSION) == STORED_PLAIN {
        let stored_bytes = page.stored.len() as u32;
        // Where a unit is a byte, as in metadata.
        if page.u32(page::COUNT) == raw_bytes {
            page.set_u32(page::COUNT, stored_bytes);
        }
        page.set_u32(page::RAW_BYTES, stored_bytes);
    }
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
