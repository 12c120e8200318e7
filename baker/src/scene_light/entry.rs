//! What a library says of a scene's lattice, or of a species alone: metadata and medium of an entry.

use flb_format::light::Light;
use flb_format::matter::{BandOptics, BandSurfaces, Class, Optics, Surfaces, TurbidMedium};
use flb_format::meta::{Bounds, TriangleCounts};
use flb_format::model::Model;
use flb_format::scene_light::{GROUND_DENSITY, Role};
use flb_format::{Medium, SpeciesMeta};
use serde_json::Value;

/// Largest density of a site of plants: only the ground has 1.
const PLANTS_DENSITY: f32 = 0.999;

/// Metadata and medium of an entry of a library, without its fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Metadata, whose settings gain the role, and what was given.
    pub meta: SpeciesMeta,
    /// Densities are shares of light that a site stops along its edge; areas those of the extinction.
    pub medium: Medium,
}

/// The entry of a medium in a role. `is_ground` is empty where there is none.
pub fn entry(
    role: &Role,
    turbid: &TurbidMedium,
    is_ground: &[bool],
    surfaces: BandSurfaces,
    light: Light,
    settings: impl IntoIterator<Item = (String, Value)>,
) -> Entry {
    let surfaces = Surfaces { bands: vec![surfaces] };
    let model = Model::Physical { surfaces, light: light.of_leaves(&turbid.angles) };
    of_model(role, turbid, is_ground, model, settings)
}

/// The entry of a medium of the model `paper` in a role, of which `turbid` is the extinction.
pub fn paper_entry(role: &Role, turbid: &TurbidMedium, optics: BandOptics) -> Entry {
    let model = Model::Paper { optics: Optics { bands: vec![optics] } };
    of_model(role, turbid, &[], model, [])
}

fn of_model(
    role: &Role,
    turbid: &TurbidMedium,
    is_ground: &[bool],
    model: Model,
    settings: impl IntoIterator<Item = (String, Value)>,
) -> Entry {
    let medium = medium(turbid, is_ground);
    let meta = SpeciesMeta {
        name: role.name(),
        model,
        grid: turbid.grid,
        bounds_m: bounds_m(turbid),
        triangles: TriangleCounts::default(),
        mesh_blake3: None,
        mean_light: None,
        sky_averages: None,
        sources: Vec::new(),
        settings: settings.into_iter().chain([role.setting()]).collect(),
        left_out: None,
        tool: concat!("flb ", env!("CARGO_PKG_VERSION")).to_owned(),
        extra: Default::default(),
    };
    Entry { meta, medium }
}

pub(super) fn medium(turbid: &TurbidMedium, is_ground: &[bool]) -> Medium {
    let mut medium = Medium::empty(turbid.grid);
    for site in turbid.sites() {
        let site = site as usize;
        let (leaf, wood) = (turbid.leaf_per_m[site], turbid.wood_per_m[site]);
        let depth = f64::from(leaf + wood) * turbid.grid.spacing_m;
        let stopped = (-libm::expm1(-depth) as f32).clamp(f32::MIN_POSITIVE, PLANTS_DENSITY);
        let is_ground = is_ground.get(site).copied().unwrap_or(false);
        medium.density[site] = if is_ground { GROUND_DENSITY } else { stopped };
        medium.class[site] = if wood > leaf { Class::Wood } else { Class::Leaf };
        medium.leaf_area_density[site] = 2.0 * leaf;
        medium.wood_area_density[site] = 4.0 * wood;
    }
    medium
}

fn bounds_m(turbid: &TurbidMedium) -> Bounds {
    let [min, max] = turbid.grid.extent_m(&turbid.sites()).unwrap_or([turbid.grid.origin_m; 2]);
    Bounds { min, max }
}
