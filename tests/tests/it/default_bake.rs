//! Golden snapshots of every stage that only the default bake has, from the crown to pictures. A snapshot that changes
//! is a change of the product: look at it, and say in the commit why it is right. `INSTA_UPDATE=always` writes them
//! anew.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use flb_baker::plan::{Plan, plan};
use flb_fixtures::PlantKind;
use flb_format::beam::BEAM_RAYS;
use flb_format::light::SunBasis;
use flb_format::matter::BandSurfaces;
use flb_format::sun::towards_sun;
use flb_format::{Placement, Transform};
use flb_render::forest::{self, Eye, Forest, Search, View, Water};
use flb_render::reference::render_reference;
use flb_render::{LightQuery, Lighting, Look, Portrait, Shading, Species, Surfaces, render_plant};
use flb_runtime::residency::{NeedFinder, Placed, Residency, ResidencySettings, UnitId, Units};
use flb_runtime::resident::LightLevel;
use flb_runtime::samplers::PhysicalSampler;
use flb_runtime::scene_light::SceneLight;
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, SpeciesLight};
use flb_scene::leaf::{Bands, LeafModel, knapp_carter};
use flb_scene::scene::Scene;
use flb_scene::scene::scatter::{Amount, Plot, scatter};
use flb_scene::surface_points::surface_points;
use flb_scene::waves::Waves;
use flb_tests::budget::streamed;
use flb_tests::default_bake::DefaultBake;
use flb_tests::describe;
use flb_tests::stand::{Kind, SKY, Stand};

static PLANTS: LazyLock<Vec<(&str, DefaultBake)>> = LazyLock::new(|| {
    [PlantKind::Oak, PlantKind::LeafCard].map(|kind| (kind.name(), DefaultBake::of(kind))).into()
});

/// What a stage made of every plant.
fn of_all(describe: impl Fn(&DefaultBake) -> String) -> String {
    PLANTS.iter().map(|(name, plant)| format!("{name}: {}", describe(plant))).collect()
}

#[test]
fn surfaces_are_golden() {
    let all = [("common leaves", knapp_carter()), ("leaf model", LeafModel::default().surfaces(&Bands::Rgb))];
    let text = |(name, surfaces): (&str, flb_format::matter::Surfaces)| {
        let band = |band: &BandSurfaces| {
            let (leaf, wood) = (band.leaf, band.wood.reflectance);
            format!("  {}: leaf {:?} {:?}, wood {wood:?}\n", band.name, leaf.reflectance, leaf.transmittance)
        };
        format!("{name}\n{}", surfaces.bands.iter().map(band).collect::<String>())
    };
    insta::assert_snapshot!("surfaces", all.map(text).concat());
}

#[test]
fn crowns_are_golden() {
    insta::assert_snapshot!("crowns", of_all(|plant| describe::crown(&plant.baked.fields)));
}

#[test]
fn solves_and_fits_are_golden() {
    insta::assert_snapshot!(
        "physical_fields",
        of_all(|plant| describe::physical_fields(&plant.baked.fields))
    );
    assert!(PLANTS.iter().all(|(_, plant)| plant.baked.converged));
}

#[test]
fn codings_are_golden() {
    let report = |plant: &DefaultBake| plant.encoded.report.clone().expect("was just coded");
    insta::assert_snapshot!("codings", of_all(|plant| describe::coding(&report(plant))));
}

#[test]
fn containers_are_golden() {
    insta::assert_snapshot!("default_containers", of_all(|plant| describe::container(&plant.file)));
}

/// Points of the mesh, every so many of its vertices.
fn points(plant: &DefaultBake) -> Vec<[f32; 3]> {
    plant.mesh.mesh.positions.iter().step_by(37).copied().collect()
}

const SUNS: [[f64; 2]; 3] = [[0.0, 90.0], [135.0, 40.0], [300.0, 8.0]];

#[test]
fn samples_are_golden() {
    let samples = |plant: &DefaultBake| {
        let light = PhysicalSampler::load(&plant.library(), 0).expect("a file of the default model");
        let mut text = "\n".to_owned();
        for [azimuth, elevation] in SUNS {
            let terms = light.terms(towards_sun(azimuth, elevation)).expect("a direction");
            let sun = light.prepare(&light.near(), terms, BEAM_RAYS);
            let mut values = Vec::new();
            for point in points(plant) {
                let mut rgb = [0.0; 3];
                light.fluence(&sun, 1.0, SKY, point, &mut rgb);
                values.extend(rgb);
            }
            text += &describe::values(&format!("sun {azimuth},{elevation}"), &values);
        }
        text
    };
    insta::assert_snapshot!("samples", of_all(samples));
}

/// Rays that look at one place each find the mean of what is prepared for all sites: no ray is cut off at 0, and each
/// looks between the sites as fields are read between them.
#[test]
fn marched_light_is_as_bright_as_prepared_light() {
    let (_, plant) = &PLANTS[0];
    let library = plant.library();
    let species = SpeciesLight::load(&library, 0).expect("a file of the default model");
    let (near, points) = (species.near(), surface_points(&plant.mesh, 3_000, false).expect("good textures"));
    let (mut marched, mut prepared) = ([0.0; 3], [0.0; 3]);
    for towards_sun in flb_transport::monte_carlo::judge::suns(8) {
        let daylight = Daylight { towards_sun, sun: 1.0, sky: 0.0 };
        let lit = || species.lit_by_in_model(&daylight).expect("a direction");
        for (lit, sum) in
            [(lit().for_rays(16), &mut marched), (lit().prepared_by(near.as_ref()), &mut prepared)]
        {
            for point in &points {
                let mut phi = [0.0; 3];
                lit.at(point.position_m, &mut phi);
                sum.iter_mut().zip(phi).for_each(|(sum, phi)| *sum += f64::from(phi));
            }
        }
    }
    let ratio = [0, 1, 2].map(|band| marched[band] / prepared[band]);
    println!("marched over prepared {ratio:.3?}");
    assert!(ratio.iter().all(|ratio| (ratio - 1.0).abs() < 0.02), "{ratio:?}");
}

/// With nothing but the file's head, with the sky's light alone, with all that it needs: the mean light of the plant
/// stays what it is. What comes is blended in.
#[test]
fn light_of_any_budget_has_the_mean_of_the_whole_file_and_does_not_flash() {
    let (_, plant) = &PLANTS[0];
    let library = Arc::new(plant.library());
    let points = surface_points(&plant.mesh, 500, false).expect("good textures");
    let points: Vec<[f32; 3]> = points.iter().map(|point| point.position_m).collect();
    for [sun, sky] in [[1.0, 0.0], [0.0, 1.0], [1.0, 0.4]] {
        for [azimuth, elevation] in SUNS {
            let daylight = Daylight { towards_sun: towards_sun(azimuth, elevation), sun, sky };
            let whole = streamed(&library, &points, &daylight, u64::MAX, 48);
            assert_eq!((whole.level, whole.lacks_bytes), (LightLevel::Whole, 0));
            assert!(whole.mean_off == 0.0 && whole.rms == 0.0, "{whole:?}");
            // Units come one by one. A page is all detail of a base of this plant, and detail is not blended in.
            assert!(whole.largest_jump.0 < 0.45, "{daylight:?}: {whole:?}");
            for budget in [1, whole.least_bytes / 8, whole.least_bytes / 2, whole.least_bytes] {
                let found = streamed(&library, &points, &daylight, budget, 1);
                // Averages of blocks of 4 sites are of the air around leaves, too: the brighter, the larger sites are.
                let most = if found.level == LightLevel::Averages { 0.2 } else { 0.1 };
                assert!(found.mean_off.abs() < most, "{daylight:?}, {budget}: {found:?}");
                assert_eq!(found.lacks_bytes > 0, budget < whole.least_bytes, "{budget}: {found:?}");
            }
        }
    }
}

/// A walk past three plants under three suns, two frames each; at last with room for three quarters of what is loaded,
/// so that some goes.
#[test]
fn streamed_units_are_golden() {
    let walk = |plant: &DefaultBake| {
        let library = plant.library();
        let units = Arc::new(Units::new(library.container(), library.path()).expect("coded near geometry"));
        let whole: u64 = units.all().map(|unit| units.get(unit).memory_bytes).sum();
        let mut residency = Residency::new(Arc::clone(&units), ResidencySettings::default());
        let mut finder = NeedFinder::new(library.container(), &units);
        let instance = |x: f64| Placement {
            species: 0,
            transform: Transform { position_m: [x, 0.0, -20.0], ..Transform::IDENTITY },
        };
        let placed = Placed::new(library.container(), [-15.0, 0.0, 15.0].map(instance));
        let mut text = format!("{} units of {whole} bytes\n", units.len());
        for frame in 0..2 * SUNS.len() {
            let [azimuth, elevation] = SUNS[frame / 2];
            if frame == 4 {
                residency.set_budget(residency.loaded_bytes() / 4 * 3);
            }
            let camera = Camera {
                position_m: [4.0 * frame as f32 - 10.0, 2.0, 0.0],
                forward: [0.0, 0.0, -1.0],
                up: [0.0, 1.0, 0.0],
                fov_deg: 60.0,
                width_px: 640,
                height_px: 360,
            };
            let light = Daylight { towards_sun: towards_sun(azimuth, elevation), sun: 1.0, sky: SKY };
            let plan = residency.plan(&finder.find(&placed, &camera, &light));
            let numbers = |units: &[UnitId]| units.iter().map(|unit| unit.index()).collect::<Vec<_>>();
            let (gone, read) = (numbers(&plan.evictions), numbers(&plan.requests));
            text +=
                &format!("  frame {frame}: quality {:.6}, drops {gone:?}, reads {read:?}\n", plan.quality);
            plan.requests.into_iter().for_each(|unit| residency.loaded(unit));
        }
        text
    };
    insta::assert_snapshot!("streamed", of_all(walk));
}

/// Leaf and wood of Knapp and Carter's leaves and common bark, R, G, B.
const SURFACES: Surfaces = Surfaces {
    leaf_reflectance: [0.070, 0.125, 0.040],
    leaf_transmittance: [0.055, 0.150, 0.020],
    wood_reflectance: [0.153, 0.123, 0.090],
    solid_offset_m: None,
};

#[test]
fn pictures_are_golden() {
    let picture = |plant: &DefaultBake| {
        let portrait = Portrait { width: 32, height: 32, samples: 4, ..Portrait::default() };
        let daylight = Daylight { towards_sun: towards_sun(135.0, 40.0), sun: 1.0, sky: SKY };
        let (lighting, look) = (Lighting::of(daylight), Look::default());
        let light = PhysicalSampler::load(&plant.library(), 0).expect("a file of the default model");
        let sun =
            light.prepare(&light.near(), light.terms(daylight.towards_sun).expect("a direction"), BEAM_RAYS);
        let fluence = |query: LightQuery, phi: &mut [f32; 3]| light.fluence(&sun, 1.0, SKY, query.point, phi);
        let (mesh, classes) = (&plant.mesh.mesh, &plant.mesh.classes);
        let plant = Species { mesh, classes, shading: Shading::Physical(SURFACES) };
        let relit = render_plant(&plant, &portrait, &lighting, &look, &fluence, &|_| Ok(()))
            .expect("a plant renders");
        let traced = render_reference(&plant, &portrait, &lighting, &look, &|_| Ok(()))
            .expect("a plant renders")
            .picture;
        format!("\n{}{}", describe::values("relit", &relit.rgb), describe::values("path traced", &traced.rgb))
    };
    insta::assert_snapshot!("pictures", of_all(picture));
}

#[test]
fn plans_and_scattered_plants_are_golden() {
    let scene = "sun = { path = { latitude_deg = 52.5, longitude_deg = 13.4, from = 2026-06-01, to = 2026-08-31 } }\n\
                 [[species]]\nname = \"oak\"\nfile = \"oak.glb\"\n\
                 [[instance]]\nspecies = \"oak\"\nposition_m = [3.0, 0.0, -4.0]\nyaw_deg = 30.0\n";
    let scene = Scene::parse("scene.toml", Path::new("."), scene).expect("a scene");
    let outline = plan(&scene, &[None]);
    insta::assert_snapshot!("plan", Plan::of(&outline).expect("it has a sun").to_toml());
    let plot = Plot { area_m: [40.0, 30.0], amount: Amount::Spacing(2.5), seed: 7, density: None };
    let spots = scatter(&plot).expect("an open field");
    let flat: Vec<f32> = spots.points_m.iter().flatten().map(|c| *c as f32).collect();
    insta::assert_snapshot!("scattered", describe::values("places", &flat));
}

#[test]
fn scene_light_is_golden() {
    let ball = Kind::ball("ball", 32, 0.5, 2.0);
    let stand = Stand::in_step(vec![ball], &[(0, 0, [0.0, 0.0]), (0, 1, [1.5, 0.4])]);
    let library = stand.library(32, &SunBasis::Harmonics { degree: 1, single: true, leaning: false });
    let container = library.container();
    let mut text = String::new();
    for (index, species) in container.species().iter().enumerate() {
        let turbid = container.read_turbid(library.source(), index).expect("it was just written");
        text += &format!("{}\n", species.meta.name);
        text += &describe::values("leaf", &turbid.leaf_per_m);
        for base in &species.bases {
            let field =
                container.read_field(library.source(), index, base.base).expect("it was just written");
            text += &describe::values(&format!("item {}", base.base), &field.values());
        }
    }
    insta::assert_snapshot!("scene_light", text);
}

/// Two oaks and a card at the water, as a scene file has them.
const SHORE: &str = "water.height_m = 0.4
[camera]
position_m = [-9.0, 5.0, 12.0]
look_at_m = [0.5, 2.0, 0.0]
fov_deg = 45.0
height_px = 32
[[species]]
name = \"oak\"
file = \"oak.glb\"
[[species]]
name = \"leaf-card\"
file = \"leaf-card.glb\"
[[instance]]
species = \"oak\"
position_m = [0.0, 0.0, 0.0]
[[instance]]
species = \"oak\"
position_m = [5.0, 0.2, -2.0]
yaw_deg = 70.0
scale = 0.8
[[instance]]
species = \"leaf-card\"
position_m = [-3.0, 0.5, 4.0]
yaw_deg = 30.0
scale = 2.0
";

#[test]
fn forests_over_water_are_golden() {
    let scene = Scene::parse("shore.toml", Path::new("."), SHORE).expect("a scene");
    assert!(scene.species.iter().zip(&*PLANTS).all(|(species, (name, _))| species.name == *name));
    let kinds = PLANTS.iter().map(|(_, plant)| Kind::of(&plant.baked.fields)).collect();
    let stand = Stand { kinds, instances: scene.instances.clone(), ground: None };
    let neighbours = stand.library(16, &SunBasis::Harmonics { degree: 1, single: true, leaning: false });
    let neighbours = SceneLight::load(&neighbours).expect("scene light");
    let (prepared, placed) = (neighbours.prepare(stand.names()), &stand.instances);

    let shading = Shading::Physical(SURFACES);
    let meshes = PLANTS.iter().map(|(_, plant)| &plant.mesh);
    let species = meshes.map(|mesh| forest::Species { mesh: &mesh.mesh, classes: &mesh.classes, shading });
    let species: Vec<_> = species.collect();
    let still = scene.water.as_ref().expect("it has water");
    let water = Water { height_m: still.height_m, color: still.color.map(|share| share as f32), waves: None };
    let over = |water: Water| {
        let forest = Forest::prepare(&species, &scene.instances, None, Search::default()).expect("a forest");
        forest.with_water(water).expect("water below the camera")
    };
    let forest = over(water);
    let camera = scene.camera.as_ref().expect("it has a camera");
    let look_at_m = camera.look_at_m.as_ref().expect("it looks at something")[0];
    let eye = Eye { position_m: camera.path_m[0], look_at_m, fov_deg: camera.fov_deg };
    let view = View { eye, width: 48, height: camera.height_px, samples: 4, sky_rays: 4, time_s: 0.0 };
    let fragments = forest.trace(&view, &|_| Ok(())).expect("a view");
    let counts = fragments.counts();
    assert!(counts[0] > 200 && counts[3] > 200, "plants and water are seen: {counts:?}");

    let lights = PLANTS.iter().map(|(_, plant)| SpeciesLight::load(&plant.library(), 0).expect("its file"));
    let lights: Vec<_> = lights.collect();
    let mut text = format!("rays that met a plant, ground, nothing, water: {counts:?}\n");
    for [azimuth, elevation] in [[135.0, 40.0], [280.0, 10.0]] {
        let sun = towards_sun(azimuth, elevation);
        let shade = prepared.at_sun(Some(sun), placed).expect("a sun");
        let daylight = Daylight { towards_sun: sun, sun: 1.0, sky: SKY };
        let lit = (0..).zip(&scene.instances).map(|(number, instance)| {
            let light = lights[instance.species].lit_by(&daylight, &instance.transform).expect("a sun");
            light.for_rays(view.samples).with_neighbours(&shade, number).expect("one of the stand")
        });
        let lit: Vec<_> = lit.collect();
        let light = |query: LightQuery, phi: &mut [f32; 3]| lit[query.instance as usize].at(query.point, phi);
        let picture = forest
            .relight(&fragments, &Lighting::of(daylight), &Look::default(), &light, &|_| Ok(()))
            .expect("finite light");
        text += &describe::values(&format!("sun {azimuth},{elevation}"), &picture.rgb);
        if elevation < 20.0 {
            let wavy = over(Water { waves: Some(Waves::default()), ..water });
            let view = View { time_s: 2.5, ..view };
            let picture = wavy.render(&view, &Lighting::of(daylight), &Look::default(), &light, &|_| Ok(()));
            text += &describe::values("the same with waves", &picture.expect("finite light").rgb);
        }
    }
    insta::assert_snapshot!("water", text);
}
