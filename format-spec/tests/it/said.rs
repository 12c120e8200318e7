//! What this reader says of corruptions that `flb torture` makes of golden files.

use flb_format::testing::forgeries::{Forgery, forgeries};
use flb_format::testing::golden;
use flb_format::testing::torture::Subject;

/// Kind, label, and words of the message.
type Said = (u8, &'static str, &'static str);

/// By the golden file that is corrupted.
const SAID: [(&str, &[Said]); 4] = [
    ("raw-f32", RAW),
    (
        "raw-f16",
        &[
            (44, "base-nan", "value 0 is NaN, expected a number"),
            (44, "base-inf", "value 0 is inf"),
            (44, "base-minus-0", "value 0 is -0, expected"),
        ],
    ),
    (
        "haar-paper",
        &[
            (44, "base-nan", "is NaN"),
            (58, "block-index", "index of block 0 is 1, the masks before it give"),
            (58, "kept-without-need", "coefficient 0 of block 0 is kept, expected a magnitude above 0"),
        ],
    ),
    (
        "classed",
        &[
            (58, "empty-map", "M41: the number of stored blocks is 0"),
            (58, "cut-tables", "M42: "),
            (58, "averages-too-long", "M47: the length"),
            (58, "detail-too-long", "M51: the length"),
        ],
    ),
];

const RAW: &[Said] = &[
    (1, "empty", "file at byte 0: the file has 0 bytes, expected at least 128"),
    (2, "127-bytes", "the file has 127 bytes"),
    (6, "lf-to-crlf", "line ends were converted"),
    (6, "crlf-to-lf", "line ends were converted"),
    (7, "seven-bits", "high bit"),
    (8, "swapped-8", "bytes are swapped"),
    (9, "zip-in-front", "not an .flb file"),
    (9, "pdf-in-front", "not an .flb file"),
    (10, "major-2", "header at byte 8: format version 2.0, this reader knows major versions 0 and 1"),
    (10, "major-65535", "format version 65535.0"),
    (11, "feature-5", "required feature bit 5 is not"),
    (11, "feature-63", "required feature bit 63"),
    (12, "required-section", "required section kind 2147483647 is not known"),
    (13, "header-60", "header at byte 60: reserved field holds 0x1"),
    (13, "header-112", "header at byte 112: reserved field"),
    (13, "section", "leaf_area_density of species 0"),
    (13, "page", "page table entry 0 of leaf_area_density of species 0"),
    (15, "page", "page 0 of leaf_area_density of species 0 at byte"),
    (15, "page-table", "page table of leaf_area_density of species 0"),
    (15, "contents", "table of contents at byte 128: digest 0000000000000000 "),
    (14, "root", "header at byte 80: BLAKE3 root"),
    (15, "header", "header at byte 120: header digest 0000000000000000, expected"),
    (16, "endless", "its header promises 18446744073709551615"),
    (17, "contents", "offset of the table of contents is 64, expected 128"),
    (17, "page-table", "the page table lies at byte 64, expected"),
    (18, "tables-end", "end of the page tables is"),
    (19, "contents", "size of the table of contents"),
    (19, "section", "size of data is 18446744073709551615"),
    (19, "page", "the page lies at byte 18446744073709551600"),
    (20, "sections", "number of sections is 4294967295, over the limit"),
    (20, "tables-end", "number of pages is"),
    (20, "pages", "the page table lies at byte"),
    (21, "no-section", "number of sections is 0, expected 1"),
    (21, "no-page", "number of pages is 0"),
    (21, "no-unit", "number of units is 0"),
    (21, "no-unit-in-a-page", "number of units is 0, expected at least 1"),
    (21, "empty-page", "payload size is 0, expected 1 to 20480"),
    (21, "raw-bytes", "payload size is 4294967295"),
    (
        22,
        "sections",
        "leaf_area_density of species 0 at byte 512: it follows wood_area_density of species 0, expected",
    ),
    (23, "section", "leaf_area_density of species 0 at byte 512: the section is listed twice"),
    (24, "section", "data at byte"),
    (25, "of-another-size", "or where an earlier page of its size lies"),
    (26, "page", "the page lies at byte 128"),
    (27, "data-offset", "data at byte"),
    (27, "raw-bytes", "size of payloads is "),
    (27, "units", "number of units is 4097, expected 4096"),
    (27, "first-unit", "first unit is 1, expected 0"),
    (27, "page-units", "a multiple of 64"),
    (28, "page-bytes", "page size is 20481"),
    (31, "codec-99", "codec 99 is not known"),
    (31, "codec-of-bases", "codec 2 is not known"),
    (31, "compression", "page compression 2 is not known"),
    (32, "claims-2-63", "declares 9223372036854775808 bytes, the page table"),
    (33, "no-size", "declares no content size"),
    (34, "two-frames", "it ends after"),
    (34, "skippable-in-front", "expected a zstd frame"),
    (35, "window-of-2-41", "a window of"),
    (36, "cut", "zstd frame refused"),
    (36, "declares-more", "declares 513 bytes, the page table 512"),
    (36, "reserved-bit", "reserved bit"),
    (37, "dictionary-7", "wants a dictionary"),
    (39, "metadata", "size of all metadata is "),
    (44, "area-nan", "is NaN, expected a number above 0"),
    (44, "area-over-2-96", "is 158456330000000000000000000000"),
    (44, "area-zero", "page 0 of leaf_area_density of species 0"),
    (44, "area-minus-1", "expected a number above 0"),
    (44, "base-nan", "value 0 is NaN, expected a number"),
    (44, "base-inf", "value 0 is inf"),
    (44, "base-minus-0", "value 0 is -0, expected"),
    (44, "base-over-2-96", "value 0 is 158456"),
    (44, "priority-nan", "priority is NaN, expected a number from +0 to 2^96"),
    (44, "priority-minus-1", "priority is -1"),
    (45, "lattice", "lattice is 2147483648"),
    (46, "lattice", "lattice is 0, expected a power of two"),
    (46, "lattice-in-metadata", "grid.lattice is 0, expected a power of two"),
    (47, "page-ahead", "page table entry 0 of "),
    (48, "dots", "name is \"..\""),
    (48, "raw-nul", "metadata is not JSON"),
    (48, "lone-surrogate", "metadata is not JSON"),
    (49, "nested-40", "nested deeper than 32 levels"),
    (49, "nested-524288", "nested deeper"),
    (49, "never-closed", "are not closed"),
    (53, "nothing-yet", "not an .flb file"),
    (58, "fewer-values", "payload of"),
    (58, "class-without-density", "expected class 0 exactly where the density is 0"),
    (58, "class-3", "is 3, expected class 1 (leaf) or 2 (wood)"),
    (58, "density-above-1", "density 2, expected a density of at most 1"),
    (60, "materials-no-array", "species 0: settings.surfaces.materials: "),
    (60, "materials-no-texel", "species 0: settings.surfaces.materials: "),
];

/// These corruptions, and every forgery.
pub(crate) fn bad_files() -> Vec<Forgery> {
    let mut files = forgeries();
    for (name, said) in SAID {
        let before = files.len();
        Subject::new(golden(name), 1).expect("a golden file").corrupt(&mut |case| {
            let found = said.iter().find(|(kind, label, _)| (*kind, *label) == (case.kind, &*case.label));
            if let (Some((.., words)), Some(code)) = (found, case.expected) {
                files.push(Forgery { code, words, bytes: case.bytes });
            }
        });
        assert_eq!(files.len() - before, said.len(), "corruptions of {name}");
    }
    files
}
