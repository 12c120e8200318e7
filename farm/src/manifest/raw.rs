//! A manifest as its text says it.

use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

use super::Budget;
use crate::recipe::Recipe;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Raw {
    pub output: Option<PathBuf>,
    pub merge: Option<bool>,
    #[serde(default)]
    pub include: Vec<Spanned<PathBuf>>,
    #[serde(default)]
    pub bake: Recipe,
    #[serde(default)]
    pub species: Vec<Spanned<RawSpecies>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSpecies {
    pub name: Option<String>,
    pub mesh: Spanned<String>,
    pub gltf_mesh: Option<String>,
    pub species_file: Option<String>,
    #[serde(default)]
    pub plant: toml::Table,
    #[serde(default)]
    pub bake: Recipe,
    #[serde(default)]
    pub budget: Budget,
    #[serde(default)]
    pub variant: Vec<Spanned<RawVariant>>,
}

/// What differs from the species.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawVariant {
    pub name: String,
    pub mesh: Option<String>,
    pub gltf_mesh: Option<String>,
    pub species_file: Option<String>,
    #[serde(default)]
    pub plant: toml::Table,
    #[serde(default)]
    pub bake: Recipe,
    #[serde(default)]
    pub budget: Budget,
}
