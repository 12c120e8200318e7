//! One object of a store: a range of its bytes, and which file it was that gave them.

use std::io;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::sync::{Arc, LazyLock, mpsc};
use std::time::Duration;

use futures_util::StreamExt;
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::client::ClientConfigKey;
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{BackoffConfig, GetOptions, ObjectMeta, ObjectStore, RetryConfig};
use tokio::runtime::Runtime;

use super::client::{Connector, Counts};
use super::error::{RemoteError, explain, reason};
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

/// A file in a store.
pub struct Object {
    store: Arc<dyn ObjectStore>,
    path: Path,
    counts: Arc<Counts>,
    limit: Duration,
}

/// Bytes, and whose.
pub struct Answer {
    pub bytes: Vec<u8>,
    pub identity: Identity,
}

impl Object {
    /// Sends nothing yet.
    pub fn new(
        url: &RemoteUrl,
        settings: &RemoteSettings,
        counts: Arc<Counts>,
    ) -> object_store::Result<Object> {
        let limit = settings.limit;
        let retry = RetryConfig {
            backoff: BackoffConfig { max_backoff: Duration::from_secs(5), ..BackoffConfig::default() },
            max_retries: settings.retries,
            retry_timeout: limit,
        };
        let millis = |time: Duration| format!("{} ms", time.as_millis().max(1));
        let options = [
            (ClientConfigKey::ConnectTimeout, millis(settings.connect)),
            (ClientConfigKey::ReadTimeout, millis(settings.idle)),
            (ClientConfigKey::Timeout, millis(limit)),
        ];
        let url = url.url();
        let connector = Connector { counts: Arc::clone(&counts), plain: url.scheme() == "http" };
        let (store, path): (Arc<dyn ObjectStore>, Path) = match url.scheme() {
            "s3" => {
                let mut builder = AmazonS3Builder::from_env();
                for (key, value) in options {
                    builder = builder.with_config(AmazonS3ConfigKey::Client(key), value);
                }
                let builder = builder.with_url(url.as_str()).with_retry(retry).with_http_connector(connector);
                (Arc::new(builder.build()?), Path::from_url_path(url.path())?)
            }
            scheme => {
                let mut builder = HttpBuilder::new();
                for (key, value) in options {
                    builder = builder.with_config(key, value);
                }
                let allow_http = (scheme == "http").to_string();
                let builder = builder.with_config(ClientConfigKey::AllowHttp, allow_http);
                // The whole URL, and no path in it: that keeps a query, and the path as it is written.
                let builder = builder.with_url(url.as_str()).with_retry(retry).with_http_connector(connector);
                (Arc::new(builder.build()?), Path::default())
            }
        };
        Ok(Object { store, path, counts, limit })
    }

    /// Reads a range that is not empty, cut at the end of the file; of the file of `identity` only, where one is given.
    pub fn get(&self, range: Range<u64>, identity: Option<&Identity>) -> Result<Answer, RemoteError> {
        let (store, path, counts) = (Arc::clone(&self.store), self.path.clone(), Arc::clone(&self.counts));
        let options = conditions(identity).with_range(Some(range.clone()));
        let (limit, asked) = (self.limit, range.clone());
        let read = async move { read(&*store, &path, options, asked, &counts).await };
        let too_slow = RemoteError::TooSlow { range: range.clone(), seconds: limit.as_secs_f64() };
        let read = async move { tokio::time::timeout(limit, read).await.unwrap_or(Err(too_slow)) };
        let failed = |reason: String| RemoteError::Failed { range, reason };
        let runtime = match RUNTIME.as_ref() {
            Ok(runtime) => runtime,
            Err(error) => return Err(failed(format!("cannot start a thread: {error}"))),
        };
        let (send, receive) = mpsc::channel();
        runtime.spawn(async move {
            let _ = send.send(read.await); // nobody waits any more: nothing to do
        });
        receive.recv().unwrap_or_else(|_| Err(failed("the task that reads it has died".to_owned())))
    }
}

async fn read(
    store: &dyn ObjectStore,
    path: &Path,
    options: GetOptions,
    asked: Range<u64>,
    counts: &Counts,
) -> Result<Answer, RemoteError> {
    let explain = |error| explain(&error, asked.clone());
    let answer = store.get_opts(path, options).await.map_err(explain)?;
    let identity = Identity(answer.meta.clone());
    let range = answer.range.clone();
    let expected = range.end - range.start;
    // At most what was asked for: `object_store` has compared the two.
    let mut bytes = Vec::with_capacity(expected.min(asked.end - asked.start) as usize);
    let fault = |found: usize, reason| RemoteError::Length {
        range: range.clone(),
        found: found as u64,
        expected,
        reason,
    };
    let mut body = answer.into_stream();
    while let Some(part) = body.next().await {
        let part = part.map_err(|error| fault(bytes.len(), Some(reason(&error))))?;
        counts.bytes.fetch_add(part.len() as u64, Ordering::Relaxed);
        bytes.extend_from_slice(&part[..part.len().min((expected as usize - bytes.len()) + 1)]);
        if bytes.len() as u64 > expected {
            return Err(fault(bytes.len(), None));
        }
    }
    if bytes.len() as u64 != expected {
        return Err(fault(bytes.len(), None));
    }
    Ok(Answer { bytes, identity })
}

/// Which file it was: its ETag, or else when it was changed and its length.
#[derive(Debug, Clone)]
pub struct Identity(ObjectMeta);

impl Identity {
    /// Length of the whole file, bytes.
    pub fn length(&self) -> u64 {
        self.0.size
    }

    /// Whether two answers come from the same file. Without ETags that is a matter of the second.
    pub fn is_same(&self, other: &Identity) -> bool {
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
    pub fn describe(&self) -> String {
        let size = self.0.size;
        match &self.0.e_tag {
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
