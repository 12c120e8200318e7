//! Open Job Description, job template 2023-09: <https://github.com/OpenJobDescription/openjd-specifications>.

use serde_json::{Value, json};

use super::{EmitSettings, mebibytes};
use crate::tasks::TaskPlan;

/// Characters of a job's name.
const MAX_NAME_CHARS: usize = 128;

/// A step for the tasks of each amount of memory, and one that ends the work.
pub(super) fn text(plan: &TaskPlan, settings: &EmitSettings) -> String {
    let mut steps: Vec<Value> = Vec::new();
    let mut most = 0;
    for class in plan.classes() {
        let bytes = plan.tasks[class.start() - 1].memory_bytes;
        most = most.max(bytes);
        let mut words = settings.task("{{Task.Param.Task}}");
        words.extend(["--progress", "openjd"].map(str::to_owned));
        let numbers = json!([{
            "name": "Task",
            "type": "INT",
            "range": format!("{}-{}", class.start(), class.end()),
        }]);
        let mut step = step(&format!("Bake{}", steps.len() + 1), &words, bytes, settings);
        step["parameterSpace"] = json!({ "taskParameterDefinitions": numbers });
        steps.push(step);
    }
    let bakes: Vec<Value> = steps.iter().map(|step| json!({ "dependsOn": step["name"] })).collect();
    let mut finish = step("Finish", &settings.finish(plan), most, settings);
    if !bakes.is_empty() {
        finish["dependencies"] = json!(bakes);
    }
    steps.push(finish);
    let file = plan.manifest.file_name().unwrap_or_default().to_string_lossy();
    let is_fit = |c: &char| !c.is_control();
    let name: String = format!("flb {file}").chars().filter(is_fit).take(MAX_NAME_CHARS).collect();
    let job =
        json!({ "specificationVersion": "jobtemplate-2023-09", "name": escaped(&name), "steps": steps });
    serde_json::to_string_pretty(&job).expect("names and numbers are JSON") + "\n"
}

fn step(name: &str, words: &[String], bytes: u64, settings: &EmitSettings) -> Value {
    let (command, arguments) = (&words[0], &words[1..]);
    json!({
        "name": name,
        "hostRequirements": { "amounts": [
            { "name": "amount.worker.vcpu", "min": settings.cores },
            { "name": "amount.worker.memory", "min": mebibytes(bytes).max(1) },
        ] },
        "script": { "actions": { "onRun": { "command": command, "args": arguments } } },
    })
}

/// Text in which braces begin no expression.
fn escaped(text: &str) -> String {
    text.replace("{{", "{ {").replace("}}", "} }")
}
