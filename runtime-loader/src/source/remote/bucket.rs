//! Objects below a prefix of an s3 bucket, whole: for stores of results, which write as well as read.
//!
//! - An object appears whole or not at all, and [`Bucket::create`] never replaces one: s3 decides which of two writers
//!   was first (`If-None-Match: *`). Servers that do not know the condition are written to without it.
//! - Failures that may pass are tried again by `object_store`, up to [`LIMIT`].
//! - Nothing is read that is longer than the answer said, or than [`MAX_BYTES`].
//! - No message holds a credential or a text of the server: its status, and the code of s3 where that is a word.

use std::ffi::OsString;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

use futures_util::StreamExt;
use http::StatusCode;
use object_store::path::{Path, PathPart};
use object_store::{Error, ObjectStore, ObjectStoreExt, PutMode, PutPayload};

use super::answer::Refused;
use super::client::{Asks, Counts};
use super::error::{reason, refusal};
use super::object::{Made, NoObject, wait};
use super::wire::Wire;
use super::{RemoteSettings, RemoteUrl};
use crate::RuntimeError;

/// Time limit for one object, all tries together.
const LIMIT: Duration = Duration::from_mins(10);
/// Time limit without a byte: while an object is written, nothing comes back.
const IDLE: Duration = Duration::from_mins(2);
/// Largest object that is read or written: more cannot be put at once.
pub const MAX_BYTES: u64 = 5 << 30;

/// Objects below a prefix of a bucket. Threads may share it.
pub struct Bucket {
    store: Arc<dyn ObjectStore>,
    prefix: Path,
    counts: Arc<Counts>,
    written_bytes: AtomicU64,
}

/// An object of a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// Name below the prefix.
    pub name: String,
    /// Length, in bytes.
    pub bytes: u64,
    /// Time of the last write.
    pub modified: SystemTime,
}

/// Failure of a request to a bucket.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("cannot {action}: {found}")]
pub struct BucketError {
    /// Verb and object: "read solve-1.artefact".
    pub action: String,
    /// Answer, or why there was none.
    pub found: String,
}

impl Bucket {
    /// Takes credentials, region and endpoint from the environment. Sends nothing yet.
    ///
    /// # Errors
    /// [`RuntimeError::Environment`]; [`RuntimeError::Io`] for a URL that is none of s3.
    pub fn open(url: &RemoteUrl) -> Result<Bucket, RuntimeError> {
        Bucket::open_by(url, std::env::vars_os(), None)
    }

    /// As [`open`](Bucket::open), in another environment, and over another wire than HTTP.
    fn open_by(
        url: &RemoteUrl,
        environment: impl IntoIterator<Item = (OsString, OsString)>,
        wire: Option<Arc<dyn Wire>>,
    ) -> Result<Bucket, RuntimeError> {
        let failed = |reason: String| RuntimeError::Io {
            path: url.to_string().into(),
            action: "use",
            source: std::io::Error::other(reason),
        };
        if !url.is_bucket() {
            return Err(failed("found a URL of HTTP, expected s3://BUCKET/PREFIX".to_owned()));
        }
        let settings = RemoteSettings { idle: IDLE, limit: LIMIT, ..RemoteSettings::default() };
        let counts = Arc::new(Counts::default());
        let made = Made::new(url, &settings, (Arc::clone(&counts), Asks::Objects), environment, wire);
        let Made { store, path, .. } = made.map_err(|error| match error {
            NoObject::Environment(source) => {
                RuntimeError::Environment { path: url.to_string().into(), source }
            }
            NoObject::Store(error) => failed(reason(&error)),
        })?;
        Ok(Bucket { store, prefix: path, counts, written_bytes: AtomicU64::new(0) })
    }

    /// The bytes of an object; `None` if there is none.
    ///
    /// # Errors
    /// [`BucketError`].
    pub fn get(&self, name: &str) -> Result<Option<Vec<u8>>, BucketError> {
        let (store, path, counts) = (Arc::clone(&self.store), self.path(name), Arc::clone(&self.counts));
        self.wait("read", name, async move {
            let answer = match store.get(&path).await {
                Ok(answer) => answer,
                Err(Error::NotFound { .. }) => return Ok(None),
                Err(error) => return Err(found(&error)),
            };
            let expected = answer.meta.size;
            if expected > MAX_BYTES {
                return Err(format!("found {expected} bytes, expected {MAX_BYTES} at most"));
            }
            let mut bytes = Vec::new();
            let length = usize::try_from(expected).map_err(|error| error.to_string())?;
            bytes
                .try_reserve_exact(length)
                .map_err(|_| format!("{length} bytes of memory needed, which the system does not give"))?;
            let mut body = answer.into_stream();
            while let Some(part) = body.next().await {
                let part = part.map_err(|error| found(&error))?;
                counts.bytes.fetch_add(part.len() as u64, Ordering::Relaxed);
                if (bytes.len() + part.len()) as u64 > expected {
                    return Err(format!("found more than the {expected} bytes of the answer's header"));
                }
                bytes.extend_from_slice(&part);
            }
            match bytes.len() as u64 == expected {
                true => Ok(Some(bytes)),
                false => Err(format!("found {} bytes, expected {expected}", bytes.len())),
            }
        })
    }

    /// Whether there is such an object.
    ///
    /// # Errors
    /// [`BucketError`].
    pub fn has(&self, name: &str) -> Result<bool, BucketError> {
        let (store, path) = (Arc::clone(&self.store), self.path(name));
        self.wait("look for", name, async move {
            match store.head(&path).await {
                Ok(_) => Ok(true),
                Err(Error::NotFound { .. }) => Ok(false),
                Err(error) => Err(found(&error)),
            }
        })
    }

    /// Writes an object, whole or not at all. One that is there stays, and that is no error.
    ///
    /// # Errors
    /// [`BucketError`].
    pub fn create(&self, name: &str, bytes: &[u8]) -> Result<(), BucketError> {
        self.put(name, bytes, PutMode::Create)
    }

    /// Writes an object, whole or not at all, in the place of one that is there.
    ///
    /// # Errors
    /// [`BucketError`].
    pub fn replace(&self, name: &str, bytes: &[u8]) -> Result<(), BucketError> {
        self.put(name, bytes, PutMode::Overwrite)
    }

    fn put(&self, name: &str, bytes: &[u8], mode: PutMode) -> Result<(), BucketError> {
        let (store, path) = (Arc::clone(&self.store), self.path(name));
        let payload = PutPayload::from(bytes.to_vec());
        self.written_bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        self.wait("write", name, async move {
            let error = match store.put_opts(&path, payload.clone(), mode.clone().into()).await {
                // Answer 409: another writer is at it, with the same bytes.
                Ok(_) | Err(Error::AlreadyExists { .. }) => return Ok(()),
                Err(error) => error,
            };
            if mode == PutMode::Create && is_not_known(&error) {
                let again = store.put_opts(&path, payload, PutMode::Overwrite.into()).await;
                return again.map(drop).map_err(|error| found(&error));
            }
            Err(found(&error))
        })
    }

    /// All objects below the prefix, those of deeper prefixes left out, by name.
    ///
    /// # Errors
    /// [`BucketError`].
    pub fn list(&self) -> Result<Vec<Listed>, BucketError> {
        let (store, prefix) = (Arc::clone(&self.store), self.prefix.clone());
        self.wait("list", "the objects", async move {
            let all = store.list_with_delimiter(Some(&prefix)).await.map_err(|error| found(&error))?;
            let listed = all.objects.into_iter().filter_map(|object| {
                let name = object.location.filename()?.to_owned();
                Some(Listed { name, bytes: object.size, modified: object.last_modified.into() })
            });
            let mut listed: Vec<Listed> = listed.collect();
            listed.sort_by(|a, b| a.name.cmp(&b.name));
            Ok(listed)
        })
    }

    /// Removes an object. One that is not there is no error.
    ///
    /// # Errors
    /// [`BucketError`].
    pub fn remove(&self, name: &str) -> Result<(), BucketError> {
        let (store, path) = (Arc::clone(&self.store), self.path(name));
        self.wait("remove", name, async move {
            match store.delete(&path).await {
                Ok(()) | Err(Error::NotFound { .. }) => Ok(()),
                Err(error) => Err(found(&error)),
            }
        })
    }

    /// Requests so far, bytes read and bytes written.
    pub fn traffic(&self) -> [u64; 3] {
        let traffic = self.counts.traffic();
        [traffic.requests, traffic.bytes, self.written_bytes.load(Ordering::Relaxed)]
    }

    fn path(&self, name: &str) -> Path {
        self.prefix.clone().join(PathPart::from(name))
    }

    fn wait<T: Send + 'static>(
        &self,
        verb: &str,
        name: &str,
        future: impl Future<Output = Result<T, String>> + Send + 'static,
    ) -> Result<T, BucketError> {
        let limited = async move {
            let too_slow = || Err(format!("found no whole answer after {} s", LIMIT.as_secs()));
            tokio::time::timeout(LIMIT, future).await.unwrap_or_else(|_| too_slow())
        };
        let outcome = wait(limited).unwrap_or_else(Err);
        outcome.map_err(|found| BucketError { action: format!("{verb} {name}"), found })
    }
}

/// Whether a server does not know the condition of a request (501 Not Implemented).
fn is_not_known(error: &Error) -> bool {
    let status = match refusal(error) {
        Some(Refused::Answer { found, .. }) => Some(*found),
        _ => None,
    };
    matches!(error, Error::NotImplemented { .. }) || status == Some(StatusCode::NOT_IMPLEMENTED)
}

/// What was found, in words of this house.
fn found(error: &Error) -> String {
    match refusal(error) {
        Some(Refused::Answer { found: StatusCode::MOVED_PERMANENTLY, .. }) => {
            "found the answer 301: the bucket is of another region; AWS_REGION names it".to_owned()
        }
        Some(refused @ Refused::Answer { .. }) => format!("found {refused}"),
        _ => reason(error),
    }
}

#[cfg(test)]
mod tests;
