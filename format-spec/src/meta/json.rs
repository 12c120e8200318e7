//! [`SpeciesMeta`] as it stands in a file: the members of both models side by side, those of the other model absent.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Bounds, LeftOut, SourceFile, SpeciesMeta, TriangleCounts};
use crate::Grid;
use crate::light::Light;
use crate::light::json::present;
use crate::mean_light::MeanLight;
use crate::model::Model;
use crate::optics::Optics;
use crate::surfaces::Surfaces;

#[derive(Serialize, Deserialize)]
pub(super) struct PlainMeta {
    name: String,
    model: String,
    grid: Grid,
    bounds_m: Bounds,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    optics: Option<Optics>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    surfaces: Option<Surfaces>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    light: Option<Light>,
    triangles: TriangleCounts,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    mesh_blake3: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    mean_light: Option<MeanLight>,
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    sky_averages: Option<Vec<f64>>,
    sources: Vec<SourceFile>,
    settings: BTreeMap<String, Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    left_out: Option<LeftOut>,
    tool: String,
    #[serde(flatten)]
    extra: BTreeMap<String, Value>,
}

impl From<SpeciesMeta> for PlainMeta {
    fn from(meta: SpeciesMeta) -> PlainMeta {
        let model = meta.model.name().to_owned();
        let (optics, surfaces, light) = meta.model.into_members();
        PlainMeta {
            name: meta.name,
            model,
            grid: meta.grid,
            bounds_m: meta.bounds_m,
            optics,
            surfaces,
            light,
            triangles: meta.triangles,
            mesh_blake3: meta.mesh_blake3,
            mean_light: meta.mean_light,
            sky_averages: meta.sky_averages,
            sources: meta.sources,
            settings: meta.settings,
            left_out: meta.left_out,
            tool: meta.tool,
            extra: meta.extra,
        }
    }
}

impl TryFrom<PlainMeta> for SpeciesMeta {
    type Error = String;

    fn try_from(plain: PlainMeta) -> Result<SpeciesMeta, String> {
        let model = Model::of_members(&plain.model, (plain.optics, plain.surfaces, plain.light))?;
        Ok(SpeciesMeta {
            name: plain.name,
            model,
            grid: plain.grid,
            bounds_m: plain.bounds_m,
            triangles: plain.triangles,
            mesh_blake3: plain.mesh_blake3,
            mean_light: plain.mean_light,
            sky_averages: plain.sky_averages,
            sources: plain.sources,
            settings: plain.settings,
            left_out: plain.left_out,
            tool: plain.tool,
            extra: plain.extra,
        })
    }
}
