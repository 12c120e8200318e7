//! A library on a real Slurm of two nodes: a node dies in the middle of a task, one task fails once, one asks to be run
//! again, one species can never be made. The bytes are those of a build on one machine.

pub(crate) mod cluster;

use std::fs;
use std::os::unix::fs::PermissionsExt;

use cluster::Cluster;
use serde_json::{Value, json};

use crate::flb::Folder;
use crate::schema::{misfits, schema};

/// Twelve species of one small mesh, and one that cannot be made.
fn manifest(with_broken: bool) -> String {
    let mut text =
        "[bake]\nquality = 'draft'\nlattice = 16\nvoxels = 64\n\n[[species]]\nmesh = 'shrub.glb'\n"
            .to_owned();
    for tenth in 1..12 {
        let colors = format!("leaf = {{ reflectance = 0.{tenth:02}, transmittance = 0.05 }}");
        text += &format!(
            "[[species.variant]]\nname = '{tenth:02}'\nplant = {{ leaf_colour = 'measured', surfaces = [{{ name = 'G', {colors}, wood = {{ reflectance = 0.1 }} }}] }}\n"
        );
    }
    if with_broken {
        text += "[[species]]\nmesh = 'broken.obj'\n";
    }
    text
}

/// The program with mishaps: task 2 hangs when it is first run, task 3 fails, task 4 is out of time.
const MISHAPS: &str = "#!/bin/sh
once() { [ ! -e \"$HERE/$1\" ] && : > \"$HERE/$1\"; }
for last; do :; done
case \"$*\" in
*\" task run \"*)
    case \"$last\" in
    2) once hang && sleep 1000 ;;
    3) once fail && exit 1 ;;
    4) once late && exit 75 ;;
    esac ;;
esac
exec \"$FLB\" \"$@\"
";

#[test]
fn a_library_survives_a_farm_and_has_the_bytes_of_one_machine() {
    let folder = Folder::with_plants(&["shrub"]);
    folder.write("library.toml", manifest(false));
    folder.flb(&["library", "build"]).expect_code(0);
    let alone = folder.read("library/library.flb");
    fs::remove_dir_all(folder.path("library")).expect("it was there");
    fs::remove_dir_all(folder.path(".flb-cache")).expect("it was there");

    folder.write("library.toml", manifest(true)).write("broken.obj", "v 0 0 0\n");
    let here = folder.path("").display().to_string();
    let program = MISHAPS.replace("$HERE", &here).replace("$FLB", env!("CARGO_BIN_EXE_flb"));
    folder.write("flb.sh", program);
    fs::set_permissions(folder.path("flb.sh"), fs::Permissions::from_mode(0o755)).expect("our own file");
    let program = folder.path("flb.sh").display().to_string();
    let mut cluster = Cluster::start(folder);
    let submit = ["farm", "submit", "--engine", "slurm", "--chunk", "0.001", "--program", &program, "--json"];
    let submitted = cluster.flb(&submit).expect_code(0).json();
    assert_eq!(misfits(&schema("farm"), &submitted), [""; 0], "{submitted}");
    assert_eq!((&submitted["tasks"], submitted["jobs"].as_array().map(Vec::len)), (&json!(13), Some(2)));
    cluster.flb(&submit).expect_code(2).says(&["is in the queue still: wait for it, cancel it"]);

    let (hang, late) = (cluster.folder.path("hang"), cluster.folder.path("late"));
    cluster.until("task 2 hangs", || hang.exists());
    let status = cluster.flb(&["farm", "status", "--json"]).expect_code(0).json();
    assert_eq!(misfits(&schema("farm"), &status), [""; 0], "{status}");
    assert!(status["queue"]["RUNNING"].as_u64() >= Some(1), "{status}");
    // Where it hangs is where the power goes.
    let node = cluster.node_of_task(2);
    cluster.kill(&node);
    cluster.until("the queue is empty", || {
        cluster.begin_held_jobs();
        cluster.flb(&["farm", "status", "--json"]).json()["queue"] == json!({})
    });
    assert!(late.exists() && cluster.folder.path("fail").exists(), "every mishap happened");
    let waited = cluster.flb(&["farm", "wait", "--interval", "0.1", "--json"]).expect_code(3);
    let waited = waited.says(&["broken: not made; flb farm logs broken"]);
    assert_eq!((&waited.json()["done"], &waited.json()["missing"]), (&json!(12), &json!(["broken"])));
    let log = cluster.flb(&["farm", "logs", "broken"]).expect_code(0);
    assert!(
        log.stdout.contains("broken: failed: ") && log.stdout.contains("no triangle is left"),
        "{}",
        log.stdout
    );
    let index: Value = serde_json::from_slice(&cluster.folder.read("library/index.json")).expect("JSON");
    assert_eq!(index["species"].as_object().map(serde_json::Map::len), Some(12));

    // Without what cannot be made, the end is all there is to do.
    cluster.folder.write("library.toml", manifest(false));
    let submitted = cluster.flb(&submit).expect_code(0).json();
    assert_eq!(submitted["tasks"], 0, "{submitted}");
    cluster.flb(&["farm", "wait", "--interval", "0.1"]).expect_code(0);
    assert!(cluster.folder.read("library/library.flb") == alone, "the bytes of a build on one machine");

    // What waits in the queue can be taken out of it.
    cluster.folder.write("library.toml", manifest(false).replace("0.05", "0.06"));
    cluster.flb(&submit).expect_code(0);
    assert!(!cluster.flb(&["farm", "cancel"]).expect_code(0).stdout.starts_with("0 "));
    cluster.flb(&["farm", "wait", "--interval", "0.1"]).expect_code(3);
}

#[test]
fn a_machine_without_slurm_and_one_that_answers_nonsense_are_told() {
    let folder = Folder::with_plants(&["shrub"]);
    folder.write("library.toml", manifest(false));
    let empty = folder.path("empty");
    fs::create_dir(&empty).expect("a folder");
    let submit = ["farm", "submit", "--engine", "slurm"];
    let run = folder.flb_in(&[("PATH", &empty.display().to_string())], &submit);
    run.expect_code(4).says(&["sbatch: ", "expected Slurm's commands in PATH"]);
    for (name, text) in [("sbatch", "#!/bin/sh\necho 7\n"), ("squeue", "#!/bin/sh\necho it is raining\n")] {
        folder.write(&format!("empty/{name}"), text);
        let mode = fs::Permissions::from_mode(0o755);
        fs::set_permissions(folder.path("empty").join(name), mode).expect("our own file");
    }
    let path = format!("{}:{}", empty.display(), std::env::var("PATH").unwrap_or_default());
    folder.flb_in(&[("PATH", &path)], &submit).expect_code(0);
    let run = folder.flb_in(&[("PATH", &path)], &["farm", "status"]);
    run.expect_code(4).says(&["squeue: found \"it is raining\", expected number|name|state|reason"]);
    folder.flb(&["farm", "status", "nowhere"]).expect_code(4).says(&["nowhere"]);
    folder.flb_with(&submit, &["--time", "soon"]).expect_code(2).says(&["found \"soon\", expected minutes"]);
}
