//! Where a file is, as a user names it: a path on this machine, or a URL.

pub(crate) mod error;

use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};

#[cfg(feature = "remote")]
use crate::source::RemoteUrl;
pub use error::LocationError;
use error::shown;

/// A file on this machine or behind a URL.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Location {
    /// A path; `file:` URLs are paths, too.
    File(PathBuf),
    /// `http`, `https` or `s3`.
    #[cfg(feature = "remote")]
    Remote(RemoteUrl),
}

impl Location {
    /// Parses a text: one that begins with a scheme and `://` is a URL, every other a path.
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

    /// Name of the location in errors: never with a query, which may hold a signature.
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

#[cfg(test)]
mod tests;
