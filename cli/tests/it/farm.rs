//! The work of a library as tasks: what engines are given, run line by line, makes what a build makes.

use std::process::Command;

use serde_json::json;

use crate::flb::{Folder, python};
use crate::library::MANIFEST;
use crate::schema::{misfits, schema};

/// One species more, on a finer lattice.
fn manifest() -> String {
    format!("{MANIFEST}\n[[species.variant]]\nname = 'fine'\nbake = {{ lattice = 32 }}\n")
}

fn farm() -> Folder {
    let folder = Folder::with_plants(&["shrub"]);
    folder.write("library.toml", manifest());
    folder
}

fn emit(folder: &Folder, format: &str, output: &str) -> serde_json::Value {
    let words = ["farm", "emit", "--format", format, "-o", output, "--program", env!("CARGO_BIN_EXE_flb")];
    let run = folder.flb_with(&words, &["--chunk", "0.001", "--json"]).expect_code(0).json();
    assert_eq!(misfits(&schema("farm"), &run), [""; 0], "{run}");
    run
}

#[test]
fn commands_make_what_a_build_makes() {
    let folder = farm();
    let emitted = emit(&folder, "commands", "work");
    assert_eq!((&emitted["species"], &emitted["tasks"]), (&json!(3), &json!(3)));
    assert_eq!(emitted["files"], json!(["commands.txt", "plan.json"]));
    let text = String::from_utf8(folder.read("work/commands.txt")).expect("text");
    let commands: Vec<&str> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.rsplit('\t').next().unwrap())
        .collect();
    assert_eq!(commands.len(), 4);
    let run = |command: &str| {
        let output =
            Command::new("sh").args(["-c", command]).current_dir(folder.path("")).output().expect("sh");
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    // Tasks in any order, one of them twice.
    for at in [2, 0, 2, 1] {
        run(commands[at]);
        assert!(!folder.path("library/library.flb").exists());
    }
    assert!(run(commands[3]).contains("0 baked, 0 from the cache, 3 as they were"));
    let library = folder.read("library/library.flb");
    std::fs::remove_dir_all(folder.path("library")).expect("it was there");
    std::fs::remove_dir_all(folder.path(".flb-cache")).expect("it was there");
    folder.flb(&["library", "build"]).expect_code(0);
    assert!(folder.read("library/library.flb") == library, "the same bytes as a build on one machine");

    // Nothing is due: the end is all that is left.
    let emitted = emit(&folder, "openjd", "again");
    assert_eq!(emitted["tasks"], 0);
    let job: serde_json::Value = serde_json::from_slice(&folder.read("again/job.json")).expect("JSON");
    assert_eq!(job["steps"].as_array().map(Vec::len), Some(1));
}

/// openjd-cli: as scripts/setup installs it.
fn openjd(folder: &Folder, words: &[&str]) -> String {
    let output = python("openjd", words).current_dir(folder.path("")).output().expect("Python");
    let text =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(output.status.success(), "{words:?}: {text}");
    text
}

#[test]
fn a_runner_of_open_job_description_checks_and_runs_the_job() {
    let folder = farm();
    emit(&folder, "openjd", "work");
    assert!(openjd(&folder, &["check", "work/job.json"]).contains("passes validation checks"));
    let told = openjd(&folder, &["run", "work/job.json"]);
    for line in
        ["openjd_status: shrub-dense: solve", "openjd_progress: 100", "0 baked, 0 from the cache, 3 as they"]
    {
        assert!(told.contains(line), "{line}: {told}");
    }
    let library = folder.read("library/library.flb");
    std::fs::remove_dir_all(folder.path("library")).expect("it was there");
    std::fs::remove_dir_all(folder.path(".flb-cache")).expect("it was there");
    folder.flb(&["library", "build"]).expect_code(0);
    assert!(folder.read("library/library.flb") == library, "the same bytes as a build on one machine");
}

#[test]
fn a_task_tells_engines_how_far_it_is_and_asks_to_be_run_again() {
    let folder = farm();
    emit(&folder, "openjd", "work");
    let task = ["task", "run", "work/plan.json"];
    // A task whose time is over before its first stage ends.
    folder
        .flb_with(&task, &["1-3", "--time-limit", "0.00001"])
        .expect_code(75)
        .says(&["the time was not enough: run the task again"]);
    let run = folder.flb_with(&task, &["1", "--progress", "openjd"]).expect_code(0);
    assert!(run.stdout.contains("openjd_status: shrub-fine: solve\n"), "{}", run.stdout);
    assert!(run.stdout.ends_with("openjd_progress: 100\n"), "{}", run.stdout);
    let run = folder.flb_with(&task, &["1-3", "--json"]).expect_code(0).json();
    assert_eq!(misfits(&schema("task"), &run), [""; 0], "{run}");
    let states: Vec<&str> =
        run["species"].as_array().expect("a list").iter().filter_map(|one| one["state"].as_str()).collect();
    assert_eq!(states, ["current", "made", "made"]);

    for (range, told) in
        [("0", "found tasks 0-0, expected numbers from 1 to 3"), ("2-9", "2-9"), ("x", "3-5")]
    {
        folder.flb_with(&task, &[range]).expect_code(2).says(&[told]);
    }
    folder.flb(&["task", "run", "gone.json", "1"]).expect_code(4).says(&["gone.json"]);
    folder.write("no.json", "{}");
    folder.flb(&["task", "run", "no.json", "1"]).expect_code(1).says(&["no.json: found ", "flb farm emit"]);
    let words = ["farm", "emit", "--format", "openjd", "-o", "work"];
    folder.flb(&words).expect_code(4).says(&["exists already"]);
    // The manifest went on.
    let newer = manifest().replace("spherical", "planophile");
    folder.write("library.toml", newer);
    folder
        .flb_with(&task, &["1-3"])
        .expect_code(1)
        .says(&["shrub-dense is made of other inputs or settings than the plan says: plan again"]);
}

#[test]
fn one_that_fails_is_told_and_the_others_are_made() {
    let folder = farm();
    folder.write("broken.obj", "v 0 0 0\n");
    folder.write("library.toml", format!("{}\n[[species]]\nmesh = 'broken.obj'\n", manifest()));
    emit(&folder, "slurm", "work");
    let run = folder.flb(&["task", "run", "work/plan.json", "1-4"]).expect_code(3);
    run.says(&["broken: failed: ", "no triangle is left"]);
    for name in ["shrub", "shrub-dense", "shrub-fine"] {
        assert!(folder.path("library/species").join(format!("{name}.flb")).is_file(), "{name}");
    }
    for name in ["bake-1.sbatch", "finish.sbatch", "submit.sh"] {
        let file = folder.path("work").join(name);
        let status = Command::new("sh").arg("-n").arg(&file).status().expect("sh");
        assert!(status.success(), "{name} is a script that a shell reads");
    }
}
