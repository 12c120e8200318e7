//! Where a file is, as a user names it: a path on this machine, or a URL.

use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};

#[cfg(feature = "remote")]
pub use crate::source::remote::RemoteUrl;

/// A file on this machine or behind a URL.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Location {
    /// A path; `file:` URLs are paths, too.
    File(PathBuf),
    /// `http`, `https` or `s3`.
    #[cfg(feature = "remote")]
    Remote(RemoteUrl),
}

/// Why a text names no file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LocationError {
    /// A URL of a scheme that is not read.
    #[error("{url}: found the scheme {found:?}, expected file, http, https or s3")]
    Scheme {
        /// The URL without its query, user and password.
        url: String,
        /// Its scheme.
        found: String,
    },
    /// A URL that cannot be understood, or lacks a part.
    #[error("{url}: {reason}")]
    Url {
        /// The URL without its query, user and password.
        url: String,
        /// What was found and expected.
        reason: String,
    },
    /// The program was built without what reads URLs.
    #[error("{url}: this build reads files only (flb-runtime without its feature `remote`)")]
    NotBuilt {
        /// The URL without its query, user and password.
        url: String,
    },
}

impl Location {
    /// What begins with a scheme and `://` is a URL, everything else a path.
    ///
    /// # Errors
    /// A URL that is malformed, of an unknown scheme, or that carries a user or a password.
    pub fn parse(text: impl AsRef<OsStr>) -> Result<Location, LocationError> {
        let text = text.as_ref();
        match text.to_str().and_then(|text| Some((text, scheme_of(text)?))) {
            None => Ok(Location::File(text.into())),
            Some((url, scheme)) => parse_url(url, &scheme.to_ascii_lowercase()),
        }
    }

    /// The path, of a file on this machine.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Location::File(path) => Some(path),
            #[cfg(feature = "remote")]
            Location::Remote(_) => None,
        }
    }

    /// What errors call it: never with a query, which may hold a signature.
    pub fn name(&self) -> PathBuf {
        match self {
            Location::File(path) => path.clone(),
            #[cfg(feature = "remote")]
            Location::Remote(url) => url.to_string().into(),
        }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.name().display().fmt(f)
    }
}

/// The scheme of a URL (RFC 3986, section 3.1), if the text is one. A single letter is a drive of Windows.
fn scheme_of(text: &str) -> Option<&str> {
    let (scheme, _) = text.split_once("://")?;
    let mut letters = scheme.chars();
    let fits = letters.next().is_some_and(|c| c.is_ascii_alphabetic())
        && letters.all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    (fits && scheme.len() > 1).then_some(scheme)
}

fn parse_url(text: &str, scheme: &str) -> Result<Location, LocationError> {
    let url = shown(text);
    match scheme {
        #[cfg(feature = "remote")]
        "file" => crate::source::remote::file_path(text).map(Location::File),
        #[cfg(feature = "remote")]
        "http" | "https" | "s3" => RemoteUrl::parse(text).map(Location::Remote),
        #[cfg(not(feature = "remote"))]
        "file" | "http" | "https" | "s3" => Err(LocationError::NotBuilt { url }),
        _ => Err(LocationError::Scheme { url, found: scheme.to_owned() }),
    }
}

/// A URL as messages show it: without user, password, query and fragment, any of which may be a secret.
pub(crate) fn shown(url: &str) -> String {
    let (scheme, rest) = url.split_once("://").unwrap_or(("", url));
    let (place, query) = match rest.find(['?', '#']) {
        Some(end) => (&rest[..end], &rest[end..]),
        None => (rest, ""),
    };
    // Of a URL that is none, every part before an @ may be a password, slashes or not.
    let host_start = match host_start_of(url, place) {
        Some(start) => start,
        None => place.rfind('@').map_or(0, |at| at + 1),
    };
    let query = if query.starts_with('?') { "?..." } else { "" };
    let place: String = place[host_start..]
        .chars()
        .flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] })
        .collect();
    format!("{scheme}://{place}{query}")
}

/// Where the host begins in what follows the scheme of a URL that is one, up to its query.
#[cfg(feature = "remote")]
fn host_start_of(url: &str, place: &str) -> Option<usize> {
    let parsed = url::Url::parse(url).ok()?;
    // Slashes of either kind that HTTP takes for the two before the host, and more of them.
    let slashes = place.len() - place.trim_start_matches(['/', '\\']).len();
    let host_end = place[slashes..].find(['/', '\\']).map_or(place.len(), |end| slashes + end);
    let has_user = !parsed.username().is_empty() || parsed.password().is_some();
    match place[..host_end].rfind('@') {
        Some(at) => Some(at + 1),
        None if has_user => None,
        None => Some(0),
    }
}

/// Nothing here knows what a URL is.
#[cfg(not(feature = "remote"))]
fn host_start_of(_: &str, _: &str) -> Option<usize> {
    None
}

#[cfg(test)]
mod tests;
