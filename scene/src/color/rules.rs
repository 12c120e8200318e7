//! Who says what texels mean: the command line, then the species file, by pattern of the material's name.

use flb_format::matter::Surfaces;
use globset::{GlobBuilder, GlobMatcher};

use crate::import::ImportError;

/// Keys of species files.
const LEAF_KEY: &str = "leaf_colour";
const WOOD_KEY: &str = "wood_colour";

/// Source of a surface's colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum ColorSource {
    /// A texel, or the base colour, is the reflectance.
    Texture,
    /// A texel tints the reflectance of what was measured.
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
    /// Pattern of names (glob, any case); `None`: every leaf, or all wood.
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
    /// Source of the colour of all wood, by the command line.
    pub wood_flag: Option<ColorSource>,
    /// Name of the species file, for messages.
    pub file: String,
    /// Rules of the species file for leaves; the first that matches counts. Patterns may match wood.
    pub rules: Vec<ColorRule>,
    /// Rules of the species file for wood, before those.
    pub wood_rules: Vec<ColorRule>,
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
        let (flag, kind) = if is_leaf { (self.flag, "leaf") } else { (self.wood_flag, "wood") };
        if let Some(flag) = flag {
            return Some((flag, format!("--{kind}-colour {}", flag.name())));
        }
        let said = |of_own_kind: bool, rule: &&ColorRule| match &rule.pattern {
            Some(pattern) => matches(pattern, name),
            None => of_own_kind,
        };
        let found = |rules: &[ColorRule], key: &str, of_own_kind: bool| {
            let rule = rules.iter().find(|rule| said(of_own_kind, rule))?;
            Some((rule.source, format!("{}: {key} {}", self.file, rule.source.name())))
        };
        let of_wood = || found(&self.wood_rules, WOOD_KEY, true);
        if is_leaf { None } else { of_wood() }.or_else(|| found(&self.rules, LEAF_KEY, is_leaf))
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
        let of_rules = [(LEAF_KEY, &self.rules), (WOOD_KEY, &self.wood_rules)];
        let of_rules = of_rules.into_iter().flat_map(|(key, rules)| {
            rules.iter().filter_map(move |rule| Some((key, rule.pattern.as_deref()?)))
        });
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
