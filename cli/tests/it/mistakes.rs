//! What people get wrong is found before the long work, and said in their words.

use crate::flb::{self, FEW, Folder, SMALL};

/// One triangle of the material `name`, `size` units long.
fn obj(name: &str, size: f64) -> String {
    format!("v 0 0 0\nv 0 {size} 0\nv {size} 0 0\nusemtl {name}\nf 1 2 3\n")
}

const QUICK: [&str; 4] = ["--lattice", "16", "--voxels", "32"];

#[test]
fn a_pattern_may_be_meant_for_one_mesh_of_several() {
    let folder = Folder::new();
    folder.write("a.obj", obj("leaf", 1.0)).write("b.obj", obj("material0", 1.0));
    let bake = ["bake", "a.obj", "b.obj", "-o", "both.flb"];
    folder.flb_with(&bake, &[&QUICK[..], &["--leaf", "material0"]].concat()).expect_code(0);
    folder
        .flb_with(&bake, &[&QUICK[..], &["--force", "--leaf", "material0", "--wood", "pine*"]].concat())
        .expect_code(2)
        .says(&["--wood: 'pine*' matches no material", "'leaf'", "'material0'"]);
}

#[test]
fn an_undecided_second_mesh_stops_the_bake_before_the_first_is_solved() {
    let folder = Folder::new();
    folder.write("a.obj", obj("leaf", 1.0)).write("b.obj", obj("material0", 1.0));
    let run = folder.flb_with(&["bake", "a.obj", "b.obj", "-o", "both.flb"], &QUICK).expect_code(2);
    assert!(!run.stderr.contains("is leaf:"), "nothing was baked yet: {}", run.stderr);
    run.says(&["b.obj", "'material0'", "--leaf 'material0'"]);
}

#[test]
fn a_name_or_size_that_no_file_can_hold_is_refused_at_once() {
    let folder = Folder::new();
    folder.write("a.obj", obj("leaf", 1.0)).write("tiny.obj", obj("leaf", 1e-30));
    let bake = |words: &[&str]| folder.flb_with(&["bake", "-o", "x.flb"], &[&QUICK[..], words].concat());
    bake(&["a.obj", "--name", "a/b"]).expect_code(2).says(&["a.obj", "name is \"a/b\""]);
    bake(&["a.obj", "--unit", "1e30"]).expect_code(2).says(&["a.obj", "--unit"]);
    bake(&["a.obj", "--unit", "1e-12"]).expect_code(2).says(&["a.obj", "expected 0.00001 to 100000 m"]);
    bake(&["tiny.obj"]).expect_code(2).says(&["tiny.obj", "--unit"]);
    bake(&["a.obj", "./a.obj"]).expect_code(2).says(&["a second species named \"a\""]);
}

#[test]
fn packing_what_lost_detail_already_is_said_and_keeps_its_error() {
    let folder = Folder::with_plants(&["shrub"]);
    let psnr = |run: &flb::Run| run.json()["species"][0]["surface_psnr_db"].as_f64().expect("a number");
    let flags = [SMALL.as_slice(), &FEW].concat();
    let baked = folder.flb_with(&["bake", "shrub.glb", "-o", "s.flb", "--json"], &flags).expect_code(0);
    let packed = folder.flb(&["pack", "s.flb", "-o", "l.flb", "--target-psnr", "52", "--json"]);
    let packed = packed.expect_code(0).says(&["s.flb", "losses add up"]);
    let (packed, baked) = (psnr(&packed), psnr(&baked));
    // Errors of 52 dB add to those of 45 dB: 0.8 dB.
    assert!(
        (0.5..1.1).contains(&(baked - packed)),
        "a fine copy is nearly as good as what it copies: {packed}, {baked}"
    );
}

#[test]
fn an_output_named_as_another_format_is_refused() {
    let folder = Folder::with_card();
    folder
        .flb(&["extract", "card.flb", "--base", "4", "--format", "npy", "-o", "b.png"])
        .expect_code(2)
        .says(&["b.png", "found .png, expected .npy"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_bake_ends_with_130_and_leaves_nothing() {
    let folder = Folder::with_plants(&["shrub"]);
    // Before it listens it ends by the signal itself: on a busy machine it needs longer to come so far.
    let interrupted_after = |wait_ms| {
        let mut bake = std::process::Command::new(env!("CARGO_BIN_EXE_flb"))
            .args(["bake", "shrub.glb", "-o", "x.flb", "--lattice", "128", "--quality", "reference"])
            .current_dir(folder.path("."))
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("the command starts");
        std::thread::sleep(std::time::Duration::from_millis(wait_ms));
        let kill = std::process::Command::new("kill").args(["-TERM", &bake.id().to_string()]).status();
        assert!(kill.expect("kill is there").success());
        bake.wait().expect("it ends").code()
    };
    let code = [300, 1200, 4800].into_iter().find_map(interrupted_after);
    assert_eq!(code, Some(130));
    assert_eq!(folder.names(), ["shrub.glb"]);
}
