//! The species file (TOML): what a mesh cannot say about itself.
//!
//! ```toml
//! name = "oak"               # default: the mesh's file name
//! up = "z"                   # axis that points up in the mesh, "y" or "z"
//! unit_m = 0.01              # metres per unit of the mesh
//! gltf_mesh = "Oak"          # the one mesh of a glTF to read, by name or as "#3"; "*": all as one plant
//! nodes = ["Oak_LOD0"]       # nodes or groups to read, with all below them; default: all
//! leaf = ["leaves*"]         # material name patterns, any case
//! wood = ["bark", "stem*"]
//! ignore = ["ground"]
//! ignore_alpha = false       # keep what alpha would cut away, as the paper does
//! ignore_vertex_colours = false # take all vertices for white: colours that are data, such as wind
//!
//! [[optics]]                 # one per band, in order; default: the paper's R, G, B
//! name = "R"
//! leaf = { sigma_a = 0.109, fs = 0.055, bs = 0.070 }   # or g instead of fs and bs
//! wood = { sigma_a = 0.109, g = -1.0 }
//! ```
//!
//! Those optics are the papers'. For the `physical` model, either surfaces per band
//!
//! ```toml
//! [[surfaces]]               # one per band, in order; default: Knapp and Carter's R, G, B
//! name = "R"
//! leaf = { reflectance = 0.07, transmittance = 0.055 }
//! wood = { reflectance = 0.12 }
//! ```
//!
//! or what the leaves are made of, from which PROSPECT computes them; the values are the defaults:
//!
//! ```toml
//! [leaf_model]
//! structure = 1.5            # plates that scatter as the leaf does, 1 to 5
//! chlorophyll_ug_cm2 = 40.0
//! carotenoids_ug_cm2 = 8.0
//! anthocyanins_ug_cm2 = 0.0
//! water_cm = 0.01
//! dry_matter_g_cm2 = 0.009
//! wood = [0.15, 0.12, 0.09]  # reflectance, one per band; default: common bark
//! # bands = [{ name = "NIR", nm = [750, 900] }]   # means within 400..=900; default: R, G, B of linear sRGB
//! ```
//!
//! Materials that differ, such as flowers, have surfaces of their own, in the same bands:
//!
//! ```toml
//! [[surfaces]]               # one per band; without a material: everything else
//! material = "petal*"
//! name = "R"
//! leaf = { reflectance = 0.6, transmittance = 0.3 }    # leaf or wood may be left out: as everything else
//! ```
//!
//! Whether a texel is the reflectance (`texture`) or a tint of the surfaces above (`measured`), for all leaves or by
//! material; default: by how near the two are.
//!
//! ```toml
//! leaf_colour = "texture"    # or: [{ material = "petal*", colour = "texture" }, { colour = "measured" }]
//! wood_colour = "measured"   # the same for wood
//! ```

mod color;
mod surfaces;

use flb_format::text::is_hidden;
use std::path::Path;

use flb_format::matter::{BandOptics, ClassOptics, Optics, Surfaces};
use serde::Deserialize;

use crate::classify::SpeciesRules;
use crate::color::{ColorRule, ColorRules, SurfaceSet};
use crate::import::{ImportError, ImportSettings, TEXT_BYTES, Up, excerpt, in_words, read_text};
use color::RawColor;
use surfaces::{RawLeafModel, RawSurface};

/// Bands that a field can have.
pub const MAX_BANDS: usize = 64;

/// Patterns of a class, and bytes of a pattern: each is tried on every material.
const MAX_PATTERNS: usize = 256;
const MAX_PATTERN_BYTES: usize = 256;

/// A parsed and validated species file.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesFile {
    /// The file's name.
    pub file: String,
    /// The species' name.
    pub name: Option<String>,
    /// Axis that points up in the mesh.
    pub up: Option<Up>,
    /// Metres per unit, above 0.
    pub unit_m: Option<f64>,
    /// The one mesh of a glTF to read.
    pub gltf_mesh: Option<String>,
    /// Patterns of the nodes or groups that are read.
    pub nodes: Vec<String>,
    /// Patterns of leaf materials.
    pub leaf: Vec<String>,
    /// Patterns of wood materials.
    pub wood: Vec<String>,
    /// Patterns of materials to leave out.
    pub ignore: Vec<String>,
    /// Whether every texel of a leaf card is taken for present.
    pub ignore_alpha: bool,
    /// Whether all vertices are taken for white.
    pub ignore_vertex_colors: bool,
    /// Optics of the `paper` model, validated; `None` means the default.
    pub optics: Option<Optics>,
    /// Surfaces of the `physical` model, validated, and computed if the file gives a leaf model; `None` means the
    /// default.
    pub surfaces: Option<Surfaces>,
    /// Surfaces of materials that have others.
    pub sets: Vec<SurfaceSet>,
    /// Rules of which leaves' texels are the reflectance.
    pub leaf_color: Vec<ColorRule>,
    /// Rules of which wood's texels are the reflectance.
    pub wood_color: Vec<ColorRule>,
    /// The file's bytes, for digests and sources.
    pub blake3: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    name: Option<String>,
    up: Option<Up>,
    unit_m: Option<f64>,
    gltf_mesh: Option<String>,
    #[serde(default)]
    nodes: Vec<String>,
    #[serde(default)]
    leaf: Vec<String>,
    #[serde(default)]
    wood: Vec<String>,
    #[serde(default)]
    ignore: Vec<String>,
    #[serde(default)]
    ignore_alpha: bool,
    #[serde(default)]
    ignore_vertex_colours: bool,
    optics: Option<Vec<RawBand>>,
    surfaces: Option<Vec<RawSurface>>,
    leaf_colour: Option<RawColor>,
    wood_colour: Option<RawColor>,
    leaf_model: Option<RawLeafModel>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawBand {
    name: String,
    leaf: RawOptics,
    wood: RawOptics,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawOptics {
    sigma_a: f64,
    g: Option<f64>,
    fs: Option<f64>,
    bs: Option<f64>,
}

impl SpeciesFile {
    /// Reads and validates the file at `path`.
    ///
    /// # Errors
    /// [`ImportError::Io`]; [`ImportError::Syntax`] with line and column for what is no TOML or an
    /// unknown key; [`ImportError::Malformed`] for a value out of its range.
    pub fn read(path: &Path) -> Result<SpeciesFile, ImportError> {
        let (file, text) = read_text(path, TEXT_BYTES)?;
        let mut species = SpeciesFile::parse(&file, text.strip_prefix('\u{feff}').unwrap_or(&text))?;
        species.blake3 = blake3::hash(text.as_bytes()).to_hex().to_string();
        Ok(species)
    }

    /// Parses a species file from text; `file` is for messages.
    pub fn parse(file: &str, text: &str) -> Result<SpeciesFile, ImportError> {
        let raw: Raw = toml::from_str(text).map_err(|error| ImportError::Syntax {
            file: file.to_owned(),
            message: excerpt(in_words(error.to_string().trim_end())),
        })?;
        let malformed = |place: &str, found: String, expected: &str| ImportError::Malformed {
            file: file.to_owned(),
            place: place.to_owned(),
            found,
            expected: expected.to_owned(),
        };
        if raw.name.as_ref().is_some_and(|name| name.trim().is_empty() || name.chars().any(is_hidden)) {
            return Err(malformed("name", format!("{:?}", raw.name.unwrap_or_default()), "a printable name"));
        }
        if let Some(unit_m) = raw.unit_m.filter(|unit_m| !(unit_m.is_finite() && *unit_m > 0.0)) {
            return Err(malformed("unit_m", unit_m.to_string(), "a finite number of metres above 0"));
        }
        let lists =
            [("nodes", &raw.nodes), ("leaf", &raw.leaf), ("wood", &raw.wood), ("ignore", &raw.ignore)];
        for (key, patterns) in lists {
            if patterns.len() > MAX_PATTERNS {
                return Err(malformed(key, format!("{} patterns", patterns.len()), "at most 256 patterns"));
            }
            if let Some(long) = patterns.iter().find(|pattern| pattern.len() > MAX_PATTERN_BYTES) {
                return Err(malformed(
                    key,
                    format!("a pattern of {} bytes", long.len()),
                    "at most 256 bytes",
                ));
            }
        }
        let optics = match raw.optics {
            Some(bands) => Some(validate_optics(bands, &malformed)?),
            None => None,
        };
        let surfaces::Resolved { surfaces, sets } =
            surfaces::resolve(raw.surfaces, raw.leaf_model, &malformed)?;
        Ok(SpeciesFile {
            file: file.to_owned(),
            name: raw.name,
            up: raw.up,
            unit_m: raw.unit_m,
            gltf_mesh: raw.gltf_mesh,
            nodes: raw.nodes,
            leaf: raw.leaf,
            wood: raw.wood,
            ignore: raw.ignore,
            ignore_alpha: raw.ignore_alpha,
            ignore_vertex_colors: raw.ignore_vertex_colours,
            optics,
            surfaces,
            sets,
            leaf_color: color::resolve("leaf_colour", raw.leaf_colour, &malformed)?,
            wood_color: color::resolve("wood_colour", raw.wood_colour, &malformed)?,
            blake3: blake3::hash(text.as_bytes()).to_hex().to_string(),
        })
    }

    /// Patterns of the file's materials.
    pub fn rules(&self) -> SpeciesRules {
        let (leaf, wood, ignore) = (self.leaf.clone(), self.wood.clone(), self.ignore.clone());
        SpeciesRules { file: self.file.clone(), leaf, wood, ignore }
    }

    /// Rules of colour in the file.
    pub fn color_rules(&self) -> ColorRules {
        ColorRules {
            file: self.file.clone(),
            rules: self.leaf_color.clone(),
            wood_rules: self.wood_color.clone(),
            sets: self.sets.clone(),
            has_surfaces: self.surfaces.is_some(),
            ..ColorRules::default()
        }
    }

    /// Import settings of the file; `over` (the command line) wins.
    pub fn import_settings(&self, over: &ImportSettings) -> ImportSettings {
        ImportSettings {
            up: over.up.or(self.up),
            unit_m: over.unit_m.or(self.unit_m),
            gltf_mesh: over.gltf_mesh.clone().or_else(|| self.gltf_mesh.clone()),
            nodes: if over.nodes.is_empty() { self.nodes.clone() } else { over.nodes.clone() },
            split: over.split.clone(),
            ignore_vertex_colors: over.ignore_vertex_colors || self.ignore_vertex_colors,
            offset_m: over.offset_m,
        }
    }
}

type Malformed<'a> = dyn Fn(&str, String, &str) -> ImportError + 'a;

fn validate_optics(bands: Vec<RawBand>, malformed: &Malformed) -> Result<Optics, ImportError> {
    validate_names("optics", bands.iter().map(|band| band.name.as_str()), malformed)?;
    let check = |(index, band): (usize, RawBand)| {
        let leaf = validate_class(&format!("optics[{index}].leaf"), &band.leaf, malformed)?;
        let wood = validate_class(&format!("optics[{index}].wood"), &band.wood, malformed)?;
        Ok(BandOptics { name: band.name, leaf, wood })
    };
    Ok(Optics { bands: bands.into_iter().enumerate().map(check).collect::<Result<_, _>>()? })
}

/// As many bands under `key` as a field can have, each with a name of its own.
fn validate_names<'a>(
    key: &str,
    names: impl ExactSizeIterator<Item = &'a str>,
    malformed: &Malformed,
) -> Result<(), ImportError> {
    if !(1..=MAX_BANDS).contains(&names.len()) {
        return Err(malformed(key, format!("{} bands", names.len()), "1..=64 bands"));
    }
    let mut taken: Vec<&str> = Vec::with_capacity(names.len());
    for (index, name) in names.enumerate() {
        let place = format!("{key}[{index}].name");
        if name.trim().is_empty() {
            return Err(malformed(&place, format!("{name:?}"), "a name"));
        }
        if taken.contains(&name) {
            return Err(malformed(&place, format!("{name:?} again"), "a name of its own"));
        }
        taken.push(name);
    }
    Ok(())
}

/// g = (fs - bs) / (fs + bs), from the shares that are scattered forwards and back (lighting model,
/// section 2).
fn validate_class(place: &str, raw: &RawOptics, malformed: &Malformed) -> Result<ClassOptics, ImportError> {
    let within = |key: &str, value: f64, low: f64, high: f64| match (low..=high).contains(&value) {
        true => Ok(value),
        false => Err(malformed(&format!("{place}.{key}"), value.to_string(), &format!("{low}..={high}"))),
    };
    let sigma_a = within("sigma_a", raw.sigma_a, 0.0, 1.0)?;
    let g = match (raw.g, raw.fs, raw.bs) {
        (Some(g), None, None) => within("g", g, -1.0, 1.0)?,
        (None, Some(fs), Some(bs)) => {
            let (fs, bs) = (within("fs", fs, 0.0, 1.0)?, within("bs", bs, 0.0, 1.0)?);
            if fs + bs == 0.0 {
                return Err(malformed(place, "fs + bs = 0".to_owned(), "one of them above 0"));
            }
            (fs - bs) / (fs + bs)
        }
        _ => {
            let given = |key, value: Option<f64>| value.map(|_| key);
            let found: Vec<&str> =
                [given("g", raw.g), given("fs", raw.fs), given("bs", raw.bs)].into_iter().flatten().collect();
            return Err(malformed(place, format!("[{}]", found.join(", ")), "g, or fs and bs"));
        }
    };
    Ok(ClassOptics { sigma_a, g })
}

#[cfg(test)]
mod tests;
