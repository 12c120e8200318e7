//! Golden files with one promise broken behind sound digests, each with its code and words of its message. What can be
//! done to any file is in [`super::torture`], and not here again.

mod bits;
mod blocks;
mod content;
mod directions;
mod layout;
mod near;
mod physical;

use super::{Digests, Parts, golden};
use crate::container::records::*;

/// A bad file.
#[derive(Debug, Clone)]
pub struct Forgery {
    /// The code that a reader must give.
    pub code: u32,
    /// Words that the message must hold.
    pub words: &'static str,
    /// The file.
    pub bytes: Vec<u8>,
}

/// Every forgery.
pub fn forgeries() -> Vec<Forgery> {
    let mut list = List(Vec::new());
    layout::add(&mut list);
    content::add(&mut list);
    physical::add(&mut list);
    directions::add(&mut list);
    near::add(&mut list);
    bits::add(&mut list);
    list.0
}

/// Sound files with blocks near geometry as no writer of this project makes them.
pub fn sound_blocks() -> Vec<Vec<u8>> {
    let random = [(1, CODEC_CLASSED, 5), (2, CODEC_HAAR, 5), (3, CODEC_CLASSED, 1), (4, CODEC_HAAR, 8)];
    let random = random.map(|(seed, codec, eighths)| blocks::any(seed, codec, eighths));
    random.into_iter().chain(bits::sound()).collect()
}

/// Kind and item.
type Key = (u32, u32);
type Words = &'static str;

/// Where forgeries go.
struct List(Vec<Forgery>);

impl List {
    fn give(&mut self, code: u32, words: Words, bytes: Vec<u8>) {
        self.0.push(Forgery { code, words, bytes });
    }

    fn of(&mut self, golden: &'static str) -> Of<'_> {
        Of { list: self, golden }
    }
}

/// Forgeries of one golden file.
struct Of<'a> {
    list: &'a mut List,
    golden: &'static str,
}

impl Of<'_> {
    /// Any change, every digest made to fit.
    fn forge(&mut self, code: u32, words: Words, edit: impl FnOnce(&mut Parts)) {
        let mut parts = Parts::of(&golden(self.golden));
        edit(&mut parts);
        self.list.give(code, words, parts.seal(Digests::Pages));
    }

    /// Pages or sections changed, the file laid out anew.
    fn rebuild(&mut self, code: u32, words: Words, edit: impl FnOnce(&mut Parts)) {
        self.forge(code, words, |parts| {
            edit(parts);
            parts.lay_out();
        });
    }

    fn header(&mut self, code: u32, words: Words, edit: impl FnOnce(&mut Header)) {
        self.forge(code, words, |parts| edit(&mut parts.header));
    }

    /// The entry of the first section of a kind and item.
    fn section(&mut self, (kind, item): Key, code: u32, words: Words, edit: impl FnOnce(&mut SectionEntry)) {
        self.forge(code, words, |parts| {
            let at = parts.find(kind, item);
            edit(&mut parts.sections[at]);
        });
    }

    /// The entry of the first base.
    fn base(&mut self, code: u32, words: Words, edit: impl FnOnce(&mut SectionEntry)) {
        self.forge(code, words, |parts| {
            let base = base(parts);
            edit(&mut parts.sections[base]);
        });
    }

    /// The entry of the first page of the first base.
    fn page(&mut self, code: u32, words: Words, edit: impl FnOnce(&mut PageEntry)) {
        self.forge(code, words, |parts| {
            let base = base(parts);
            edit(&mut parts.tables[base][0]);
        });
    }

    /// The entry of the first page of such a section.
    fn first_page(&mut self, (kind, item): Key, code: u32, words: Words, edit: impl FnOnce(&mut PageEntry)) {
        self.forge(code, words, |parts| {
            let section = parts.find(kind, item);
            edit(&mut parts.tables[section][0]);
        });
    }

    /// The plain payload of the first page of such a section, which may get another length.
    fn payload(&mut self, (kind, item): Key, code: u32, words: Words, edit: impl FnOnce(&mut Vec<u8>)) {
        self.rebuild(code, words, |parts| {
            let section = parts.find(kind, item);
            let mut payload = parts.stored(section, 0).to_vec();
            edit(&mut payload);
            parts.set_payload(section, 0, &payload);
        });
    }

    fn without(&mut self, kind: u32, species: u32, item: u32, code: u32, words: &'static str) {
        self.rebuild(code, words, |parts| {
            let key = SectionKey { kind, species, item };
            parts.remove(parts.sections.iter().position(|section| section.key == key).expect("it is there"));
        });
    }

    /// The metadata of the first species.
    fn text(&self) -> String {
        let mut parts = Parts::of(&golden(self.golden));
        String::from_utf8(parts.stored(0, 0).to_vec()).expect("metadata are UTF-8")
    }

    /// Other metadata of the first species.
    fn metadata(&mut self, code: u32, words: Words, text: impl AsRef<[u8]>) {
        self.payload((KIND_METADATA, 0), code, words, |payload| *payload = text.as_ref().to_vec());
    }

    /// Metadata of the first species with one piece replaced, which must be there.
    fn swap(&mut self, code: u32, words: Words, from: &str, to: &str) {
        let text = self.text();
        assert!(text.contains(from), "{from} is not in {text}");
        self.metadata(code, words, text.replacen(from, to, 1));
    }
}

/// A text from the first `start` on, to the first `end` behind it.
fn piece<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let at = text.find(start).expect("it is there");
    let to = text[at..].find(end).expect("it is there") + end.len();
    &text[at..at + to]
}

/// Index of the first base.
fn base(parts: &Parts) -> usize {
    parts.sections.iter().position(|section| section.key.kind == KIND_BASE).expect("a file with bases")
}
