//! Every numbered promise, broken on purpose behind sound digests: the right code, place and words.

mod forge;

use std::collections::BTreeSet;
use std::io;

use flb_format::error::CODES;
use flb_format::records::*;
use flb_format::{Container, ErrorClass, Source};
use forge::bits::bit_cases;
use forge::content::{Case, content_cases, relayout};
use forge::near::near_cases;
use forge::physical::physical_cases;
use forge::{Parts, forge, golden_file, read_all, replace_last_page, verdict};

const RAW: &str = "raw-f32";
const F16: &str = "raw-f16";
const HAAR: &str = "haar-paper";
const ZSTD: &str = "haar-paper-zstd";

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
        (2005, "required section kind 77 is not known", kind(77, 1)),
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
        (3008, "priority is inf", page(RAW, |p| p.priority = f32::INFINITY)),
        (3008, "priority is -0", page(RAW, |p| p.priority = -0.0)),
        (3008, "priority is -1", page(RAW, |p| p.priority = -1.0)),
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

#[test]
fn every_broken_promise_gets_its_code_place_and_words() {
    let mut seen = BTreeSet::from([1000, 6001, 6002, 6003, 6004, 6005, 6006]); // in the tests below
    let mut wrong = Vec::new();
    let cases = [
        header_cases(),
        section_cases(),
        table_cases(),
        page_cases(),
        content_cases(),
        physical_cases(),
        near_cases(),
        bit_cases(),
    ];
    for (i, (code, words, bytes)) in cases.into_iter().flatten().enumerate() {
        let Err(error) = verdict(&bytes) else {
            wrong.push(format!("case {i} ({code}, {words}): accepted"));
            continue;
        };
        let text = error.to_string();
        let place = error.place().expect("a broken promise has a place").to_string();
        let start = format!("FLB-{code} {place}: ");
        if error.code() != code || !text.contains(words) || !text.starts_with(&start) {
            wrong.push(format!("case {i} ({code}, {words}): {text}"));
        }
        let unsupported = [1003, 1004, 2005, 2006, 3007].contains(&code);
        assert_eq!(error.class() == ErrorClass::Unsupported, unsupported, "{text}");
        assert_eq!(error.class() == ErrorClass::Limit, code == 1009, "{text}");
        // Padding and root are looked at by the full check alone.
        if ![4004, 4005].contains(&code) {
            assert_eq!(read_all(&bytes).expect_err("a bad file").to_string(), text, "as fields are read");
        }
        seen.insert(code);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let all: BTreeSet<u32> = CODES.iter().copied().collect();
    assert_eq!(seen, all, "codes without a case, or cases without a code");
}

#[test]
fn spec_lists_every_code_and_no_other() {
    let spec = include_str!("../SPEC.md");
    let listed: Vec<u32> =
        spec.lines().filter_map(|line| line.strip_prefix("| FLB-")?.get(..4)?.parse().ok()).collect();
    let codes: Vec<u32> = CODES.iter().copied().filter(|code| *code < 6000).collect();
    assert_eq!(listed, codes);
}

#[test]
fn unknown_optional_sections_features_and_minor_versions_pass() {
    let file = forge(RAW, |parts| {
        let last = parts.sections.last_mut().expect("a file has sections");
        (last.key.kind, last.flags) = (77, 0);
        (last.codec, last.lattice, last.bands, last.threshold) = (1234, 7, 99, f32::NAN);
        parts.header.optional_features = u64::MAX;
        parts.header.version = (1, 9);
    });
    verdict(&file).expect("what is optional may be unknown");
    let container = Container::open(&file).expect("it opens");
    assert_eq!(container.species()[0].bases.len(), 1);
    assert_eq!(container.format_version(), (1, 9));
}

#[test]
fn requests_that_a_file_cannot_answer_are_refused() {
    let file = golden_file(RAW);
    let container = Container::open(&file).expect("it opens");
    let base = container.find_base(0, 1).expect("the file has base 1").section;
    let texts = [
        container.read_field(&file, 1, 0).expect_err("no such species").to_string(),
        container.read_field(&file, 0, 5).expect_err("no such base").to_string(),
        container.read_page(&file, base, 99).expect_err("no such page").to_string(),
        container.read_block_page(&file, base, 0).expect_err("no blocks").to_string(),
        container.read_turbid(&file, 0).expect_err("no extinction").to_string(),
    ];
    assert!(texts[4].starts_with("FLB-6006 the extinction was asked for, species 0 is of"), "{}", texts[4]);
    assert_eq!(texts[0], "FLB-6001 species 1 was asked for, the file has 1");
    assert_eq!(texts[1], "FLB-6002 base 5 was asked for, species 0 has no such base");
    assert_eq!(texts[2], format!("FLB-6003 page 99 of section {base} was asked for, there is none"));
    assert!(texts[3].starts_with("FLB-6004 page 0 of base 1 of species 0 at byte "), "{}", texts[3]);
    assert!(
        texts[3].ends_with("pages of another codec were asked for, this section's is raw-f32"),
        "{}",
        texts[3]
    );
}

#[test]
fn a_base_that_was_left_out_is_refused_with_the_reason() {
    let file = golden_file("left-out");
    let container = Container::open(&file).expect("it opens");
    let refusal = |base| container.read_field(&file, 0, base).expect_err("it is not there").to_string();
    let reason = "upright plants under the whole sky; band B is not drawn";
    assert_eq!(
        refusal(7),
        format!("FLB-6005 base 7 was asked for, but it was left out of species 0: {reason}")
    );
    assert_eq!(refusal(5), "FLB-6002 base 5 was asked for, species 0 has no such base");
    container.read_field(&file, 0, 9).expect("base 9 is there");
}

/// Says that it is as long as the file, and fails beyond a point: a disk gone bad.
struct Broken(Vec<u8>, u64);

impl Source for Broken {
    fn len_bytes(&self) -> io::Result<u64> {
        self.0.len_bytes()
    }

    fn read_exact_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        if offset_bytes + buffer.len() as u64 > self.1 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.0.read_exact_at(offset_bytes, buffer)
    }
}

#[test]
fn a_file_that_cannot_be_read_is_an_input_error() {
    let bytes = golden_file(RAW);
    let length = bytes.len() as u64;
    for (readable, place) in [(100, "file at byte 0"), (200, "table of contents at byte 128")] {
        let error = Container::open(&Broken(bytes.clone(), readable)).expect_err("it cannot be read");
        assert_eq!((error.code(), error.class()), (1000, ErrorClass::Io));
        assert!(error.to_string().starts_with(&format!("FLB-1000 {place}: cannot read ")), "{error}");
    }
    let broken = Broken(bytes, length - 1);
    let container = Container::open(&broken).expect("header and tables can be read");
    assert_eq!(container.read_field(&broken, 0, 1).expect_err("the last page").code(), 1000);
}
