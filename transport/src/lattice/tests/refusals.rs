//! What is refused, and that the message says where and why.

use flb_format::bases::BaseSet;
use flb_format::matter::{Class, Optics};

use super::super::{SolveError, SolveSettings, SolverKind, Steps, media, solve};
use super::{one_band, quiet};

fn message(medium: &flb_format::Medium, optics: &Optics, settings: &SolveSettings) -> String {
    solve(medium, optics, settings, &quiet).unwrap_err().to_string()
}

#[test]
fn bad_media_are_refused_with_the_place() {
    let settings = SolveSettings::default();
    let check = |change: &dyn Fn(&mut flb_format::Medium), expected: &str| {
        let mut medium = media::empty(16);
        change(&mut medium);
        let found = message(&medium, &one_band(0), &settings);
        assert!(found.contains(expected), "{found:?} should contain {expected:?}");
    };
    let index = media::empty(16).grid.index(5, 6, 7);
    for bad in [f32::NAN, f32::INFINITY, -0.1, 1.0 + f32::EPSILON] {
        check(&|m| m.density[index] = bad, &format!("site [5, 6, 7]: density {bad}"));
    }
    check(&|m| m.density[index] = 0.5, "class Empty with density 0.5");
    check(&|m| m.class[index] = Class::Leaf, "class Leaf with density 0");
    check(&|m| media::put(m, [1, 8, 8], Class::Leaf, 0.5), "outer two layers");
    check(&|m| media::put(m, [8, 14, 8], Class::Leaf, 0.5), "outer two layers");
    check(&|m| m.grid.lattice = 24, "lattice of 24");
    check(&|m| m.grid.lattice = 8, "lattice of 8");
    check(&|m| m.grid.lattice = 512, "lattice of 512");
    check(&|m| m.density.truncate(9), "density: found 9 values, expected 4096");
    check(&|m| m.class.truncate(9), "class: found 9 values, expected 4096");
}

#[test]
fn optics_outside_the_non_negative_region_are_refused_with_the_reason() {
    let medium = media::empty(16);
    let settings = SolveSettings::default();
    for sigma_a in [-0.01, 1.01, f64::NAN] {
        let mut optics = Optics::paper();
        optics.bands[1].wood.sigma_a = sigma_a;
        let found = message(&medium, &optics, &settings);
        assert!(found.contains("band 1 (G), Wood: sigma_a") && found.contains("negative"), "{found}");
    }
    for g in [-1.01, 1.01, f64::NAN] {
        let mut optics = Optics::paper();
        optics.bands[2].leaf.g = g;
        let found = message(&medium, &optics, &settings);
        assert!(found.contains("band 2 (B), Leaf: g = "), "{found}");
    }
    let none = Optics { bands: vec![] };
    assert!(message(&medium, &none, &settings).contains("0 bands"));
    let many = Optics { bands: vec![Optics::paper().bands[0].clone(); 65] };
    assert!(message(&medium, &many, &settings).contains("65 bands"));
}

#[test]
fn settings_that_can_never_be_met_are_refused() {
    let medium = media::empty(16);
    for tolerance in [0.0, -1.0, 1.0, f64::NAN] {
        let settings = SolveSettings { tolerance, ..SolveSettings::default() };
        let found = solve(&medium, &one_band(0), &settings, &quiet).unwrap_err();
        assert!(matches!(found, SolveError::Tolerance { .. }));
    }
    let settings = SolveSettings { max_sweeps: 0, ..SolveSettings::default() };
    assert_eq!(solve(&medium, &one_band(0), &settings, &quiet), Err(SolveError::MaxSweeps));
    let explicit = SolveSettings { solver: SolverKind::Explicit, ..SolveSettings::default() };
    for steps in [Steps::Count(0), Steps::PerEdge(0)] {
        let settings = SolveSettings { steps: Some(steps), ..explicit.clone() };
        assert_eq!(solve(&medium, &one_band(0), &settings, &quiet), Err(SolveError::NoSteps));
    }
    let settings = SolveSettings { steps: Some(Steps::PAPERS), ..SolveSettings::default() };
    let found = message(&medium, &one_band(0), &settings);
    assert!(found.contains("Sweep") && found.contains("expected Explicit or Literal"), "{found}");
    let settings = SolveSettings { bases: BaseSet::NONE, ..SolveSettings::default() };
    assert_eq!(solve(&medium, &one_band(0), &settings, &quiet), Err(SolveError::NoBases));
}

#[cfg(not(feature = "gpu"))]
#[test]
fn a_build_without_the_gpu_solver_says_so() {
    let settings = SolveSettings { solver: super::super::SolverKind::GPU, ..SolveSettings::default() };
    let found = message(&media::empty(16), &one_band(0), &settings);
    assert!(found.contains("feature `gpu`"), "{found}");
    assert_eq!(super::super::find_gpu().unwrap_err().to_string(), found);
}
