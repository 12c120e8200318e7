//! The cache: what stages made, under the names of their keys, so that the same build reads it back instead of working
//! again.
//!
//! Every entry is checked before it is used; one that fails is made again. A cache never fails a command: where it
//! cannot be read or written, the work is done as without one. All of this is told to a function of its opener.

#[cfg(feature = "remote")]
mod bucket;
pub mod care;
mod folder;
mod packed;
mod place;
mod shelf;

use std::collections::HashSet;
use std::fs;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use flb_baker::bake::Store;
use serde::Serialize;

use crate::FarmError;
use folder::Folder;
pub use place::Place;
pub(crate) use shelf::Listed;
use shelf::{NotRead, Shelf, Writing};

/// Hears what is amiss with a cache.
pub type Tell<'t> = &'t (dyn Fn(&str) + Sync);

/// Beginning of the names of entries that may have other bytes another day.
const CHANGING: &str = "parts-";

/// A place that keeps results, if there is one.
pub struct Cache<'t> {
    place: Option<Place>,
    shelf: Option<Box<dyn Shelf>>,
    /// Whether reading has failed, so that nothing else is tried.
    is_shut: AtomicBool,
    /// Whether a write has failed, so that no other is tried.
    is_full: AtomicBool,
    /// Entries that were refused, and are to be replaced.
    refused: Mutex<HashSet<String>>,
    traffic: Mutex<Traffic>,
    tell: Tell<'t>,
}

/// Entries and bytes that went into a cache and came out of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Traffic {
    /// Entries that were asked for, whether they were there or not.
    pub asked: u64,
    /// Bytes of those that were read.
    pub read_bytes: u64,
    /// Entries that were written.
    pub written: u64,
    /// Bytes of them.
    pub written_bytes: u64,
}

impl Store for Cache<'_> {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        let entry = format!("{name}.artefact");
        let packed = self.read(&entry)?;
        packed::unpack(packed).inspect_err(|reason| self.damaged(&entry, reason)).ok()
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        let packed = packed::pack(bytes);
        self.write(&format!("{name}.artefact"), packed.as_deref().unwrap_or(bytes));
    }

    fn refuse(&self, name: &str, reason: &str) {
        self.damaged(&format!("{name}.artefact"), reason);
    }

    fn keeps(&self) -> bool {
        self.shelf.is_some()
    }
}

/// What keeps the entries of a place.
fn shelf_of(place: &Place) -> Result<Box<dyn Shelf>, FarmError> {
    Ok(match place {
        Place::Folder(folder) => Box::new(Folder(folder.clone())),
        #[cfg(feature = "remote")]
        Place::Bucket(url) => Box::new(bucket::Bucket::open(url)?),
    })
}

impl<'t> Cache<'t> {
    /// Keeps results in a place; a folder is made if it is missing. `None` keeps nothing.
    ///
    /// # Errors
    /// [`FarmError::Runtime`] for variables of the environment that cannot be used, of a bucket.
    pub fn open(place: Option<&Place>, tell: Tell<'t>) -> Result<Cache<'t>, FarmError> {
        let Some(named) = place else { return Ok(Cache::none(tell)) };
        let cache = Cache::existing(named, tell)?;
        if let Some(Err(error)) = place.and_then(Place::folder).map(fs::create_dir_all) {
            cache.close(&error);
        }
        Ok(cache)
    }

    /// A cache that keeps nothing.
    pub fn none(tell: Tell<'t>) -> Cache<'t> {
        Cache {
            place: None,
            shelf: None,
            is_shut: AtomicBool::new(false),
            is_full: AtomicBool::new(false),
            refused: Mutex::default(),
            traffic: Mutex::default(),
            tell,
        }
    }

    /// A cache that is looked at: nothing is made.
    ///
    /// # Errors
    /// As of [`open`](Cache::open).
    pub fn existing(place: &Place, tell: Tell<'t>) -> Result<Cache<'t>, FarmError> {
        Ok(Cache { shelf: Some(shelf_of(place)?), place: Some(place.clone()), ..Cache::none(tell) })
    }

    /// The cache of what belongs to this machine alone, beside a manifest, where this one is a bucket.
    pub(crate) fn of_machine(&self, manifest: &std::path::Path) -> Option<Cache<'t>> {
        match &self.place {
            Some(place) if place.folder().is_none() => {
                Cache::open(Some(&Place::beside(manifest)), self.tell).ok()
            }
            _ => None,
        }
    }

    /// The bytes of an entry; `None` if there is none, or if it cannot be read.
    pub fn read(&self, entry: &str) -> Option<Vec<u8>> {
        let shelf = self.open_shelf()?;
        let found = shelf.get(entry);
        self.count(|traffic| {
            traffic.asked += 1;
            traffic.read_bytes += found.iter().flatten().map(|bytes| bytes.len() as u64).sum::<u64>();
        });
        match found {
            Ok(found) => found,
            Err(NotRead::Entry(reason)) => {
                self.damaged(entry, &reason);
                None
            }
            Err(NotRead::All(reason)) => {
                self.shut(&reason);
                None
            }
        }
    }

    /// Whether there is an entry.
    pub fn has(&self, entry: &str) -> bool {
        let Some(shelf) = self.open_shelf() else { return false };
        self.count(|traffic| traffic.asked += 1);
        shelf.has(entry).inspect_err(|reason| self.shut(reason)).unwrap_or(false)
    }

    /// Keeps an entry, whole or not at all.
    pub fn write(&self, entry: &str, bytes: &[u8]) {
        let Some(shelf) = self.open_shelf().filter(|_| !self.is_full.load(Ordering::Relaxed)) else { return };
        let was_refused = self.refused.lock().expect("no holder panics").remove(entry);
        let writing = match was_refused || entry.starts_with(CHANGING) {
            true => Writing::Replace,
            false => Writing::Create,
        };
        match shelf.put(entry, bytes, writing) {
            Ok(()) => self.count(|traffic| {
                traffic.written += 1;
                traffic.written_bytes += bytes.len() as u64;
            }),
            Err(error) => self.close(&error),
        }
    }

    /// Tells that an entry cannot be used; the next of its name takes its place.
    pub fn damaged(&self, entry: &str, reason: &str) {
        self.refused.lock().expect("no holder panics").insert(entry.to_owned());
        (self.tell)(&format!("{}: {reason}; made again", self.name(entry)));
    }

    /// Returns how much went in and came out so far.
    pub fn traffic(&self) -> Traffic {
        *self.traffic.lock().expect("no holder panics")
    }

    fn count(&self, add: impl FnOnce(&mut Traffic)) {
        add(&mut self.traffic.lock().expect("no holder panics"));
    }

    /// Every file of the place.
    pub(crate) fn list(&self) -> Result<Vec<Listed>, FarmError> {
        self.shelf.as_ref().map_or(Ok(Vec::new()), |shelf| shelf.list())
    }

    /// The bytes of a file, or why there are none: "has no solve-1.artefact".
    pub(crate) fn read_listed(&self, entry: &str) -> Result<Vec<u8>, String> {
        let missing = || format!("has no {entry}");
        match self.shelf.as_ref().ok_or_else(missing)?.get(entry) {
            Ok(found) => found.ok_or_else(missing),
            Err(NotRead::Entry(reason) | NotRead::All(reason)) => Err(reason),
        }
    }

    /// Removes a file.
    pub(crate) fn remove(&self, entry: &str) -> Result<(), FarmError> {
        self.shelf.as_ref().map_or(Ok(()), |shelf| shelf.remove(entry))
    }

    /// A file as messages name it.
    pub fn name(&self, entry: &str) -> String {
        self.shelf.as_ref().map_or(entry.to_owned(), |shelf| shelf.name(entry))
    }

    fn open_shelf(&self) -> Option<&dyn Shelf> {
        self.shelf.as_deref().filter(|_| !self.is_shut.load(Ordering::Relaxed))
    }

    fn close(&self, error: &dyn std::fmt::Display) {
        if !self.is_full.swap(true, Ordering::Relaxed) {
            self.warn("takes nothing more", error);
        }
    }

    fn shut(&self, error: &dyn std::fmt::Display) {
        if !self.is_shut.swap(true, Ordering::Relaxed) {
            self.warn("cannot be used", error);
        }
    }

    fn warn(&self, fault: &str, error: &dyn std::fmt::Display) {
        let place = self.place.as_ref().map(Place::to_string).unwrap_or_default();
        (self.tell)(&format!("warning: {place}: the cache {fault}, and the work goes on without: {error}"));
    }
}
