//! `flb bake --backend gpu`, `flb render --backend gpu`. Needs an adapter; lavapipe (`scripts/setup test` installs it)
//! will do.

use crate::flb::{Folder, PAPER, SMALL};
use crate::picture::{self, pixels};
use crate::schema;

/// Lattice and voxels of bakes with the default model: software that stands in for a GPU is slow.
const TINY: [&str; 6] = ["--lattice", "16", "--voxels", "128", "--rays", "1"];

#[test]
fn the_gpu_bakes_what_the_cpu_does() {
    let folder = Folder::with_plants(&["shrub"]);
    let bake = |out: &str, more: &[&str]| {
        let words = ["bake", "shrub.glb", "-o", out, "--threshold", "0"];
        let words = [&words[..], &PAPER, &SMALL, more].concat();
        folder.flb(&words).expect_code(0)
    };
    bake("cpu.flb", &[]);
    let run = bake("gpu.flb", &["--backend", "gpu", "--json"]).says(&["flb: solving on "]);
    assert_eq!(run.json()["converged"], true);
    // Of the largest value of each array, and of other bits than the CPU's.
    folder.flb(&["diff", "cpu.flb", "gpu.flb", "--tolerance", "1e-3"]).expect_code(0);
    folder.flb(&["diff", "cpu.flb", "gpu.flb"]).expect_code(1);
    let recorded = b"\"solve.solver\":\"gpu\"";
    assert!(folder.read("gpu.flb").windows(recorded.len()).any(|bytes| bytes == recorded));

    bake("again.flb", &["--backend", "gpu", "--threads", "1", "--gpus", "all"]);
    assert!(folder.read("again.flb") == folder.read("gpu.flb"), "two runs on one GPU differ");
    let words = ["bake", "shrub.glb", "-o", "no.flb", "--gpus", "64"];
    folder.flb(&[&words[..], &["--backend", "gpu"]].concat()).says(&["--gpus 64: found 1 of one kind: "]);
    folder.flb(&words).expect_code(2).says(&["--gpus is for --backend gpu or auto"]);
}

#[test]
fn the_gpu_bakes_the_default_model_as_the_cpu_does() {
    let folder = Folder::with_plants(&["shrub"]);
    let bake = |out: &str, more: &[&str]| {
        let words =
            ["bake", "shrub.glb", "-o", out, "--ordinates", "18", "--suns", "sh1s", "--codec", "raw-f32"];
        folder.flb(&[&words[..], &TINY, more].concat()).expect_code(0)
    };
    bake("cpu.flb", &[]);
    let run = bake("gpu.flb", &["--backend", "gpu", "--json"]).says(&["flb: solving on "]);
    let json = run.json();
    assert_eq!(schema::misfits(&schema::schema("bake"), &json), [""; 0], "{json}");
    assert_eq!(json["converged"], true);
    // Coefficients of a fit are off by more than the light that they make. Stated errors differ in their last digits.
    let differ = |tolerance: &str| -> usize {
        let run = folder.flb(&["diff", "cpu.flb", "gpu.flb", "--tolerance", tolerance]).expect_code(1);
        assert!(run.stdout.contains("base 0"), "{}", run.stdout);
        run.stdout.lines().filter(|line| line.contains("base ") && line.contains("different")).count()
    };
    assert_eq!(differ("1e-3"), 0);
    assert!(differ("0") > 0, "the bits of the CPU");
    let recorded = b"\"solve.solver\":\"ordinates-gpu\"";
    let says = |file: &str| folder.read(file).windows(recorded.len()).any(|bytes| bytes == recorded);
    assert!(says("gpu.flb") && !says("cpu.flb"));

    // What the CPU kept is not taken for the GPU's, nor the other way round.
    let cache = ["--cache", "kept"];
    bake("kept-cpu.flb", &cache);
    bake("again.flb", &[&cache[..], &["--backend", "gpu", "--threads", "1"]].concat());
    assert!(folder.read("again.flb") == folder.read("gpu.flb"), "two runs on one GPU differ");
    assert!(folder.read("kept-cpu.flb") == folder.read("cpu.flb"));
}

#[test]
fn a_bake_that_leaves_it_open_passes_software_and_missing_gpus_over() {
    let folder = Folder::with_plants(&["shrub"]);
    let words = |out: &'static str, backend: &'static str| {
        let words =
            ["bake", "shrub.glb", "-o", out, "--ordinates", "18", "--suns", "sh1s", "--backend", backend];
        [&words[..], &TINY].concat()
    };
    folder.flb(&words("cpu.flb", "cpu")).expect_code(0);
    let nothing = [("WGPU_BACKEND", "vulkan"), ("VK_DRIVER_FILES", "/none"), ("VK_ICD_FILENAMES", "/none")];
    let none = folder.flb_in(&nothing, &words("none.flb", "auto")).expect_code(0);
    none.says(&["solving on the CPU: no GPU"]);
    assert!(folder.read("none.flb") == folder.read("cpu.flb"));
    let run = folder.flb(&words("auto.flb", "auto")).expect_code(0);
    // With a real one it may solve there.
    let on_cpu = run.stderr.contains("solving on the CPU: ");
    assert!(on_cpu == (folder.read("auto.flb") == folder.read("cpu.flb")), "{}", run.stderr);
}

#[test]
fn a_bake_without_a_gpu_says_what_to_install_and_writes_nothing() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let nothing = [("WGPU_BACKEND", "vulkan"), ("VK_DRIVER_FILES", "/none"), ("VK_ICD_FILENAMES", "/none")];
    let words = ["bake", "leaf-card.glb", "-o", "x.flb", "--backend", "gpu"];
    for model in [&PAPER[..], &[]] {
        let run = folder.flb_in(&nothing, &[&words[..], model].concat());
        run.expect_code(5).says(&["no GPU", "VULKAN", "apt-get install mesa-vulkan-drivers"]);
        assert_eq!(folder.names(), ["leaf-card.glb"]);
    }
}

#[test]
fn a_solver_of_the_cpu_on_the_gpu_is_refused() {
    let folder = Folder::with_plants(&["leaf-card"]);
    for (backend, solver) in [("gpu", "sweep"), ("gpu", "explicit"), ("auto", "literal")] {
        let words = ["bake", "leaf-card.glb", "-o", "x.flb", "--backend", backend, "--solver", solver];
        folder.flb_with(&words, &PAPER).expect_code(2).says(&["--solver", "--backend gpu"]);
    }
}

/// A stand of two species baked small by a model, as `stand.toml`.
fn stand(model: &[&str], more: &[&str]) -> Folder {
    let flags = [&["--lattice", "16", "--voxels", "128"], model, more].concat();
    let folder = Folder::with_baked(&["oak", "shrub"], &flags, &[0, 3]);
    let species = ["--species", "oak=oak.glb,oak.flb", "--species", "shrub=shrub.glb,shrub.flb"];
    let scatter = ["scatter", "--count", "12", "--area", "30,20", "-o", "stand.toml"];
    folder.flb_with(&scatter, &species).expect_code(0);
    folder
}

/// Root mean square of the differences of two pictures, of 255.
fn rms(folder: &Folder, a: &str, b: &str) -> f64 {
    picture::rms(&pixels(&folder.read(a)), &pixels(&folder.read(b)))
}

const RENDER: [&str; 5] = ["render", "stand.toml", "--size", "96x54", "--backend"];

#[test]
fn a_gpu_draws_scenes_as_the_cpu_does() {
    let suns = ["--suns", "sh1", "--ordinates", "18"];
    // Of 255. With the near beam, places of estimates differ in their last bits and with them their noise.
    for (model, most) in
        [(&PAPER[..], 0.6), (&["--suns", "lattice18", "--ordinates", "18"], 0.6), (&suns, 4.0)]
    {
        let folder = stand(model, &[]);
        folder.flb_with(&RENDER, &["cpu", "-o", "cpu.png"]).expect_code(0);
        let run = folder.flb_with(&RENDER, &["gpu", "--json", "-o", "gpu.png"]).expect_code(0);
        let run = run.says(&["flb: rendering on "]);
        let json = run.json();
        assert_eq!(schema::misfits(&schema::schema("render"), &json), [""; 0], "{json}");
        assert!(json["scene"]["adapters"][0].is_string() && json["scene"]["light_bytes"].as_u64() > Some(0));
        assert!(json["scene"]["rays"][0].as_u64() > Some(500), "{json}");
        let off = rms(&folder, "cpu.png", "gpu.png");
        assert!(off < most, "{model:?}: {off} of 255");
        folder.flb_with(&RENDER, &["cpu", "--sun", "90,20", "-o", "other.png"]).expect_code(0);
        assert!(rms(&folder, "other.png", "gpu.png") > 2.0 * off.max(1.0), "any picture would do");
        folder.flb_with(&RENDER, &["gpu", "-o", "again.png"]).expect_code(0);
        assert!(folder.read("again.png") == folder.read("gpu.png"), "two runs on one GPU differ");
    }
}

#[test]
fn a_gpu_draws_scenes_in_their_scene_light_as_the_cpu_does() {
    let folder = stand(&["--suns", "lattice18", "--ordinates", "18"], &[]);
    let bake = ["bake-scene", "stand.toml", "-o", "stand.flb", "--lattice", "16", "--ordinates", "18"];
    folder.flb(&bake).expect_code(0);
    let render = |backend: &str, more: &[&str], out: &str| {
        let words = [&[backend, "--show", "indirect", "-o", out], more].concat();
        folder.flb_with(&RENDER, &words).expect_code(0)
    };
    let with = ["--scene-light", "stand.flb"];
    render("cpu", &with, "cpu.png");
    let json = render("gpu", &[&with[..], &["--json"]].concat(), "gpu.png").json();
    assert_eq!(schema::misfits(&schema::schema("render"), &json), [""; 0], "{json}");
    assert!(json["scene"]["adapters"][0].is_string(), "{json}");
    render("gpu", &[], "without.png");
    let (off, unlike) = (rms(&folder, "cpu.png", "gpu.png"), rms(&folder, "without.png", "gpu.png"));
    assert!(off < 0.6 && unlike > 4.0 * off, "{off} of 255, {unlike} without");
    // By night there is no sun to shade; and the next sun has a shade of its own.
    let suns = ["--sun", "0,-10", "--sun", "135,35"];
    for backend in ["cpu", "gpu"] {
        render(backend, &[&with[..], &suns].concat(), &format!("suns-{backend}.png"));
    }
    let off = rms(&folder, "suns-cpu.png", "suns-gpu.png");
    assert!(off < 0.6, "{off} of 255");
}

#[test]
fn a_gpu_mirrors_plants_in_water_as_the_cpu_does() {
    let folder = stand(&PAPER, &[]);
    folder.flb_with(&RENDER, &["cpu", "-o", "dry.png"]).expect_code(0);
    let mut scene = String::from_utf8(folder.read("stand.toml")).expect("TOML is text");
    scene.insert_str(0, "water = { height_m = 0.1 }\n");
    folder.write("stand.toml", scene);
    let rays = ["cpu", "gpu"].map(|backend| {
        let output = format!("{backend}.png");
        let json = folder.flb_with(&RENDER, &[backend, "--json", "-o", &output]).expect_code(0).json();
        let rays: [u64; 4] = serde_json::from_value(json["scene"]["rays"].clone()).expect("four counts");
        rays
    });
    assert!(rays[0][3] > 1000 && rays[0][3].abs_diff(rays[1][3]) < 20, "{rays:?}");
    let off = rms(&folder, "cpu.png", "gpu.png");
    assert!(off < 0.6 && rms(&folder, "dry.png", "gpu.png") > 5.0, "{off} of 255");
}

#[test]
fn where_it_is_left_open_software_and_missing_gpus_are_passed_over() {
    let folder = stand(&PAPER, &[]);
    folder.flb_with(&RENDER, &["cpu", "-o", "cpu.png"]).expect_code(0);
    let nothing = [("WGPU_BACKEND", "vulkan"), ("VK_DRIVER_FILES", "/none"), ("VK_ICD_FILENAMES", "/none")];
    let none = folder.flb_in(&nothing, &[&RENDER[..], &["auto", "-o", "none.png"]].concat());
    none.expect_code(0).says(&["rendering on the CPU", "no GPU"]);
    assert!(folder.read("none.png") == folder.read("cpu.png"));
    let run = folder.flb_with(&RENDER, &["auto", "-o", "auto.png"]).expect_code(0);
    // With a real one it may draw there.
    assert!(
        run.stderr.contains("rendering on the CPU: ") == (folder.read("auto.png") == folder.read("cpu.png"))
    );
    let missing = folder.flb_in(&nothing, &[&RENDER[..], &["gpu", "-o", "x.png"]].concat());
    missing.expect_code(5).says(&["no GPU", "VULKAN", "apt-get install mesa-vulkan-drivers"]);
}

#[test]
fn all_gpus_that_there_are_draw_what_one_does_and_more_are_refused() {
    let folder = stand(&PAPER, &[]);
    folder.flb_with(&RENDER, &["gpu", "-o", "one.png"]).expect_code(0);
    let run = folder.flb_with(&RENDER, &["gpu", "--gpus", "all", "--json", "-o", "all.png"]).expect_code(0);
    let json = run.json();
    assert_eq!(schema::misfits(&schema::schema("render"), &json), [""; 0], "{json}");
    let adapters = json["scene"]["adapters"].as_array().expect("a list");
    for name in adapters {
        assert!(run.stderr.contains(name.as_str().expect("a name")), "{}", run.stderr);
    }
    // Several kinds of GPU round apart.
    if adapters.len() == 1 {
        assert!(folder.read("one.png") == folder.read("all.png"));
    }
    let refused = |more: &[&str], code: i32, says: &[&str]| {
        folder.flb_with(&RENDER, &[more, &["-o", "x.png"]].concat()).expect_code(code).says(says);
        assert!(!folder.path("x.png").exists());
    };
    let name = adapters[0].as_str().expect("a name");
    refused(&["gpu", "--gpus", "64"], 5, &["--gpus 64", "found", name]);
    refused(&["gpu", "--gpus", "0"], 2, &["expected all, or 1 to 64, such as 2", "\"0\""]);
    refused(&["gpu", "--gpus", "both"], 2, &["expected all", "\"both\""]);
    refused(&["cpu", "--gpus", "2"], 2, &["stand.toml", "--gpus is for --backend gpu or auto"]);
    let single = ["render", "oak.flb", "--mesh", "oak.glb", "--sun", "135,35", "-o", "x.png"];
    folder.flb_with(&single, &["--gpus", "2"]).expect_code(2).says(&["--gpus is for scenes"]);
    // Where it is left open, the CPU does it, and says why.
    let run = folder.flb_with(&RENDER, &["auto", "--gpus", "64", "-o", "auto.png"]).expect_code(0);
    run.says(&["rendering on the CPU: "]);
}

#[test]
fn what_a_gpu_cannot_draw_is_refused_by_name() {
    let folder = stand(&PAPER, &["--codec", "raw-f16"]);
    let run = folder.flb_with(&RENDER, &["gpu", "-o", "x.png"]).expect_code(5);
    run.says(&["oak", "raw-f16", "render on the CPU", "flb pack FILE -o NEW.flb --codec classed"]);
    let single = ["render", "oak.flb", "--mesh", "oak.glb", "--sun", "135,35", "-o", "x.png"];
    folder.flb_with(&single, &["--backend", "gpu"]).expect_code(2).says(&["--backend", "scenes"]);
    assert!(!folder.names().contains(&"x.png".to_owned()));
}
