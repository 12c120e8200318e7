//! Why a text names no file, and what of a URL messages show.

/// Reason why a text names no file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LocationError {
    /// A URL of a scheme that is not read.
    #[error("{url}: found the scheme {found:?}, expected file, http, https or s3")]
    Scheme {
        /// The URL without its query, user and password.
        url: String,
        /// Scheme of the URL.
        found: String,
    },
    /// A URL that cannot be understood, or lacks a part.
    #[error("{url}: {reason}")]
    Url {
        /// The URL without its query, user and password.
        url: String,
        /// Part that was found, and what was expected.
        reason: String,
    },
    /// The program was built without what reads URLs.
    #[error("{url}: this build reads files only (flb-runtime without its feature `remote`)")]
    NotBuilt {
        /// The URL without its query, user and password.
        url: String,
    },
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
