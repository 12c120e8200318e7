//! Why bytes behind a URL could not be read. The URL itself is named by the caller, which knows the file's name.

use std::error::Error;
use std::fmt;
use std::io;
use std::ops::Range;
use std::time::Duration;

use http::StatusCode;
use object_store::client::{HttpError, HttpErrorKind};

use super::answer::{NoRange, Refused};
use super::patience::Enough;
use crate::location::error::shown;

/// Characters of what the client says.
const MAX_REASON: usize = 300;

/// Failure of a request for a range of bytes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RemoteError {
    /// The server does not know ranges, or does not want to serve one.
    #[error(
        "{}: found the answer 200 with the whole file, expected 206 with this range: the server does not serve ranges",
        Bytes(range)
    )]
    NoRanges {
        /// Range that was asked for.
        range: Range<u64>,
    },
    /// Any other answer than the range.
    #[error("{}: found the answer {found}, expected 206 with this range", Bytes(range))]
    Status {
        /// Range that was asked for.
        range: Range<u64>,
        /// The HTTP status.
        found: StatusCode,
    },
    /// The answer 416: no byte of the range is there, it says. A file of no bytes may be one.
    #[error(
        "{}: found the answer 416 Range Not Satisfiable {}, expected 206 with this range",
        Bytes(range), OfLength(*length)
    )]
    Unsatisfiable {
        /// Range that was asked for.
        range: Range<u64>,
        /// Length of the file that the answer states.
        length: Option<u64>,
    },
    /// An answer that says of itself that it is another range, or does not say it in the form of RFC 9110.
    #[error("{}: found the Content-Range {found}, expected this range", Bytes(range))]
    ContentRange {
        /// Range that was asked for.
        range: Range<u64>,
        /// The header in quotes, or nothing in quotes; cut where it is long.
        found: String,
    },
    /// A body that is shorter or longer than the answer's header promised.
    #[error("{}: found {found} bytes, expected {expected}{}", Bytes(range), Reason(reason))]
    Length {
        /// Range that was asked for.
        range: Range<u64>,
        /// Bytes that came.
        found: u64,
        /// Bytes that the range has.
        expected: u64,
        /// Reason why no more came, where that is known.
        reason: Option<String>,
    },
    /// The server took too long.
    #[error("{}: found no whole answer after {seconds} s", Bytes(range))]
    TooSlow {
        /// Range that was asked for.
        range: Range<u64>,
        /// The limit.
        seconds: f64,
    },
    /// An answer that says "not now" to every try that the limit leaves time for.
    #[error(
        "{}: found the answer {found} to each of {tries} tries, expected 206 with this range within {limit_seconds} s",
        Bytes(range)
    )]
    Busy {
        /// Range that was asked for.
        range: Range<u64>,
        /// The HTTP status of the last.
        found: StatusCode,
        /// Requests for the range.
        tries: u32,
        /// The limit for all of them.
        limit_seconds: f64,
    },
    /// An answer that asks to come back after the limit.
    #[error(
        "{}: found the answer {found} that asks to wait {seconds} s, \
         expected 206 with this range within {limit_seconds} s",
        Bytes(range)
    )]
    Wait {
        /// Range that was asked for.
        range: Range<u64>,
        /// The HTTP status.
        found: StatusCode,
        /// Seconds of the answer's Retry-After.
        seconds: u64,
        /// The limit for all tries together.
        limit_seconds: f64,
    },
    /// A redirect that is not followed.
    #[error("{}: {reason}", Bytes(range))]
    Redirect {
        /// Range that was asked for.
        range: Range<u64>,
        /// Redirect that was found, and what was expected.
        reason: String,
    },
    /// No answer came, or one that cannot be understood.
    #[error("{}: {reason}", Bytes(range))]
    Failed {
        /// Range that was asked for.
        range: Range<u64>,
        /// Message of the HTTP client.
        reason: String,
    },
}

impl From<RemoteError> for io::Error {
    fn from(error: RemoteError) -> io::Error {
        let kind = match &error {
            RemoteError::Status { found, .. } => match *found {
                StatusCode::NOT_FOUND | StatusCode::GONE => io::ErrorKind::NotFound,
                StatusCode::UNAUTHORIZED | StatusCode::FORBIDDEN => io::ErrorKind::PermissionDenied,
                _ => io::ErrorKind::Other,
            },
            RemoteError::NoRanges { .. } => io::ErrorKind::Unsupported,
            RemoteError::TooSlow { .. } | RemoteError::Busy { .. } | RemoteError::Wait { .. } => {
                io::ErrorKind::TimedOut
            }
            _ => io::ErrorKind::Other,
        };
        io::Error::new(kind, error)
    }
}

/// What the client's error means for a request for `range`, or for the rest of it, after which there is `enough`.
pub(super) fn explain(
    error: &object_store::Error,
    enough: &Enough,
    range: Range<u64>,
    limit: Duration,
) -> RemoteError {
    let limit_seconds = limit.as_secs_f64();
    let of_request = chain(error).find_map(|error| error.downcast_ref::<NoRange>());
    let range = of_request.and_then(|refused| refused.asked.clone()).unwrap_or(range);
    match (refusal(error), enough) {
        (Some(Refused::Status { found, .. }), Enough::Wait { asked }) => {
            RemoteError::Wait { range, found: *found, seconds: asked.as_secs(), limit_seconds }
        }
        (Some(Refused::Status { found, .. }), Enough::Time { tries }) if *tries > 1 => {
            RemoteError::Busy { range, found: *found, tries: *tries, limit_seconds }
        }
        (Some(Refused::NoAnswer(error)), Enough::Time { .. }) if error.kind() == HttpErrorKind::Timeout => {
            RemoteError::TooSlow { range, seconds: limit_seconds }
        }
        (Some(Refused::Status { found: StatusCode::OK, .. }), _) => RemoteError::NoRanges { range },
        (Some(Refused::Status { found, .. }), _) => RemoteError::Status { range, found: *found },
        (Some(Refused::Unsatisfiable { length }), _) => RemoteError::Unsatisfiable { range, length: *length },
        (Some(Refused::ContentRange(found)), _) => RemoteError::ContentRange { range, found: found.clone() },
        (Some(Refused::Redirect(reason)), _) => RemoteError::Redirect { range, reason: reason.clone() },
        (Some(Refused::Header(reason)), _) => RemoteError::Failed { range, reason: reason.clone() },
        // The second is of whole objects (`bucket.rs`), which are no ranges.
        (Some(Refused::NoAnswer(_) | Refused::Answer { .. }) | None, _) => {
            RemoteError::Failed { range, reason: reason(error) }
        }
    }
}

/// What is wrong with the answer, or that there was none, somewhere in a client's error.
pub(super) fn refusal<'a>(error: &'a (dyn Error + 'static)) -> Option<&'a Refused> {
    chain(error).find_map(|error| error.downcast_ref())
}

/// The words of an error that do not repeat the URL: what lies under the HTTP client's own error, or else the
/// innermost, without what that quotes.
pub(super) fn reason(error: &(dyn Error + 'static)) -> String {
    let errors: Vec<_> = chain(error).collect();
    match errors.iter().rposition(|error| error.is::<HttpError>()) {
        Some(http) => {
            let mut words: Vec<String> = errors[http + 1..].iter().map(ToString::to_string).collect();
            words.dedup(); // a layer that has nothing to add repeats what is below it
            plain(&words.join(": "))
        }
        None => plain(&without_quotes(&errors[errors.len() - 1].to_string())),
    }
}

/// An error and its sources.
fn chain<'a>(error: &'a (dyn Error + 'static)) -> impl Iterator<Item = &'a (dyn Error + 'static)> {
    std::iter::successors(Some(error), |error| (*error).source())
}

/// What stands between quotes may be what a server or a variable held.
fn without_quotes(text: &str) -> String {
    let mut parts = text.split(['"', '\'']);
    let mut words = parts.next().unwrap_or_default().to_owned();
    while let (Some(_), rest) = (parts.next(), parts.next()) {
        words += "...";
        words += rest.unwrap_or_default();
    }
    words
}

/// One line of bounded length, in which URLs have no query.
fn plain(text: &str) -> String {
    let word = |word: &str| if word.contains("://") { shown(word) } else { word.to_owned() };
    let words: Vec<String> = text.split(' ').map(word).collect();
    let text = words.join(" ");
    let mut line: String = text
        .chars()
        .take(MAX_REASON)
        .flat_map(|c| match c.is_control() {
            true => c.escape_default().collect::<Vec<char>>(),
            false => vec![c],
        })
        .collect();
    if text.chars().nth(MAX_REASON).is_some() {
        line += "...";
    }
    line
}

/// "bytes 0 to 65535".
struct Bytes<'a>(&'a Range<u64>);

impl fmt::Display for Bytes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "bytes {} to {}", self.0.start, self.0.end.saturating_sub(1))
    }
}

/// "for a file of 10 bytes".
struct OfLength(Option<u64>);

impl fmt::Display for OfLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(length) => write!(f, "for a file of {length} bytes"),
            None => f.write_str("without the file's length"),
        }
    }
}

struct Reason<'a>(&'a Option<String>);

impl fmt::Display for Reason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.as_ref().map_or(Ok(()), |reason| write!(f, " ({reason})"))
    }
}
