use std::path::Path;

use super::*;
use crate::import::ImportError;

pub(super) const SCENE: &str = r#"
[[species]]
name = "oak"
file = "plants/oak.glb"

[[instance]]
species = "oak"
position_m = [1, 2, 3]
yaw_deg = 90.0
"#;

pub(super) fn parse(text: &str) -> Result<Scene, ImportError> {
    Scene::parse("forest.toml", Path::new("scenes"), text)
}

/// Message of the scene above with `from` replaced by `to`.
fn refusal(from: &str, to: &str) -> String {
    assert!(SCENE.contains(from), "{from}");
    parse(&SCENE.replacen(from, to, 1)).expect_err(to).to_string()
}

/// Message of the scene above behind more lines.
fn refusal_of(more: &str) -> String {
    parse(&format!("{more}{SCENE}")).expect_err(more).to_string()
}

#[test]
fn one_sun_needs_no_list() {
    let of = |fixed: &str| parse(&format!("sun = {{ fixed = {fixed} }}\n{SCENE}")).expect("a scene").suns;
    assert_eq!(of("[135, 35.5]"), of("[[135.0, 35.5]]"));
    assert_eq!(of("[135, 35.5]"), Suns::Fixed(vec![[135.0, 35.5]]));
}

#[test]
fn a_sun_has_an_irradiance_and_others_beside_it() {
    let of =
        |sun: &str| parse(&format!("sun = {{ {sun} }}\n{SCENE}")).map(|scene| (scene.suns, scene.sunlight));
    let sunlight = |sun: &str| of(sun).expect(sun).1;
    assert_eq!(sunlight("fixed = [135, 35]"), Sunlight::default());
    assert_eq!(sunlight("fixed = [135, 35], irradiance = 2").irradiance, [2.0; 3]);
    assert_eq!(sunlight("irradiance = [2, 1.5, 0]").irradiance, [2.0, 1.5, 0.0]);
    assert_eq!(of("irradiance = 2").expect("a scene").0, Suns::Sky);
    let moon = AddedSun { sun_deg: [10.0, -5.5], irradiance: [0.125; 3] };
    let white = AddedSun { sun_deg: [20.0, 30.0], irradiance: [1.0; 3] };
    let two = "added = [{ at = [10, -5.5], irradiance = 0.125 }, { at = [20, 30] }]";
    assert_eq!(sunlight(two).added, [moon, white]);
    let refused = |sun: &str| of(sun).expect_err(sun).to_string();
    for (sun, expected) in [
        ("irradiance = 0", "line 1, sun.irradiance: found 0, expected 0 to 10^6, and not 0 in all bands"),
        ("irradiance = [1, -1, 0]", "expected 0 to 10^6, and not 0 in all bands"),
        ("irradiance = nan", "expected 0 to 10^6"),
        ("irradiance = [1, 2]", "expected one number, or three for R, G, B"),
        ("irradiance = \"red\"", "expected one number, or three for R, G, B"),
        ("added = [[10, 20]]", "expected a list of { at = [azimuth, elevation], irradiance = ... }"),
        ("added = { at = [10, 20] }", "expected a list of"),
        (
            "added = [{ at = [10, 20], colour = 1 }]",
            "found the key \"colour\", expected at and irradiance alone",
        ),
        ("added = [{ irradiance = 1 }]", "expected a list of"),
        ("added = [{ at = [10, 95] }]", "elevation of sun.added: found 95, expected -90 to 90"),
        (
            "added = [{ at = [10, 20], irradiance = -1 }]",
            "irradiance of sun.added: found -1, expected 0 to 10^6",
        ),
        ("lux = 1", "unknown field `lux`"),
    ] {
        assert!(refused(sun).contains(expected), "{sun}: {}", refused(sun));
    }
    let many = format!("added = [{}]", "{ at = [10, 20] }, ".repeat(MAX_ADDED_SUNS + 1));
    assert!(refused(&many).contains("sun.added"), "{}", refused(&many));
}

#[test]
fn highlights_have_a_strength_and_an_exponent() {
    let of = |line: &str| parse(&format!("{line}\n{SCENE}")).map(|scene| scene.highlight);
    assert_eq!(of("").expect("a scene"), HighlightChoice::default());
    let both = of("highlight = { leaf = [0.1, 8], water = [2, 500.5] }").expect("a scene");
    assert_eq!(both, HighlightChoice { leaf: Some([0.1, 8.0]), wood: None, water: Some([2.0, 500.5]) });
    let refused = |line: &str| of(line).expect_err(line).to_string();
    for (line, expected) in [
        ("highlight.leaf = [-1, 8]", "line 1, strength of highlight.leaf: found -1, expected 0 to 1000"),
        ("highlight.wood = [1, 0]", "exponent of highlight.wood: found 0, expected 0.01 to 10000"),
        ("highlight.water = [nan, 1]", "strength of highlight.water: found NaN"),
        ("highlight.water = 1", "line 1"),
        ("highlight.bark = [1, 1]", "unknown field `bark`"),
    ] {
        assert!(refused(line).contains(expected), "{line}: {}", refused(line));
    }
}

#[test]
fn what_a_scene_does_not_say_has_a_default() {
    let scene = parse(SCENE).expect("it is sound");
    assert_eq!((scene.bands, scene.ambient, scene.suns, scene.camera), (None, None, Suns::Sky, None));
    assert_eq!(scene.species[0].file.as_deref(), Some(Path::new("scenes/plants/oak.glb")));
    assert_eq!(
        (scene.instances[0].transform.position_m, scene.instances[0].transform.scale),
        ([1.0, 2.0, 3.0], 1.0)
    );
}

#[test]
fn a_sky_is_even_clear_or_an_image_beside_the_scene() {
    let sky = |line: &str| {
        let scene = parse(&format!("{line}\n{SCENE}")).expect(line);
        let names_sky = scene.files().any(|file| file.ends_with("noon.hdr"));
        assert_eq!(names_sky, matches!(scene.sky, SceneSky::Image(_)), "{line}");
        (scene.sky, scene.ambient)
    };
    assert_eq!(sky(""), (SceneSky::Even, None));
    assert_eq!(sky("sky = { ambient = 0.3 }"), (SceneSky::Even, Some(0.3)));
    assert_eq!(sky("sky = { clear = {} }"), (SceneSky::Clear { turbidity: 3.0 }, None));
    assert_eq!(
        sky("sky.clear.turbidity = 6\nsky.ambient = 2"),
        (SceneSky::Clear { turbidity: 6.0 }, Some(2.0))
    );
    assert_eq!(sky("sky.image = \"noon.hdr\""), (SceneSky::Image("scenes/noon.hdr".into()), None));
    assert_eq!(sky("sky = \"noon.hdr\""), sky("sky.image = \"noon.hdr\""));
    let scene =
        parse(&format!("sky = {{ clear = {{}}, backdrop = \"clouds.exr\" }}\n{SCENE}")).expect("a scene");
    assert!(
        matches!(scene.sky, SceneSky::Clear { .. }) && scene.files().any(|file| file.ends_with("clouds.exr"))
    );
    assert_eq!(scene.backdrop, Some("scenes/clouds.exr".into()));
}

#[test]
fn everything_that_a_scene_can_say_is_read() {
    let text = r#"
        bands = ["R", "PAR"]
        sky = { ambient = 0 }
        sun.path = { latitude_deg = 52.5, longitude_deg = -13, from = 2026-06-01, to = 2026-08-31 }
        camera = { path_m = [[0, 1, 2], [3, 4, 5]], fov_deg = 40, height_px = 1080, pixels_per_site = 2 }
        species = [{ name = "oak", upright = true }, { name = "fir", file = "/fir.flb", species_file = "f.toml" }]
        instance = [{ species = "fir", position_m = [0, 0, 0], rotation = [0.6, 0, 0, 0.8], scale = 2 }]
    "#;
    let scene = parse(text).expect("it is sound");
    assert_eq!((scene.bands, scene.ambient), (Some(vec!["R".to_owned(), "PAR".to_owned()]), Some(0.0)));
    assert_eq!(scene.suns, Suns::Path("52.5,-13,2026-06-01..2026-08-31".parse().expect("a path")));
    let camera = scene.camera.expect("there is one");
    assert_eq!((camera.path_m.len(), camera.height_px, camera.pixels_per_site), (2, 1080, 2.0));
    assert_eq!(scene.species[1].file.as_deref(), Some(Path::new("/fir.flb")));
    let instance = scene.instances[0];
    assert_eq!(
        (instance.species, instance.transform.scale, instance.transform.is_upright()),
        (1, 2.0, false)
    );
    let fixed = parse(&format!("sun = {{ fixed = [[10, 20], [30, -5]] }}\n{SCENE}")).expect("it is sound");
    assert_eq!(fixed.suns, Suns::Fixed(vec![[10.0, 20.0], [30.0, -5.0]]));
}

#[test]
fn what_a_camera_looks_at_is_one_point_or_one_for_each_position() {
    let camera = |text: &str| {
        let text = format!("camera = {{ {text}, fov_deg = 40, height_px = 9 }}\n{SCENE}");
        parse(&text).map(|scene| scene.camera.expect("there is one").look_at_m)
    };
    let two = "path_m = [[0, 1, 2], [3, 4, 5]]";
    let (one, other) = ([7.0, 8.0, 9.0], [1.0, 1.0, 1.0]);
    assert_eq!(camera(two).expect("it is sound"), None);
    let look = camera("position_m = [0, 0, 0], look_at_m = [7, 8, 9]");
    assert_eq!(look.expect("it is sound"), Some(vec![one]));
    let look = camera(&format!("{two}, look_at_m = [7, 8, 9]"));
    assert_eq!(look.expect("it is sound"), Some(vec![one, one]));
    let look = camera(&format!("{two}, look_at_path_m = [[7, 8, 9], [1, 1, 1]]"));
    assert_eq!(look.expect("it is sound"), Some(vec![one, other]));
    for (text, expected) in [
        (
            format!("{two}, look_at_path_m = [[7, 8, 9]]"),
            "line 1, camera.look_at_path_m: found 1 points, expected 2, one for each position",
        ),
        (
            format!("{two}, look_at_m = [7, 8, 9], look_at_path_m = [[7, 8, 9], [1, 1, 1]]"),
            "line 1, camera: found look_at_m and look_at_path_m, expected one of them",
        ),
        (
            format!("{two}, look_at_m = [3, 4, 5]"),
            "line 1, what camera looks at: found [3.0, 4.0, 5.0], where it stands, expected another point",
        ),
        (format!("{two}, look_at_m = [3, nan, 5]"), "what camera looks at: found NaN"),
    ] {
        let message = camera(&text).expect_err(&text).to_string();
        assert!(message.contains(expected), "{message} for {expected}");
    }
}

#[test]
fn a_ground_is_a_plane_or_a_height_map() {
    let ground = |text: &str| parse(&format!("ground = {{ {text} }}\n{SCENE}")).map(|scene| scene.ground);
    let plane = |height_m| Terrain::Plane { height_m };
    assert_eq!(parse(SCENE).expect("it is sound").ground, None);
    let bare = ground("").expect("it is sound").expect("there is one");
    assert_eq!((bare.terrain, bare.color), (plane(0.0), [0.23, 0.22, 0.15]));
    let low = ground("height_m = -2, colour = [0, 0.5, 1]").expect("it is sound");
    assert_eq!(low, Some(Ground { terrain: plane(-2.0), color: [0.0, 0.5, 1.0] }));
    let map = "height_map = \"h.png\", origin_m = [-5, 1, -6], size_m = [10, 12], height_m = [0, 2.5]";
    let Some(Ground { terrain: Terrain::Map(map_found), .. }) = ground(map).expect("it is sound") else {
        panic!("a height map was named");
    };
    assert_eq!(map_found.file, Path::new("scenes/h.png"));
    assert_eq!((map_found.origin_m, map_found.size_m), ([-5.0, 1.0, -6.0], [10.0, 12.0]));
    assert_eq!(map_found.height_m, [0.0, 2.5]);
    for (text, expected) in [
        ("colour = [0, 0, 1.5]".to_owned(), "line 1, ground.colour: found 1.5, expected 0 to 1"),
        ("height_m = nan".to_owned(), "line 1, ground.height_m: found NaN"),
        ("height_m = [0, 1]".to_owned(), "ground.height_m: found [0, 1], expected a number for a plane"),
        ("size_m = [1, 1]".to_owned(), "ground: found origin_m or size_m without height_map"),
        ("height_map = \"h.png\"".to_owned(), "ground: found a height_map without origin_m or size_m"),
        (map.replace(", height_m = [0, 2.5]", ""), "ground.height_m: found none, expected [low, high]"),
        (map.replace("[0, 2.5]", "2.5"), "ground.height_m: found 2.5, expected [low, high]"),
        (map.replace("[0, 2.5]", "[3, 2.5]"), "ground.height_m: found 2.5, expected 3 to 1000000000"),
        (map.replace("[10, 12]", "[10, 0]"), "ground.size_m: found 0"),
        (map.replace("[-5,", "[inf,"), "ground.origin_m: found inf"),
        ("steepness = 1".to_owned(), "unknown field `steepness`"),
    ] {
        let message = ground(&text).expect_err(&text).to_string();
        assert!(message.contains(expected), "{message} for {expected}");
    }
}

#[test]
fn a_species_names_the_library_of_its_light_and_may_have_another_name_there() {
    let with = |more: &str| parse(&SCENE.replacen("file =", &format!("{more}\nfile ="), 1));
    let species = |more: &str| with(more).expect(more).species[0].clone();
    let lit = species("light = \"light/oak.flb\"");
    assert_eq!((lit.light.as_deref(), lit.light_species), (Some(Path::new("scenes/light/oak.flb")), None));
    let named = species("light = \"all.flb\"\nlight_species = \"elm\"");
    assert_eq!(named.light_species.as_deref(), Some("elm"));
    let message = with("light_species = \"elm\"").expect_err("no light").to_string();
    assert!(message.contains("line 4, species: found light_species without light"), "{message}");
}

#[test]
fn yaw_turns_clockwise_as_azimuth_does_and_a_quaternion_agrees() {
    let turned = |turn: &str| {
        parse(&SCENE.replace("yaw_deg = 90.0", turn)).expect(turn).instances[0].transform.rotation
    };
    let apply = |rotation: [[f64; 3]; 3], v: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|row| (0..3).map(|column| rotation[row][column] * v[column]).sum())
    };
    let (north, east) = ([0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
    assert_eq!(apply(turned("yaw_deg = 90"), north), east);
    // Right-handed about +Y is counterclockwise seen from above.
    let half = 15.0f64.to_radians();
    let by_quaternion = turned(&format!("rotation = [0, {}, 0, {}]", -libm::sin(half), libm::cos(half)));
    let by_yaw = turned("yaw_deg = 30");
    for (a, b) in by_quaternion.iter().flatten().zip(by_yaw.iter().flatten()) {
        assert!((a - b).abs() < 1e-15, "{by_quaternion:?} for {by_yaw:?}");
    }
    assert_eq!(by_quaternion[1], [0.0, 1.0, 0.0]);
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    for (from, to, expected) in [
        ("name =", "nam =", "line 3"),
        ("name =", "nam =", "unknown field `nam`"),
        ("[1, 2, 3]", "[1, 2]", "line 8"),
        ("[1, 2, 3]", "[1, 2, inf]", "line 6, instance.position_m: found inf"),
        (
            "\"oak\"\nposition",
            "\"ash\"\nposition",
            "line 6, instance.species: found \"ash\", expected one of oak",
        ),
        ("= 90.0", "= nan", "line 6, instance.yaw_deg: found NaN, expected -36000 to 36000"),
        ("90.0", "90.0\nscale = 0", "line 6, instance.scale: found 0"),
        (
            "90.0",
            "90.0\nrotation = [0, 0, 0, 1]",
            "line 6, instance: found yaw_deg and rotation, expected one",
        ),
        ("yaw_deg = 90.0", "rotation = [0, 0, 0, 0]", "length of instance.rotation: found 0"),
        ("\"oak\"\nfile", "\"\"\nfile", "line 2, species.name: found \"\""),
        ("file =", "upright = true\nfile =", ""),
    ] {
        if expected.is_empty() {
            parse(&SCENE.replacen(from, to, 1)).expect("a yaw is upright");
            continue;
        }
        let message = refusal(from, to);
        assert!(
            message.starts_with("forest.toml: ") && message.contains(expected),
            "{message} for {expected}"
        );
    }
    let tilted = SCENE
        .replace("file", "upright = true\nfile")
        .replace("yaw_deg = 90.0", "rotation = [0.6, 0, 0, 0.8]");
    let message = parse(&tilted).expect_err("it tilts").to_string();
    assert!(
        message.contains("line 7, instance.rotation: found a tilted plant of the upright species \"oak\""),
        "{message}"
    );
    let camera = |text: &str| format!("camera = {{ {text} }}\n");
    for (more, expected) in [
        ("bands = []\n".to_owned(), "line 1, bands: found 0 names"),
        ("bands = [\"R\", \"R\"]\n".to_owned(), "bands: found \"R\" twice"),
        ("sky = { ambient = -1 }\n".to_owned(), "line 1, sky.ambient: found -1"),
        (
            "sky = { clear = { turbidity = 1.9 } }\n".to_owned(),
            "line 1, sky.clear.turbidity: found 1.9, expected 2 to 10",
        ),
        (
            "sky = { clear = {}, image = \"a.hdr\" }\n".to_owned(),
            "line 1, sky: found clear and image, expected one of them",
        ),
        ("sky = 3\n".to_owned(), "invalid type: integer `3`, expected a table, or the file of an image"),
        ("sky = { clear = 3 }\n".to_owned(), "invalid type: integer `3`, expected a table"),
        ("sky = { clear = { haze = 3 } }\n".to_owned(), "unknown field `haze`, expected `turbidity`"),
        ("sun = {}\n".to_owned(), "line 1, sun: found neither fixed nor path"),
        ("sun = { fixed = [] }\n".to_owned(), "sun.fixed: found none"),
        (
            "sun = [135, 35]\n".to_owned(),
            "expected a table with fixed = [[azimuth, elevation], ...] in degrees",
        ),
        (
            "sun = { fixed = [[1, 2], [3]] }\n".to_owned(),
            "sun.fixed: found [3], expected [azimuth, elevation] in degrees, or a list of them",
        ),
        ("sun = { fixed = \"noon\" }\n".to_owned(), "found \"noon\", expected [azimuth, elevation]"),
        (
            "sun = { fixd = [1, 2] }\n".to_owned(),
            "unknown field `fixd`, expected one of `fixed`, `path`, `irradiance`, `added`",
        ),
        ("sun = { fixed = [[0, 91]] }\n".to_owned(), "elevation of sun.fixed: found 91, expected -90 to 90"),
        (
            format!("sun = {{ fixed = [{}] }}\n", "[0, 9],".repeat(1025)),
            "sun.fixed: 1025 is over the limit of 1024",
        ),
        (
            "sun.path = { latitude_deg = 91, longitude_deg = 0, from = 2026-01-01, to = 2026-01-02 }\n"
                .to_owned(),
            "line 1, sun.path: found latitude 91, expected -90 to 90 degrees",
        ),
        (
            "sun.path = { latitude_deg = 1, longitude_deg = 0, from = 2026-01-03, to = 2026-01-02 }\n"
                .to_owned(),
            "found 2026-01-03 to 2026-01-02, expected the earlier day first",
        ),
        (camera("position_m = [0, 0, 0], fov_deg = 180, height_px = 9"), "line 1, camera.fov_deg: found 180"),
        (camera("position_m = [0, 0, 0], fov_deg = 40, height_px = 0"), "camera.height_px: found 0"),
        (camera("fov_deg = 40, height_px = 9"), "camera: found neither position_m nor path_m"),
        (camera("path_m = [], fov_deg = 40, height_px = 9"), "camera: found a path_m without points"),
        (camera("position_m = [0, 0, nan], fov_deg = 40, height_px = 9"), "a position of camera: found NaN"),
        ("terrain = 1\n".to_owned(), "unknown field `terrain`"),
    ] {
        let message = refusal_of(&more);
        assert!(
            message.starts_with("forest.toml: ") && message.contains(expected),
            "{message} for {expected}"
        );
    }
    let message = parse("").expect_err("it is empty").to_string();
    assert_eq!(message, "forest.toml: line 1, species: found none, expected one [[species]] or more");
    let alone = parse("\n[[species]]\nname = \"oak\"\n").expect_err("no instance").to_string();
    assert!(
        alone.contains("line 2, species: found species \"oak\" without an instance, expected"),
        "{alone}"
    );
}

#[test]
fn a_sun_path_on_the_command_line_is_read_or_refused_with_an_example() {
    let path: SunPath = " 52.5 , 13.4, 2024-02-29..2026-08-31".parse().expect("a path");
    assert_eq!((path.from.to_string(), path.to.to_string()), ("2024-02-29".into(), "2026-08-31".into()));
    let day: SunPath = "-90,180,2026-06-21".parse().expect("a day");
    assert_eq!(day.from, day.to);
    for (text, expected) in [
        ("", "expected LAT,LON,DATE..DATE"),
        ("52.5,13.4", "such as 52.5,13.4,2026-06-01..2026-08-31"),
        ("52.5,x,2026-06-21", "expected LAT,LON"),
        ("52.5,13.4,2026-02-30", "expected LAT,LON"),
        ("52.5,13.4,2026-06-21T10:00:00", "expected a date without a time"),
        ("52.5,13.4,1899-12-31", "expected a year from 1900 to 2100"),
        ("nan,13.4,2026-06-21", "found latitude NaN, expected -90 to 90"),
        ("0,181,2026-06-21", "found longitude 181"),
        ("0,0,2026-06-22..2026-06-21", "the earlier day first"),
    ] {
        let message = text.parse::<SunPath>().expect_err(text);
        assert!(message.contains(expected), "{message} for {expected}");
    }
}

#[test]
fn days_are_counted_over_leap_years() {
    for (text, expected) in [
        ("2000-01-01", 0),
        ("2000-03-01", 60),
        ("2001-01-01", 366),
        ("1900-03-01", -36_465),
        ("2100-12-31", 36_889),
    ] {
        let path: SunPath = format!("0,0,{text}").parse().expect(text);
        assert_eq!(path.from.since_2000(), expected, "{text}");
    }
}

fn grey_png(folder: &Path, name: &str, image: image::DynamicImage) -> std::path::PathBuf {
    let path = folder.join(name);
    image.save_with_format(&path, image::ImageFormat::Png).expect("a temporary file");
    path
}

#[test]
fn heights_come_from_grey_pixels_and_lie_on_triangles_between_them() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pixels =
        image::ImageBuffer::from_raw(3, 2, vec![0u16, 65_535, 0, 13_107, 0, 65_535]).expect("6 pixels");
    let file = grey_png(folder.path(), "h.png", image::DynamicImage::ImageLuma16(pixels));
    let map = HeightMap { file, origin_m: [10.0, 1.0, 20.0], size_m: [4.0, 3.0], height_m: [-1.0, 4.0] };
    let heights = map.read().expect("it is sound");
    assert_eq!((heights.columns, heights.rows, heights.spacing_m()), (3, 2, [2.0, 3.0]));
    assert_eq!(heights.height_m, [0.0, 5.0, 0.0, 1.0, 0.0, 5.0]);
    for (x_m, z_m, expected) in [
        (10.0, 20.0, 0.0),
        (12.0, 20.0, 5.0),
        (11.0, 20.0, 2.5),
        (11.0, 21.5, 3.0), // on the diagonal, from 5 to 1
        (10.5, 20.75, 1.5),
        (12.0, 23.0, 0.0),
        (0.0, 0.0, 0.0), // beyond the edge
        (99.0, 99.0, 5.0),
    ] {
        assert!((heights.at_m(x_m, z_m) - expected).abs() < 1e-6, "{x_m}, {z_m}: {}", heights.at_m(x_m, z_m));
    }
}

#[test]
fn a_picture_that_is_no_grey_png_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let grey =
        image::DynamicImage::ImageLuma8(image::ImageBuffer::from_raw(2, 1, vec![0, 255]).expect("2 pixels"));
    let flat = grey_png(folder.path(), "flat.png", grey.clone());
    let read = Grey::read(&flat).expect("it is sound");
    assert_eq!((read.columns, read.rows, &read.values[..]), (2, 1, &[0.0, 1.0][..]));
    assert_eq!([read.at(0.0, 0.5), read.at(0.5, 0.5), read.at(1.0, 0.0)], [0.0, 0.5, 1.0]);
    let map = HeightMap { file: flat, origin_m: [0.0; 3], size_m: [1.0; 2], height_m: [0.0, 1.0] };
    let message = map.read().expect_err("one row").to_string();
    assert!(message.contains("found 2 x 1, expected 2 x 2 or more for a height map"), "{message}");
    let colors = grey_png(folder.path(), "rgb.png", image::DynamicImage::ImageRgb8(grey.into_rgb8()));
    let message = Grey::read(&colors).expect_err("colours").to_string();
    assert!(message.contains("rgb.png: pixels: found Rgb8, expected grey of 8 or 16 bits"), "{message}");
    let text = folder.path().join("text.png");
    std::fs::write(&text, "no picture").expect("a temporary file");
    assert!(matches!(Grey::read(&text), Err(ImportError::Syntax { .. })));
    assert!(matches!(Grey::read(&folder.path().join("none.png")), Err(ImportError::Io { .. })));
    // A header alone that claims 20,000 pixels in a row.
    let mut wide = std::fs::read(&map.file).expect("it was written");
    wide[16..20].copy_from_slice(&20_000u32.to_be_bytes());
    let sum = crc32(&wide[12..29]);
    wide[29..33].copy_from_slice(&sum.to_be_bytes());
    std::fs::write(&text, &wide).expect("a temporary file");
    let message = Grey::read(&text).expect_err("too wide").to_string();
    assert!(message.contains("pixels along an edge: 20000 is over the limit of 16384"), "{message}");
}

/// Of PNG, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
    })
}

#[test]
fn a_path_is_met_at_its_points_and_halfway_between_them() {
    let path = [[0.0, 10.0], [4.0, 10.0], [4.0, -10.0]];
    let at = |share| along(&path, share);
    assert_eq!([at(0.0), at(0.5), at(1.0)], path);
    assert_eq!([at(0.25), at(0.75)], [[2.0, 10.0], [4.0, 0.0]]);
    assert_eq!(along(&path[..1], 0.7), path[0]);
}

#[test]
fn a_path_takes_as_long_for_each_of_its_lines() {
    let points = [[0.0, 0.0], [10.0, 0.0], [10.0, 2.0]];
    let table =
        [(0.0, [0.0, 0.0]), (0.25, [5.0, 0.0]), (0.5, [10.0, 0.0]), (0.75, [10.0, 1.0]), (1.0, [10.0, 2.0])];
    for (t, expected) in table {
        assert_eq!(along(&points, t), expected, "at {t}");
    }
    assert_eq!(along(&[[7.0]], 0.3), [7.0]);
}
