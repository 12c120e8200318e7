//! Why bytes behind a URL could not be read. The URL itself is named by whoever knows the file's name.

use std::error::Error;
use std::fmt;
use std::io;
use std::ops::Range;

use http::StatusCode;
use object_store::client::HttpError;

use super::client::Refused;

/// What went wrong with a request for a range of bytes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RemoteError {
    /// The server does not know ranges, or does not want to serve one.
    #[error(
        "{}: found the answer 200 with the whole file, expected 206 with this range: the server does not serve ranges",
        Bytes(range)
    )]
    NoRanges {
        /// What was asked for.
        range: Range<u64>,
    },
    /// Any other answer than the range.
    #[error("{}: found the answer {found}, expected 206 with this range", Bytes(range))]
    Status {
        /// What was asked for.
        range: Range<u64>,
        /// The HTTP status.
        found: StatusCode,
    },
    /// An answer that says of itself that it is another range, or does not say it in the form of RFC 9110.
    #[error("{}: found the Content-Range {found:?}, expected this range", Bytes(range))]
    ContentRange {
        /// What was asked for.
        range: Range<u64>,
        /// The header, or nothing.
        found: String,
    },
    /// A body that is shorter or longer than the answer's header promised.
    #[error("{}: found {found} bytes, expected {expected}{}", Bytes(range), Reason(reason))]
    Length {
        /// What was asked for.
        range: Range<u64>,
        /// Bytes that came.
        found: u64,
        /// Bytes that the range has.
        expected: u64,
        /// Why no more came, where that is known.
        reason: Option<String>,
    },
    /// The server took too long.
    #[error("{}: found no whole answer after {seconds} s", Bytes(range))]
    TooSlow {
        /// What was asked for.
        range: Range<u64>,
        /// The limit.
        seconds: f64,
    },
    /// No answer came, or one that cannot be understood.
    #[error("{}: {reason}", Bytes(range))]
    Failed {
        /// What was asked for.
        range: Range<u64>,
        /// What the client says.
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
            RemoteError::TooSlow { .. } => io::ErrorKind::TimedOut,
            _ => io::ErrorKind::Other,
        };
        io::Error::new(kind, error)
    }
}

/// What the client's error means for a request for `range`.
pub fn explain(error: &object_store::Error, range: Range<u64>) -> RemoteError {
    match find::<Refused>(error) {
        Some(Refused::Status(StatusCode::OK)) => RemoteError::NoRanges { range },
        Some(Refused::Status(found)) => RemoteError::Status { range, found: *found },
        Some(Refused::ContentRange(found)) => RemoteError::ContentRange { range, found: found.clone() },
        None => RemoteError::Failed { range, reason: reason(error) },
    }
}

/// The words of an error that do not repeat the URL: what lies under the HTTP client's own error, or else the innermost.
pub fn reason(error: &(dyn Error + 'static)) -> String {
    let from = match chain(error).position(|error| error.is::<HttpError>()) {
        Some(http) => http + 1,
        None => chain(error).count() - 1,
    };
    let words: Vec<String> = chain(error).skip(from).map(ToString::to_string).collect();
    words.join(": ")
}

/// The first error of this type in a chain of sources.
fn find<'a, E: Error + 'static>(error: &'a (dyn Error + 'static)) -> Option<&'a E> {
    chain(error).find_map(|error| error.downcast_ref())
}

/// An error and its sources.
fn chain<'a>(error: &'a (dyn Error + 'static)) -> impl Iterator<Item = &'a (dyn Error + 'static)> {
    std::iter::successors(Some(error), |error| (*error).source())
}

/// "bytes 0 to 65535".
struct Bytes<'a>(&'a Range<u64>);

impl fmt::Display for Bytes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "bytes {} to {}", self.0.start, self.0.end.saturating_sub(1))
    }
}

struct Reason<'a>(&'a Option<String>);

impl fmt::Display for Reason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.as_ref().map_or(Ok(()), |reason| write!(f, " ({reason})"))
    }
}
