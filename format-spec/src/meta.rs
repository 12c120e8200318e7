//! What a file says about a species, stored as canonical JSON (sorted keys, no white space).

mod json;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::Grid;
use crate::bases::BaseSet;
use crate::light::Light;
use crate::mean_light::MeanLight;
use crate::model::Model;
use crate::optics::Optics;
use crate::surfaces::Surfaces;

/// Largest size of a text for people, in bytes, UTF-8: the reason why something was left out, the name of the tool.
pub const MAX_REASON_BYTES: usize = 1000;

/// Everything about a species but its light: units, bounds, optics, where it came from and how.
/// Unknown keys are kept in `extra`, so that a rewrite loses nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "json::PlainMeta", into = "json::PlainMeta")]
pub struct SpeciesMeta {
    /// Name, unique in its library.
    pub name: String,
    /// Light transport model that made the bases, with its optics or surfaces. In JSON the members `model` and
    /// `optics`, or `model`, `surfaces` and `light`.
    pub model: Model,
    /// The lattice in model space, metres.
    pub grid: Grid,
    /// Bounds of the mesh in model space, metres.
    pub bounds_m: Bounds,
    /// Triangle counts after import.
    pub triangles: TriangleCounts,
    /// Digest of the mesh that the light is of: 64 lower-case hexadecimal digits (SPEC.md, section 9.2). `None` where
    /// the file does not say: it was made of no mesh, or before files said it.
    pub mesh_blake3: Option<String>,
    /// The mean of its light over the plant; `None` where the file does not say.
    pub mean_light: Option<MeanLight>,
    /// The mean of the sky's light over the plant by band, where each block is its average, as [`MeanLight::sky`] is of
    /// all of it (SPEC.md, section 9.4); `None` where the file does not say.
    pub sky_averages: Option<Vec<f64>>,
    /// Files that the species was made from, in the order in which they were read.
    pub sources: Vec<SourceFile>,
    /// Settings of each stage that shaped the bytes, as "stage.setting" -> value.
    pub settings: BTreeMap<String, serde_json::Value>,
    /// Bases and bands that the species could have and lacks, because a plan left them out.
    pub left_out: Option<LeftOut>,
    /// Program and version that wrote the species, "flb 0.1.0".
    pub tool: String,
    /// Keys of a later minor version, kept as they are.
    pub extra: BTreeMap<String, serde_json::Value>,
}

impl SpeciesMeta {
    /// Adds bases and bands to what was left out, and why. Adding nothing changes nothing.
    pub fn leave_out(&mut self, bases: BaseSet, bands: &[String], reason: &str) {
        if bases.is_empty() && bands.is_empty() {
            return;
        }
        let earlier = self.left_out.take();
        let mut left_out =
            earlier.unwrap_or(LeftOut { bases: BaseSet::NONE, bands: vec![], reason: String::new() });
        left_out.bases = left_out.bases.union(bases);
        left_out.bands.extend_from_slice(bands);
        if left_out.reason.is_empty() {
            left_out.reason = reason.to_owned();
        } else if left_out.reason != reason {
            left_out.reason = format!("{}; {reason}", left_out.reason);
        }
        let end = left_out.reason.floor_char_boundary(MAX_REASON_BYTES);
        left_out.reason.truncate(end);
        self.left_out = Some(left_out);
    }

    /// Number of bands.
    pub fn band_count(&self) -> usize {
        self.model.band_count()
    }

    /// Names of the bands, in order.
    pub fn bands(&self) -> impl ExactSizeIterator<Item = &str> {
        (0..self.band_count()).map(|band| self.model.band(band))
    }

    /// The papers' optics; `None` for another model.
    pub fn optics(&self) -> Option<&Optics> {
        self.model.optics()
    }

    /// Distance off solids at which light is sampled, metres ([`Light::solid_offset`]).
    pub fn solid_offset_m(&self) -> Option<f64> {
        let (_, light) = self.physical()?;
        light.solid_offset.map(|sites| sites * self.grid.spacing_m)
    }

    /// Surfaces and light of a `physical` species; `None` for another model.
    pub fn physical(&self) -> Option<(&Surfaces, &Light)> {
        self.model.physical()
    }
}

/// Bases and bands that were not solved, or were dropped afterwards, on purpose.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// Bases that the file has not; maybe none.
    pub bases: BaseSet,
    /// Names of bands that the optics had; maybe none.
    pub bands: Vec<String>,
    /// Reason why they are not needed, for people: "upright plants under the whole sky".
    pub reason: String,
}

/// An axis-aligned box, metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: [f64; 3],
    /// Largest coordinates.
    pub max: [f64; 3],
}

/// Triangles of a mesh by class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TriangleCounts {
    /// All triangles that were voxelised or left out as neither.
    pub total: u64,
    /// Triangles of leaf materials.
    pub leaf: u64,
    /// Triangles of wood materials.
    pub wood: u64,
}

/// One input file by name (no folders) and digest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceFile {
    /// File name without its folder.
    pub name: String,
    /// BLAKE3 of its bytes, 64 lower-case hexadecimal digits.
    pub blake3: String,
}
