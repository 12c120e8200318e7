//! Scenes of as many plants as there may be, and files that ask for more memory than there is: a command takes the
//! memory of what it makes of them, or ends in a clear error, and the system never ends it.
#![cfg(target_os = "linux")]

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::flb::{Folder, Run};

/// Seconds of processor time after which a run counts as endless.
const ENDLESS_S: u32 = 300;

const PLANTS: usize = 1_000_000;
/// Of a plan of so many plants: their text of 49 MB, 112 bytes for each, and what any run takes.
const PLAN_PEAK_KB: u64 = 300_000;

/// A scene of a million plants of one species, with a camera and a sun, as tables or as one array.
fn scene(of_species: &str, is_array: bool) -> String {
    let top = "sun.fixed = [[135.0, 35.0]]\n\
        camera = { position_m = [0.0, 9.0, 600.0], look_at_m = [0.0, 0.0, 0.0], fov_deg = 45.0, height_px = 36 }\n";
    let mut text = top.to_owned();
    let species = format!("[[species]]\nname = \"o\"\n{of_species}\n");
    let plants = (0..PLANTS).map(|i| (i % 1000, i / 1000));
    if is_array {
        text += "instance = [\n";
        for (x, z) in plants {
            writeln!(text, "{{species=\"o\",position_m=[{x},0,{z}]}},").expect("a string takes everything");
        }
        text + "]\n" + &species
    } else {
        text += &species;
        for (x, z) in plants {
            writeln!(text, "[[instance]]\nspecies=\"o\"\nposition_m=[{x},0,{z}]")
                .expect("a string takes everything");
        }
        text
    }
}

/// How a run ends, and the most memory that it had at once, kilobytes.
fn peak(folder: &Folder, words: &[&str]) -> (i32, u64) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_flb"))
        .args(words)
        .current_dir(folder.path(""))
        .stdout(Stdio::null())
        .spawn()
        .expect("the command starts");
    let status = format!("/proc/{}/status", child.id());
    let mut peak_kb = 0;
    loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let found = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let found = found.and_then(|rest| rest.trim().strip_suffix(" kB")?.parse().ok());
        peak_kb = peak_kb.max(found.unwrap_or(0));
        if let Some(ended) = child.try_wait().expect("it can be waited for") {
            return (ended.code().unwrap_or(-1), peak_kb);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn within(folder: &Folder, memory_kb: u32, words: &[&str]) -> Run {
    folder.flb_under(&[format!("-v {memory_kb}"), format!("-t {ENDLESS_S}")], words)
}

#[test]
fn a_million_plants_are_planned_in_300_mb_as_tables_and_as_an_array() {
    let folder = Folder::new();
    for is_array in [false, true] {
        folder.write("a.toml", scene("", is_array));
        let (code, peak_kb) = peak(&folder, &["plan", "a.toml", "-o", "plan.toml", "--force"]);
        eprintln!("array: {is_array}: {peak_kb} kB");
        assert_eq!(code, 0);
        assert!(peak_kb > 100_000, "{peak_kb} kB: the scene itself is larger");
        assert!(peak_kb < PLAN_PEAK_KB, "{peak_kb} kB");
        let plan = String::from_utf8(folder.read("plan.toml")).expect("TOML is text");
        assert!(plan.contains("\"o\""), "{plan}");
    }
}

/// Kilobytes for each plant that is drawn, under an even sky and under another; beside the scene itself and its mesh.
const DRAWN_KB: [u64; 2] = [PLANTS as u64 / 2, PLANTS as u64 * 2];

#[test]
fn a_million_plants_are_drawn_in_the_memory_that_is_counted_and_refused_beyond_the_limit() {
    let folder = Folder::with_plants(&["shrub"]);
    let bake = ["bake", "shrub.glb", "-o", "o.flb", "--lattice", "16", "--voxels", "128"];
    folder.flb_with(&bake, &["--ordinates", "18"]).expect_code(0);
    folder
        .write("a.toml", scene("file = \"shrub.glb\"\nlight = \"o.flb\"\nlight_species = \"shrub\"", false));
    let draw = ["render", "a.toml", "-o", "a.png", "--size", "32x18", "--samples", "1", "--force"];
    for (sky, each_kb) in [("even", DRAWN_KB[0]), ("clear", DRAWN_KB[1])] {
        let words = [&draw[..], &["--sky", sky]].concat();
        // The light of a million plants under an uneven sky takes minutes; that it is counted is quickly seen.
        if sky == "even" {
            let (code, peak_kb) = peak(&folder, &words);
            eprintln!("render under a sky that is {sky}: {peak_kb} kB");
            assert_eq!(code, 0);
            assert!(peak_kb < PLAN_PEAK_KB + each_kb, "{sky}: {peak_kb} kB");
        }
        let limit = format!("{}", each_kb as f64 / 1e6 * 0.9);
        let run = folder.flb(&[&words[..], &["--memory-limit", &limit]].concat()).expect_code(6);
        assert!(
            run.stderr.contains("a.toml: 1000000 plants: ") && run.stderr.contains("--memory-limit"),
            "{}",
            run.stderr
        );
    }
    let stream = ["stream", "o.flb", "a.toml", "--seconds", "1", "--fps", "2"];
    let (_, peak_kb) = peak(&folder, &stream);
    eprintln!("stream: {peak_kb} kB");
    assert!(peak_kb < PLAN_PEAK_KB + DRAWN_KB[0], "{peak_kb} kB");
    let run = folder.flb(&[&stream[..], &["--memory-limit", "0.01"]].concat()).expect_code(6);
    assert!(run.stderr.contains("a.toml: 1000000 plants: "), "{}", run.stderr);
}

/// Address space of commands with one thread: too little for the scene, for what is made of it, for neither.
const SPACES_KB: [u32; 4] = [160_000, 320_000, 480_000, 900_000];

#[test]
fn no_command_on_a_million_plants_is_ended_by_the_system_whatever_memory_there_is() {
    let folder = Folder::with_plants(&["shrub"]);
    let bake = ["bake", "shrub.glb", "-o", "o.flb", "--lattice", "16", "--voxels", "128"];
    folder.flb_with(&bake, &["--suns", "lattice18", "--ordinates", "18"]).expect_code(0);
    folder
        .write("a.toml", scene("file = \"shrub.glb\"\nlight = \"o.flb\"\nlight_species = \"shrub\"", false));
    let commands: [&[&str]; 4] = [
        &["plan", "a.toml", "-o", "plan.toml"],
        &["stream", "o.flb", "a.toml", "--seconds", "1", "--fps", "2"],
        &["bake-scene", "a.toml", "-o", "scene.flb", "--lattice", "16", "--ordinates", "18"],
        &["render", "a.toml", "-o", "a.png", "--size", "32x18", "--samples", "1", "--backend", "cpu"],
    ];
    for command in commands {
        let mut codes = Vec::new();
        for space_kb in SPACES_KB {
            let flags: &[&str] = if command[0] == "stream" { &[] } else { &["--force"] };
            let words = [&["--threads", "1"], command, flags].concat();
            let run = within(&folder, space_kb, &words);
            eprintln!("{} in {space_kb} kB: {}: {}", command[0], run.code, run.stderr);
            match run.code {
                // A replay that shows no picture in its second is a loss.
                0 | 3 => {}
                6 => assert!(
                    run.stderr.contains("a.toml: ") && run.stderr.contains(" bytes of memory"),
                    "{}",
                    run.stderr
                ),
                code => panic!("{command:?} in {space_kb} kB: {code}: {}", run.stderr),
            }
            codes.push(run.code);
        }
        assert_eq!(codes[0], 6, "{command:?}: less than the scene itself");
        assert_ne!(codes[3], 6, "{command:?}: enough for all of it");
    }
}

/// A PNG of zeros.
fn png(width: u32, height: u32, color: png::ColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_compression(png::Compression::Fast);
    let zeros = vec![0; color.samples() * width as usize * height as usize];
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&zeros))
        .expect("it is written to memory");
    bytes
}

#[test]
fn files_that_ask_for_more_memory_than_there_is_are_a_limit_by_name() {
    let folder = Folder::new();
    let golden = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../format-spec/golden/classed.flb");
    let golden = golden.to_string_lossy().into_owned();
    folder.flb(&["torture", &golden, "-o", "bad"]).expect_code(0);
    folder.write("heights.png", png(8192, 8192, png::ColorType::Grayscale));
    folder.write("leaf.png", png(16_384, 5120, png::ColorType::Rgba));
    folder.write("leaf.mtl", "newmtl leaf\nmap_Kd leaf.png\n");
    folder.write("leaf.obj", "mtllib leaf.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl leaf\nf 1 2 3\n");
    folder.write("text.toml", scene("", false));
    let mut sparse = std::fs::File::create(folder.path("sparse.glb")).expect("a file");
    // The rest takes no room on the disk.
    sparse.write_all(b"glTF").and_then(|()| sparse.set_len(250 << 20)).expect("it can be written");
    let [paper, haar] = ["bad/38-giant-haar-paper.flb", "bad/38-giant-haar.flb"];
    let needed = ["--memory-limit", "100", "--force"];
    let table: [(&str, u32, Vec<&str>); 14] = [
        (paper, 100_000, vec!["validate", paper, "--level", "decode"]),
        // Too little for a second arena of glibc, 64 MB, which would now and then leave no room for a thread's stack.
        (haar, 120_000, vec!["validate", haar, "--level", "decode"]),
        (haar, 250_000, vec!["validate", haar, "--level", "decode"]),
        (
            paper,
            900_000,
            [&["extract", paper, "--base", "0", "--format", "npy", "-o", "x.npy"], &needed[..]].concat(),
        ),
        (
            haar,
            900_000,
            [&["extract", haar, "--base", "0", "--format", "npy", "-o", "x.npy"], &needed[..]].concat(),
        ),
        (
            haar,
            500_000,
            [&["extract", haar, "--base", "0", "--format", "npy", "-o", "x.npy"], &needed[..]].concat(),
        ),
        (paper, 900_000, [&["pack", paper, "-o", "x.flb"], &needed[..]].concat()),
        (haar, 900_000, [&["pack", haar, "-o", "x.flb"], &needed[..]].concat()),
        (haar, 700_000, vec!["diff", haar, haar, "--memory-limit", "100"]),
        (paper, 900_000, vec!["diff", paper, paper, "--memory-limit", "100"]),
        (
            "heights.png",
            300_000,
            vec![
                "scatter",
                "--count",
                "9",
                "--area",
                "9,9",
                "--density",
                "heights.png",
                "--species",
                "a=leaf.obj",
                "-o",
                "s.toml",
            ],
        ),
        ("leaf.obj", 300_000, vec!["materials", "leaf.obj"]),
        ("sparse.glb", 200_000, vec!["materials", "sparse.glb"]),
        // The program itself takes 76 MB.
        ("text.toml", 90_000, vec!["plan", "text.toml", "-o", "p.toml"]),
    ];
    for (file, space_kb, words) in table {
        let run = within(&folder, space_kb, &[&["--threads", "1"], &words[..]].concat());
        let said = format!("{}{}", run.stderr, run.stdout);
        assert_eq!(run.code, 6, "{words:?} in {space_kb} kB: {said}");
        assert!(
            said.contains(file) && said.contains(" bytes of memory needed"),
            "{words:?} in {space_kb} kB: {said}"
        );
    }
}
