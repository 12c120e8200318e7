//! Scenes of the tests: grown plants with textures and cut leaves, and walls.

use flb_fixtures::{PlantKind, grow};
use flb_format::light::SunBasis;
use flb_format::matter::{Class, LeafAngles, TurbidMedium};
use flb_format::meta::{Bounds, TriangleCounts};
use flb_format::model::Model;
use flb_format::sample::site_of;
use flb_format::scene_light::{LUMINANCE, Role};
use flb_format::sun::towards_sun;
use flb_format::{Codec, Field, Grid, Medium, Placement, SpeciesFields, SpeciesMeta, Transform};
use flb_packer::rate::Target;
use flb_packer::{EncodeSettings, encode_species, write_library_to};
use flb_render::forest::{Eye, Ground, Land, View};
use flb_render::{Shading, Surfaces};
use flb_runtime::Library;
use flb_scene::scene::Heights;
use flb_scene::{MaterialClass, Mesh};

use crate::{grown, model};

/// Of the materials of [`plant`].
pub const CLASSES: [MaterialClass; 2] = [MaterialClass::Wood, MaterialClass::Leaf];

/// Surfaces of a plant under the `physical` model.
pub fn physical() -> Shading {
    Shading::Physical(Surfaces {
        leaf_reflectance: [0.055, 0.15, 0.02],
        leaf_transmittance: [0.07, 0.125, 0.04],
        wood_reflectance: [0.3, 0.25, 0.2],
        solid_offset_m: Some(0.15),
    })
}

/// A plant with textured bark and leaves cut by alpha, as import reads it back.
pub fn plant(kind: PlantKind, triangles: u32) -> Mesh {
    let plant = grow(kind, 3, triangles).expect("a count within the limits");
    grown::mesh(&plant, [0.9, 1.0, 0.8, 1.0])
}

/// Plants of two species over a square of this edge, each turned and scaled, around a point.
pub fn stand(count: usize, edge_m: f64, middle: [f64; 3]) -> Vec<Placement> {
    (0..count)
        .map(|i| {
            let share = |step: f64| (0.5 + step * i as f64).fract();
            let [sin, _, minus_cos] = towards_sun(360.0 * share(0.618_033_988_75), 0.0);
            let rotation = [[-minus_cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, -minus_cos]];
            let [x, z] = [share(0.754_877_666_25), share(0.569_840_290_99)].map(|at| (at - 0.5) * edge_m);
            Placement {
                species: i % 2,
                transform: Transform {
                    rotation,
                    position_m: [middle[0] + x, middle[1], middle[2] + z],
                    scale: 0.8 + 0.4 * share(0.819_172_513_4),
                },
            }
        })
        .collect()
}

/// Level ground.
pub fn plane() -> Ground {
    Ground { land: Land::Plane { height_m: 0.0 }, color: [0.23, 0.22, 0.15], fades_at_m: None }
}

/// Hills of a metre over a square around the origin.
pub fn hills(edge_m: f64) -> Ground {
    let (columns, rows) = (33, 25);
    let height = |at: u32| {
        let [x, z] = [f64::from(at % columns) / 32.0, f64::from(at / columns) / 24.0];
        (x * (1.0 - x) * 4.0 - (z - 0.4) * (z - 0.4) * 3.0) as f32
    };
    let heights = Heights {
        columns,
        rows,
        height_m: (0..columns * rows).map(height).collect(),
        origin_m: [-edge_m / 2.0; 2],
        size_m: [edge_m; 2],
    };
    Ground { land: Land::Heights(heights), color: [0.3, 0.25, 0.2], fades_at_m: None }
}

/// From the south-west, from above.
pub fn view(size: [u32; 2], samples: u32, distance_m: f64) -> View {
    let eye = Eye {
        position_m: [-distance_m * 0.6, distance_m * 0.5, distance_m * 0.8],
        look_at_m: [0.0, 2.0, 0.0],
        fov_deg: 45.0,
    };
    View { eye, width: size[0], height: size[1], samples, sky_rays: 4, time_s: 0.0 }
}

/// A library in memory of species with these suns (`None`: of the model `paper`), whose fields are waves with noise.
pub fn library(species: &[(&str, Option<SunBasis>)], codec: Codec) -> Library {
    let all: Vec<_> =
        (1..).zip(species).map(|(seed, (name, suns))| fields(name, suns.as_ref(), seed, STANDING)).collect();
    library_of(&all, codec)
}

/// Light of a scene in memory whose plants are called by these names: waves with noise as well, half as high and on
/// sites twice as large around the origin.
pub fn scene_light(species: &[&str], suns: Option<&SunBasis>) -> Library {
    const AROUND: Grid = Grid { lattice: LATTICE, origin_m: [-16.0, -12.0, -16.0], spacing_m: 1.0 };
    let alone = species.iter().map(|species| Role::Alone { species: (*species).to_owned() });
    let roles = std::iter::once(Role::Scene { digest: "d1".to_owned() }).chain(alone);
    let entry = |(seed, role): (u32, Role)| {
        let (grid, factor) = if seed == 10 { (AROUND, 0.5) } else { (STANDING, 1.0) };
        let mut entry = fields(&role.name(), suns, seed, grid);
        entry.meta.settings.extend([role.setting()]);
        match &mut entry.meta.model {
            Model::Physical { surfaces, .. } => {
                surfaces.bands.truncate(1);
                surfaces.bands[0].name = LUMINANCE.to_owned();
            }
            Model::Paper { optics } => {
                optics.bands.truncate(1);
                optics.bands[0].name = LUMINANCE.to_owned();
            }
        }
        entry.bases.iter_mut().for_each(|(_, base)| {
            *base = Field::new(base.lattice, 1, base.band(0).into_owned());
            base.values_mut().iter_mut().for_each(|value| *value *= factor);
        });
        entry
    };
    library_of(&(10..).zip(roles).map(entry).collect::<Vec<_>>(), Codec::RawF32)
}

fn library_of(all: &[SpeciesFields], codec: Codec) -> Library {
    let settings = EncodeSettings { codec, target: Target::Psnr(50.0), ..EncodeSettings::papers() };
    let encode = |fields| encode_species(fields, &settings, &|_| Ok(())).expect("these are good fields");
    let coded: Vec<_> = all.iter().map(encode).collect();
    let mut bytes = Vec::new();
    write_library_to(&mut bytes, &coded.iter().collect::<Vec<_>>()).expect("memory takes it");
    Library::from_source("plants.flb", Box::new(bytes)).expect("it opens")
}

const LATTICE: u32 = 32;
/// Around a plant.
const STANDING: Grid = Grid { lattice: LATTICE, origin_m: [-8.0, -1.0, -8.0], spacing_m: 0.5 };

fn fields(name: &str, suns: Option<&SunBasis>, seed: u32, grid: Grid) -> SpeciesFields {
    let mut medium = Medium::empty(grid);
    let (mut leaf_per_m, wood_per_m) = (vec![0.0; grid.sites()], vec![0.0; grid.sites()]);
    for (site, leaf_per_m) in leaf_per_m.iter_mut().enumerate() {
        let from_middle = grid.site(site).map(|c| c as f32 / 15.5 - 1.0);
        if from_middle.iter().map(|c| c * c).sum::<f32>() < 0.7 && noise(site as u32, seed) > 0.3 {
            (medium.density[site], medium.class[site]) = (0.2, Class::Leaf);
            medium.leaf_area_density[site] = 1.0;
            *leaf_per_m = 0.5;
        }
    }
    let turbid = TurbidMedium { grid, leaf_per_m, wood_per_m, angles: LeafAngles::planophile() };
    let (model, items, turbid) = model::model(suns, turbid);
    let meta = SpeciesMeta {
        name: name.to_owned(),
        model,
        grid,
        bounds_m: Bounds { min: [-8.0, -1.0, -8.0], max: [8.0, 15.0, 8.0] },
        triangles: TriangleCounts::default(),
        mesh_blake3: None,
        mean_light: None,
        sky_averages: None,
        sources: Vec::new(),
        settings: Default::default(),
        tool: "test".to_owned(),
        left_out: None,
        extra: Default::default(),
    };
    let bases = (0..items as u8).map(|base| (base, field(LATTICE, base, seed))).collect();
    SpeciesFields { meta, medium, turbid, bases }
}

/// Waves with a little noise, another for every base.
fn field(lattice: u32, base: u8, seed: u32) -> Field {
    let mut field = Field::zeros(lattice, 3);
    let sites = (lattice as usize).pow(3);
    let outside = if base == 0 { 9.0 } else { 0.5 };
    for (i, value) in field.values_mut().iter_mut().enumerate() {
        let wave = site_of(i % sites, lattice).map(|c| c as f32 / lattice as f32);
        let slow = wave[0] * (1.0 - wave[1]) + wave[2] * f32::from(base % 5) * 0.1;
        *value = outside * (0.4 + slow + 0.1 * noise(i as u32, seed + 1 + u32::from(base)));
    }
    field
}

/// From 0 to 1, by a hash.
fn noise(at: u32, seed: u32) -> f32 {
    (flb_scene::sampling::hash(at ^ flb_scene::sampling::hash(seed)) >> 8) as f32 / (1 << 24) as f32
}
