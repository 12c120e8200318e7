//! Kinds 1 to 9 and 51 to 53: what transfers, editors and interrupted writers make of a file.

use super::{Cases, Dice};
use crate::testing::{Digests, Page};

/// Truncations of header and tables, beside those at their ends.
const CUTS: usize = 12;

pub(super) fn cases(cases: &mut Cases) {
    let file = cases.subject.file.clone();
    let tables_end = cases.subject.container.header().tables_end as usize;
    cases.give(1, "empty", "no byte at all", 1001, Vec::new());
    for length in [1, 7, 8, 9, 64, 127] {
        let (label, done) = (format!("{length}-bytes"), format!("the first {length} bytes"));
        cases.give(2, &label, &done, 1001, file[..length].to_vec());
    }
    let mut dice = Dice(cases.subject.seed);
    let mut cuts: Vec<usize> = (0..CUTS).map(|_| 128 + dice.below(tables_end - 128)).collect();
    cuts.extend([128, tables_end - 1, tables_end]);
    cuts.sort_unstable();
    cuts.dedup();
    for cut in cuts {
        let (label, done) = (format!("cut-at-{cut}"), format!("the first {cut} bytes"));
        cases.give(3, &label, &done, 1008, file[..cut].to_vec());
    }
    truncated_page(cases, &file);
    let behind = |more: &[u8]| [&file, more].concat();
    cases.give(5, "one-byte-more", "a byte of 0 behind the end", 1008, behind(&[0]));
    cases.give(5, "a-page-more", "4096 bytes of 0 behind the end", 1008, behind(&[0; 4096]));
    cases.give(6, "lf-to-crlf", "each LF made CR LF", 1002, replaced(&file, b"\n", b"\r\n"));
    cases.give(6, "crlf-to-lf", "each CR LF made LF", 1002, replaced(&file, b"\r\n", b"\n"));
    let seven_bits = file.iter().map(|b| b & 0x7F).collect();
    cases.give(7, "seven-bits", "the high bit of each byte cleared", 1002, seven_bits);
    for width in [2, 4, 8] {
        let swapped = file.chunks(width).flat_map(|word| word.iter().rev().copied()).collect();
        let done = format!("the bytes of each word of {width} reversed");
        cases.give(8, &format!("swapped-{width}"), &done, 1002, swapped);
    }
    let in_front = |more: &[u8]| [more, &file].concat();
    cases.give(9, "zip-in-front", "a ZIP's local header in front", 1002, in_front(b"PK\x03\x04"));
    cases.give(9, "pdf-in-front", "a PDF's first line in front", 1002, in_front(b"%PDF-1.7\n"));
    let zip_end = [b"PK\x05\x06".as_slice(), &[0; 18]].concat();
    cases.give(9, "zip-behind", "a ZIP's end record behind the end", 1008, behind(&zip_end));
    unfinished(cases, &file, tables_end);
}

fn truncated_page(cases: &mut Cases, file: &[u8]) {
    let tables = &cases.subject.container;
    let last = (0..tables.sections().len()).flat_map(|i| tables.pages(i)).max_by_key(|page| page.offset);
    let last = *last.expect("a file has pages");
    let start = last.offset as usize;
    for (label, cut) in [
        ("last-byte", file.len() - 1),
        ("half-of-the-last-page", start + last.stored_bytes as usize / 2),
        ("the-last-page", start),
    ] {
        let done = format!("cut to {cut} of {} bytes", file.len());
        cases.give(4, label, &done, 1008, file[..cut].to_vec());
    }
}

/// The format has no footer and no flag of being finished: what stands in front is the truth, and the root covers all.
fn unfinished(cases: &mut Cases, file: &[u8], tables_end: usize) {
    let mut parts = cases.subject.parts.clone();
    parts.add_unknown(0, &[Page::plain(b"later", 1)]);
    parts.lay_out();
    let mut rolled_back = parts.seal(Digests::Pages);
    rolled_back[..tables_end].copy_from_slice(&file[..tables_end]);
    let done = "header and tables of the file before a section was added, in front of the later data";
    cases.give(51, "rolled-back-tables", done, 1008, rolled_back);
    cases.give(52, "twice", "the file twice, one behind the other", 1008, [file, file].concat());
    let zeroed = |from: usize, to: usize| {
        let mut bytes = file.to_vec();
        bytes[from..to].fill(0);
        bytes
    };
    let no_data = zeroed(tables_end, file.len());
    cases.give(53, "no-data-yet", "header and tables written, all data 0", 4001, no_data);
    cases.give(53, "no-tables-yet", "the header written, all else 0", 2002, zeroed(128, file.len()));
    cases.give(53, "no-header-yet", "the header 0, all else written", 1002, zeroed(0, 128));
    cases.give(53, "nothing-yet", "all bytes 0", 1002, zeroed(0, file.len()));
}

fn replaced(file: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let (mut out, mut at) = (Vec::with_capacity(file.len()), 0);
    while at < file.len() {
        let found = file[at..].starts_with(from);
        out.extend_from_slice(if found { to } else { &file[at..at + 1] });
        at += if found { from.len() } else { 1 };
    }
    out
}
