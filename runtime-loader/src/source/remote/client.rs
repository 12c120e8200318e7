//! The HTTP client under `object_store`: counts requests, and turns away every answer that is not the range asked for
//! before anything reads its body, which a hostile server may make endless.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use async_trait::async_trait;
use http::header::{CONTENT_RANGE, RANGE};
use http::{HeaderMap, StatusCode};
use object_store::ClientOptions;
use object_store::client::{
    HttpClient, HttpConnector, HttpError, HttpErrorKind, HttpRequest, HttpResponse, HttpService,
    ReqwestConnector,
};

use crate::Traffic;

/// Requests sent and bytes received by one source.
#[derive(Debug, Default)]
pub struct Counts {
    /// Repeated ones, and those for credentials, included.
    pub requests: AtomicU64,
    /// Of bodies, headers left out.
    pub bytes: AtomicU64,
}

impl Counts {
    pub fn traffic(&self) -> Traffic {
        let [requests, bytes] = [&self.requests, &self.bytes].map(|count| count.load(Ordering::Relaxed));
        Traffic { requests, bytes }
    }
}

/// An answer that is not the range that was asked for.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    #[error("the answer {0}")]
    Status(StatusCode),
    #[error("the Content-Range {0:?}")]
    ContentRange(String),
}

/// Makes clients that count into `counts`.
#[derive(Debug)]
pub struct Connector {
    pub counts: Arc<Counts>,
    /// Whether to go on without certificates where the system has none: only a URL of plain `http` can.
    pub plain: bool,
}

impl HttpConnector for Connector {
    fn connect(&self, options: &ClientOptions) -> object_store::Result<HttpClient> {
        // Fails only if the program has chosen a provider already, which then serves.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let connector = ReqwestConnector::default();
        let inner = match connector.connect(options) {
            Err(_) if self.plain => connector.connect(&options.clone().with_no_system_certificates(true)),
            outcome => outcome,
        }?;
        Ok(HttpClient::new(Watched { inner, counts: Arc::clone(&self.counts) }))
    }
}

#[derive(Debug)]
struct Watched {
    inner: HttpClient,
    counts: Arc<Counts>,
}

#[async_trait]
impl HttpService for Watched {
    async fn call(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        self.counts.requests.fetch_add(1, Ordering::Relaxed);
        let asks_for_range = request.headers().contains_key(RANGE);
        let response = self.inner.execute(request).await?;
        if !asks_for_range {
            return Ok(response); // for credentials of s3
        }
        match response.status() {
            StatusCode::PARTIAL_CONTENT => check_content_range(response.headers())?,
            status => return Err(HttpError::new(kind_of(status), Refused::Status(status))),
        }
        Ok(response)
    }
}

/// Whether another try may help: `Request` is tried again, `Unknown` is not.
fn kind_of(status: StatusCode) -> HttpErrorKind {
    let passes = status.is_server_error()
        || status == StatusCode::TOO_MANY_REQUESTS
        || status == StatusCode::REQUEST_TIMEOUT;
    if passes { HttpErrorKind::Request } else { HttpErrorKind::Unknown }
}

/// `bytes FIRST-LAST/LENGTH`, in order. `object_store` compares it with what was asked for, but adds to numbers that it
/// has not looked at.
fn check_content_range(headers: &HeaderMap) -> Result<(), HttpError> {
    let found = headers
        .get(CONTENT_RANGE)
        .map_or(String::new(), |value| String::from_utf8_lossy(value.as_bytes()).into());
    let fits = || -> Option<bool> {
        let (range, length) = found.trim().strip_prefix("bytes ")?.split_once('/')?;
        let (first, last) = range.split_once('-')?;
        let [first, last, length] = [first, last, length].map(|number| number.parse::<u64>().ok());
        Some(first? <= last? && last? < length?)
    };
    match fits() {
        Some(true) => Ok(()),
        _ => Err(HttpError::new(HttpErrorKind::Unknown, Refused::ContentRange(found))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_content_range_within_its_length_is_taken() {
        let check = |text: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(CONTENT_RANGE, text.parse().expect("a header"));
            check_content_range(&headers)
        };
        assert!(check("bytes 0-0/1").is_ok() && check("bytes 5-9/10").is_ok());
        let most = u64::MAX;
        for bad in [
            "bytes 5-9/9",
            "bytes 9-5/10",
            "bytes 0-0/*",
            "bytes */10",
            "0-0/1",
            "bytes 0-0",
            "bytes -1/2",
            "",
        ] {
            assert!(check(bad).is_err(), "{bad}");
        }
        assert!(check(&format!("bytes 0-{most}/{most}")).is_err());
        assert!(check_content_range(&HeaderMap::new()).is_err());
    }
}
