//! Where results of stages are kept between bakes: a trait for those who keep them, and how the stages use it.

use flb_scene::Step;
use serde_json::{Value, json};

use super::observer::Event;
use super::{BakeError, Key, Work};
use crate::artefact::{self, Artefact};

/// Keeps results of stages under names, for later bakes with the same inputs and settings.
///
/// A store is trusted in nothing: what it gives is checked against its name and by what it must be, and made again if
/// it is neither. A store that fails costs time and no more, so it tells of its failures by itself.
pub trait Store {
    /// The bytes under a name; `None` if there are none, or if they cannot be read.
    fn get(&self, name: &str) -> Option<Vec<u8>>;

    /// Keeps bytes under a name. Another bake may have kept the same bytes already; under names that begin with
    /// `parts-`, others.
    fn put(&self, name: &str, bytes: &[u8]);

    /// Learns that what [`Store::get`] gave under a name cannot be used, and why; [`Store::put`] follows.
    fn refuse(&self, name: &str, reason: &str) {
        let _ = (name, reason);
    }

    /// Whether anything is kept: if not, no digest is worked out.
    fn keeps(&self) -> bool {
        true
    }
}

/// A store that keeps nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoStore;

impl Store for NoStore {
    fn get(&self, _: &str) -> Option<Vec<u8>> {
        None
    }

    fn put(&self, _: &str, _: &[u8]) {}

    fn keeps(&self) -> bool {
        false
    }
}

/// The digest of what a stage starts from, for the keys of what it makes; zeros where nothing is kept.
pub fn digest<A: Artefact>(store: &dyn Store, input: &A) -> Result<[u8; 32], BakeError> {
    match store.keeps() {
        true => Ok(artefact::digest(input)?),
        false => Ok([0; 32]),
    }
}

/// The artefact of a key, or else one made by `make` and kept. Tells the observer which of the two.
pub(super) fn reuse_or_make<A: Artefact>(
    work: &Work,
    step: Step,
    key: &Key,
    check: impl FnOnce(&A) -> Result<(), String>,
    make: impl FnOnce() -> Result<A, BakeError>,
) -> Result<A, BakeError> {
    if let Some(value) = read(work.store, key, check) {
        work.hear(Event::Reused { step, species: work.species.to_owned() });
        return Ok(value);
    }
    tell_what_changed(work, step, key);
    let value = make()?;
    keep(work.store, key, &value)?;
    remember(work, key);
    Ok(value)
}

/// Tells the observer which parts of a key are others than when this stage of this species was last made.
pub(super) fn tell_what_changed(work: &Work, step: Step, key: &Key) {
    let last = work.store.get(&parts_name(work, key));
    let Some(last) = last.and_then(|bytes| serde_json::from_slice::<Vec<(String, Value)>>(&bytes).ok())
    else {
        return;
    };
    let was = |name: &str| last.iter().find(|(other, _)| other == name).map(|(_, value)| value);
    let differs = |(name, value): &&(&'static str, Value)| was(name) != Some(value);
    let parts: Vec<String> = key.parts().iter().filter(differs).map(|(name, _)| (*name).to_owned()).collect();
    if !parts.is_empty() {
        work.hear(Event::Changed { step, species: work.species.to_owned(), parts });
    }
}

/// Keeps the parts of a key for [`tell_what_changed`].
pub(super) fn remember(work: &Work, key: &Key) {
    if work.store.keeps() {
        work.store.put(&parts_name(work, key), json!(key.parts()).to_string().as_bytes());
    }
}

fn parts_name(work: &Work, key: &Key) -> String {
    format!("parts-{}", artefact::key(key.stage(), &[work.species.as_bytes()], "parts"))
}

/// The artefact of a key, if there is one that passes `check`.
pub(super) fn read<A: Artefact>(
    store: &dyn Store,
    key: &Key,
    check: impl FnOnce(&A) -> Result<(), String>,
) -> Option<A> {
    let name = key.name();
    let bytes = store.get(&name)?;
    let value = artefact::from_bytes(&bytes, &key.digest()).map_err(|error| error.to_string());
    match value.and_then(|value| check(&value).map(|()| value)) {
        Ok(value) => Some(value),
        Err(reason) => {
            store.refuse(&name, &reason);
            None
        }
    }
}

/// Keeps an artefact.
pub(super) fn keep<A: Artefact>(store: &dyn Store, key: &Key, value: &A) -> Result<(), BakeError> {
    if store.keeps() {
        store.put(&key.name(), &artefact::to_bytes(value, &key.digest())?);
    }
    Ok(())
}

/// Refuses an artefact of something else.
pub(super) fn fits<T: PartialEq + std::fmt::Debug>(
    what: &str,
    found: &T,
    expected: &T,
) -> Result<(), String> {
    match found == expected {
        true => Ok(()),
        false => Err(format!("artefact of {what} {found:?}, expected {expected:?}")),
    }
}
