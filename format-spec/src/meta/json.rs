//! [`SpeciesMeta`] as it stands in a file: the members of both models side by side, those of the other model absent.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Bounds, LeftOut, SourceFile, SpeciesMeta, TriangleCounts};
use crate::light::json::present;
use crate::light::{Light, Model};
use crate::{Grid, MeanLight, Optics, Surfaces};

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
        let (optics, surfaces, light) = match meta.model {
            Model::Paper { optics } => (Some(optics), None, None),
            Model::Physical { surfaces, light } => (None, Some(surfaces), Some(light)),
        };
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
        let there = |there: bool| if there { "present" } else { "missing" };
        let members = (plain.optics, plain.surfaces, plain.light);
        let model = match (plain.model.as_str(), members) {
            ("paper", (Some(optics), None, None)) => Model::Paper { optics },
            ("physical", (None, Some(surfaces), Some(light))) => Model::Physical { surfaces, light },
            ("paper" | "physical", (optics, surfaces, light)) => {
                return Err(format!(
                    "model {:?} with `optics` {}, `surfaces` {}, `light` {}: paper has optics alone, physical has surfaces \
                     and light",
                    plain.model,
                    there(optics.is_some()),
                    there(surfaces.is_some()),
                    there(light.is_some())
                ));
            }
            (other, _) => return Err(format!("model is {other}, expected \"paper\" or \"physical\"")),
        };
        Ok(SpeciesMeta {
            name: plain.name,
            model,
            grid: plain.grid,
            bounds_m: plain.bounds_m,
            triangles: plain.triangles,
            mesh_blake3: plain.mesh_blake3,
            mean_light: plain.mean_light,
            sources: plain.sources,
            settings: plain.settings,
            left_out: plain.left_out,
            tool: plain.tool,
            extra: plain.extra,
        })
    }
}
