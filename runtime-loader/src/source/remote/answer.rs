//! What an answer's status and headers say, before anything reads its body: the range that was asked for, or why not.

use std::ops::Range;
use std::time::{Duration, SystemTime};

use chrono::DateTime;
use http::header::{
    CONTENT_ENCODING, CONTENT_LENGTH, CONTENT_RANGE, DATE, ETAG, HeaderName, LAST_MODIFIED, RETRY_AFTER,
};
use http::{HeaderMap, StatusCode};
use object_store::client::HttpError;

use super::secrets::Secrets;
use crate::location::error::shown;

/// Characters of a server that a message repeats.
const MAX_SHOWN: usize = 200;
/// Of an ETag, which every later request carries.
const MAX_TAG_BYTES: usize = 1024;

/// Why a request brought no range.
#[derive(Debug, thiserror::Error)]
pub(super) enum Refused {
    #[error("the answer {found}")]
    Status {
        found: StatusCode,
        /// How long the server asks to wait.
        wait: Option<Duration>,
    },
    /// Of a whole object or a list, with the code that s3 gives.
    #[error("the answer {found}{}", code.as_ref().map(|code| format!(" ({code})")).unwrap_or_default())]
    Answer { found: StatusCode, code: Option<String> },
    /// The answer 416, and the length of the file where it says it.
    #[error("the answer 416 Range Not Satisfiable")]
    Unsatisfiable { length: Option<u64> },
    /// Is no form of the range that was asked for.
    #[error("the Content-Range {0}")]
    ContentRange(String),
    /// Says something that no good server says.
    #[error("{0}")]
    Header(String),
    /// Leads to where this may not go.
    #[error("{0}")]
    Redirect(String),
    /// Nothing came that could be judged.
    #[error("no answer")]
    NoAnswer(#[source] HttpError),
}

/// Why a request for a range brought none, and which range that was: the rest of a body that was cut is one of its own.
#[derive(Debug, thiserror::Error)]
#[error("no range")]
pub(super) struct NoRange {
    pub asked: Option<Range<u64>>,
    #[source]
    pub refused: Refused,
}

/// The headers of an answer that is the range asked for, those left out that nothing here reads.
pub(super) fn judge(
    asked: &Range<u64>,
    status: StatusCode,
    headers: &HeaderMap,
    secrets: &Secrets,
) -> Result<HeaderMap, Refused> {
    let found = headers.get(CONTENT_RANGE).map_or(&[][..], |value| value.as_bytes());
    match status {
        StatusCode::PARTIAL_CONTENT => {}
        StatusCode::RANGE_NOT_SATISFIABLE => {
            return Err(Refused::Unsatisfiable { length: length_of(found) });
        }
        _ => return Err(Refused::Status { found: status, wait: wait_of(headers, SystemTime::now()) }),
    }
    let bytes = bytes_of(found, asked).ok_or_else(|| Refused::ContentRange(quoted(found, secrets)))?;
    if let Some(coding) = headers.get(CONTENT_ENCODING).map(|value| value.as_bytes()).filter(|coding| {
        [&b"gzip"[..], b"x-gzip", b"deflate", b"br", b"zstd", b"compress"]
            .iter()
            .any(|known| coding.eq_ignore_ascii_case(known))
    }) {
        let found = quoted(coding, secrets);
        return Err(Refused::Header(format!(
            "found the Content-Encoding {found}, expected the bytes as they are"
        )));
    }
    let tag_bytes = headers.get(ETAG).map_or(0, |tag| tag.len());
    if tag_bytes > MAX_TAG_BYTES {
        return Err(Refused::Header(format!(
            "found an ETag of {tag_bytes} bytes, expected {MAX_TAG_BYTES} at most"
        )));
    }
    for name in [ETAG, LAST_MODIFIED] {
        if let Some(value) = headers.get(&name).filter(|value| value.to_str().is_err()) {
            let found = quoted(value.as_bytes(), secrets);
            let name = if name == ETAG { "ETag" } else { "Last-Modified" };
            return Err(Refused::Header(format!("found the {name} {found}, expected visible ASCII")));
        }
    }
    let kept = |name: HeaderName| headers.get(&name).map(|value| (name, value.clone()));
    let mut kept: HeaderMap = [ETAG, LAST_MODIFIED, CONTENT_RANGE].into_iter().filter_map(kept).collect();
    // Of this answer, and only ever a number: the body is held against the range.
    kept.insert(CONTENT_LENGTH, bytes.into());
    Ok(kept)
}

/// Length of a Content-Range (RFC 9110, section 14.4), if it is the one asked for, cut at the end of the file.
fn bytes_of(found: &[u8], asked: &Range<u64>) -> Option<u64> {
    let found = str::from_utf8(found).ok()?;
    let (range, length) = found.trim().strip_prefix("bytes ")?.split_once('/')?;
    let (first, last) = range.split_once('-')?;
    let number = |text: &str| text.parse::<u64>().ok().filter(|_| !text.starts_with('+'));
    let (first, last, length) = (number(first)?, number(last)?, number(length)?);
    let end = last.checked_add(1).filter(|&end| end == asked.end.min(length) && end > first)?;
    (first == asked.start && length < u64::MAX).then_some(end - first)
}

/// What a Content-Range says of the length where it names no range.
fn length_of(found: &[u8]) -> Option<u64> {
    let length = str::from_utf8(found).ok()?.trim().strip_prefix("bytes */")?;
    length.parse().ok().filter(|_| !length.starts_with('+'))
}

/// The bytes that a request's Range header names, as `object_store` writes it.
pub(super) fn range_of(header: &[u8]) -> Option<Range<u64>> {
    let (first, last) = str::from_utf8(header).ok()?.strip_prefix("bytes=")?.split_once('-')?;
    Some(first.parse().ok()?..last.parse::<u64>().ok()?.checked_add(1)?)
}

/// Retry-After (RFC 9110, section 10.2.3): seconds, or a date, which is held against the server's own clock where the
/// answer says it.
fn wait_of(headers: &HeaderMap, now: SystemTime) -> Option<Duration> {
    let text = |name: HeaderName| Some(headers.get(name)?.to_str().ok()?.trim());
    let value = text(RETRY_AFTER)?;
    if !value.is_empty() && value.bytes().all(|byte| byte.is_ascii_digit()) {
        return Some(Duration::from_secs(value.parse().unwrap_or(u64::MAX))); // more digits than fit are many seconds
    }
    let date = |text: &str| Some(DateTime::parse_from_rfc2822(text).ok()?.timestamp());
    let now = text(DATE).and_then(date).or_else(|| {
        Some(now.duration_since(SystemTime::UNIX_EPOCH).ok()?.as_secs() as i64) // fits for 292 billion years
    })?;
    Some(Duration::from_secs(u64::try_from(date(value)?.saturating_sub(now)).unwrap_or(0)))
}

/// What a server sent, in quotes, without secrets, control characters escaped, cut.
pub(super) fn quoted(found: &[u8], secrets: &Secrets) -> String {
    cut(&secrets.hide(found, 4 * MAX_SHOWN + 4))
}

/// The same of a URL, which is shown without query and fragment. Secrets go first: they may hold what ends a URL's
/// path.
pub(super) fn quoted_url(found: &str, secrets: &Secrets) -> String {
    let found = secrets.hide(found.as_bytes(), found.len());
    cut(shown(&String::from_utf8_lossy(&found)).as_bytes())
}

fn cut(found: &[u8]) -> String {
    let text = String::from_utf8_lossy(&found[..found.len().min(4 * MAX_SHOWN)]);
    let shown: String = text.chars().take(MAX_SHOWN).collect();
    let cut = if shown.len() < found.len() && text.chars().count() >= MAX_SHOWN { "..." } else { "" };
    format!("{shown:?}{cut}")
}

#[cfg(test)]
mod tests;
