//! A file behind a URL, read by HTTP range requests (`http`, `https`) or from S3, through the crate `object_store`.
//!
//! - Opening fetches the first [`HEAD_BYTES`] and keeps them: header, tables and metadata of an ordinary file.
//!   What lies beyond is fetched when it is read, neighbours together (`ahead.rs`).
//! - The first answer says how long the file is and which file it is. Every later request asks for that file, and
//!   every later answer is compared: a file that is replaced meanwhile is an error that says so ([`Replaced`]).
//! - Answers that say "not now" (408, 429, 502, 503, 504) are asked again until [`RemoteSettings::limit`], and not
//!   before the server's Retry-After; refused connections, timeouts and other answers 5xx a few times (`patience.rs`).
//! - The answer 416 means that the file is empty, or was replaced by a shorter one, only if it says so by the file's
//!   length (`Content-Range: bytes */0`). Without a length that fits it is a failure of the server.
//! - Redirects are followed, up to ten; from `https` never to `http`, with s3 only within one origin, from a public
//!   address to a private one only where that is allowed (`redirect.rs`). No request carries a Referer, and none to
//!   another origin what was meant for the one before.
//! - Nothing that a server sends makes this read or keep more than was asked for. Bodies are taken as they are: nothing
//!   is decompressed.
//! - No message holds the query of a URL or a value of it, a credential, or more than a line of what a server sent;
//!   where a server sends one of these back, it is hidden (`secrets.rs`).

use std::ffi::OsString;
use std::io;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use flb_format::Source;

use super::replaced::Replaced;
use crate::RuntimeError;
use crate::source::Traffic;

mod address;
mod ahead;
mod answer;
mod bucket;
mod client;
mod credentials;
mod error;
mod object;
mod patience;
mod redirect;
pub mod replay;
mod s3;
mod secrets;
mod url;
mod wire;

pub use address::is_private;
pub use bucket::{Bucket, BucketError, Listed, MAX_BYTES as MAX_OBJECT_BYTES};
pub use error::RemoteError;
pub use s3::EnvironmentError;
pub use url::RemoteUrl;
pub(crate) use url::file_path;

use ahead::{MAX_BYTES, ReadAhead};
pub(crate) use client::Counts;
use object::{Identity, NoObject, Object};
use wire::Wire;

/// Bytes that the first request asks for.
pub const HEAD_BYTES: u64 = 64 << 10;

/// Timeouts, retries and redirects of requests.
#[derive(Debug, Clone)]
pub struct RemoteSettings {
    /// Time limit to connect.
    pub connect: Duration,
    /// Time limit without a byte.
    pub idle: Duration,
    /// Time limit for a range, all tries together.
    pub limit: Duration,
    /// Tries after the first, where no answer says "not now"; those are bounded by `limit` alone.
    pub retries: usize,
    /// Follow redirects from a public address to a private one, and by a proxy to names whose address cannot be seen
    /// from here.
    pub allow_private_redirects: bool,
    /// Test of whether an address is private ([`is_private`]).
    pub is_private: fn(IpAddr) -> bool,
}

impl Default for RemoteSettings {
    fn default() -> RemoteSettings {
        let seconds = Duration::from_secs;
        RemoteSettings {
            connect: seconds(5),
            idle: seconds(10),
            limit: seconds(60),
            retries: 4,
            allow_private_redirects: false,
            is_private,
        }
    }
}

/// A file behind a URL. Threads may share it; they wait for each other's requests.
pub struct RemoteSource {
    object: Object,
    counts: Arc<Counts>,
    /// Of the file that was opened.
    identity: Identity,
    /// The first bytes of the file.
    head: Vec<u8>,
    ahead: Mutex<ReadAhead>,
}

impl RemoteSource {
    /// Fetches the head of the file.
    ///
    /// # Errors
    /// [`RuntimeError::Io`] with a [`RemoteError`]; [`RuntimeError::Empty`]; [`RuntimeError::Environment`].
    pub fn open(url: &RemoteUrl, settings: &RemoteSettings) -> Result<RemoteSource, RuntimeError> {
        RemoteSource::open_by(url, settings, std::env::vars_os(), None)
    }

    /// As [`open`](RemoteSource::open), in another environment, and over another wire than HTTP.
    fn open_by(
        url: &RemoteUrl,
        settings: &RemoteSettings,
        environment: impl IntoIterator<Item = (OsString, OsString)>,
        wire: Option<Arc<dyn Wire>>,
    ) -> Result<RemoteSource, RuntimeError> {
        let failed = |source| RuntimeError::Io { path: url.to_string().into(), action: "read", source };
        let counts = Arc::new(Counts::default());
        let object = Object::new(url, settings, Arc::clone(&counts), environment, wire);
        let object = object.map_err(|error| match error {
            NoObject::Environment(source) => {
                RuntimeError::Environment { path: url.to_string().into(), source }
            }
            NoObject::Store(error) => failed(io::Error::other(error::reason(&error))),
        })?;
        match object.get(0..HEAD_BYTES, None) {
            Ok(answer) => {
                let ahead = Mutex::new(ReadAhead::new(HEAD_BYTES));
                Ok(RemoteSource { object, counts, identity: answer.identity, head: answer.bytes, ahead })
            }
            // It says itself that it has no byte. The mere answer 416 is no verdict: a broken proxy gives it, too.
            Err(RemoteError::Unsatisfiable { range, length: Some(0) }) if range.start == 0 => {
                Err(RuntimeError::Empty { path: url.to_string().into() })
            }
            Err(error) => Err(failed(error.into())),
        }
    }

    /// Requests and bytes fetched so far.
    pub fn traffic(&self) -> Traffic {
        self.counts.traffic()
    }

    pub(crate) fn counts(&self) -> Arc<Counts> {
        Arc::clone(&self.counts)
    }

    fn check_range(&self, offset_bytes: u64, bytes: usize) -> io::Result<()> {
        let length = self.identity.length();
        if offset_bytes.checked_add(bytes as u64).is_some_and(|end| end <= length) {
            return Ok(());
        }
        let message = format!("{bytes} bytes from {offset_bytes} on, of a file of {length}");
        Err(io::Error::new(io::ErrorKind::UnexpectedEof, message))
    }

    /// Bytes of a range of the file that was opened.
    fn fetch(&self, range: std::ops::Range<u64>) -> io::Result<Vec<u8>> {
        let expected = &self.identity;
        let secrets = &self.object.secrets;
        let replaced =
            |found: String| io::Error::other(Replaced { found, expected: expected.describe(secrets) });
        match self.object.get(range, Some(expected)) {
            Ok(answer) if answer.identity.is_same(expected) => Ok(answer.bytes),
            Ok(answer) => Err(replaced(answer.identity.describe(secrets))),
            Err(RemoteError::Status { found, .. }) if found == http::StatusCode::PRECONDITION_FAILED => {
                Err(replaced("another file (answer 412)".to_owned()))
            }
            Err(RemoteError::Unsatisfiable { length: Some(length), .. }) if length < expected.length() => {
                Err(replaced("a shorter file (answer 416)".to_owned()))
            }
            Err(error) => Err(error.into()),
        }
    }
}

impl Source for RemoteSource {
    /// Length at opening.
    fn len_bytes(&self) -> io::Result<u64> {
        Ok(self.identity.length())
    }

    fn read_exact_at(&self, offset_bytes: u64, mut buffer: &mut [u8]) -> io::Result<()> {
        self.check_range(offset_bytes, buffer.len())?;
        let length = self.identity.length();
        // What is kept stays whole if a thread panics while it holds it.
        let mut ahead = self.ahead.lock().unwrap_or_else(PoisonError::into_inner);
        let mut at = offset_bytes;
        while !buffer.is_empty() {
            let in_head =
                usize::try_from(at).ok().and_then(|at| self.head.get(at..)).filter(|head| !head.is_empty());
            let Some(found) = in_head.or_else(|| ahead.find(at)) else {
                let range = ahead.plan(at, buffer.len() as u64, length);
                let bytes = self.fetch(range.clone())?;
                ahead.keep(range.start, bytes);
                continue;
            };
            let step = found.len().min(buffer.len());
            let (filled, rest) = buffer.split_at_mut(step);
            filled.copy_from_slice(&found[..step]);
            buffer = rest;
            at += step as u64;
        }
        Ok(())
    }

    /// A request of its own for what is not in the head of the file.
    fn read_once_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        self.check_range(offset_bytes, buffer.len())?;
        // The head is short.
        let start = offset_bytes.min(self.head.len() as u64) as usize;
        let (known, unknown) = buffer.split_at_mut((self.head.len() - start).min(buffer.len()));
        known.copy_from_slice(&self.head[start..start + known.len()]);
        let mut at = offset_bytes + known.len() as u64;
        for part in unknown.chunks_mut(MAX_BYTES as usize) {
            let bytes = self.fetch(at..at + part.len() as u64)?;
            if bytes.len() != part.len() {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            part.copy_from_slice(&bytes);
            at += part.len() as u64;
        }
        Ok(())
    }
}
