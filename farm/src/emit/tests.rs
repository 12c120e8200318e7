use std::path::Path;

use super::*;
use crate::cache::Place;
use crate::tasks::{Task, TaskPlan};

/// Seven tasks in two classes of memory.
fn plan() -> TaskPlan {
    let task = |at: usize| Task {
        species: vec![(format!("oak-{at}"), "0".repeat(64))],
        memory_bytes: if at < 2 { 2 << 30 } else { 1 << 29 },
        seconds: 30.0,
    };
    let cache = Place::Folder("/a b/cache".into());
    TaskPlan::of_tasks(Path::new("/a b/library.toml"), &cache, (0..7).map(task).collect()).expect("text")
}

fn settings() -> EmitSettings {
    EmitSettings {
        program: "flb".into(),
        folder: "/a b/farm".into(),
        cores: 4,
        partition: Some("night".to_owned()),
        time: None,
        time_limit_s: None,
    }
}

fn text(engine: Engine, name: &str) -> String {
    let files = files(&plan(), engine, &settings()).expect("text");
    let names: Vec<&String> = files.iter().map(|(name, _)| name).collect();
    let found = files.iter().find(|(found, _)| found == name);
    found.unwrap_or_else(|| panic!("{name} is not in {names:?}")).1.clone()
}

#[test]
fn commands_are_lines_that_a_shell_reads() {
    let text = text(Engine::Commands, "commands.txt");
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split('\t').collect()).collect();
    assert_eq!(rows.len(), 8);
    assert_eq!(rows[0], ["task-1", "-", "2048", "30", "flb --threads 4 task run '/a b/farm/plan.json' 1"]);
    assert_eq!(rows[7][..3], ["finish", "task-1,task-2,task-3,task-4,task-5,task-6,task-7", "2048"]);
    let finish = "flb --threads 4 library build '/a b/library.toml' --cache '/a b/cache' --keep-going";
    assert_eq!(rows[7][4], finish);
    assert_eq!(shell(&["it's".to_owned(), String::new()]), r"'it'\''s' ''");
}

#[test]
fn open_job_description_has_a_step_for_each_amount_of_memory() {
    let job: serde_json::Value = serde_json::from_str(&text(Engine::OpenJd, "job.json")).expect("JSON");
    assert_eq!(job["specificationVersion"], "jobtemplate-2023-09");
    let range = |step: usize| {
        job["steps"][step]["parameterSpace"]["taskParameterDefinitions"][0]["range"]
            .as_str()
            .map(str::to_owned)
    };
    assert_eq!((range(0).as_deref(), range(1).as_deref(), range(2)), (Some("1-2"), Some("3-7"), None));
    let memory = |step: usize| job["steps"][step]["hostRequirements"]["amounts"][1]["min"].as_u64();
    assert_eq!((memory(0), memory(1)), (Some(2048), Some(512)));
    let finish = &job["steps"][2];
    let after = serde_json::json!([{ "dependsOn": "Bake1" }, { "dependsOn": "Bake2" }]);
    assert_eq!((&finish["name"], &finish["dependencies"]), (&"Finish".into(), &after));
    assert_eq!(finish["script"]["actions"]["onRun"]["command"], "flb");
}

#[test]
fn arrays_of_slurm_take_the_tasks_of_an_amount_of_memory() {
    let second = text(Engine::Slurm, "bake-2.sbatch");
    for line in [
        "#SBATCH --mem=512M",
        "#SBATCH --cpus-per-task=4",
        "#SBATCH --partition=night",
        "#SBATCH --array=0-4",
        "flb --threads 4 task run '/a b/farm/plan.json' $((SLURM_ARRAY_TASK_ID + 3))",
    ] {
        assert!(second.lines().any(|found| found == line), "{line}: {second}");
    }
    assert!(!second.contains("--time"), "{second}");
    let submit = text(Engine::Slurm, "submit.sh");
    assert!(
        submit.contains("sbatch --parsable bake-2.sbatch") && submit.contains("--kill-on-invalid-dep=yes")
    );
    // More tasks than an array takes are several arrays.
    let one = plan().tasks[6].clone();
    let many = TaskPlan::of_tasks(Path::new("l"), &Place::Folder("c".into()), vec![one; 2500]).expect("text");
    let files = files(&many, Engine::Slurm, &settings()).expect("text");
    assert_eq!(files.len(), 5);
    assert!(files[2].1.contains("--array=0-499\n") && files[2].1.contains("+ 2001))"), "{}", files[2].1);
}
