//! The HTTP client under `object_store`: counts requests, follows redirects by the rules of `redirect.rs`, and turns
//! away every answer that is not the range asked for before anything reads its body, which a hostile server may make
//! endless.
//!
//! It tries nothing twice: every failure is given up as one that `object_store` does not repeat; `object.rs` decides.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use async_trait::async_trait;
use futures_util::StreamExt;
use http::header::RANGE;
use http::{Method, Request, StatusCode};
use object_store::client::{
    ClientConfigKey, HttpClient, HttpConnector, HttpError, HttpErrorKind, HttpRequest, HttpRequestBody,
    HttpResponse, HttpResponseBody, HttpService,
};
use object_store::{ClientOptions, Error};

use super::answer::{NoRange, Refused, judge, range_of};
use super::credentials::{Kind, is_near};
use super::redirect::{Hop, Reach, Rules};
use super::wire::{Clients, PrivateName, Wire, WireSettings};
use crate::source::Traffic;

/// Of an answer to a request for credentials, and of one that is no success.
const MAX_CREDENTIALS_BYTES: usize = 64 << 10;
/// Of a list of objects: a thousand names of a thousand bytes, and as much around each.
const MAX_LIST_BYTES: usize = 4 << 20;

/// Requests sent and bytes received by one source.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    /// Number of requests, repeated and redirected ones and those for credentials included.
    pub requests: AtomicU64,
    /// Bytes of bodies, headers left out.
    pub bytes: AtomicU64,
}

impl Counts {
    pub(crate) fn traffic(&self) -> Traffic {
        let [requests, bytes] = [&self.requests, &self.bytes].map(|count| count.load(Ordering::Relaxed));
        Traffic { requests, bytes }
    }
}

/// Makes clients that count into `counts`.
#[derive(Debug)]
pub(super) struct Connector {
    pub counts: Arc<Counts>,
    pub asks: Asks,
    /// Requests to s3 are signed.
    pub is_signed: bool,
    pub rules: Rules,
    pub wire: WireChoice,
}

/// What is asked for beside credentials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asks {
    /// Ranges of a file.
    Ranges,
    /// Whole objects of s3, and lists of them (`bucket.rs`).
    Objects,
}

/// What carries the requests.
#[derive(Debug)]
pub(super) enum WireChoice {
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
                let clients = Clients::new(WireSettings { allow_http, ..made_for.clone() });
                Arc::new(clients.map_err(|error| Error::Generic {
                    store: "HTTP",
                    source: Box::new(HttpError::new(HttpErrorKind::Unknown, error.without_url())),
                })?)
            }
        };
        let Connector { counts, asks, is_signed, rules, .. } = self;
        let (counts, asks, is_signed) = (Arc::clone(counts), *asks, *is_signed);
        Ok(HttpClient::new(Watched { wire, counts, asks, is_signed, rules: rules.clone() }))
    }
}

#[derive(Debug)]
struct Watched {
    wire: Arc<dyn Wire>,
    counts: Arc<Counts>,
    asks: Asks,
    is_signed: bool,
    rules: Rules,
}

#[async_trait]
impl HttpService for Watched {
    async fn call(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        // Requests for credentials are signed by nothing, and there are none where no signature is wanted.
        let is_own = !self.is_signed || request.headers().contains_key("x-amz-content-sha256");
        if self.asks == Asks::Objects && is_own {
            return self.object(request).await;
        }
        match request.headers().contains_key(RANGE) {
            true => {
                let asked = request.headers().get(RANGE).and_then(|range| range_of(range.as_bytes()));
                let refused = self.range(request, asked.clone()).await;
                refused.map_err(|refused| HttpError::new(HttpErrorKind::Unknown, NoRange { asked, refused }))
            }
            false => self.credentials(request).await,
        }
    }
}

impl Watched {
    /// The range that a request asks for, wherever it leads.
    async fn range(&self, request: HttpRequest, asked: Option<Range<u64>>) -> Result<HttpResponse, Refused> {
        let secrets = &self.rules.secrets;
        let asked = asked.ok_or_else(|| Refused::Header("the request has no range".to_owned()))?;
        let mut hop = Hop::first(request.uri(), request.headers().clone())?;
        loop {
            let mut request = Request::new(HttpRequestBody::empty());
            (*request.uri_mut(), *request.headers_mut()) = (hop.uri.clone(), hop.headers.clone());
            *request.method_mut() = Method::GET;
            secrets.learn(request.uri().query(), request.headers());
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
                    parts.headers = judge(&asked, parts.status, &parts.headers, secrets)?;
                    return Ok(HttpResponse::from_parts(parts, body));
                }
            }
        }
    }

    /// A whole object, or a list of some. Redirects are not followed. Of an answer that is no success only its code is
    /// kept. The body of an object is left to its reader, which knows how long it may be.
    async fn object(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        self.counts.requests.fetch_add(1, Ordering::Relaxed);
        let is_object = request.method() == Method::GET && request.uri().query().is_none();
        let (response, _) = self.wire.send(request, Reach::Any).await?;
        let (parts, body) = response.into_parts();
        if parts.status.is_success() && is_object {
            return Ok(HttpResponse::from_parts(parts, body));
        }
        let most = if parts.status.is_success() { MAX_LIST_BYTES } else { MAX_CREDENTIALS_BYTES };
        let mut bytes = read_bounded(body, most, "an answer").await?;
        if !parts.status.is_success() {
            let code = code_of(&bytes);
            let is_missing =
                parts.status == StatusCode::NOT_FOUND && code.is_none_or(|code| code == "NoSuchKey");
            let is_plain = is_missing
                || (parts.status.is_server_error() && parts.status != StatusCode::NOT_IMPLEMENTED)
                || matches!(parts.status.as_u16(), 304 | 408 | 409 | 412 | 429);
            if !is_plain {
                let refused = Refused::Answer { found: parts.status, code: code.map(str::to_owned) };
                return Err(HttpError::new(HttpErrorKind::Unknown, refused));
            }
            bytes.clear();
        }
        Ok(HttpResponse::from_parts(parts, bytes.into()))
    }

    /// What gives s3 its credentials. Redirects are not followed, and what a server says with an error is not kept:
    /// both could carry a secret on. An endpoint near by is asked without a proxy, which would see the token.
    async fn credentials(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        self.counts.requests.fetch_add(1, Ordering::Relaxed);
        let kind = Kind::of(request.method(), request.uri());
        let reach = if is_near(request.uri()) { Reach::Near } else { Reach::Any };
        let (response, _) = self.wire.send(request, reach).await?;
        let (parts, body) = response.into_parts();
        let mut bytes = Vec::new();
        if parts.status.is_success() {
            bytes = read_bounded(body, MAX_CREDENTIALS_BYTES, "credentials").await?;
            bytes = kind.check(bytes).map_err(strange)?;
        }
        Ok(HttpResponse::from_parts(parts, bytes.into()))
    }
}

/// A body, up to so many bytes.
async fn read_bounded(body: HttpResponseBody, most: usize, what: &str) -> Result<Vec<u8>, HttpError> {
    let mut bytes = Vec::new();
    let mut body = body.bytes_stream();
    while let Some(part) = body.next().await {
        bytes.extend_from_slice(&part?);
        if bytes.len() > most {
            return Err(strange(&format!("more than {most} bytes of {what}")));
        }
    }
    Ok(bytes)
}

/// The code of an answer of s3 that is no success, if it is a word.
fn code_of(body: &[u8]) -> Option<&str> {
    const MAX_CODE: usize = 64;
    let text = str::from_utf8(body).ok()?;
    let code = text.split_once("<Code>")?.1.split_once("</Code>")?.0;
    let is_word = code.bytes().all(|byte| byte.is_ascii_alphanumeric());
    (is_word && (1..=MAX_CODE).contains(&code.len())).then_some(code)
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
