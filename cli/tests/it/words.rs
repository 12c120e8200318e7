//! What reaches a terminal or a log: whatever names a file holds, wherever stderr leads, and with secrets in URLs.
#![cfg(target_os = "linux")]

use std::fs::{File, OpenOptions};
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};

use flb_format::text::is_hidden;
use serde_json::json;

use crate::flb::{Folder, SMALL};

/// Bytes of a message: cli/src/print.rs.
const MAX_MESSAGE_BYTES: usize = 2048;

/// A name that would paint a terminal red, ring, return, turn text around, hide a letter and begin a message of its
/// own.
const NASTY: &str = "leaf\u{1b}[31m\u{7}\r\u{202e}\u{200b}\u{9b}2J\u{7f}\nflb: error: forged";

/// A triangle with this name wherever a glTF has one.
fn gltf(name: &str) -> serde_json::Value {
    json!({
        "asset": {"version": "2.0", "generator": name, "copyright": name},
        "scene": 0,
        "scenes": [{"nodes": [0], "name": name}],
        "nodes": [{"mesh": 0, "name": name, "extensions": {name: {}}}],
        "meshes": [{"name": name, "primitives": [{"attributes": {"POSITION": 0, name: 0}, "material": 0}]}],
        "materials": [{"name": name, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "alphaMode": "MASK"}],
        "textures": [{"source": 0, "name": name}],
        "images": [{"uri": format!("{name}.png"), "name": name}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "name": name}],
        "bufferViews": [{"buffer": 0, "byteLength": 36, "name": name}],
        "buffers": [{"byteLength": 36, "name": name,
            "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
        "extensionsUsed": [name],
    })
}

/// Every line of stderr is a message or goes on with one; nothing on either stream steers a terminal.
#[track_caller]
fn check(what: &str, stdout: &[u8], stderr: &[u8]) {
    for (stream, bytes) in [("stdout", stdout), ("stderr", stderr)] {
        let text = std::str::from_utf8(bytes).expect("UTF-8");
        let found = text.chars().find(|c| *c != '\n' && is_hidden(*c));
        assert_eq!(found, None, "{what}: {stream}: {text:?}");
        assert!(!text.contains("\nflb: error: forged"), "{what}: {stream}: {text}");
    }
    for message in String::from_utf8_lossy(stderr).split("flb: ").filter(|part| !part.is_empty()) {
        assert!(message.len() < MAX_MESSAGE_BYTES, "{what}: {} bytes", message.len());
    }
    let lines = String::from_utf8_lossy(stderr).into_owned();
    assert!(
        lines.lines().all(|line| line.starts_with("flb: ") || line.starts_with("   | ")),
        "{what}: {lines}"
    );
}

#[test]
fn names_in_files_and_of_files_reach_no_terminal() {
    let folder = Folder::with_card();
    folder.write("good.gltf", gltf(NASTY).to_string());
    let mut required = gltf(NASTY);
    required["extensionsRequired"] = json!([NASTY]);
    folder.write("required.gltf", required.to_string());
    let mut version = gltf(NASTY);
    version["asset"]["version"] = json!(NASTY);
    folder.write("version.gltf", version.to_string());
    let obj = format!(
        "mtllib {0}.mtl\no {0}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl {0}\nf 1 2 3\n",
        NASTY.replace('\n', "")
    );
    folder.write("named.obj", &obj).write(&format!("{NASTY}.obj"), &obj).write(&format!("{NASTY}.txt"), "?");
    folder.write("scene.toml", format!("[[species]]\nname = {}\n", serde_json::to_string(NASTY).unwrap()));
    folder.write("raw.toml", format!("# {NASTY}\n[[species]]\nnam\u{1b}[31me = 1\n"));
    folder.write("species.toml", format!("leaf = [{}]\n", serde_json::to_string(NASTY).unwrap()));
    let odd_file = format!("{NASTY}.obj");
    let odd_text = format!("{NASTY}.txt");
    let odd_flag = format!("--{NASTY}");
    for words in [
        &["materials", "good.gltf"][..],
        &["materials", "good.gltf", "--json"],
        &["materials", "required.gltf"],
        &["materials", "version.gltf"],
        &["materials", "named.obj"],
        &["materials", &odd_file],
        &["materials", &odd_file, "--json"],
        &["materials", &odd_text],
        &["materials", "good.gltf", "--leaf", NASTY],
        &["materials", "good.gltf", "--gltf-mesh", NASTY],
        &["materials", "good.gltf", "--species", "species.toml"],
        &["bake", "good.gltf", "-o", "x.flb"],
        &["bake", "good.gltf", "--leaf", "*", "-o", NASTY, "--name", NASTY],
        &["bake", &odd_file, "--leaf", "*", "--lattice", "16", "--voxels", "64", "-o", "odd.flb"],
        &["info", "odd.flb"],
        &["info", "odd.flb", "--json"],
        &["info", NASTY],
        &["validate", NASTY],
        &["validate", NASTY, "--json"],
        &["plan", "scene.toml", "-o", "plan.toml"],
        &["plan", "raw.toml", "-o", "plan.toml"],
        &["render", "card.flb", "--mesh", "good.gltf", "--sun", "1,1", "-o", "x.png"],
        &["extract", "card.flb", "--species", NASTY, "--base", "1", "--format", "png", "-o", "x.png"],
        &["scene", "good.gltf", "-o", "scene2.toml"],
        &["scene", "good.gltf", "--light", &format!("{NASTY}=card.flb"), "-o", "scene3.toml"],
        &["diff", "card.flb", NASTY],
        &[&odd_flag],
        &["info", "card.flb", NASTY],
    ] {
        let run = folder.flb(words);
        assert!((0..=6).contains(&run.code), "{words:?}: {}: {}", run.code, run.stderr);
        check(&format!("{words:?}"), run.stdout.as_bytes(), run.stderr.as_bytes());
        if words.contains(&"--json") && !run.stdout.is_empty() {
            run.json();
        }
    }
}

#[test]
fn json_stays_json_whatever_its_names_hold() {
    let folder = Folder::new();
    folder.write("m.gltf", gltf("https://h/x?a\"b \\ ?valid").to_string());
    let words = ["materials", "m.gltf", "--leaf", "*", "--json"];
    let found = folder.flb_in(&[("AWS_SECRET_ACCESS_KEY", "true")], &words).expect_code(0).json();
    assert_eq!(found["decided"], true);
    assert_eq!(found["materials"][0]["name"], "https://h/x?...\"b \\ ?valid");
}

#[test]
fn a_name_of_half_a_megabyte_makes_a_short_message() {
    let folder = Folder::new();
    let long = "n".repeat(60_000);
    folder.write("a.gltf", gltf(&long).to_string());
    let many: Vec<_> = (0..5000).map(|i| json!({"name": format!("material number {i}")})).collect();
    let mut undecided = gltf("leaf");
    undecided["materials"] = json!(many);
    folder.write("b.gltf", undecided.to_string());
    for words in [&["materials", "a.gltf"][..], &["bake", "b.gltf", "-o", "x.flb"], &["info", &long]] {
        let run = folder.flb(words);
        check(&format!("{:?}", words[0]), &[], run.stderr.as_bytes());
    }
}

/// The command with its streams, in the folder.
fn command(folder: &Folder, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_flb"));
    command.args(words).current_dir(folder.path("")).stdin(Stdio::null());
    command
}

fn full() -> File {
    OpenOptions::new().write(true).open("/dev/full").expect("Linux has it")
}

/// A pipe whose reader is gone.
fn broken() -> Stdio {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

#[test]
fn a_broken_stderr_stops_no_work() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let bake = ["bake", "leaf-card.glb", "--model", "paper", "-o"];
    for (name, stderr) in [("full.flb", full().into()), ("broken.flb", broken())] {
        let words = [&bake[..], &[name], &SMALL].concat();
        let status =
            command(&folder, &words).stdout(Stdio::null()).stderr(stderr).status().expect("it starts");
        assert_eq!(status.code(), Some(0), "{name}");
    }
    assert_eq!(folder.read("full.flb"), folder.read("broken.flb"));
    // And none that fails ends in another way.
    for stderr in [Stdio::from(full()), broken()] {
        let status = command(&folder, &["info", "none.flb"]).stderr(stderr).status().expect("it starts");
        assert_eq!(status.code(), Some(4));
    }
}

#[test]
fn a_stdout_that_takes_nothing_is_4() {
    let folder = Folder::with_card();
    for words in [&["info", "card.flb"][..], &["info", "card.flb", "--json"], &["--help"], &["--version"]] {
        for stderr in [Stdio::from(full()), Stdio::null()] {
            let status = command(&folder, words).stdout(full()).stderr(stderr).status().expect("it starts");
            assert_eq!(status.code(), Some(4), "{words:?}");
        }
        let output = command(&folder, words).stdout(broken()).output().expect("it starts");
        assert_eq!(output.status.code(), Some(4), "{words:?}");
        assert!(output.stderr.is_empty(), "a reader that went away is told nothing");
    }
}

#[test]
fn a_stdout_that_was_never_open_is_4_and_not_silence() {
    let folder = Folder::with_card();
    for words in ["info card.flb --json", "info card.flb", "validate card.flb", "--version"] {
        let run = |end: &str| {
            let mut shell = Command::new("sh");
            let script = format!("\"$0\" {words} {end}");
            shell.args(["-c", &script, env!("CARGO_BIN_EXE_flb")]).current_dir(folder.path(""));
            shell.output().expect("the shell starts")
        };
        let closed = run(">&-");
        assert_eq!(closed.status.code(), Some(4), "{words}");
        assert!(String::from_utf8_lossy(&closed.stderr).contains("standard output is closed"));
        assert_eq!(run(">/dev/null").status.code(), Some(0), "{words}");
        // As programs open it that want no output of their children.
        assert_eq!(run("1<>/dev/null").status.code(), Some(0), "{words}");
    }
    // Open, but not to write: the standard library passes over what it says.
    let reading = File::open("/dev/null").expect("it is there");
    let reading = command(&folder, &["info", "card.flb", "--json"]).stdout(reading).status();
    assert_eq!(reading.expect("it starts").code(), Some(4));
    // A closed stderr is none of our business, nor is a stdin.
    let mut shell = Command::new("sh");
    shell
        .args(["-c", "\"$0\" info card.flb 2>&- <&-", env!("CARGO_BIN_EXE_flb")])
        .current_dir(folder.path(""));
    assert_eq!(shell.output().expect("the shell starts").status.code(), Some(0));
}

/// Shapes in which a URL may hide a secret, by which tests of attack got it told.
const ODD_URLS: [&str; 12] = [
    "http://u:p/S3CR3T@h/x",
    "http://h/x#S3CR3T",
    r"http:\\h\x?sig=S3CR3T",
    "//u:S3CR3T@h/x?sig=S3CR3T",
    "ftp:/h/x?sig=S3CR3T",
    "http%3A//u:S3CR3T@h/x",
    "http://u s:S3CR3T@h/x",
    "http://h/x?a=b cS3CR3T",
    "http://h/x?a=\"S3CR3T",
    "gs:/h/x?sig=S3CR3T",
    r"gs:\\h\x?sig=S3CR3T",
    "https://h/x?sig=S3CR3T",
];

#[test]
fn no_message_holds_the_secret_of_a_url_in_a_file() {
    let folder = Folder::with_card();
    let quiet = |words: &[&str], url: &str| {
        let run = folder.flb(words);
        assert!((0..=6).contains(&run.code), "{words:?}: {}", run.code);
        let said = run.stdout + &run.stderr;
        assert!(!said.contains("S3CR3T"), "{words:?} ({url}): {said}");
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl leaf\nf 1/1 2/1 3/1\n";
    let positions = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    for url in ODD_URLS {
        let text = serde_json::Value::from(url).to_string(); // TOML writes texts as JSON does
        folder.write("a.mtl", format!("newmtl leaf\nmap_Kd {url}\n"));
        folder.write("a.obj", format!("mtllib a.mtl\n{triangle}"));
        folder.write("b.obj", format!("mtllib {url}\n{triangle}"));
        let gltf = |buffer: &str, image: &str| {
            serde_json::json!({
                "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
                "materials": [{"name": "leaf", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
                "textures": [{"source": 0}], "images": [{"uri": image}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
                "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": buffer}],
            })
        };
        folder.write("c.gltf", gltf(url, "none.png").to_string());
        folder.write("d.gltf", gltf(positions, url).to_string());
        for mesh in ["a.obj", "b.obj", "c.gltf", "d.gltf"] {
            quiet(&["materials", mesh], url);
        }
        let species = "[[species]]\nname = \"s\"\nupright = true\n";
        for scene in [
            format!("light = {text}\n{species}"),
            format!("{species}file = {text}\n"),
            format!("{species}file = {text}\nunknown = 1\n"),
            format!("{species}unknown = {text}\n"),
            format!("{species}upright = {text}\n"),
            format!("{species}height_m = {text} x\n"),
            format!(
                "[ground]\nheight_map = {text}\norigin_m = [0, 0, 0]\nsize_m = [1, 1]\nheight_m = [0, 1]\n{species}"
            ),
        ] {
            folder.write("scene.toml", scene);
            quiet(&["plan", "scene.toml", "-o", "x.toml"], url);
            quiet(&["render", "scene.toml", "--size", "8x8", "-o", "x.png"], url);
        }
        for wrong in [format!("name = {text} x\n"), format!("unit_m = {text}\n"), format!("{text} = 1\n")] {
            folder.write("wrong.toml", wrong);
            quiet(&["bake", "leaf-card.glb", "--species", "wrong.toml", "-o", "x.flb"], url);
            quiet(&["bake", "leaf-card.glb", "--model", "paper", "--plan", "wrong.toml", "-o", "x.flb"], url);
        }
    }
}

#[test]
fn no_message_holds_the_secret_of_a_url_wherever_it_stands() {
    let folder = Folder::with_card();
    let secret = "S3CR3T";
    let url = format!("https://user:{secret}@host.invalid/a.glb?X-Amz-Signature={secret}'{secret}");
    let environment = [("AWS_SECRET_ACCESS_KEY", secret), ("AWS_SESSION_TOKEN", secret)];
    let pair = format!("oak={url}");
    let odd = [
        format!("HTTPS://h/x?sig={secret}"),
        format!("http://user:p/{secret}@h/x"),
        format!("http:/h/x?sig={secret}"),
        format!("//h/x?sig={secret}"),
        format!("GS://h/x?{secret}"),
        format!("http://h/x?sig=\"{secret}"),
        format!("gs:/h/x?sig={secret}"),
        format!("gs:\\\\h\\x?sig={secret}"),
    ];
    for url in &odd {
        for words in [
            &["bake", url, "-o", "x.flb"][..],
            &["bake", "leaf-card.glb", "-o", url],
            &["bake", "leaf-card.glb", "--species", url, "-o", "x.flb"],
            &["info", url],
            &["info", url, "--json"],
            &["materials", "leaf-card.glb", "--leaf", url],
            &["scatter", "--species", url, "--count", "1", "-o", "x.toml"],
        ] {
            let run = folder.flb(words);
            // One of them is the name of a file that can be written.
            assert!((0..=6).contains(&run.code), "{words:?}: {}", run.code);
            let said = run.stdout + &run.stderr;
            assert!(!said.contains(secret), "{words:?}: {said}");
        }
    }
    for words in [
        &["bake", &url, "-o", "x.flb"][..],
        &["bake", "leaf-card.glb", "-o", &url],
        &["bake", "leaf-card.glb", "--species", &url, "-o", "x.flb"],
        &["bake", "leaf-card.glb", "--plan", &url, "-o", "x.flb"],
        &["bake", "leaf-card.glb", "--cache", &url, "--lattice", &url, "-o", "x.flb"],
        &["materials", &url],
        &["plan", &url, "-o", "x.toml"],
        &["render", "card.flb", "--mesh", &url, "--sun", "1,1", "-o", "x.png"],
        &["render", &url, "--mesh", "leaf-card.glb", "--sun", "1,1", "-o", "x.png"],
        &["render", &format!("{url}.toml"), "-o", "x.png"],
        &["scene", &url, "-o", "x.toml"],
        &["scene", "leaf-card.glb", "--light", &pair, "-o", "x.toml"],
        &["info", &url],
        &["validate", &url, "--json"],
        &["torture", &url, "-o", "bad"],
        &["trade", &url],
        &["stream", &url, "scene.toml"],
        &["info", "card.flb", &url],
        &[&url],
    ] {
        let run = folder.flb_in(&environment, words);
        assert!((1..=6).contains(&run.code), "{words:?}: {}", run.code);
        let said = run.stdout + &run.stderr;
        assert!(!said.contains(secret), "{words:?}: {said}");
    }
}

#[test]
fn a_limit_on_threads_is_said() {
    let folder = Folder::with_card();
    // Root may have any number, so another user is asked.
    let run = |threads: u32| {
        let mut shell = Command::new("bash"); // not every sh has this limit
        let script = format!("ulimit -u {threads}; exec \"$0\" info card.flb");
        shell.args(["-c", &script, env!("CARGO_BIN_EXE_flb")]).current_dir(folder.path(""));
        if rustix::process::geteuid().is_root() {
            shell.uid(54_321).gid(54_321);
        }
        shell.output().expect("the shell starts")
    };
    std::fs::set_permissions(folder.path(""), std::os::unix::fs::PermissionsExt::from_mode(0o755))
        .expect("ours");
    for threads in [1, 2, 5, 12] {
        let output = run(threads);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(6), "{threads}: {said}");
        assert!(said.contains("ulimit -u"), "{said}");
    }
    let output = run(2000);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}
