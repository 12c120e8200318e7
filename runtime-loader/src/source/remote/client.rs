//! The HTTP client under `object_store`: counts requests, follows redirects by the rules of `redirect.rs`, and turns away
//! every answer that is not the range asked for before anything reads its body, which a hostile server may make endless.
//!
//! It tries nothing twice: every failure is given up as one that `object_store` does not repeat, and `object.rs` decides.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use async_trait::async_trait;
use futures_util::StreamExt;
use http::header::RANGE;
use http::{Method, Request};
use object_store::client::{
    ClientConfigKey, HttpClient, HttpConnector, HttpError, HttpErrorKind, HttpRequest, HttpRequestBody,
    HttpResponse, HttpService,
};
use object_store::{ClientOptions, Error};

use super::answer::{Refused, judge, range_of};
use super::redirect::{Hop, Reach, Rules};
use super::wire::{Clients, PrivateName, Wire, WireSettings};
use crate::Traffic;

/// Of an answer to a request for credentials.
const MOST_CREDENTIALS_BYTES: usize = 64 << 10;

/// Requests sent and bytes received by one source.
#[derive(Debug, Default)]
pub struct Counts {
    /// Repeated and redirected ones, and those for credentials, included.
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

/// Makes clients that count into `counts`.
#[derive(Debug)]
pub struct Connector {
    pub counts: Arc<Counts>,
    pub rules: Rules,
    pub wire: WireChoice,
}

/// What carries the requests.
#[derive(Debug)]
pub enum WireChoice {
    /// HTTP; whether plain `http` may be spoken is the store's to say.
    Http(WireSettings),
    /// Anything.
    Given(Arc<dyn Wire>),
}

impl HttpConnector for Connector {
    fn connect(&self, options: &ClientOptions) -> object_store::Result<HttpClient> {
        let wire = match &self.wire {
            WireChoice::Given(wire) => Arc::clone(wire),
            WireChoice::Http(made_for) => {
                let said = options.get_config_value(&ClientConfigKey::AllowHttp);
                let allow_http = made_for.allow_http || said.as_deref() == Some("true");
                let mut made_for = WireSettings { allow_http, ..made_for.clone() };
                // Of the store that gives a machine in the cloud its credentials: other machines have none.
                if options.get_config_value(&ClientConfigKey::ConnectTimeout).as_deref() == Some("1s") {
                    made_for.settings.connect = made_for.settings.connect.min(Duration::from_secs(1));
                }
                let clients = Clients::new(made_for);
                Arc::new(clients.map_err(|error| Error::Generic {
                    store: "HTTP",
                    source: Box::new(HttpError::new(HttpErrorKind::Unknown, error.without_url())),
                })?)
            }
        };
        Ok(HttpClient::new(Watched { wire, counts: Arc::clone(&self.counts), rules: self.rules.clone() }))
    }
}

#[derive(Debug)]
struct Watched {
    wire: Arc<dyn Wire>,
    counts: Arc<Counts>,
    rules: Rules,
}

#[async_trait]
impl HttpService for Watched {
    async fn call(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        match request.headers().contains_key(RANGE) {
            true => {
                let refused = |refused| HttpError::new(HttpErrorKind::Unknown, refused);
                self.range(request).await.map_err(refused)
            }
            false => self.credentials(request).await,
        }
    }
}

impl Watched {
    /// The range that a request asks for, wherever it leads.
    async fn range(&self, request: HttpRequest) -> Result<HttpResponse, Refused> {
        let asked = request.headers().get(RANGE).and_then(|range| range_of(range.as_bytes()));
        let asked = asked.ok_or_else(|| Refused::Header("the request has no range".to_owned()))?;
        let mut hop = Hop::first(request.uri(), request.headers().clone())?;
        loop {
            let mut request = Request::new(HttpRequestBody::empty());
            (*request.uri_mut(), *request.headers_mut()) = (hop.uri.clone(), hop.headers.clone());
            *request.method_mut() = Method::GET;
            self.counts.requests.fetch_add(1, Ordering::Relaxed);
            let (response, peer) = match self.wire.send(request, hop.reach).await {
                Ok(answer) => answer,
                Err(error) => return Err(no_answer(error, hop.hops)),
            };
            let (mut parts, body) = response.into_parts();
            let answer = (parts.status, &parts.headers);
            match hop.next(answer, peer, &self.rules, |uri| self.wire.is_proxied(uri))? {
                Some(next) => hop = next,
                None => {
                    parts.headers = judge(&asked, parts.status, &parts.headers)?;
                    return Ok(HttpResponse::from_parts(parts, body));
                }
            }
        }
    }

    /// What gives s3 its credentials. Redirects are not followed, and what a server says with an error is not kept: both
    /// could carry a secret on.
    async fn credentials(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        self.counts.requests.fetch_add(1, Ordering::Relaxed);
        let (response, _) = self.wire.send(request, Reach::Any).await?;
        let (parts, body) = response.into_parts();
        let mut bytes = Vec::new();
        if parts.status.is_success() {
            let mut body = body.bytes_stream();
            while let Some(part) = body.next().await {
                bytes.extend_from_slice(&part?);
                if bytes.len() > MOST_CREDENTIALS_BYTES {
                    return Err(strange("more than 65536 bytes of credentials"));
                }
            }
            if !fits_headers(&bytes) {
                return Err(strange("credentials with bytes that no header can hold"));
            }
        }
        Ok(HttpResponse::from_parts(parts, bytes.into()))
    }
}

fn no_answer(error: HttpError, hops: usize) -> Refused {
    match find::<PrivateName>(&error) {
        Some(private) => Refused::Redirect(format!(
            "redirect {hops}: found a name to which a public server leads, and {private}; expected a public address \
             (or allow-private-redirects)"
        )),
        None => Refused::NoAnswer(error),
    }
}

/// The first error of this type in a chain of sources.
fn find<'a, E: std::error::Error + 'static>(error: &'a (dyn std::error::Error + 'static)) -> Option<&'a E> {
    let mut next = Some(error);
    while let Some(error) = next {
        if let Some(found) = error.downcast_ref() {
            return Some(found);
        }
        next = error.source();
    }
    None
}

fn strange(found: &str) -> HttpError {
    HttpError::new(HttpErrorKind::Decode, Refused::Header(format!("found {found}")))
}

/// Whether every text in an answer of JSON or XML may become a header, as a session token does: `object_store` takes that
/// for granted. No token has an escape but that of a slash.
fn fits_headers(bytes: &[u8]) -> bool {
    let escaped = bytes.windows(2).any(|pair| pair[0] == b'\\' && !matches!(pair[1], b'/' | b'"'));
    let plain = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    !escaped && bytes.iter().all(plain) && !bytes.windows(2).any(|pair| pair == b"&#")
}
