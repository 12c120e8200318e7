//! URLs that name one file: checked once, so that nothing behind fails on their form.

use std::fmt;
use std::path::PathBuf;

use crate::location::error::{LocationError, shown};

/// `http`, `https` or `s3`, with a host (a bucket) and without user, password and fragment.
#[derive(Clone, PartialEq, Eq)]
pub struct RemoteUrl(url::Url);

impl RemoteUrl {
    pub(crate) fn parse(text: &str) -> Result<RemoteUrl, LocationError> {
        let refuse = |reason: &str| LocationError::Url { url: shown(text), reason: reason.to_owned() };
        let mut url = url::Url::parse(text).map_err(|error| refuse(&error.to_string()))?;
        if !url.username().is_empty() || url.password().is_some() {
            return Err(refuse("holds a user or a password, which a list of processes shows to everyone"));
        }
        url.set_fragment(None);
        if url.scheme() == "s3" {
            if url.host_str().is_none_or(str::is_empty) {
                return Err(refuse("names no bucket, expected s3://BUCKET/KEY"));
            }
            let fits = |c: char| c.is_ascii_alphanumeric() || "-._".contains(c);
            if !url.host_str().is_some_and(|bucket| bucket.len() <= 255 && bucket.chars().all(fits)) {
                return Err(refuse("names no bucket, expected letters, digits, dots, - and _, 255 at most"));
            }
            if url.port().is_some() || url.query().is_some() {
                return Err(refuse("has a port or a query, expected s3://BUCKET/KEY alone"));
            }
            if url.path().trim_matches('/').is_empty() {
                return Err(refuse("names no object, expected s3://BUCKET/KEY"));
            }
        }
        // The HTTP client has rules of its own, and takes them for granted.
        http::Uri::try_from(url.as_str()).map_err(|error| refuse(&error.to_string()))?;
        Ok(RemoteUrl(url))
    }

    /// Tells URLs of s3 from those of HTTP.
    pub fn is_bucket(&self) -> bool {
        self.0.scheme() == "s3"
    }

    pub(super) fn url(&self) -> &url::Url {
        &self.0
    }
}

/// As it is displayed: a query may be a secret.
impl fmt::Debug for RemoteUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "RemoteUrl({self})")
    }
}

impl fmt::Display for RemoteUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&shown(self.0.as_str()))
    }
}

/// The path that a `file:` URL names.
pub(crate) fn file_path(text: &str) -> Result<PathBuf, LocationError> {
    let refuse = |reason: String| LocationError::Url { url: shown(text), reason };
    let url = url::Url::parse(text).map_err(|error| refuse(error.to_string()))?;
    url.to_file_path().map_err(|()| refuse("expected a path on this machine".to_owned()))
}
