//! `flb scatter`, and `flb render` of scenes.

use serde_json::{Value, json};

use crate::flb::{Folder, PAPER};
use crate::picture::pixels;
use crate::schema::{misfits, schema};

#[track_caller]
fn fits(command: &str, value: &Value) {
    assert_eq!(misfits(&schema(command), value), [""; 0], "{command}: {value}");
}

/// With an oak and a shrub, baked small by a model into `oak.flb` and `shrub.flb`.
fn baked(model: &[&str]) -> Folder {
    let flags = [&["--lattice", "16", "--voxels", "128"], model].concat();
    Folder::with_baked(&["oak", "shrub"], &flags, &[0, 3])
}

const SPECIES: [&str; 4] = ["--species", "oak=oak.glb,oak.flb*2", "--species", "shrub=shrub.glb,shrub.flb"];

/// Writes `stand.toml` with 24 plants.
fn scatter(folder: &Folder) {
    let words = ["scatter", "--count", "24", "--area", "60,40", "-o", "stand.toml"];
    folder.flb_with(&words, &SPECIES).expect_code(0);
}

#[test]
fn a_stand_is_scattered_the_same_every_time_and_can_be_planned() {
    let folder = baked(&PAPER);
    let words = ["scatter", "--spacing", "3", "--area", "60,40", "--scale", "0.5..0.7", "--json"];
    let scattered = folder.flb_with(&words, &[&SPECIES[..], &["-o", "a.toml"]].concat()).expect_code(0);
    fits("scatter", &scattered.json());
    let count = scattered.json()["instances"].as_u64().expect("a count");
    assert!((140..200).contains(&count), "{count}");
    let oaks = scattered.json()["species"][0]["instances"].as_u64().expect("a count") as f64 / count as f64;
    assert!((oaks - 2.0 / 3.0).abs() < 0.12, "{oaks}");
    folder.flb_with(&words, &[&SPECIES[..], &["-o", "b.toml", "--threads", "1"]].concat()).expect_code(0);
    assert_eq!(folder.read("a.toml"), folder.read("b.toml"));
    folder.flb_with(&words, &[&SPECIES[..], &["-o", "c.toml", "--seed", "2"]].concat()).expect_code(0);
    assert_ne!(folder.read("a.toml"), folder.read("c.toml"));
    folder.flb(&["plan", "a.toml", "-o", "plan.toml"]).expect_code(0);
    // From another folder the files are still found.
    std::fs::create_dir(folder.path("deep")).expect("a folder");
    folder.flb_with(&words, &[&SPECIES[..], &["-o", "deep/a.toml"]].concat()).expect_code(0);
    folder.flb(&["plan", "deep/a.toml", "-o", "deep.toml"]).expect_code(0);
}

#[test]
fn with_yaws_each_plant_is_turned_by_one_of_them() {
    let folder = Folder::with_plants(&["shrub"]);
    let words = ["scatter", "--species", "shrub=shrub.glb", "--count", "200", "--area", "60,60"];
    let yaws = |yaws: &str, name: &str| -> Vec<f64> {
        folder.flb_with(&words, &["--yaws", yaws, "-o", name]).expect_code(0);
        let text = String::from_utf8(folder.read(name)).expect("TOML is text");
        let all = text.lines().filter_map(|line| line.strip_prefix("yaw_deg = "));
        all.map(|yaw| yaw.parse().expect("a number")).collect()
    };
    for (count, name) in [(8, "eight.toml"), (7, "seven.toml")] {
        let mut plants = vec![0; count];
        for yaw in yaws(&count.to_string(), name) {
            let turn = yaw * count as f64 / 360.0;
            assert!((turn - turn.round()).abs() < 1e-5, "{yaw}");
            plants[turn.round() as usize] += 1;
        }
        assert!(plants.iter().all(|plants| (10..50).contains(plants)), "{plants:?}");
    }
    assert!(yaws("1", "one.toml").iter().all(|yaw| *yaw == 0.0));
    assert_eq!(folder.flb_with(&words, &["--yaws", "0", "-o", "none.toml"]).code, 2);
}

#[test]
fn plants_stand_on_the_height_map_and_where_the_density_map_is_bright() {
    let folder = Folder::with_plants(&["shrub"]);
    let grey = |name: &str, values: [u8; 4]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
        encoder.set_color(png::ColorType::Grayscale);
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(&values).expect("4 pixels");
        writer.finish().expect("an end");
        folder.write(name, bytes);
    };
    grey("west.png", [255, 0, 255, 0]);
    grey("slope.png", [0, 255, 0, 255]);
    let words = ["scatter", "--species", "shrub=shrub.glb", "--count", "300", "--area", "40,40"];
    let maps = ["--density", "west.png", "--height-map", "slope.png", "--height", "-2..6"];
    folder.flb_with(&words, &[&maps[..], &["-o", "hill.toml"]].concat()).expect_code(0);
    let text = String::from_utf8(folder.read("hill.toml")).expect("TOML is text");
    let positions: Vec<[f64; 3]> = text
        .lines()
        .filter_map(|line| line.strip_prefix("position_m = "))
        .skip(1)
        .map(|list| serde_json::from_str(list).expect("three numbers"))
        .collect();
    assert_eq!(positions.len(), 300);
    for [x, y, _] in &positions {
        assert!((y - (2.0 + x * 0.2)).abs() < 2e-3, "{x}: {y}");
    }
    let far_west = positions.iter().filter(|[x, ..]| *x < -10.0).count();
    let far_east = positions.iter().filter(|[x, ..]| *x > 10.0).count();
    assert!(far_west > 120 && far_east == 0, "{far_west} and {far_east}");
    let render = ["render", "hill.toml", "--size", "40x30", "--samples", "1", "-o", "hill.png"];
    folder.flb(&render).expect_code(0);
    assert!(pixels(&folder.read("hill.png")).iter().any(|value| *value > 50));
}

#[test]
fn a_scene_is_drawn_in_the_light_of_its_species_to_the_same_bytes_by_any_number_of_threads() {
    let folder = baked(&PAPER);
    scatter(&folder);
    let render = ["render", "stand.toml", "--size", "64x36", "--samples", "2"];
    let run = folder.flb_with(&render, &["--json", "-o", "all.png"]).expect_code(0).json();
    fits("render", &run);
    assert_eq!((&run["species"], &run["suns"]), (&json!("oak, shrub"), &json!([[135.0, 35.0]])));
    assert_eq!(
        (&run["scene"]["instances"], &run["scene"]["species"][1]["model"]),
        (&json!(24), &json!("paper"))
    );
    folder.flb_with(&render, &["--threads", "1", "-o", "one.png"]).expect_code(0);
    assert_eq!(folder.read("all.png"), folder.read("one.png"));
    // Baked light is there: it is most of what shows on plants.
    folder.flb_with(&render, &["--show", "direct", "-o", "off.png"]).expect_code(0);
    let sum = |name: &str| pixels(&folder.read(name)).iter().map(|value| u64::from(*value)).sum::<u64>();
    assert!(sum("all.png") > sum("off.png") + 20_000, "{} {}", sum("all.png"), sum("off.png"));
    // Several suns make a sheet, as of a single plant.
    let sheet = ["--sun", "90,20", "--sun", "180,60", "--json", "-o", "sheet.png"];
    let run = folder.flb_with(&render, &sheet).expect_code(0).json();
    assert_eq!((&run["width"], &run["height"]), (&json!(132), &json!(36)));
    // Linear, in f32: a PNG hides the last bits.
    for threads in ["1", "2", "3"] {
        let name = format!("linear{threads}.exr");
        folder.flb_with(&render, &["--threads", threads, "-o", &name]).expect_code(0);
        assert!(folder.read(&name) == folder.read("linear1.exr"), "{threads} threads");
    }
}

#[test]
fn physical_species_light_a_scene_by_harmonics_and_by_directions() {
    for suns in [&["--suns", "sh1", "--ordinates", "18"][..], &["--suns", "lattice18", "--ordinates", "18"]] {
        let folder = baked(suns);
        scatter(&folder);
        let render = ["render", "stand.toml", "--size", "48x27", "--samples", "1"];
        let run = folder.flb_with(&render, &["--json", "-o", "day.png"]).expect_code(0).json();
        fits("render", &run);
        assert_eq!(run["scene"]["species"][0]["model"], "physical");
        folder.flb_with(&render, &["--sun", "0,-10", "-o", "night.png"]).expect_code(0);
        folder.flb_with(&render, &["--sun", "0,-10", "--ambient", "0", "-o", "dark.png"]).expect_code(0);
        let sum = |name: &str| pixels(&folder.read(name)).iter().map(|value| u64::from(*value)).sum::<u64>();
        assert!(sum("day.png") > sum("night.png") && sum("night.png") > sum("dark.png"));
        assert_eq!(sum("dark.png"), 0);
    }
}

/// Largest change of a pixel of baked light, of 255, between frames half a degree apart: 3 was found.
const MAX_CHANGE: u8 = 6;
/// Mean change of a whole picture, of 255, shadows included: 4.2 was found, for their edges move over every leaf.
const MEAN_CHANGE: f64 = 6.0;
/// Largest change of a pixel of baked light between morning and noon, at least: else nothing was compared.
const CHANGE_OF_A_DAY: u8 = 2 * MAX_CHANGE;

#[test]
fn any_way_to_find_what_rays_meet_makes_the_same_picture() {
    let folder = baked(&PAPER);
    scatter(&folder);
    let render = ["render", "stand.toml", "--size", "48x27", "--sun", "120,25", "--force", "-o", "a.png"];
    let picture = |find: &[&str]| {
        folder.flb_with(&render, find).expect_code(0);
        folder.read("a.png")
    };
    let default = picture(&[]);
    for find in ["model=grid,camera=grid,sun=grid", "model=tree,camera=tree,sun=tree", "sun=grid"] {
        assert_eq!(default, picture(&["--find", find]), "{find}");
    }
    folder.flb_with(&render, &["--find", "model=kd"]).expect_code(2).says(&["expected some of model"]);
}

#[test]
fn layers_of_a_scene_and_of_a_plant_are_in_one_exr_or_in_a_png_with_alpha() {
    let folder = baked(&PAPER);
    scatter(&folder);
    let scene = ["render", "stand.toml", "--size", "32x18", "--sun", "90,30", "--force"];
    let plant = ["render", "oak.flb", "--mesh", "oak.glb", "--size", "24x24", "--sun", "90,30", "--force"];
    for render in [&scene[..], &plant] {
        let all = ["--show", "light,direct,indirect,base:3,alpha", "-o", "all.exr"];
        folder.flb_with(render, &all).expect_code(0);
        let exr = folder.read("all.exr");
        let has = |exr: &[u8], name: &str| {
            let name = [name.as_bytes(), &[0]].concat();
            exr.windows(name.len()).any(|found| found == name)
        };
        for name in ["A", "R", "direct.R", "indirect.B", "base3.G"] {
            assert!(has(&exr, name), "{name}");
        }
        folder.flb_with(render, &["--show", "indirect", "-o", "one.exr"]).expect_code(0);
        let one = folder.read("one.exr");
        assert!(has(&one, "R") && !has(&one, "indirect.R") && !has(&one, "A"));
        folder.flb_with(render, &["--show", "light,alpha", "-o", "over.png"]).expect_code(0);
        let png = folder.read("over.png");
        assert_eq!((png[24], png[25]), (8, 6), "8 bits of red, green, blue and alpha");
        folder.flb_with(render, &["-o", "plain.png"]).expect_code(0);
        assert_eq!(folder.read("plain.png")[25], 2);
        let refused = |show: &str, output: &str, says: &[&str]| {
            folder.flb_with(render, &["--show", show, "-o", output]).expect_code(2).says(says);
        };
        refused("light,direct", "a.png", &["a.png", "--show", "an .exr holds all"]);
        refused("alpha", "a.png", &["a.png", "--show"]);
        refused("light,light", "a.exr", &["light twice is to be shown"]);
        refused("base:99", "a.exr", &["base 99 is to be shown", "bases 0 to 18"]);
        refused(
            "lit",
            "a.exr",
            &["found \"lit\", expected light, direct, indirect, base:N, global or alpha"],
        );
        refused("global", "a.exr", &[]);
    }
}

#[test]
fn light_changes_little_while_the_sun_moves_half_a_degree() {
    for model in [&PAPER[..], &["--suns", "sh1", "--ordinates", "18"]] {
        let folder = baked(model);
        scatter(&folder);
        // From the east over the south to the west, 60 degrees high at noon.
        let suns = ["--sun", "90,1", "--sun", "180,60", "--sun", "270,1"];
        let render = ["render", "stand.toml", "--size", "32x18", "--samples", "8", "--frames", "433"];
        let frames = |show: &str| -> Vec<Vec<u8>> {
            let out = format!("{show}.png");
            let words = ["--show", show, "-o", &out, "--json"];
            let run = folder.flb_with(&[&render[..], &suns].concat(), &words).expect_code(0).json();
            fits("render", &run);
            assert_eq!(run["scene"]["frames"].as_array().map(Vec::len), Some(433));
            assert_eq!((&run["suns"][0], &run["suns"][432]), (&json!([90.0, 1.0]), &json!([270.0, 1.0])));
            (1..=433).map(|frame| pixels(&folder.read(&format!("{show}-{frame:04}.png")))).collect()
        };
        let changes = |frames: &[Vec<u8>]| -> Vec<Vec<u8>> {
            let change = |pair: &[Vec<u8>]| {
                pair[0].iter().zip(&pair[1]).map(|(a, b)| a.abs_diff(*b)).collect::<Vec<u8>>()
            };
            frames.windows(2).map(change).collect()
        };
        // Baked light alone has no shadow edges.
        let baked = frames("indirect");
        let largest = changes(&baked).iter().flatten().copied().max().expect("pixels");
        assert!(largest <= MAX_CHANGE, "{model:?}: {largest}");
        // It does change: the comparison can find something.
        let whole_day = baked[0].iter().zip(&baked[216]).map(|(a, b)| a.abs_diff(*b)).max().expect("pixels");
        assert!(whole_day >= CHANGE_OF_A_DAY, "{model:?}: {whole_day}");
        for change in changes(&frames("light")) {
            let mean = change.iter().map(|value| f64::from(*value)).sum::<f64>() / change.len() as f64;
            assert!(mean <= MEAN_CHANGE, "{model:?}: {mean}");
        }
    }
}

#[test]
fn frames_follow_the_sun_of_a_place() {
    let folder = Folder::with_plants(&["shrub"]);
    let scene = |sun: &str| {
        format!(
            "{sun}[camera]\nposition_m = [0.0, 1.0, 6.0]\nlook_at_m = [0.0, 0.8, 0.0]\nfov_deg = 40.0\nheight_px = 18\n[ground]\n\
             [[species]]\nname = \"shrub\"\nfile = \"shrub.glb\"\n[[instance]]\nspecies = \"shrub\"\nposition_m = [0.0, 0.0, 0.0]\n"
        )
    };
    folder.write("day.toml", scene(""));
    let render = |file: &str, words: &[&str]| {
        folder.flb_with(&["render", file, "--samples", "1", "-o", "f.png", "--force", "--json"], words)
    };
    let frames = ["--frames", "3"];
    let berlin = ["--sun-path", "52.5,13.4,2026-06-21T05:00..2026-06-21T21:00"];
    let run = render("day.toml", &[&frames[..], &berlin].concat()).expect_code(0).json();
    fits("render", &run);
    let times = ["2026-06-21T05:00:00Z", "2026-06-21T13:00:00Z", "2026-06-21T21:00:00Z"];
    assert_eq!(run["scene"]["times"], json!(times));
    let elevation = |frame: usize| run["suns"][frame][1].as_f64().expect("a number");
    assert!(elevation(0) > 15.0 && elevation(1) > 50.0 && elevation(2) < -5.0, "{}", run["suns"]);
    // The night's frame is lit by the sky alone.
    let sum = |name: &str| pixels(&folder.read(name)).iter().map(|value| u64::from(*value)).sum::<u64>();
    let night = sum("f-0003.png");
    assert!(sum("f-0002.png") > night);
    render("day.toml", &[&frames[..], &berlin, &["--ambient", "0"]].concat()).expect_code(0);
    assert!(sum("f-0003.png") < night);

    // A whole day, of the flag and of the scene's own path, starts and ends at the horizon.
    let run = render("day.toml", &[&frames[..], &["--sun-path", "52.5,13.4,2026-06-21"]].concat());
    let run = run.expect_code(0).json();
    let path =
        "[sun]\npath = { latitude_deg = 52.5, longitude_deg = 13.4, from = 2026-06-21, to = 2026-08-31 }\n";
    folder.write("path.toml", scene(path));
    let of_scene = render("path.toml", &frames).expect_code(0).json();
    assert_eq!((&run["suns"], &run["scene"]["times"]), (&of_scene["suns"], &of_scene["scene"]["times"]));
    let noon = of_scene["suns"][1][1].as_f64().expect("a number");
    assert!((noon - (90.0 - 52.5 + 23.436)).abs() < 0.02, "{noon}");
    assert!(
        (0..=2)
            .step_by(2)
            .all(|end| of_scene["suns"][end][1].as_f64().is_some_and(|up| (0.0..1e-6).contains(&up)))
    );
    // Suns that are named win over the path, and have no times.
    let named = render("path.toml", &["--sun", "90,10"]).expect_code(0).json();
    assert_eq!((&named["suns"], &named["scene"]["times"]), (&json!([[90.0, 10.0]]), &json!([])));

    folder.write(
        "night.toml",
        scene(&path.replace("52.5", "80.0").replace("06-21, to = 2026-08", "12-21, to = 2026-12")),
    );
    for (file, words, expected) in [
        ("path.toml", &[][..], "path.toml: the scene's sun has a path: take --frames N"),
        ("day.toml", &frames, "day.toml: the scene has no suns of its own: name one with --sun"),
        (
            "night.toml",
            &frames,
            "night.toml: [sun] path: found 2026-12-21 at latitude 80, when the sun does not rise",
        ),
        ("day.toml", &berlin, "--frames"),
        ("day.toml", &["--frames", "3", "--sun", "1,1", "--sun-path", "0,0,2026-06-21"], "--sun"),
        (
            "day.toml",
            &["--frames", "3", "--sun-path", "52.5,13.4,5am..9pm"],
            "such as 52.5,13.4,2026-06-21T05:00",
        ),
    ] {
        render(file, words).expect_code(2).says(&[expected]);
    }
}

#[test]
fn a_camera_moves_along_its_path() {
    let folder = Folder::with_plants(&["shrub"]);
    folder.write(
        "walk.toml",
        "[sun]\nfixed = [[180.0, 40.0]]\n\
         [camera]\npath_m = [[0.0, 1.0, 6.0], [0.0, 1.0, 3.0]]\nlook_at_m = [0.0, 0.8, 0.0]\nfov_deg = 40.0\nheight_px = 18\n\
         [[species]]\nname = \"shrub\"\nfile = \"shrub.glb\"\n\
         [[instance]]\nspecies = \"shrub\"\nposition_m = [0.0, 0.0, 0.0]\n",
    );
    let render = ["render", "walk.toml", "--frames", "3", "--samples", "1", "-o", "f.png", "--json"];
    let run = folder.flb(&render).expect_code(0).json();
    assert_eq!((&run["width"], &run["height"]), (&json!(32), &json!(18)));
    assert_eq!(run["scene"]["frames"], json!(["f-0001.png", "f-0002.png", "f-0003.png"]));
    let frames = [1, 2, 3].map(|frame| folder.read(&format!("f-000{frame}.png")));
    assert!(frames[0] != frames[1] && frames[1] != frames[2]);
    folder.flb(&render).expect_code(4).says(&["f-0001.png", "--force"]);
}

#[test]
fn water_is_drawn_and_counted_and_changes_neither_plans_nor_the_light_of_plants() {
    let folder = Folder::with_plants(&["shrub"]);
    let scene = |more: &str, y: &str| {
        format!(
            "{more}[sun]\nfixed = [[180.0, 40.0], [90.0, 5.0]]\n\
             [camera]\nposition_m = [0.0, {y}, 6.0]\nlook_at_m = [0.0, 0.6, 0.0]\nfov_deg = 40.0\nheight_px = 27\n\
             [[species]]\nname = \"shrub\"\nfile = \"shrub.glb\"\n[[instance]]\nspecies = \"shrub\"\nposition_m = [0.0, 0.05, 0.0]\n"
        )
    };
    folder.write("dry.toml", scene("", "1.2"));
    folder.write("lake.toml", scene("[water]\nheight_m = 0\n", "1.2"));
    let render = |file: &str, output: &str, words: &[&str]| {
        folder.flb_with(&["render", file, "--samples", "2", "-o", output, "--json", "--force"], words)
    };
    let [dry, lake] = ["dry", "lake"].map(|name| {
        let run = render(&format!("{name}.toml"), &format!("{name}.png"), &[]).expect_code(0).json();
        fits("render", &run);
        let rays: [u64; 4] = serde_json::from_value(run["scene"]["rays"].clone()).expect("four counts");
        assert_eq!(rays.iter().sum::<u64>(), 48 * 27 * 2);
        rays
    });
    // What was sky below the horizon is water; the shrub stands above it, and its image lies in it.
    assert_eq!((dry[3], dry[0], dry[1]), (0, lake[0], 0));
    assert!(lake[3] > 500 && lake[2] + lake[3] == dry[2], "{lake:?} {dry:?}");
    assert_ne!(folder.read("dry.png"), folder.read("lake.png"));
    // Frames light again what was traced once: the last is that of a picture of its sun alone.
    render("lake.toml", "f.png", &["--frames", "2"]).expect_code(0);
    render("lake.toml", "last.png", &["--sun", "90,5", "--threads", "1"]).expect_code(0);
    assert_eq!(folder.read("f-0002.png"), folder.read("last.png"));

    for name in ["dry", "lake"] {
        folder.flb(&["plan", &format!("{name}.toml"), "-o", &format!("plan-{name}.toml")]).expect_code(0);
    }
    assert_eq!(folder.read("plan-dry.toml"), folder.read("plan-lake.toml"));

    for (more, y, expected) in [
        (
            "[water]\nheight_m = 1.2\n",
            "1.2",
            "x.toml: [camera] stands at a height of 1.2 m in picture 1 of 1, expected above the [water]",
        ),
        (
            "[water]\nheight_m = 0\ncolour = [0, 2, 0]\n",
            "1.2",
            "x.toml: line 3, water.colour: found 2, expected 0 to 1",
        ),
        (
            "ground = {}\nwater = { height_m = 0 }\n",
            "1.2",
            "x.toml: line 2, water.height_m: found 0, expected above",
        ),
    ] {
        folder.write("x.toml", scene(more, y));
        let run = render("x.toml", "x.png", &[]);
        assert!(run.code == 1 || run.code == 2, "{}", run.stderr);
        run.says(&[expected]);
    }
    assert!(!folder.path("x.png").exists());
}

#[test]
fn what_a_scene_lacks_is_named() {
    let folder = baked(&PAPER);
    scatter(&folder);
    let scene = String::from_utf8(folder.read("stand.toml")).expect("TOML is text");
    let render =
        |words: &[&str]| folder.flb_with(&["render", "bad.toml", "-o", "x.png", "--size", "8x8"], words);
    let edited = |from: &str, to: &str| {
        assert!(scene.contains(from), "{from}");
        folder.write("bad.toml", scene.replace(from, to));
    };
    for (from, to, code, expected) in [
        (
            "look_at_m = [0.0, 0.0, 0.0]\n",
            "",
            2,
            "bad.toml: [camera] has no look_at_m, which a picture needs",
        ),
        (
            "fixed = [[135.0, 35.0]]",
            "path = { latitude_deg = 1, longitude_deg = 1, from = 2026-06-01, to = 2026-06-01 }",
            2,
            "name one with --sun",
        ),
        ("file = \"oak.glb\"\n", "", 2, "species \"oak\" has no mesh as its file"),
        ("file = \"oak.glb\"", "file = \"oak.flb\"", 2, "species \"oak\" has no mesh as its file"),
        ("light = \"oak.flb\"", "light = \"none.flb\"", 4, "none.flb"),
        (
            "light = \"oak.flb\"",
            "light = \"oak.flb\"\nlight_species = \"elm\"",
            2,
            "no species is named \"elm\"; there are: oak",
        ),
        ("file = \"oak.glb\"", "file = \"shrub.glb\"", 2, "does not fit the light of species \"oak\""),
        (
            "height_m = 0.0",
            "height_map = \"no.png\"\norigin_m = [0, 0, 0]\nsize_m = [1, 1]\nheight_m = [0, 1]",
            4,
            "no.png",
        ),
        ("look_at_m = [0.0, 0.0, 0.0]\n", "look_at_m = [0.0, 0.0]\n", 2, "bad.toml"),
    ] {
        edited(from, to);
        let run = render(&["--force"]);
        assert!(run.code != 0 || code == 0, "{from}");
        run.says(&[expected]);
    }
    edited("fov_deg", "fov_deg");
    for (words, expected) in [
        (&["--mesh", "oak.glb"][..], "--mesh is for a single plant"),
        (&["--view", "1,1"], "--view is for a single plant"),
        (&["--against", "oak.flb"], "--against is for a single plant"),
        (&["--path-traced"], "--path-traced is for a single plant"),
        (&["--frames", "0"], "--frames"),
    ] {
        render(words).expect_code(2).says(&[expected]);
    }
    for (words, expected) in [
        (&["--sun", "1,1"][..], "--mesh <MESH> is missing"),
        (&["--mesh", "oak.glb"], "--sun <AZIMUTH,ELEVATION> is missing"),
        (&["--mesh", "oak.glb", "--sun", "1,1", "--frames", "2"], "--frames is for scenes"),
    ] {
        folder.flb_with(&["render", "oak.flb", "-o", "y.png"], words).expect_code(2).says(&[expected]);
    }
    // Light of two models is in different units.
    let bake =
        ["bake", "shrub.glb", "-o", "other.flb", "--lattice", "16", "--voxels", "128", "--suns", "sh1"];
    folder.flb_with(&bake, &["--ordinates", "18"]);
    edited("light = \"shrub.flb\"", "light = \"other.flb\"\nlight_species = \"shrub\"");
    render(&["--force"]).expect_code(2).says(&[
        "is of the model paper, species \"",
        "(other.flb) of physical: expected one model, as their light is in different units",
    ]);
}

#[test]
fn what_cannot_be_scattered_is_refused() {
    let folder = Folder::with_plants(&["shrub"]);
    let good = ["scatter", "--species", "shrub=shrub.glb", "-o", "s.toml"];
    for (words, code, expected) in [
        (&[][..], 2, "--count"),
        (&["--count", "0"], 2, "count is 0"),
        (&["--count", "5", "--area", "0,1"], 2, "area is [0.0, 1.0]"),
        (&["--count", "9000000"], 6, "plants: 9000000 is over the limit of 1048576"),
        (&["--count", "5", "--scale", "2..1"], 2, "expected LOW..HIGH"),
        (&["--count", "5", "--scale", "0..1"], 2, "--scale is [0.0, 1.0], expected 0.001 to 1000"),
        (&["--count", "5", "--species", "shrub=shrub.glb"], 2, "--species: \"shrub\" twice"),
        (&["--count", "5", "--species", "elm=elm.glb"], 4, "elm.glb: species \"elm\": there is no such file"),
        (&["--count", "5", "--density", "shrub.glb"], 2, "shrub.glb"),
        (&["--count", "5", "--density", "none.png"], 4, "none.png"),
    ] {
        let run = folder.flb_with(&good, words);
        assert!(run.code == code || (code == 2 && run.code == 1), "{words:?}: {} {}", run.code, run.stderr);
        run.says(&[expected]);
    }
    assert!(!folder.path("s.toml").exists());
}
