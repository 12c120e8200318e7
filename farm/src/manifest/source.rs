//! The text of a manifest, and errors at places in it.

use flb_scene::ImportError;
use flb_scene::import::{excerpt, in_words};

use super::nearest::with_nearest;

pub(super) type Checked<T> = Result<T, ImportError>;

/// A text, and the name of its file.
pub(super) struct Source {
    pub file: String,
    pub text: String,
    /// Places of the line feeds.
    feeds: Vec<usize>,
}

impl Source {
    pub(super) fn new(file: String, text: String) -> Source {
        let feeds = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect();
        Source { file, text, feeds }
    }

    /// "library.toml: line 12".
    pub(super) fn place(&self, at: usize) -> String {
        format!("{}: line {}", self.file, self.line(at))
    }

    fn line(&self, at: usize) -> usize {
        1 + self.feeds.partition_point(|feed| *feed < at)
    }

    /// A value that cannot be, at a byte of the text.
    pub(super) fn malformed(&self, at: usize, place: &str, found: &str, expected: &str) -> ImportError {
        ImportError::Malformed {
            file: self.file.clone(),
            place: format!("line {}, {place}", self.line(at)),
            found: excerpt(found.to_owned()),
            expected: expected.to_owned(),
        }
    }

    /// What the parser says, with its line and column, and the key that an unknown one may have meant.
    pub(super) fn syntax(&self, error: &toml::de::Error) -> ImportError {
        let message = with_nearest(&in_words(error.to_string().trim_end()));
        ImportError::Syntax { file: self.file.clone(), message: excerpt(message) }
    }
}
