//! A pattern of names: the name itself or a glob, in any case.

use globset::{Error, GlobBuilder, GlobMatcher};

/// What `--leaf`, `--node` and species files name materials, nodes and groups by.
#[derive(Debug, Clone)]
pub(crate) struct NamePattern {
    /// In lower case.
    name: String,
    /// `None` for what is no glob.
    glob: Option<GlobMatcher>,
}

impl NamePattern {
    /// From a text.
    ///
    /// # Errors
    /// For what is no glob: [`NamePattern::exactly`] takes it as a name.
    pub(crate) fn compile(text: &str) -> Result<NamePattern, Error> {
        let glob = GlobBuilder::new(text).case_insensitive(true).build()?.compile_matcher();
        Ok(NamePattern { glob: Some(glob), ..NamePattern::exactly(text) })
    }

    /// The name alone, whatever a glob would make of it.
    pub(crate) fn exactly(text: &str) -> NamePattern {
        NamePattern { name: text.to_lowercase(), glob: None }
    }

    /// The pattern in lower case.
    pub(crate) fn text(&self) -> &str {
        &self.name
    }

    /// Whether it is that name, in any case.
    pub(crate) fn is_name(&self, name: &str) -> bool {
        self.name == name.to_lowercase()
    }

    /// Whether it means a name.
    pub(crate) fn matches(&self, name: &str) -> bool {
        self.is_name(name) || self.glob.as_ref().is_some_and(|glob| glob.is_match(name))
    }
}
