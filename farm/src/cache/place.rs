//! Where results are kept, as a user names it.

use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};

#[cfg(feature = "remote")]
use flb_runtime::source::RemoteUrl;
use flb_runtime::{Location, LocationError};

/// Folder of results beside a manifest.
const BESIDE: &str = ".flb-cache";

/// Place of results: a folder, or a prefix in a bucket.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// A folder.
    Folder(PathBuf),
    /// `s3://BUCKET/PREFIX`.
    #[cfg(feature = "remote")]
    Bucket(RemoteUrl),
}

impl Place {
    /// Reads the name of a place.
    ///
    /// # Errors
    /// A URL that is malformed, or of another scheme than s3 and file.
    pub fn parse(text: impl AsRef<OsStr>) -> Result<Place, LocationError> {
        let location = Location::parse(text)?;
        if let Some(folder) = location.file() {
            return Ok(Place::Folder(folder.to_owned()));
        }
        #[cfg(feature = "remote")]
        if let Location::Remote(url) = &location
            && url.is_bucket()
        {
            return Ok(Place::Bucket(url.clone()));
        }
        let expected = if cfg!(feature = "remote") { "a folder or s3://BUCKET/PREFIX" } else { "a folder" };
        let reason = format!("found a URL that is no cache of this build, expected {expected}");
        Err(LocationError::Url { url: location.to_string(), reason })
    }

    /// The folder beside a manifest.
    pub fn beside(manifest: &Path) -> Place {
        Place::Folder(manifest.parent().unwrap_or(Path::new("")).join(BESIDE))
    }

    /// The place with a path from the root.
    pub(crate) fn absolute(&self) -> Place {
        match self {
            Place::Folder(folder) => {
                Place::Folder(std::path::absolute(folder).unwrap_or_else(|_| folder.clone()))
            }
            #[cfg(feature = "remote")]
            Place::Bucket(url) => Place::Bucket(url.clone()),
        }
    }

    /// The folder, if it is one.
    pub fn folder(&self) -> Option<&Path> {
        match self {
            Place::Folder(folder) => Some(folder),
            #[cfg(feature = "remote")]
            Place::Bucket(_) => None,
        }
    }
}

/// As a user names it.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Folder(folder) => folder.display().fmt(f),
            #[cfg(feature = "remote")]
            Place::Bucket(url) => url.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_and_buckets_are_places_and_pages_are_none() {
        assert_eq!(Place::parse("a/b"), Ok(Place::Folder("a/b".into())));
        assert_eq!(Place::beside(Path::new("trees/library.toml")), Place::Folder("trees/.flb-cache".into()));
        assert_eq!(Place::beside(Path::new("library.toml")), Place::Folder(".flb-cache".into()));
        let refused = |text: &str| Place::parse(text).expect_err(text).to_string();
        assert!(refused("ftp://host/results").contains("found the scheme"));
        #[cfg(feature = "remote")]
        {
            let place = Place::parse("s3://bucket/results/").expect("a place");
            assert!(
                matches!(place, Place::Bucket(_)) && place.absolute() == place && place.folder().is_none()
            );
            assert_eq!(place.to_string(), "s3://bucket/results/");
            assert!(refused("s3://bucket").contains("expected s3://BUCKET/KEY"));
            let told = refused("https://host/results?signature=c0ffee");
            assert!(
                told.contains("expected a folder or s3://BUCKET/PREFIX") && !told.contains("c0ffee"),
                "{told}"
            );
        }
        #[cfg(not(feature = "remote"))]
        refused("s3://bucket/results");
    }
}
