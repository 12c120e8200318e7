use std::sync::{Arc, Mutex};

use flb_fixtures::{PlantKind, grow};
use flb_format::Codec;
use flb_format::eye::Eye;
use flb_format::light::SunBasis;
use flb_render::shading::Units;
use flb_render::{Indirect, Look, Picture, Portrait, Shading};
use flb_scene::scene::{
    Camera, Ground, HighlightChoice, Scene, SceneSky, SceneSpecies, Sunlight, Suns, Terrain,
};
use flb_scene::{ClassedMesh, ImportSettings, Observer, Unobserved};
use flb_testkit::{plants, scenes};

use crate::alone::{PlantLook, PlantRenderer};
use crate::open::{find_species, scene_species};
use crate::plant::{PlantLight, ScenePlant};
use crate::stream::{Painter, Shot, Show};
use crate::*;

pub(crate) const SIZE: [u32; 2] = [64, 48];
pub(crate) const SUN_DEG: [f64; 2] = [120.0, 40.0];

/// Six plants of two species on a ground, and their light.
pub(crate) fn stand() -> Stage {
    stand_of(&SunBasis::Lattice18)
}

pub(crate) fn stand_of(suns: &SunBasis) -> Stage {
    stand_in(Some(suns), scenes::physical())
}

/// Of the model `paper`.
pub(crate) fn stand_of_paper() -> Stage {
    stand_in(None, Shading::Paper)
}

fn stand_in(suns: Option<&SunBasis>, shading: Shading) -> Stage {
    let lit = [("a", suns.cloned()), ("b", suns.cloned())];
    let library = Arc::new(scenes::library(&lit, Codec::Classed));
    let plant = |(kind, species)| ScenePlant {
        mesh: ClassedMesh { mesh: scenes::plant(kind, 600), classes: scenes::CLASSES.to_vec() },
        read_as: ImportSettings::default(),
        shading,
        light: Some(PlantLight { library: Arc::clone(&library), species }),
        matched: None,
    };
    let Eye { position_m, look_at_m, fov_deg } = scenes::view(SIZE, 1, 14.0).eye;
    let aside = |[x, y, z]: [f64; 3]| [x + 3.0, y, z];
    let scene = Scene {
        bands: None,
        light: None,
        ambient: None,
        sky: SceneSky::Even,
        backdrop: None,
        suns: Suns::Fixed(vec![SUN_DEG, [250.0, 15.0]]),
        sunlight: Sunlight::default(),
        highlight: HighlightChoice::default(),
        camera: Some(Camera {
            path_m: vec![position_m, aside(position_m)],
            look_at_m: Some(vec![look_at_m]),
            fov_deg,
            height_px: SIZE[1],
            pixels_per_site: 1.0,
        }),
        ground: Some(Ground { terrain: Terrain::Plane { height_m: 0.0 }, color: [0.23, 0.22, 0.15] }),
        water: None,
        species: ["a", "b"].map(|name| SceneSpecies { name: name.to_owned(), ..Default::default() }).into(),
        instances: scenes::stand(6, 12.0, [0.0; 3]),
    };
    let plants = [(PlantKind::Oak, 0), (PlantKind::Shrub, 1)].map(plant);
    Stage::new(scene, plants.into()).expect("a plant for each species")
}

pub(crate) fn look(stage: &Stage, sky: StageSky) -> SceneLook {
    let settings =
        LookSettings { size: Some(SIZE), samples: 1, ambient: Some(0.4), ..LookSettings::default() };
    SceneLook::new(stage, &settings, sky).expect("a sky")
}

fn renderer<'s>(stage: &'s Stage, frames: &[SceneFrame], sky: StageSky) -> SceneRenderer<'s> {
    SceneRenderer::new(stage, look(stage, sky), frames, Backend::Cpu, &Unobserved).expect("it is read")
}

/// Largest difference of two pictures.
pub(crate) fn apart(one: &Picture, other: &Picture) -> f32 {
    one.rgb.iter().zip(&other.rgb).fold(0.0, |worst: f32, (a, b)| worst.max((a - b).abs()))
}

#[test]
fn streamed_light_that_is_all_there_makes_the_frame_of_whole_files() {
    let harmonics = SunBasis::Harmonics { degree: 2, single: true, leaning: true };
    let clear = StageSky::clear(3.0).expect("a sky");
    let mut pictures = Vec::new();
    for (suns, sky) in
        [(&SunBasis::Lattice18, StageSky::EVEN), (&harmonics, StageSky::EVEN), (&harmonics, clear)]
    {
        let stage = stand_of(suns);
        let frames = frames(&stage.scene, &FrameSettings::default()).expect("camera and sun");
        assert_eq!(frames.len(), 1);
        let shot = Shot { eye: frames[0].eye, sun_deg: SUN_DEG, show: Show::Whole };
        let mut renderer = renderer(&stage, &frames, sky.clone());
        let found = renderer.picture(&frames[0], &Unobserved).expect("a picture");
        assert!(renderer.rays().expect("counts")[0] > 200 && renderer.light_bytes() > 1_000);
        let mut painter = Painter::new(&stage, look(&stage, sky), 64 << 20).expect("a painter");
        let wait = std::time::Duration::from_secs(300);
        let streamed = painter.paint_whole(&shot, SIZE, wait).expect("a picture");
        assert!(streamed.progress.is_final);
        assert!(apart(&found, &streamed.picture) < 1e-5, "{}", apart(&found, &streamed.picture));
        assert!(found.rgb.iter().any(|value| *value > 0.01));
        pictures.push(found);
    }
    assert!(apart(&pictures[1], &pictures[2]) > 0.01, "skies differ");
}

#[test]
fn of_a_plant_alone_direct_and_indirect_light_make_the_picture() {
    let stage = stand_of(&SunBasis::Harmonics { degree: 2, single: true, leaning: true });
    let plant = &stage.plants[0];
    let light = plant.light.as_ref().expect("it has some");
    let picture = |indirect, sky: StageSky| {
        let [width, height] = SIZE;
        let portrait = Portrait { width, height, samples: 2, ..Portrait::default() };
        let look = Look { indirect, ..Look::default() };
        let sunlight = Sunlight::default();
        let shows = vec![SceneShow::Light];
        let look = PlantLook { portrait, look, ambient: None, sky, sunlight, shows, is_path_traced: false };
        let renderer = PlantRenderer::new(&plant.mesh, light, look, &[SUN_DEG]).expect("it is read");
        renderer.picture(Some(SUN_DEG), &Unobserved).expect("a picture")
    };
    let [on, off, only] =
        [Indirect::On, Indirect::Off, Indirect::Only].map(|part| picture(part, StageSky::EVEN));
    let sum = Picture { rgb: off.rgb.iter().zip(&only.rgb).map(|(a, b)| a + b).collect(), ..off.clone() };
    assert!(apart(&on, &sum) < 1e-4, "{}", apart(&on, &sum));
    assert!(apart(&on, &off) > 0.01 && apart(&on, &only) > 0.01);
    let clear = picture(Indirect::Only, StageSky::clear(3.0).expect("a sky"));
    assert!(apart(&clear, &only) > 1e-3, "skies differ");
}

#[test]
fn a_species_is_the_named_one_else_the_only_one_else_the_one_that_is_hinted_at() {
    let library = |names: &[&str]| {
        scenes::library(&names.iter().map(|name| (*name, None)).collect::<Vec<_>>(), Codec::Classed)
    };
    let (one, two) = (library(&["a"]), library(&["a", "b"]));
    assert_eq!(find_species(&two, Some("b"), Some("a")).expect("it is there"), 1);
    assert_eq!(find_species(&one, None, Some("c")).expect("it is the only one"), 0);
    assert_eq!(find_species(&two, None, Some("b")).expect("it is there"), 1);
    let refused = |name, hint| find_species(&two, name, hint).expect_err("it is not there").to_string();
    assert_eq!(refused(Some("c"), None), "no species is named \"c\"; there are: a, b");
    assert_eq!(refused(None, Some("c")), "holds 2 species, expected the name of one of them: a, b");
    let of_scene = |light_species: Option<&str>| SceneSpecies {
        name: "c".to_owned(),
        light_species: light_species.map(str::to_owned),
        ..stand().scene.species[0].clone()
    };
    assert_eq!(scene_species(&two, &of_scene(Some("b"))).expect("it is there"), 1);
    let error = scene_species(&two, &of_scene(None)).expect_err("it is not there").to_string();
    assert_eq!(error, "no species is named \"c\"; there are: a, b");
}

#[test]
fn frames_go_from_the_first_camera_and_sun_to_the_last_and_a_kept_renderer_takes_each_as_a_fresh_one() {
    let stage = stand();
    let settings = FrameSettings { count: Some(3), ..FrameSettings::default() };
    let frames = frames(&stage.scene, &settings).expect("camera and sun");
    assert_eq!(
        frames.iter().map(|frame| frame.sun_deg.expect("a sun")[0]).collect::<Vec<_>>(),
        [120.0, 185.0, 250.0]
    );
    assert_eq!(frames[2].eye.position_m[0], frames[0].eye.position_m[0] + 3.0);
    let mut kept = renderer(&stage, &frames, StageSky::EVEN);
    for frame in frames.iter().chain([&frames[2], &frames[0]]) {
        let found = kept.picture(frame, &Unobserved).expect("a picture");
        let fresh = renderer(&stage, &frames, StageSky::EVEN).picture(frame, &Unobserved).expect("a picture");
        assert_eq!(apart(&found, &fresh), 0.0);
    }
}

#[test]
fn a_scene_without_what_frames_need_is_refused_by_what_it_lacks() {
    let refused = |change: &dyn Fn(&mut Scene), settings: &FrameSettings| {
        let mut scene = stand().scene;
        change(&mut scene);
        frames(&scene, settings).expect_err("it is refused").to_string()
    };
    let default = FrameSettings::default();
    assert!(refused(&|scene| scene.camera = None, &default).contains("has no [camera]"));
    let needs_sun = FrameSettings { needs_sun: true, ..default };
    assert!(refused(&|scene| scene.suns = Suns::Sky, &needs_sun).contains("has no suns of its own"));
    let stage = stand();
    let error = Stage::new(stage.scene, Vec::new()).err().expect("it is refused");
    assert!(
        error.to_string().contains("0 plants, expected one for each of the scene's 2 species"),
        "{error}"
    );
    let paper = StageSky::clear(3.0).expect("a sky").over([0.0, 1.0, 0.0], None, Units::White);
    assert!(matches!(paper, Err(StageError::UnevenSkyOverPaper)));
}

/// Keeps what it hears.
#[derive(Default)]
struct Heard(Mutex<Vec<String>>);

impl Observer for Heard {
    fn note(&self, text: &str) {
        self.0.lock().expect("no panic").push(text.to_owned());
    }
}

#[test]
fn a_scene_is_opened_with_the_files_that_it_names_and_another_mesh_is_told_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("oak.glb"), grow(PlantKind::Oak, 1, 600).expect("a good count").to_glb())
        .expect("written");
    let lit = plants::bytes(&[plants::plant("oak", Some(&SunBasis::Lattice18), 16, 1)], Codec::Classed);
    std::fs::write(at("oak.flb"), lit).expect("written");
    let text = "sun = { fixed = [[120.0, 40.0]] }\n\
                camera = { path_m = [[0.0, 2.0, 20.0]], look_at_m = [0.0, 2.0, 0.0], fov_deg = 40.0, height_px = 48 }\n\
                [[species]]\nname = \"oak\"\nfile = \"oak.glb\"\nlight = \"oak.flb\"\n\
                [[species]]\nname = \"bare\"\nfile = \"oak.glb\"\n\
                [[instance]]\nspecies = \"oak\"\nposition_m = [-4.0, 0.0, 0.0]\n\
                [[instance]]\nspecies = \"bare\"\nposition_m = [4.0, 0.0, 0.0]\n";
    std::fs::write(at("scene.toml"), text).expect("written");
    let open = |settings: &OpenSettings, heard: &Heard| {
        Stage::open(Scene::read(&at("scene.toml")).expect("a scene"), settings, heard)
    };
    let heard = Heard::default();
    let refused = open(&OpenSettings::default(), &heard).err().expect("another mesh").to_string();
    assert!(refused.contains("oak.glb") && refused.contains("was baked with"), "{refused}");
    let bands = OpenSettings { bands: vec!["X".to_owned()], mesh_may_differ: true };
    let refused = open(&bands, &heard).err().expect("no such band").to_string();
    assert!(refused.contains("oak.flb") && refused.contains("no band \"X\""), "{refused}");
    let settings = OpenSettings { mesh_may_differ: true, ..OpenSettings::default() };
    let stage = open(&settings, &heard).expect("it opens");
    assert!(stage.plants[0].light.is_some() && stage.plants[1].light.is_none());
    let heard = heard.0.into_inner().expect("no panic");
    let says = |part: &str| heard.iter().any(|note| note.contains(part));
    assert!(says("does not fit the light of species \"oak\"") && says("is leaf"), "{heard:?}");
}
