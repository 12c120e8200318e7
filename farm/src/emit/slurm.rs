//! Batch scripts of Slurm: <https://slurm.schedmd.com/sbatch.html>.

use std::fmt::Write;
use std::ops::RangeInclusive;

use super::{EmitSettings, mebibytes, shell};
use crate::tasks::TaskPlan;

/// Tasks of an array: a cluster whose settings say nothing takes numbers up to 1000.
const MAX_ARRAY: usize = 1000;

/// Times that a task is run again.
const MAX_AGAIN: u32 = 5;

/// Scripts of arrays of tasks that take the same memory, one that ends the work, and one that submits all.
pub(super) fn scripts(plan: &TaskPlan, settings: &EmitSettings) -> Vec<(String, String)> {
    let mut scripts = Vec::new();
    for tasks in arrays(plan) {
        let name = format!("bake-{}.sbatch", scripts.len() + 1);
        scripts.push((name, bake(plan, settings, *tasks.start(), tasks.count())));
    }
    let submit = submit(scripts.iter().map(|(name, _)| name.as_str()));
    scripts.push(("finish.sbatch".to_owned(), finish(plan, settings)));
    scripts.push(("submit.sh".to_owned(), submit));
    scripts
}

/// Tasks of each array, numbers from 1.
pub(super) fn arrays(plan: &TaskPlan) -> Vec<RangeInclusive<usize>> {
    let cut = |class: RangeInclusive<usize>| {
        let last = *class.end();
        class.step_by(MAX_ARRAY).map(move |first| first..=last.min(first + MAX_ARRAY - 1))
    };
    plan.classes().into_iter().flat_map(cut).collect()
}

/// The lines that every script begins with.
fn head(name: &str, bytes: u64, settings: &EmitSettings) -> String {
    let mut text = format!(
        "#!/bin/sh\n#SBATCH --job-name={name}\n#SBATCH --cpus-per-task={}\n#SBATCH --mem={}M\n#SBATCH --requeue\n",
        settings.cores,
        mebibytes(bytes).max(1)
    );
    for (flag, value) in [("partition", &settings.partition), ("time", &settings.time)] {
        if let Some(value) = value {
            let _ = writeln!(text, "#SBATCH --{flag}={value}");
        }
    }
    text
}

fn bake(plan: &TaskPlan, settings: &EmitSettings, first: usize, count: usize) -> String {
    let mut text = head("flb-bake", plan.tasks[first - 1].memory_bytes, settings);
    let words = settings.task("");
    let command = shell(&words[..words.len() - 1]);
    let _ = write!(
        text,
        "#SBATCH --array=0-{}\n#SBATCH --output=%x-%A_%a.log\n\
         {command} $((SLURM_ARRAY_TASK_ID + {first}))\n\
         code=$?\n\
         # It asks to be run again.\n\
         if [ $code = 75 ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt {MAX_AGAIN} ]; then scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}\"; fi\n\
         exit $code\n",
        count - 1
    );
    text
}

fn finish(plan: &TaskPlan, settings: &EmitSettings) -> String {
    let most = plan.tasks.iter().map(|task| task.memory_bytes).max().unwrap_or(1 << 30);
    let text = head("flb-finish", most, settings);
    format!("{text}#SBATCH --output=%x-%j.log\nexec {}\n", shell(&settings.finish(plan)))
}

/// Submits every array, and the end behind all of them, whatever became of them: it says what failed. The numbers of
/// the jobs go to `jobs.txt`.
fn submit<'n>(arrays: impl Iterator<Item = &'n str>) -> String {
    let mut text = "#!/bin/sh\nset -e\ncd \"$(dirname \"$0\")\"\nafter=\n: > jobs.txt\n".to_owned();
    for name in arrays {
        let _ = write!(
            text,
            "job=$(sbatch --parsable {name})\njob=${{job%%;*}}\necho \"$job\" >> jobs.txt\nafter=$after:$job\n"
        );
    }
    text += "job=$(sbatch --parsable --kill-on-invalid-dep=yes ${after:+--dependency=afterany$after} finish.sbatch)\n\
             job=${job%%;*}\necho \"$job\" >> jobs.txt\n";
    text
}
