//! A good file, corrupted in every way that a file can carry, each with the code that a reader must give it.
//!
//! ```text
//! good file -Subject-> parts -> Case (kind, label, what was done, expected code, bytes), one at a time
//! ```
//!
//! The kinds are those of the list that the format was made against, 1 to 60 ([`KINDS`]). Where a corruption is meant
//! to reach a check behind a digest, every digest is made to fit it ([`Parts::seal`]). Conditions of a disk, a server
//! or a process are no bytes: [`CONDITIONS`] names the tests that carry them.

mod content;
mod flips;
mod frames;
mod giants;
mod kinds;
mod layout;
mod metadata;
mod records;
mod transfers;

use super::{Dice, Digests, Parts, check};
use crate::container::records::{Header, PageEntry, SectionEntry};
use crate::{Container, FormatError};

pub use flips::code_of_flip;
pub use kinds::{CONDITIONS, Condition, KINDS};

/// One corruption.
#[derive(Debug, Clone)]
pub struct Case {
    /// Kind of the corruption, 1 to 60, one of [`KINDS`].
    pub kind: u8,
    /// Words for a file's name, apart by hyphens; no two cases of a kind have the same.
    pub label: String,
    /// Description of what was done to the good file.
    pub done: String,
    /// The code that a reader must give; `None` for a file that must pass.
    pub expected: Option<u32>,
    /// The file.
    pub bytes: Vec<u8>,
}

/// A good file, opened.
#[derive(Debug)]
pub struct Subject {
    file: Vec<u8>,
    container: Container,
    /// Laid out anew: pages that share bytes in the file lie apart here, so that each can be spoilt by itself.
    parts: Parts,
    seed: u64,
}

impl Subject {
    /// Takes a file that keeps every promise; `seed` chooses where truncations and flipped bits lie.
    ///
    /// # Errors
    /// The first promise that the file breaks.
    pub fn new(file: Vec<u8>, seed: u64) -> Result<Subject, FormatError> {
        check(&file)?;
        let container = Container::open(&file)?;
        let mut parts = Parts::of(&file);
        parts.lay_out();
        let parts = Parts::of(&parts.seal(Digests::Pages));
        Ok(Subject { file, container, parts, seed })
    }

    /// Makes every corruption, one after another, in order of their kinds within each group.
    pub fn corrupt(&self, sink: &mut dyn FnMut(Case)) {
        let mut cases = Cases { subject: self, sink };
        transfers::cases(&mut cases);
        records::header_cases(&mut cases);
        records::section_cases(&mut cases);
        records::page_cases(&mut cases);
        layout::cases(&mut cases);
        frames::cases(&mut cases);
        giants::cases(&mut cases);
        metadata::cases(&mut cases);
        content::cases(&mut cases);
        flips::cases(&mut cases);
    }

    /// Index of the leaf area density of the first species: every file has one, behind another section and before one.
    fn area(&self) -> usize {
        self.container.species()[0].medium[2]
    }
}

/// Where cases go.
struct Cases<'a> {
    subject: &'a Subject,
    sink: &'a mut dyn FnMut(Case),
}

/// In place of a code: the file is sound.
const PASSES: u32 = 0;

impl Cases<'_> {
    fn give(&mut self, kind: u8, label: &str, done: &str, code: u32, bytes: Vec<u8>) {
        let expected = (code != PASSES).then_some(code);
        (self.sink)(Case { kind, label: label.to_owned(), done: done.to_owned(), expected, bytes });
    }

    /// Records or pages changed in place, every digest made to fit.
    fn poke(&mut self, kind: u8, label: &str, done: &str, code: u32, edit: impl FnOnce(&mut Parts)) {
        let mut parts = self.subject.parts.clone();
        edit(&mut parts);
        self.give(kind, label, done, code, parts.seal(Digests::Pages));
    }

    /// The file put together anew.
    fn rebuild(&mut self, kind: u8, label: &str, done: &str, code: u32, edit: impl FnOnce(&mut Parts)) {
        self.poke(kind, label, done, code, |parts| {
            edit(parts);
            parts.lay_out();
        });
    }

    fn header(&mut self, kind: u8, label: &str, done: &str, code: u32, edit: impl FnOnce(&mut Header)) {
        self.poke(kind, label, done, code, |parts| edit(&mut parts.header));
    }

    /// In the entry of the leaf area density: the sections around it have its shape.
    fn section(
        &mut self,
        kind: u8,
        label: &str,
        done: &str,
        code: u32,
        edit: impl FnOnce(&mut SectionEntry),
    ) {
        let area = self.subject.area();
        self.poke(kind, label, done, code, |parts| edit(&mut parts.sections[area]));
    }

    /// In the entry of its first page.
    fn page(&mut self, kind: u8, label: &str, done: &str, code: u32, edit: impl FnOnce(&mut PageEntry)) {
        let area = self.subject.area();
        self.poke(kind, label, done, code, |parts| edit(&mut parts.tables[area][0]));
    }
}
