//! A good file, corrupted in every way that a file can carry, each with the code that `validate` must give it.
//!
//! ```text
//! good file -Subject-> parts -> Case (kind, label, what was done, expected code, bytes), one at a time
//! ```
//!
//! The kinds are those of the list that the format was made against, 1 to 60 ([`KINDS`]). Where a corruption is meant
//! to reach a check behind a digest, every digest is made to fit it ([`draft::Image::seal`]). Conditions of a disk, a
//! server or a process are no bytes: [`CONDITIONS`] names the tests that carry them.

mod content;
pub mod draft;
mod flips;
mod frames;
mod giants;
mod kinds;
mod layout;
mod metadata;
mod records;
mod transfers;

use flb_format::{Container, FormatError};

use crate::Level;
use crate::validate::check;
use draft::{Digests, Draft, Image};

pub use flips::code_of_flip;
pub use kinds::{CONDITIONS, Condition, KINDS};

/// One corruption.
#[derive(Debug, Clone)]
pub struct Case {
    /// 1 to 60, one of [`KINDS`].
    pub kind: u8,
    /// Words for a file's name, apart by hyphens; no two cases of a kind have the same.
    pub label: String,
    /// What was done to the good file.
    pub done: String,
    /// The code that `validate` must give; `None` for a file that must pass.
    pub expected: Option<u32>,
    /// The file.
    pub bytes: Vec<u8>,
}

/// A good file, opened.
#[derive(Debug)]
pub struct Subject {
    file: Vec<u8>,
    container: Container,
    draft: Draft,
    /// The draft as it is. Pages that share bytes in the file lie apart here, so that each can be spoilt by itself.
    image: Image,
    seed: u64,
}

impl Subject {
    /// Takes a file that keeps every promise; `seed` chooses where truncations and flipped bits lie.
    ///
    /// # Errors
    /// The first promise that the file breaks.
    pub fn new(file: Vec<u8>, seed: u64) -> Result<Subject, FormatError> {
        check(&file, Level::Decode)?;
        let container = Container::open(&file)?;
        let draft = Draft::of(&container, &file)?;
        let image = draft.clone().build();
        Ok(Subject { file, container, draft, image, seed })
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

/// What `validate` must say of a sound file.
const PASSES: Option<u32> = None;

impl Cases<'_> {
    fn give(
        &mut self,
        kind: u8,
        label: &str,
        done: impl Into<String>,
        expected: impl Into<Option<u32>>,
        bytes: Vec<u8>,
    ) {
        let (label, done, expected) = (label.to_owned(), done.into(), expected.into());
        (self.sink)(Case { kind, label, done, expected, bytes });
    }

    /// A few bytes changed in place, every digest made to fit.
    fn poke(
        &mut self,
        kind: u8,
        label: &str,
        done: impl Into<String>,
        expected: impl Into<Option<u32>>,
        edit: impl FnOnce(&mut Image),
    ) {
        let mut image = self.subject.image.clone();
        edit(&mut image);
        image.seal(Digests::Pages);
        self.give(kind, label, done, expected, image.bytes);
    }

    /// The file put together anew.
    fn rebuild(
        &mut self,
        kind: u8,
        label: &str,
        done: impl Into<String>,
        expected: impl Into<Option<u32>>,
        edit: impl FnOnce(&mut Draft),
    ) {
        let mut draft = self.subject.draft.clone();
        edit(&mut draft);
        self.give(kind, label, done, expected, draft.build().bytes);
    }
}

/// Numbers from a seed: Knuth's MMIX generator, of which the upper bits are the random ones.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % limit
    }
}

#[cfg(test)]
mod tests;
