//! What keeps entries: a folder or a bucket.

use std::time::SystemTime;

use crate::FarmError;

/// Whether an entry may be there already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Writing {
    /// One that is there has the same bytes.
    Create,
    /// One that is there is replaced.
    Replace,
}

/// Reason why an entry was not read.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum NotRead {
    /// This entry alone: it is made again.
    Entry(String),
    /// Nothing there can be read.
    #[cfg_attr(not(feature = "remote"), expect(dead_code, reason = "folders fail entry by entry"))]
    All(String),
}

/// A file of a place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Listed {
    pub name: String,
    pub bytes: u64,
    /// Time of the last use, to the day; in a bucket that of the last write.
    pub used: SystemTime,
}

/// Keeps entries under names, each whole or not at all. Threads and programs may share it.
pub(super) trait Shelf: Send + Sync {
    /// The bytes of an entry; `None` if there is none.
    fn get(&self, entry: &str) -> Result<Option<Vec<u8>>, NotRead>;

    fn has(&self, entry: &str) -> Result<bool, String>;

    fn put(&self, entry: &str, bytes: &[u8], writing: Writing) -> Result<(), String>;

    /// Every file, those that are no entries as well.
    fn list(&self) -> Result<Vec<Listed>, FarmError>;

    /// Removes an entry. One that is not there is no error.
    fn remove(&self, entry: &str) -> Result<(), FarmError>;

    /// An entry as messages name it.
    fn name(&self, entry: &str) -> String;
}
