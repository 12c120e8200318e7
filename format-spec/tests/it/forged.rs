//! Every numbered promise, broken on purpose behind sound digests: the right code, place and words.

use std::collections::BTreeSet;
use std::io;

use flb_format::container::records::*;
use flb_format::error::{CODES, ErrorClass};
use flb_format::testing::forgeries::Forgery;
use flb_format::testing::{Digests, Parts, check, golden};
use flb_format::{Container, FormatError, Source};

use crate::said::bad_files;

const RAW: &str = "raw-f32";

/// What [`check`] looks at, by putting every medium and every field together.
fn read_all(bytes: &dyn Source) -> Result<(), FormatError> {
    let container = Container::open(bytes)?;
    for (i, species) in container.species().iter().enumerate() {
        container.read_medium(bytes, i)?;
        species.extinction.map(|_| container.read_turbid(bytes, i)).transpose()?;
        species.blocks.map(|_| container.read_shared(bytes, i)).transpose()?;
        species.bases.iter().try_for_each(|base| container.read_field(bytes, i, base.base).map(drop))?;
    }
    Ok(())
}

#[test]
fn every_broken_promise_gets_its_code_place_and_words() {
    let mut seen = BTreeSet::from([1000, 6001, 6002, 6003, 6004, 6005, 6006, 6007]); // in the tests below and of `room`
    let mut wrong = Vec::new();
    for (i, Forgery { code, words, bytes }) in bad_files().into_iter().enumerate() {
        let Err(error) = check(&bytes) else {
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
        // Padding, root and what a renderer may leave aside are looked at by the full check alone.
        if ![4004, 4005, 5015].contains(&code) {
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
    let spec = include_str!("../../SPEC.md");
    let listed: Vec<u32> =
        spec.lines().filter_map(|line| line.strip_prefix("| FLB-")?.get(..4)?.parse().ok()).collect();
    let codes: Vec<u32> = CODES.iter().copied().filter(|code| *code < 6000).collect();
    assert_eq!(listed, codes);
}

#[test]
fn unknown_optional_sections_features_and_minor_versions_pass() {
    let mut parts = Parts::of(&golden(RAW));
    let last = parts.sections.last_mut().expect("a file has sections");
    (last.key.kind, last.key.species, last.flags) = (77, NO_SPECIES, 0);
    (last.codec, last.lattice, last.bands, last.threshold) = (1234, 7, 99, f32::NAN);
    parts.header.optional_features = u64::MAX;
    parts.header.version = (1, 9);
    let file = parts.seal(Digests::Pages);
    check(&file).expect("what is optional may be unknown");
    let container = Container::open(&file).expect("it opens");
    assert_eq!(container.species()[0].bases.len(), 1);
    assert_eq!(container.format_version(), (1, 9));
}

#[test]
fn requests_that_a_file_cannot_answer_are_refused() {
    let file = golden(RAW);
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
    let file = golden("left-out");
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
    let bytes = golden(RAW);
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
