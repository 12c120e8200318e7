//! One object of a store: a range of its bytes, and which file it was that gave them.

use std::ffi::OsString;
use std::io;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::sync::{Arc, LazyLock, mpsc};
use std::time::{Duration, Instant};

use futures_util::StreamExt;
use object_store::aws::AmazonS3Builder;
use object_store::client::ClientConfigKey;
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{BackoffConfig, GetOptions, ObjectMeta, ObjectStore, RetryConfig};
use tokio::runtime::Runtime;

use super::client::{Asks, Connector, Counts, WireChoice};
use super::error::{RemoteError, explain, reason, refusal};
use super::patience::{Enough, Patience};
use super::redirect::Rules;
use super::s3::{self, EnvironmentError};
use super::secrets::Secrets;
use super::wire::{Wire, WireSettings};
use super::{RemoteSettings, RemoteUrl};

/// One thread that drives the requests of all sources, so that a source may be read from anywhere, an asynchronous
/// program included, where blocking on a runtime of one's own would panic.
static RUNTIME: LazyLock<io::Result<Runtime>> = LazyLock::new(|| {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .thread_name("flb-remote")
        .enable_all()
        .build()
});

/// What is said of a request whose task panics: the fault is in this program, whatever was sent.
const PANICKED: &str = "internal fault: the task of the request panicked; please report it";

/// Characters of an ETag that a message repeats.
const MAX_TAG_SHOWN: usize = 200;

/// A file in a store.
pub(super) struct Object {
    store: Arc<dyn ObjectStore>,
    path: Path,
    counts: Arc<Counts>,
    limit: Duration,
    retries: usize,
    pub secrets: Arc<Secrets>,
}

/// Bytes, and whose.
pub(super) struct Answer {
    pub bytes: Vec<u8>,
    pub identity: Identity,
}

/// Why there is no object to read.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoObject {
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
    #[error(transparent)]
    Store(#[from] object_store::Error),
}

impl Object {
    /// Sends nothing yet. The environment is that of s3; a `wire` takes the place of HTTP.
    pub(super) fn new(
        url: &RemoteUrl,
        settings: &RemoteSettings,
        counts: Arc<Counts>,
        environment: impl IntoIterator<Item = (OsString, OsString)>,
        wire: Option<Arc<dyn Wire>>,
    ) -> Result<Object, NoObject> {
        let (limit, retries) = (settings.limit, settings.retries);
        let made = Made::new(url, settings, (Arc::clone(&counts), Asks::Ranges), environment, wire)?;
        Ok(Object { store: made.store, path: made.path, counts, limit, retries, secrets: made.secrets })
    }

    /// Reads a range that is not empty, cut at the end of the file; of the file of `identity` only, where one is given.
    pub(super) fn get(&self, range: Range<u64>, identity: Option<&Identity>) -> Result<Answer, RemoteError> {
        let (store, path, counts) = (Arc::clone(&self.store), self.path.clone(), Arc::clone(&self.counts));
        let options = conditions(identity).with_range(Some(range.clone()));
        let (limit, retries, asked) = (self.limit, self.retries, range.clone());
        let read = async move {
            let mut patience = Patience::new(limit, retries);
            let began = Instant::now();
            loop {
                let error = match read(&*store, &path, options.clone(), asked.clone(), &counts).await {
                    Ok(outcome) => return outcome,
                    Err(error) => error,
                };
                let wait = match refusal(&error) {
                    Some(refused) => patience.wait(refused, began.elapsed()),
                    None => Err(Enough::Failed),
                };
                match wait {
                    Ok(wait) => tokio::time::sleep(wait).await,
                    Err(enough) => return Err(explain(&error, &enough, asked, limit)),
                }
            }
        };
        let too_slow = RemoteError::TooSlow { range: range.clone(), seconds: limit.as_secs_f64() };
        let read = async move { tokio::time::timeout(limit, read).await.unwrap_or(Err(too_slow)) };
        wait(read).unwrap_or_else(|reason| Err(RemoteError::Failed { range, reason }))
    }
}

/// A client of the store that a URL names.
pub(super) struct Made {
    pub store: Arc<dyn ObjectStore>,
    /// The URL's path there.
    pub path: Path,
    pub secrets: Arc<Secrets>,
}

impl Made {
    /// Sends nothing yet.
    pub(super) fn new(
        url: &RemoteUrl,
        settings: &RemoteSettings,
        (counts, asks): (Arc<Counts>, Asks),
        environment: impl IntoIterator<Item = (OsString, OsString)>,
        wire: Option<Arc<dyn Wire>>,
    ) -> Result<Made, NoObject> {
        // For bodies that are cut, for credentials, and for whole objects. Tries at a range are counted by
        // `patience.rs`.
        let retry = RetryConfig {
            backoff: BackoffConfig { max_backoff: Duration::from_secs(5), ..BackoffConfig::default() },
            max_retries: settings.retries,
            retry_timeout: settings.limit,
        };
        let url = url.url();
        let plain = url.scheme() == "http";
        let variables = if url.scheme() == "s3" { s3::settings(environment)? } else { Vec::new() };
        let secrets = Arc::new(Secrets::of(url.query(), s3::secrets(&variables)));
        let connector = Connector {
            counts,
            asks,
            is_signed: !variables
                .iter()
                .any(|(name, value)| *name == "AWS_SKIP_SIGNATURE" && value == "true"),
            rules: Rules {
                same_origin: url.scheme() == "s3",
                allow_private: settings.allow_private_redirects,
                is_private: settings.is_private,
                secrets: Arc::clone(&secrets),
            },
            wire: wire.map_or_else(
                || WireChoice::Http(WireSettings { settings: settings.clone(), allow_http: plain, plain }),
                WireChoice::Given,
            ),
        };
        let (store, path): (Arc<dyn ObjectStore>, Path) = match url.scheme() {
            "s3" => {
                let mut builder = AmazonS3Builder::new();
                for (variable, value) in variables {
                    builder = builder.with_config(variable.to_ascii_lowercase().parse()?, value);
                }
                let builder = builder.with_url(url.as_str()).with_retry(retry).with_http_connector(connector);
                let path = Path::from_url_path(url.path()).map_err(object_store::Error::from)?;
                (Arc::new(builder.build()?), path)
            }
            _ => {
                let builder = HttpBuilder::new().with_config(ClientConfigKey::AllowHttp, plain.to_string());
                // The whole URL, and no path in it: that keeps a query, and the path as it is written.
                let builder = builder.with_url(url.as_str()).with_retry(retry).with_http_connector(connector);
                (Arc::new(builder.build()?), Path::default())
            }
        };
        Ok(Made { store, path, secrets })
    }
}

/// Waits for a future on the thread of all requests, from anywhere. The error is a fault of this machine or program.
pub(super) fn wait<T: Send + 'static>(future: impl Future<Output = T> + Send + 'static) -> Result<T, String> {
    let runtime = RUNTIME.as_ref().map_err(|error| format!("cannot start a thread: {error}"))?;
    let (send, receive) = mpsc::channel();
    runtime.spawn(async move {
        let _ = send.send(future.await); // its receiver has gone: nothing to do
    });
    // The sender goes without a word only where its task panics.
    receive.recv().map_err(|_| PANICKED.to_owned())
}

/// One try. The outer error is one after which another try may be of use.
async fn read(
    store: &dyn ObjectStore,
    path: &Path,
    options: GetOptions,
    asked: Range<u64>,
    counts: &Counts,
) -> Result<Result<Answer, RemoteError>, object_store::Error> {
    let answer = store.get_opts(path, options).await?;
    let identity = Identity(answer.meta.clone());
    let range = answer.range.clone();
    let expected = range.end - range.start;
    // At most what was asked for: `judge` has compared the two.
    let mut bytes = Vec::with_capacity(expected.min(asked.end - asked.start) as usize);
    let fault = |found: usize, reason| RemoteError::Length {
        range: range.clone(),
        found: found as u64,
        expected,
        reason,
    };
    let mut body = answer.into_stream();
    while let Some(part) = body.next().await {
        let part = match part {
            Ok(part) => part,
            // The rest was asked for, and refused.
            Err(error) if refusal(&error).is_some() => return Err(error),
            Err(error) => return Ok(Err(fault(bytes.len(), Some(reason(&error))))),
        };
        counts.bytes.fetch_add(part.len() as u64, Ordering::Relaxed);
        bytes.extend_from_slice(&part[..part.len().min((expected as usize - bytes.len()) + 1)]);
        if bytes.len() as u64 > expected {
            return Ok(Err(fault(bytes.len(), None)));
        }
    }
    if bytes.len() as u64 != expected {
        return Ok(Err(fault(bytes.len(), None)));
    }
    Ok(Ok(Answer { bytes, identity }))
}

/// Which file it was: its ETag, or else when it was changed and its length.
#[derive(Debug, Clone)]
pub(super) struct Identity(ObjectMeta);

impl Identity {
    /// Length of the whole file, bytes.
    pub(super) fn length(&self) -> u64 {
        self.0.size
    }

    /// Whether two answers come from the same file. Without ETags that is a matter of the second.
    pub(super) fn is_same(&self, other: &Identity) -> bool {
        let same_words = match (&self.0.e_tag, &other.0.e_tag) {
            (Some(a), Some(b)) => a == b,
            (None, None) => self.0.last_modified == other.0.last_modified,
            _ => false,
        };
        same_words && self.0.size == other.0.size
    }

    fn has_date(&self) -> bool {
        self.0.last_modified.timestamp() != 0 // what `object_store` gives where the answer has none
    }

    /// For messages.
    pub(super) fn describe(&self, secrets: &Secrets) -> String {
        let size = self.0.size;
        let tag = self.0.e_tag.as_ref().map(|tag| secrets.hide(tag.as_bytes(), tag.len()));
        match tag.map(|tag| String::from_utf8_lossy(&tag).into_owned()) {
            Some(tag) if tag.len() > MAX_TAG_SHOWN => {
                let shown: String = tag.chars().take(MAX_TAG_SHOWN).collect();
                format!("ETag {shown}... of {size} bytes")
            }
            Some(tag) => format!("ETag {tag} of {size} bytes"),
            None if self.has_date() => {
                format!("{size} bytes changed at {}", self.0.last_modified.format("%F %T UTC"))
            }
            None => format!("{size} bytes without ETag or date"),
        }
    }
}

/// The conditions of a request for the same file again (RFC 9110, section 13.1). A weak ETag never matches there.
fn conditions(identity: Option<&Identity>) -> GetOptions {
    let options = GetOptions::new();
    let Some(identity) = identity else { return options };
    match &identity.0.e_tag {
        Some(tag) if !tag.starts_with("W/") => options.with_if_match(Some(tag.clone())),
        _ => options.with_if_unmodified_since(identity.has_date().then_some(identity.0.last_modified)),
    }
}

#[cfg(test)]
mod tests;
