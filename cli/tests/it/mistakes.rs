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
    for command in
        [&["materials", "a.obj", "--unit=1e30"][..], &["materials", "a.obj", "--unit=1e12", "--json"]]
    {
        let run = folder.flb(command).expect_code(2);
        assert!(run.stderr.contains("by which a vertex of a.obj is at"), "{}", run.stderr);
    }
    folder.write("far.obj", obj("leaf", 1e20));
    folder.flb(&["materials", "far.obj"]).expect_code(1).says(&["far.obj: a vertex: found", "up to 1e9 m"]);
}

#[test]
fn meshes_of_one_file_name_are_told_the_way_out_and_take_it() {
    let folder = Folder::new();
    for name in ["oak", "pine", "deep/pine"] {
        std::fs::create_dir_all(folder.path(name)).expect("a folder");
        folder.write(&format!("{name}/scene.obj"), obj("leaf", 1.0));
    }
    let bake =
        |words: &[&str]| folder.flb_with(&["bake", "-o", "x.flb", "--force"], &[&QUICK[..], words].concat());
    let two = ["oak/scene.obj", "pine/scene.obj"];
    bake(&two).expect_code(2).says(&[
        "pine/scene.obj: a second species named \"scene\"",
        "give one for each mesh, in their order, such as --name oak --name pine",
    ]);
    bake(&[&two[..], &["deep/pine/scene.obj"]].concat())
        .expect_code(2)
        .says(&["such as --name plant1 --name plant2 --name plant3"]);
    bake(&[&two[..], &["--name", "oak", "--name", "pine"]].concat()).expect_code(0);
    let info = folder.flb(&["info", "x.flb"]).expect_code(0).stdout;
    assert!(info.contains("species oak\n") && info.contains("species pine\n"), "{info}");
    bake(&[&two[..], &["--name", "tree"]].concat())
        .expect_code(2)
        .says(&["found --name 1 times for 2 meshes, expected it once for each, in their order"]);
    bake(&[&two[..], &["--name", "tree", "--name", "tree"]].concat())
        .expect_code(2)
        .says(&["a second species named \"tree\""]);
    bake(&["oak/scene.obj", "--name", "tree"]).expect_code(0);
}

#[test]
fn a_dash_is_no_file_to_write() {
    let folder = Folder::with_card();
    folder.write(
        "scene.toml",
        "[[species]]\nname = \"a\"\n[[instance]]\nspecies = \"a\"\nposition_m = [0.0, 0.0, 0.0]\n",
    );
    for words in [
        &["bake", "leaf-card.glb", "-o", "-"][..],
        &["bake", "leaf-card.glb", "-o", "x.flb", "--keep-fields", "-"],
        &["pack", "card.flb", "-o", "-"],
        &["migrate", "card.flb", "-o", "-"],
        &["extract", "card.flb", "--base", "1", "--format", "npy", "-o", "-"],
        &["grow", "shrub", "-o", "-"],
        &["plan", "scene.toml", "-o", "-"],
        &["bake-scene", "scene.toml", "-o", "-"],
        &["scene", "leaf-card.glb", "-o", "-"],
        &["scatter", "--species", "a=leaf-card.glb", "--count", "1", "-o", "-"],
        &["render", "card.flb", "--mesh", "leaf-card.glb", "--sun", "1,1", "-o", "-"],
        &["stream", "card.flb", "scene.toml", "--trace", "-"],
        &["trade", "leaf-card.glb", "--out", "-"],
        &["torture", "card.flb", "-o", "-"],
        &["judge", "card.flb", "--mesh", "leaf-card.glb", "--picture", "-"],
    ] {
        let run = folder.flb(words).expect_code(2);
        assert!(run.stderr.contains("./- is a file of that name"), "{words:?}: {}", run.stderr);
        assert!(!folder.path("-").exists(), "{words:?}");
    }
    folder.flb(&["migrate", "card.flb", "-o", "./-"]).expect_code(0);
    assert!(folder.path("-").exists());
}

#[test]
fn scatter_refuses_words_of_which_no_scene_can_be_made() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let scatter = |words: &[&str]| {
        folder.flb(&[&["scatter", "--count", "3", "-o", "s.toml", "--force"], words].concat())
    };
    for (species, words) in [
        ("a\nb=leaf-card.glb", "species.name"),
        ("a\u{202e}b=leaf-card.glb", "species.name"),
        ("a\u{7f}=leaf-card.glb", "species.name"),
    ] {
        let run = scatter(&["--species", species]).expect_code(2);
        assert!(
            run.stderr.contains("the scene to be written") && run.stderr.contains(words),
            "{}",
            run.stderr
        );
    }
    let card = ["--species", "a=leaf-card.glb"];
    for more in [["--area", "nan,9"], ["--area", "9,inf"], ["--scale", "nan..1"], ["--scale", "0..1"]] {
        scatter(&[&card[..], &more].concat()).expect_code(2);
    }
    folder.write("map.png", grey());
    for height in ["nan..1", "0..inf", "0..1e300", "-1e12..0"] {
        let map = ["--height-map", "map.png", "--height", height];
        let run = scatter(&[&card[..], &map].concat());
        assert!([1, 2].contains(&run.code), "{height}: {} {}", run.code, run.stderr);
    }
    assert!(!folder.path("s.toml").exists());
    scatter(&card).expect_code(0);
    folder.flb(&["plan", "s.toml", "-o", "plan.toml"]).expect_code(0);
}

/// A grey PNG of 2 x 2 pixels.
fn grey() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Grayscale);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&[9, 200, 120, 30]));
    written.expect("a PNG");
    bytes
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
