//! A line for each task.

use std::fmt::Write;

use super::{EmitSettings, mebibytes, shell};
use crate::tasks::TaskPlan;

/// Lines of five cells with tabs between: name, names of the tasks that go before, MiB, seconds, command.
pub(super) fn text(plan: &TaskPlan, settings: &EmitSettings) -> String {
    let mut text = "# name\tafter\tMiB\tseconds\tcommand\n".to_owned();
    let mut row = |name: &str, after: &str, bytes: u64, seconds: f64, words: &[String]| {
        let (mib, command) = (mebibytes(bytes), shell(words));
        let _ = writeln!(text, "{name}\t{after}\t{mib}\t{seconds:.0}\t{command}");
    };
    for (at, task) in plan.tasks.iter().enumerate() {
        let number = at + 1;
        let words = settings.task(&number.to_string());
        row(&format!("task-{number}"), "-", task.memory_bytes, task.seconds, &words);
    }
    let names: Vec<String> = (1..=plan.tasks.len()).map(|number| format!("task-{number}")).collect();
    let after = if names.is_empty() { "-".to_owned() } else { names.join(",") };
    let most = plan.tasks.iter().map(|task| task.memory_bytes).max().unwrap_or(0);
    row("finish", &after, most, 0.0, &settings.finish(plan));
    text
}
