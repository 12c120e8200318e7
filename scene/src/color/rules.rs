//! Who says what texels mean: the command line, then the species file, by pattern of the material's name.

use flb_format::matter::Surfaces;
use globset::{GlobBuilder, GlobMatcher};

use crate::import::ImportError;

/// Source of a surface's colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum ColorSource {
    /// A texel, or the base colour, is the reflectance.
    Texture,
    /// A texel tints the reflectance of measured leaves.
    Measured,
}

impl ColorSource {
    /// "texture" or "measured".
    pub fn name(self) -> &'static str {
        match self {
            ColorSource::Texture => "texture",
            ColorSource::Measured => "measured",
        }
    }
}

/// Materials, and where their colour comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorRule {
    /// Pattern of names (glob, any case); `None`: every leaf.
    pub pattern: Option<String>,
    /// Source of the materials' colour.
    pub source: ColorSource,
}

/// Measured surfaces of the materials that a pattern matches.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceSet {
    /// Pattern of names (glob, any case).
    pub pattern: String,
    /// Surfaces as leaf and as wood, of the bands of the species' own.
    pub surfaces: Surfaces,
}

/// All that is said of colours.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ColorRules {
    /// Source of every leaf's colour, by the command line.
    pub flag: Option<ColorSource>,
    /// Name of the species file, for messages.
    pub file: String,
    /// Rules of the species file; the first that matches counts.
    pub rules: Vec<ColorRule>,
    /// Surface sets of the species file; the first that matches counts.
    pub sets: Vec<SurfaceSet>,
    /// Whether the species file says what all leaves reflect and let through.
    pub has_surfaces: bool,
}

impl ColorRules {
    /// Whether it is said what a material lets through, whatever its file says.
    pub(super) fn has_surface(&self, name: &str) -> bool {
        self.has_surfaces || self.set(name).is_some()
    }

    /// What is said of a material, and by whom.
    pub(super) fn source(&self, name: &str, is_leaf: bool) -> Option<(ColorSource, String)> {
        if let Some(flag) = self.flag.filter(|_| is_leaf) {
            return Some((flag, format!("--leaf-colour {}", flag.name())));
        }
        let said = |rule: &&ColorRule| match &rule.pattern {
            Some(pattern) => matches(pattern, name),
            None => is_leaf,
        };
        let rule = self.rules.iter().find(said)?;
        Some((rule.source, format!("{}: leaf_colour {}", self.file, rule.source.name())))
    }

    /// The surfaces that are said of a material.
    pub(super) fn set(&self, name: &str) -> Option<&SurfaceSet> {
        self.sets.iter().find(|set| matches(&set.pattern, name))
    }

    /// Checks that every pattern matches one of the names.
    ///
    /// # Errors
    /// [`ImportError::NothingMatched`], [`ImportError::BadPattern`].
    pub fn check(&self, names: &[&str]) -> Result<(), ImportError> {
        let of_rules = self.rules.iter().filter_map(|rule| Some(("leaf_colour", rule.pattern.as_deref()?)));
        let of_sets = self.sets.iter().map(|set| ("surfaces.material", set.pattern.as_str()));
        for (key, pattern) in of_rules.chain(of_sets) {
            let origin = || format!("{}: {key}", self.file);
            let is_name = names.iter().any(|name| name.eq_ignore_ascii_case(pattern));
            if !is_name && let Err(error) = glob(pattern) {
                let reason = error.kind().to_string();
                return Err(ImportError::BadPattern {
                    origin: origin(),
                    pattern: pattern.to_owned(),
                    reason,
                });
            }
            if !names.iter().any(|name| matches(pattern, name)) {
                let materials: Vec<String> = names.iter().map(|name| format!("'{name}'")).collect();
                return Err(ImportError::NothingMatched {
                    origin: origin(),
                    pattern: pattern.to_owned(),
                    materials: materials.join(", "),
                });
            }
        }
        Ok(())
    }
}

fn glob(pattern: &str) -> Result<GlobMatcher, globset::Error> {
    Ok(GlobBuilder::new(pattern).case_insensitive(true).build()?.compile_matcher())
}

/// A material's exact name is a pattern even where it is no glob, as `leaf[` is.
fn matches(pattern: &str, name: &str) -> bool {
    pattern.to_lowercase() == name.to_lowercase() || glob(pattern).is_ok_and(|glob| glob.is_match(name))
}
