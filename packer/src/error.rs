//! Everything that can keep a file from being packed.

use flb_files::FileError;
use flb_format::FormatError;
use flb_format::progress::Cancelled;

/// Reason why nothing was written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the fields repeat the messages")]
#[non_exhaustive]
pub enum PackError {
    /// A file that is read, or a value that is written, breaks the format.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The file cannot be published.
    #[error(transparent)]
    File(#[from] FileError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("no species to write")]
    Empty,
    #[error(
        "two species are named {name:?}; a library's names are unique: bake one of them with another --name"
    )]
    SameName { name: String },
    #[error("{what} is {found}, expected {expected}")]
    Setting { what: &'static str, found: String, expected: &'static str },
    #[error("{what} of species {species:?} is {found}, expected {expected}")]
    Shape { species: String, what: String, found: String, expected: String },
    #[error(
        "base {base} of species {species:?}, band {band}, site {site}: value {found}, expected a \
         finite number of magnitude up to {most}"
    )]
    FieldValue { species: String, base: u8, band: u32, site: usize, found: f32, most: &'static str },
    #[error("{array} of species {species:?}, site {site}: {found}, expected {expected}")]
    MediumValue { species: String, array: &'static str, site: usize, found: String, expected: &'static str },
    #[error("{what} would be {found}, over the format's limit of {limit}")]
    Limit { what: &'static str, found: u64, limit: u64 },
    /// A fault of one species of several.
    #[error("species {name:?}: {source}")]
    OfSpecies { name: String, source: Box<PackError> },
}

impl PackError {
    /// The same with the name of the species where the error has none.
    pub(crate) fn of(self, name: &str) -> PackError {
        match self {
            PackError::FieldValue { base, band, site, found, most, .. } => {
                PackError::FieldValue { species: name.to_owned(), base, band, site, found, most }
            }
            other => PackError::OfSpecies { name: name.to_owned(), source: Box::new(other) },
        }
    }
}
