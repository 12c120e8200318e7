//! Golden snapshots of every stage that only the default bake has, from the crown to pictures. A snapshot that changes
//! is a change of the product: look at it, and say in the commit why it is right. `INSTA_UPDATE=always` writes them
//! anew.

use std::path::Path;
use std::sync::LazyLock;

use flb_baker::plan::{Plan, plan};
use flb_fixtures::PlantKind;
use flb_format::SunBasis;
use flb_format::beam::BEAM_RAYS;
use flb_format::sun::towards_sun;
use flb_render::{Indirect, RenderSettings, Shading, Surfaces, render, render_reference};
use flb_runtime::PhysicalSampler;
use flb_scene::scene::Scene;
use flb_scene::scene::scatter::{Amount, Plot, scatter};
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

fn picture_settings(samples: u32) -> RenderSettings {
    // Leaf and wood of Knapp and Carter's leaves and common bark, R, G, B.
    let surfaces = Surfaces {
        leaf_reflectance: [0.070, 0.125, 0.040],
        leaf_transmittance: [0.055, 0.150, 0.020],
        wood_reflectance: [0.153, 0.123, 0.090],
    };
    RenderSettings {
        width: 32,
        height: 32,
        samples,
        sun: towards_sun(135.0, 40.0),
        ambient: SKY,
        indirect: Indirect::On,
        shading: Shading::Physical(surfaces),
        ..RenderSettings::default()
    }
}

#[test]
fn pictures_are_golden() {
    let picture = |plant: &DefaultBake| {
        let settings = picture_settings(4);
        let light = PhysicalSampler::load(&plant.library(), 0).expect("a file of the default model");
        let sun = light.prepare(&light.near(), light.terms(settings.sun).expect("a direction"), BEAM_RAYS);
        let fluence =
            |point: [f32; 3], phi: &mut [f32; 3]| light.fluence(&sun, 1.0, settings.ambient, point, phi);
        let (mesh, classes) = (&plant.mesh.mesh, &plant.mesh.classes);
        let relit = render(mesh, classes, &fluence, &settings, &|_| {}).expect("a plant renders");
        let traced = render_reference(mesh, classes, &settings, &|_| {}).expect("a plant renders").picture;
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
    let library = stand.library(32, &SunBasis::Harmonics { degree: 1, single: true });
    let container = library.container();
    let mut text = String::new();
    for (index, species) in container.species().iter().enumerate() {
        let turbid = container.read_turbid(library.source(), index).expect("it was just written");
        text += &format!("{}\n", species.meta.name);
        text += &describe::values("leaf", &turbid.leaf_per_m);
        for base in &species.bases {
            let field =
                container.read_field(library.source(), index, base.base).expect("it was just written");
            text += &describe::values(&format!("item {}", base.base), &field.values);
        }
    }
    insta::assert_snapshot!("scene_light", text);
}
