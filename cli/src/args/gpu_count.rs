//! `--gpus`: how many GPUs draw a scene together, or share a bake.

use flb_stage::backend::GpuCount;

/// "all", or a number.
pub(super) fn gpu_count(text: &str) -> Result<GpuCount, String> {
    match text.trim().parse() {
        _ if text.trim() == "all" => Ok(GpuCount::All),
        Ok(count @ 1..=64) => Ok(GpuCount::Exactly(count)),
        _ => Err(format!("expected all, or 1 to 64, such as 2; found {text:?}")),
    }
}
