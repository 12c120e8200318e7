//! A server made of bytes: what a fuzzer feeds the client, and what the client made of it. Nothing is sent.
//!
//! The first byte chooses the URL. Then answers follow, one for every request, each as a status, headers and a body:
//! see `Script`. Past the end of the script every answer is an empty 404.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use async_trait::async_trait;
use flb_format::Source;
use http::header::{
    CONTENT_ENCODING, CONTENT_LENGTH, CONTENT_RANGE, ETAG, HeaderName, LAST_MODIFIED, LOCATION, RETRY_AFTER,
};
use http::{HeaderMap, HeaderValue, Response, StatusCode, Uri};
use object_store::client::{HttpError, HttpErrorKind, HttpRequest, HttpResponse};

use super::redirect::Reach;
use super::wire::{PrivateName, Wire};
use super::{RemoteSettings, RemoteSource, RemoteUrl};

/// Secret in the query of every URL and in the credentials; never in a message, never at another host.
pub const SECRET: &str = "c0ffee5ec2e7";

const URLS: [&str; 4] = [
    "http://public.example/a.flb?signature=c0ffee5ec2e7",
    "https://public.example/a.flb?signature=c0ffee5ec2e7",
    "http://private.example:8080/a.flb?signature=c0ffee5ec2e7",
    "s3://bucket/a.flb",
];

const STATUSES: [u16; 16] = [206, 206, 206, 206, 200, 302, 301, 303, 307, 308, 404, 412, 416, 429, 503, 500];

/// What a line of a script is before its text.
const HEADERS: [HeaderName; 7] =
    [CONTENT_RANGE, LOCATION, ETAG, LAST_MODIFIED, CONTENT_LENGTH, RETRY_AFTER, CONTENT_ENCODING];

/// Outcome of a script.
#[derive(Debug)]
pub struct Replayed {
    /// The host of the URL, which may see the secret.
    pub host: String,
    /// Every request: its host, whether that is private, and all of its URL and headers as text.
    pub requests: Vec<(String, bool, String)>,
    /// Bytes of bodies that were kept.
    pub bytes: usize,
    /// Every message, of opening and of reading, as displayed and as debugged.
    pub messages: Vec<String>,
}

/// Answers, from bytes: one for the status, then headers (a number of [`HEADERS`], a length, so many bytes) up to a
/// number that is none, then two for the length of the body, which is made up.
struct Script<'a> {
    rest: &'a [u8],
}

impl Script<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.rest.split_first()?;
        self.rest = rest;
        Some(*first)
    }

    fn take(&mut self, count: usize) -> &[u8] {
        let (taken, rest) = self.rest.split_at(count.min(self.rest.len()));
        self.rest = rest;
        taken
    }

    fn answer(&mut self) -> Option<(StatusCode, HeaderMap, Vec<u8>)> {
        let status = STATUSES[usize::from(self.byte()?) % STATUSES.len()];
        let mut headers = HeaderMap::new();
        while let Some(name) = self.byte().and_then(|number| HEADERS.get(usize::from(number))) {
            let length = self.byte().unwrap_or(0);
            if let Ok(value) = HeaderValue::from_bytes(self.take(length.into())) {
                headers.append(name, value);
            }
        }
        let length = u16::from_be_bytes([self.byte().unwrap_or(0), self.byte().unwrap_or(0)]);
        let status = StatusCode::from_u16(status).unwrap_or(StatusCode::OK); // all of the list are
        Some((status, headers, vec![7; length.into()]))
    }
}

/// Hosts that are private are 127.0.0.2, and so are names that begin with "private".
#[derive(Debug)]
struct Scripted {
    answers: Mutex<VecDeque<(StatusCode, HeaderMap, Vec<u8>)>>,
    requests: Mutex<Vec<(String, bool, String)>>,
}

fn address_of(host: &str) -> IpAddr {
    let literal = host.trim_matches(['[', ']']).parse();
    literal.unwrap_or(if host.starts_with("private") {
        IpAddr::from([127, 0, 0, 2])
    } else {
        [1, 1, 1, 1].into()
    })
}

#[async_trait]
impl Wire for Scripted {
    async fn send(
        &self,
        request: HttpRequest,
        reach: Reach,
    ) -> Result<(HttpResponse, Option<IpAddr>), HttpError> {
        let host = request.uri().host().unwrap_or_default().to_owned();
        let address = address_of(&host);
        let is_private = super::is_private(address);
        if reach == Reach::Public && is_private {
            return Err(HttpError::new(HttpErrorKind::Connect, PrivateName));
        }
        let text = |value: &HeaderValue| String::from_utf8_lossy(value.as_bytes()).into_owned();
        let headers = request.headers().iter().map(|(name, value)| format!("{name}: {}\n", text(value)));
        let words = format!("{}\n{}", request.uri(), headers.collect::<String>());
        self.requests.lock().unwrap_or_else(PoisonError::into_inner).push((host, is_private, words));
        let answer = self.answers.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        let (status, headers, body) = answer.unwrap_or((StatusCode::NOT_FOUND, HeaderMap::new(), Vec::new()));
        let mut response = Response::new(body.into());
        (*response.status_mut(), *response.headers_mut()) = (status, headers);
        Ok((response, Some(address)))
    }

    fn is_proxied(&self, _: &Uri) -> bool {
        false
    }
}

/// Message of opening a URL in an environment, if it is one and cannot be opened, as displayed and as debugged. Every
/// answer is 404.
pub fn open_in(url: &str, environment: impl IntoIterator<Item = (OsString, OsString)>) -> String {
    let url = match crate::Location::parse(url) {
        Ok(crate::Location::Remote(url)) => url,
        Ok(crate::Location::File(_)) => return String::new(),
        Err(error) => return format!("{error} {error:?}"),
    };
    let wire = Scripted { answers: Mutex::default(), requests: Mutex::default() };
    let settings =
        RemoteSettings { limit: Duration::from_millis(50), retries: 0, ..RemoteSettings::default() };
    let said = match RemoteSource::open_by(&url, &settings, environment, Some(Arc::new(wire))) {
        Ok(_) => String::new(),
        Err(error) => format!("{error} {error:?}"),
    };
    format!("{url} {url:?} {said}")
}

/// Opens the file that a script serves, and reads three ranges of it.
pub fn replay(script: &[u8]) -> Replayed {
    let mut script = Script { rest: script };
    let url = URLS[usize::from(script.byte().unwrap_or(0)) % URLS.len()];
    let url = RemoteUrl::parse(url).expect("all of the list are URLs");
    let answers = std::iter::from_fn(|| script.answer()).take(100).collect();
    let wire = Arc::new(Scripted { answers: Mutex::new(answers), requests: Mutex::default() });
    // No time to wait, so that no try is followed by another.
    let settings =
        RemoteSettings { limit: Duration::from_millis(50), retries: 0, ..RemoteSettings::default() };
    let environment = [
        ("AWS_ACCESS_KEY_ID", "key"),
        ("AWS_SECRET_ACCESS_KEY", SECRET),
        ("AWS_SESSION_TOKEN", SECRET),
        ("AWS_ENDPOINT", "https://public.example"),
    ]
    .map(|(name, value)| (OsString::from(name), OsString::from(value)));
    let (mut messages, mut bytes) = (Vec::new(), 0);
    match RemoteSource::open_by(&url, &settings, environment, Some(Arc::clone(&wire) as _)) {
        Ok(source) => {
            bytes += source.head.len();
            let length = source.identity.length();
            for (at, count) in [(0, 1), (length / 2, 5000), (length.saturating_sub(100), 100)] {
                let mut buffer = vec![0; count.min(length.saturating_sub(at)) as usize];
                match source.read_exact_at(at, &mut buffer) {
                    Ok(()) => bytes += buffer.len(),
                    Err(error) => messages.extend([error.to_string(), format!("{error:?}")]),
                }
            }
            messages.push(source.identity.describe(&source.object.secrets));
        }
        Err(error) => messages.extend([error.to_string(), format!("{error:?}")]),
    }
    messages.push(format!("{url} {url:?}"));
    let requests = std::mem::take(&mut *wire.requests.lock().unwrap_or_else(PoisonError::into_inner));
    let host = requests.first().map_or(String::new(), |(host, ..)| host.clone());
    Replayed { host, requests, bytes, messages }
}
