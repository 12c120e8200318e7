//! Headers, tables and pages that break a promise.

use flb_format::records::*;

use super::content::{Case, relayout};
use super::{Parts, forge, golden_file, replace_last_page};

const RAW: &str = "raw-f32";
const F16: &str = "raw-f16";
const HAAR: &str = "haar-paper";
const ZSTD: &str = "haar-paper-zstd";

/// All of them.
pub(crate) fn layout_cases() -> Vec<Case> {
    [header_cases(), section_cases(), table_cases(), page_cases()].into_iter().flatten().collect()
}

fn header_cases() -> Vec<Case> {
    let header = |edit: fn(&mut Header)| forge(RAW, |parts| edit(&mut parts.header));
    let patched = |at: usize, value: u8| {
        let mut bytes = golden_file(RAW);
        bytes[at] = value;
        bytes
    };
    vec![
        (1001, "file at byte 0: the file has 0 bytes, expected at least 128", Vec::new()),
        (1001, "the file has 127 bytes", golden_file(RAW)[..127].to_vec()),
        (1002, "header at byte 0: magic [88, 46, 4c", patched(0, 0x88)),
        (
            1003,
            "header at byte 8: format version 2.0, this reader knows major versions 0 and 1",
            patched(8, 2),
        ),
        (1003, "format version 9.0", header(|h| h.version = (9, 0))),
        (1004, "required feature bit 4 is not", header(|h| h.required_features |= 16)),
        (1004, "required feature bit 63", header(|h| h.required_features |= 1 << 63)),
        (1004, "required feature bit 3", {
            forge("v0.1/raw-f32", |parts| parts.header.required_features |= FEATURE_BLOCKS)
        }),
        (1005, "header at byte 120: header digest ", patched(120, 0)),
        (1005, "header digest ", patched(40, 0)),
        (1006, "header of 256 bytes, expected 128", header(|h| h.header_bytes = 256)),
        (1007, "header at byte 60: reserved field holds 0x1", header(|h| h.reserved_60 = 1)),
        (1007, "header at byte 112: reserved field", header(|h| h.reserved_112 = u64::MAX)),
        (1008, "header promises 5", header(|h| h.file_bytes = 5)),
        (1008, "its header promises 18446744073709551615", header(|h| h.file_bytes = u64::MAX)),
        (1009, "number of sections is 4294967295, over the limit", header(|h| h.section_count = u32::MAX)),
        (1009, "number of pages is", header(|h| h.tables_end = u64::MAX)),
        (1010, "feature bit 0 (zstd) is true, but the page tables say false", {
            header(|h| h.required_features = 1)
        }),
        (1010, "is false, but", forge(ZSTD, |parts| parts.header.required_features = 0)),
        (2001, "offset of the table of contents is 64, expected 128", header(|h| h.contents_offset = 64)),
        (2001, "offset of the table of contents", header(|h| h.contents_offset = u64::MAX - 3)),
        (2001, "number of sections is 0, expected 1", header(|h| h.section_count = 0)),
        (2001, "size of the table of contents", header(|h| h.contents_bytes += 1)),
        (2001, "size of the table of contents", header(|h| h.contents_bytes = u64::MAX)),
        (2001, "end of the page tables is 0", header(|h| h.tables_end = 0)),
        (2001, "end of the page tables is", header(|h| h.tables_end = h.file_bytes + 1)),
        (2001, "end of the page tables is", header(|h| h.tables_end += 16)),
        (2009, "data at byte", header(|h| h.tables_end -= 48)),
        (2009, "expected", header(|h| h.tables_end += 64)),
        (2002, "table of contents at byte 128: digest ", {
            let mut parts = Parts::of(&golden_file(RAW));
            parts.header.contents_digest = 0;
            let header = parts.header.to_bytes();
            parts.bytes[..128].copy_from_slice(&header);
            parts.bytes
        }),
    ]
}

fn section_cases() -> Vec<Case> {
    let base = |edit: fn(&mut SectionEntry)| {
        forge(HAAR, |parts| {
            let base = parts.base();
            edit(&mut parts.sections[base]);
        })
    };
    let first = |edit: fn(&mut SectionEntry)| forge(RAW, |parts| edit(&mut parts.sections[0]));
    let kind = |kind: u32, flags: u32| {
        forge(RAW, |parts| {
            let last = parts.sections.last_mut().expect("a file has sections");
            (last.key.kind, last.flags) = (kind, flags);
        })
    };
    vec![
        (1007, "base 0 of species 0", base(|s| s.reserved = 8)),
        (2003, "base 1 of species 0 at byte 704: it follows base 2 of species 0, expected ascending", {
            forge(RAW, |parts| parts.sections[5].key.item = 2)
        }),
        (2004, "base 1 of species 0 at byte 704: the section is listed twice", {
            forge(RAW, |parts| parts.sections[5].key.item = 1)
        }),
        (2007, "kind is 0, expected at least 1", first(|s| (s.key.kind, s.flags) = (0, 0))),
        (2005, "required section kind 77 is not known", kind(77, 1)),
        (2007, "species is 1, expected a species of the file, or 4294967295", {
            forge(RAW, |parts| {
                let last = parts.sections.last_mut().expect("a file has sections");
                (last.key.kind, last.key.species, last.flags) = (77, 1, 0);
            })
        }),
        (1008, "the file has", {
            forge(RAW, |parts| parts.sections.last_mut().expect("a file has sections").data_bytes -= 1)
        }),
        (2005, "required section kind 6 is not known", {
            forge("v0.1/raw-f32", |parts| parts.sections.last_mut().expect("a section").key.kind = 6)
        }),
        (2006, "codec 3 is not known", base(|s| s.codec = 3)),
        (2006, "codec 99 is not known", first(|s| s.codec = 99)),
        (2006, "codec 2", forge(RAW, |parts| parts.sections[1].codec = 2)),
        (2006, "codec 6", forge(RAW, |parts| parts.sections[1].codec = 6)),
        (2006, "codec 7", base(|s| s.codec = 7)),
        (2007, "threshold is 1, expected 0", {
            forge(F16, |parts| {
                let base = parts.base();
                parts.sections[base].threshold = 1.0;
            })
        }),
        (2007, "flags is 4, expected bits 0 and 1 only", kind(77, 4)),
        (2007, "flags is 3, expected 1", base(|s| s.flags = 3)),
        (2007, "flags is 0, expected 1", base(|s| s.flags = 0)),
        (2007, "page size is 0", base(|s| s.page_bytes = 0)),
        (2007, "page size is 4294967295", base(|s| s.page_bytes = u32::MAX)),
        (2007, "page size is 16385", base(|s| s.page_bytes = 16385)),
        (2007, "number of pages is 0", base(|s| s.page_count = 0)),
        (2007, "number of units is 0", base(|s| s.units = 0)),
        (2007, "number of units is 126, expected 125", base(|s| s.units = 126)),
        (2007, "item is 1", first(|s| s.key.item = 1)),
        (2007, "threshold is -0, expected", base(|s| s.threshold = -0.0)),
        (2007, "threshold is NaN", base(|s| s.threshold = f32::NAN)),
        (2007, "threshold is inf", base(|s| s.threshold = f32::INFINITY)),
        (2007, "threshold is 1, expected 0", first(|s| s.threshold = 1.0)),
        (2007, "lattice is 16, expected 0", first(|s| s.lattice = 16)),
        (2007, "bands is 1, expected 0", first(|s| s.bands = 1)),
        (2007, "lattice is 0, expected a power of two", base(|s| s.lattice = 0)),
        (2007, "lattice is 24", base(|s| s.lattice = 24)),
        (2007, "lattice is 2147483648", base(|s| s.lattice = 1 << 31)),
        (2007, "bands is 65, expected 1 to 64", base(|s| s.bands = 65)),
        (2007, "bands is 2, expected 3, as in the metadata", base(|s| s.bands = 2)),
        (2007, "size of data is 18446744073709551615", base(|s| s.data_bytes = u64::MAX)),
        (1009, "size of metadata is 1048577, over", first(|s| s.units = 1_048_577)),
        (2008, "species 0 has no metadata", forge(RAW, |parts| parts.sections[0].key.species = 1)),
        (
            2008,
            "species 0 has no wood_area_density",
            forge(RAW, |parts| {
                // Of a kind that sorts behind all others, and may be skipped.
                let section = parts.sections.remove(4);
                let table = parts.tables.remove(4);
                drop((section, table));
                relayout(parts);
            }),
        ),
        (
            2008,
            "species 0 has no base",
            forge(RAW, |parts| {
                for section in &mut parts.sections[5..] {
                    (section.key.kind, section.flags) = (9, 0);
                }
            }),
        ),
        (2008, "species 7 has no metadata", forge(RAW, |parts| parts.sections[6].key.species = 7)),
        (2009, "data at byte", base(|s| s.data_offset += 64)),
        (2009, "expected 0 (no hole", base(|s| s.data_bytes = 0)),
        (2009, "data at byte", base(|s| s.data_offset -= 64)),
        (2009, "data at byte", base(|s| s.data_offset += 1)),
        (2009, "data at byte 18446744073709551615", base(|s| s.data_offset = u64::MAX)),
        (3001, "the page table lies at byte 0", base(|s| s.table_offset = 0)),
        (3001, "the page table lies at byte", base(|s| s.page_count = u32::MAX)),
        (3006, "size of data is", base(|s| s.data_bytes -= 1)),
        (
            3006,
            "size of payloads is 18446744073709551615, but its pages give",
            base(|s| s.raw_bytes = u64::MAX),
        ),
        (3002, "page table of metadata of species 0", {
            let mut parts = Parts::of(&golden_file(RAW));
            parts.sections[0].table_digest = 0;
            let record = parts.sections[0].to_bytes();
            parts.bytes[128..224].copy_from_slice(&record);
            let contents = parts.bytes[128..128 + parts.header.contents_bytes as usize].to_vec();
            parts.header.contents_digest = flb_format::container::digest::plain(&contents);
            let header = parts.header.to_bytes();
            parts.bytes[..128].copy_from_slice(&header);
            parts.bytes
        }),
    ]
}

fn table_cases() -> Vec<Case> {
    let page = |name, edit: fn(&mut PageEntry)| {
        forge(name, |parts| {
            let base = parts.base();
            edit(&mut parts.tables[base][0]);
        })
    };
    // Page 1 has the bytes of page 0: no fault of its place but in the draft.
    let twice = |name| {
        forge(name, |parts| {
            let base = parts.base();
            parts.tables[base][1] = parts.tables[base][0];
        })
    };
    vec![
        (1007, "page table entry 0 of base 0 of species 0", page(RAW, |p| p.reserved = 1)),
        (1007, "reserved field holds 0x3f800000", page("v0.1/raw-f32", |p| p.priority = 1.0)),
        (3003, "the page lies at byte", page(RAW, |p| p.offset += 16)),
        (3003, "the page lies at byte 0", page(RAW, |p| p.offset = 0)),
        (3003, "page table entry 0 of base 0", {
            // The bytes of a later page, which a reader from the front does not have.
            forge(RAW, |parts| {
                let base = parts.base();
                parts.tables[base][0].offset = parts.tables[base][1].offset;
            })
        }),
        (3003, "or where an earlier page of its size lies", {
            forge(RAW, |parts| {
                let base = parts.base();
                parts.tables[base][1].offset = parts.tables[1][0].offset;
            })
        }),
        (3003, "the page lies at byte 18446744073709551615", page(RAW, |p| p.offset = u64::MAX)),
        (3003, "page table entry 1", twice("v0.1/raw-f32")),
        (3005, "first unit is 0, expected 5120", twice(RAW)),
        (3004, "payload size is 0, expected 1 to 20480", page(RAW, |p| p.raw_bytes = 0)),
        (3004, "payload size is 4294967295", page(RAW, |p| p.raw_bytes = u32::MAX)),
        (3004, "stored size is 100, expected 20480", page(RAW, |p| p.stored_bytes = 100)),
        (3004, "stored size is 4294967295", page(ZSTD, |p| p.stored_bytes = u32::MAX)),
        (3004, "stored size is 0, expected 1 to", page(ZSTD, |p| p.stored_bytes = 0)),
        (3005, "number of units is 5121, expected a unit per 4 bytes", page(RAW, |p| p.count += 1)),
        (3005, "number of units is 10241, expected a unit per 2 bytes", page(F16, |p| p.count += 1)),
        (3005, "number of units is 10240, expected a unit per 4 bytes", {
            // The codec of another file's base: the sizes give it away.
            forge(F16, |parts| {
                for section in parts.sections.iter_mut().filter(|s| s.codec == CODEC_RAW_F16) {
                    section.codec = CODEC_RAW_F32;
                }
                parts.header.required_features = FEATURE_PHYSICAL;
            })
        }),
        (3005, "number of units is 0, expected at least 1", page(RAW, |p| p.count = 0)),
        (3005, "first unit is 1, expected 0", page(RAW, |p| p.first = 1)),
        (3005, "at most a unit per 12 bytes", page(HAAR, |p| p.count = u32::MAX)),
        (3005, "a unit per 12 bytes and 256 a band", page(HAAR, |p| p.count = 1)),
        (3005, "a unit for each value", forge(RAW, |parts| parts.tables[1][0].count = 64)),
        (3003, "page table entry 1", {
            // Its bytes are those of page 0, but compressed.
            forge(RAW, |parts| {
                let base = parts.base();
                let first = parts.tables[base][0];
                let second = &mut parts.tables[base][1];
                (second.offset, second.raw_bytes, second.compression) = (first.offset, 20_480, STORED_ZSTD);
            })
        }),
        (3005, "a multiple of 64", forge(RAW, |parts| parts.tables[1][0].count += 1)),
        (3005, "8 units per byte", forge(RAW, |parts| parts.tables[1][0].count = 1 << 30)),
        (3005, "a unit per byte", forge(RAW, |parts| parts.tables[0][0].count -= 1)),
        (
            3006,
            "number of units is 125, but its pages give 124",
            forge("haar-paper-exact", |parts| {
                let base = parts.base();
                parts.tables[base].last_mut().expect("a page").count -= 1;
            }),
        ),
        (3007, "page compression 2 is not known", page(RAW, |p| p.compression = 2)),
        (3008, "priority is NaN, expected a number from +0 to 2^96", page(RAW, |p| p.priority = f32::NAN)),
        (
            3008,
            "priority is 158456330000000000000000000000,",
            page(RAW, |p| p.priority = 2.0 * MAX_MAGNITUDE),
        ),
        (3008, "priority is inf", page(RAW, |p| p.priority = f32::INFINITY)),
        (3008, "priority is -0", page(RAW, |p| p.priority = -0.0)),
        (3008, "priority is -1", page(RAW, |p| p.priority = -1.0)),
    ]
}

/// Small files that ask for much work.
pub(crate) fn work_cases() -> Vec<Case> {
    // A section of unknown kind whose pages are one page, again and again.
    let often = |raw_bytes: u32, count: u32| {
        forge(RAW, |parts| {
            let section = parts.sections.len() - 1;
            let entry = &mut parts.sections[section];
            (entry.key.kind, entry.flags, entry.page_bytes) = (77, 0, MAX_PAGE_BYTES);
            let mut page = parts.tables[section][0];
            (page.raw_bytes, page.compression, page.count) = (raw_bytes, STORED_ZSTD, 1);
            parts.repair_pages = false; // that would take as long as reading all of them
            parts.tables[section] = vec![page];
            relayout(parts);
            let (first, table) = (parts.tables[section][0], &mut parts.tables[section]);
            table.extend((1..count).map(|i| PageEntry { first: i.into(), ..first }));
            // The tables grow behind what is laid out; the data of every section move with them.
            let more = u64::from(count - 1) * PAGE_ENTRY_BYTES;
            let at = parts.header.tables_end as usize;
            let old_end = at.next_multiple_of(SECTION_ALIGN as usize);
            let end = (at + more as usize).next_multiple_of(SECTION_ALIGN as usize);
            let by = (end - old_end) as u64;
            parts.bytes.splice(at..at, std::iter::repeat_n(0, by as usize));
            parts.header.tables_end += more;
            parts.header.file_bytes += by;
            for (section, table) in parts.sections.iter_mut().zip(&mut parts.tables) {
                section.data_offset += by;
                table.iter_mut().for_each(|page| page.offset += by);
            }
            let entry = &mut parts.sections[section];
            (entry.page_count, entry.units) = (count, count.into());
            entry.raw_bytes = u64::from(count) * u64::from(raw_bytes);
        })
    };
    let metadata = forge(RAW, |parts| {
        let (entry, table) = (parts.sections[0], parts.tables[0].clone());
        for species in 1..9 {
            let mut entry = entry;
            entry.key.species = species;
            parts.sections.insert(species as usize, entry);
            parts.tables.insert(species as usize, table.clone());
        }
        for (section, table) in parts.sections.iter_mut().zip(&mut parts.tables).take(9) {
            section.page_bytes = 1 << 20;
            (section.raw_bytes, section.units) = (1 << 20, 1 << 20);
            let page = &mut table[0];
            (page.raw_bytes, page.count, page.compression) = (1 << 20, 1 << 20, STORED_ZSTD);
        }
        relayout(parts);
    });
    vec![
        (1009, "size of all metadata is 9437184, over the limit of 8388608", metadata),
        (1009, "over the limit of 1099511627776", often(MAX_PAGE_BYTES, (1 << 18) + 1)),
    ]
}

fn page_cases() -> Vec<Case> {
    let frame = |payload: &[u8]| zstd::bulk::compress(payload, 3).expect("it compresses");
    let zeros = vec![0u8; 12 * 40 + 4000];
    let size = zeros.len() as u32;
    let whole = frame(&zeros);
    let mut skippable = vec![0x50, 0x2A, 0x4D, 0x18, 4, 0, 0, 0, 1, 2, 3, 4];
    skippable.extend(&whole);
    let streamed = zstd::stream::encode_all(zeros.as_slice(), 3).expect("it compresses"); // no size
    // Magic, descriptor, window or size fields by hand.
    let header = |rest: &[u8]| [&[0x28, 0xB5, 0x2F, 0xFD], rest, &[0; 8]].concat();
    let huge = header(&[0b1110_0000, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F]);
    let window = header(&[0b1000_0000, 0xFF, size as u8, (size >> 8) as u8, 0, 0]);
    let mut cut = whole.clone();
    cut.pop();
    let last = |stored: &[u8]| replace_last_page(ZSTD, size, 1, stored);
    vec![
        (
            4001,
            "page 0 of base 0 of species 0 at byte",
            forge(RAW, |parts| {
                let base = parts.base();
                parts.tables[base][0].digest = 0;
                parts.repair_pages = false;
            }),
        ),
        (4002, "expected a zstd frame", last(&skippable)),
        (4002, "it ends after", last(&[whole.as_slice(), &whole].concat())),
        (4002, "it ends after", last(&[whole.as_slice(), &[0]].concat())),
        (4002, "declares no content size", last(&streamed)),
        (4002, "declares 9223372036854775807 bytes, the page table", last(&huge)),
        (4002, "a window of", last(&window)),
        (4002, "wants a dictionary", last(&header(&[0b0010_0001, 0, 0]))),
        (4002, "reserved bit", last(&header(&[0b0010_1000, 0, 0]))),
        (4002, "zstd frame refused", last(&cut)),
        (4002, "declares 4480 bytes, the page table 4481", replace_last_page(ZSTD, size + 1, 1, &whole)),
        (4003, "page 0 of base 18 of species 1 at byte", {
            let mut parts = Parts::of(&golden_file(HAAR));
            let last = parts.sections.len() - 1;
            let stored = parts.stored(last, 0).to_vec();
            let short = &stored[..stored.len() - 4];
            replace_last_page(HAAR, short.len() as u32, STORED_PLAIN, short)
        }),
        (4004, "padding at byte", {
            let mut parts = Parts::of(&golden_file(RAW));
            let at = parts.header.tables_end as usize;
            parts.bytes[at] = 1;
            parts.join()
        }),
        (4005, "header at byte 80: BLAKE3 root", {
            let mut parts = Parts::of(&golden_file(RAW));
            parts.header.root[31] ^= 1;
            let header = parts.header.to_bytes();
            parts.bytes[..128].copy_from_slice(&header);
            parts.bytes
        }),
    ]
}
