//! Time that is left of a bake, by how far its stage is and by the shares of a bake's time that stages take.

use flb_scene::Step;

/// Stages of a bake in their order, with seconds of the built-in oak on two cores: `flb bake oak.glb -o oak.flb`.
const SECONDS: [(Step, f64); 8] = [
    (Step::Import, 0.1),
    (Step::Voxelise, 1.1),
    (Step::Downsample, 0.1),
    (Step::Crown, 1.1),
    (Step::Solve, 6.0),
    (Step::Solids, 1.6),
    (Step::Encode, 1.9),
    (Step::Write, 0.1),
];
/// Share of a stage from which on its time tells of what is left.
const MIN_SHARE: f64 = 0.05;

/// Seconds until the stages of a bake have ended, where one of them has taken so many for a share of its work; `None`
/// for other steps, and where too little is done.
pub(super) fn of_bake(step: Step, share: f64, took_s: f64) -> Option<f64> {
    let at = SECONDS.iter().position(|(stage, _)| *stage == step).filter(|_| share >= MIN_SHARE)?;
    let stage_s = took_s / share;
    let later: f64 = SECONDS[at + 1..].iter().map(|(_, seconds)| seconds).sum();
    Some(stage_s - took_s + stage_s * later / SECONDS[at].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_the_rest_of_the_stage_and_the_later_ones_at_its_pace() {
        assert_eq!(of_bake(Step::Solve, 0.01, 1.0), None);
        assert_eq!(of_bake(Step::Render, 0.5, 1.0), None);
        let later = (1.6 + 1.9 + 0.1) / 6.0;
        let left = of_bake(Step::Solve, 0.25, 10.0).expect("enough is done");
        assert!((left - (30.0 + 40.0 * later)).abs() < 1e-9, "{left}");
        let end = of_bake(Step::Write, 1.0, 0.2).expect("all is done");
        assert!(end.abs() < 1e-9, "{end}");
    }
}
