//! The solver on the GPU against its twin, the sweep solver and the oracle. They need an adapter, and fail without one;
//! lavapipe (`scripts/setup test` installs it) will do.

mod wgsl;

use std::slice::from_ref;

use flb_format::Medium;
use flb_format::bases::BaseSet;
use flb_format::matter::{Class, ClassOptics, Optics};
use flb_format::progress::Cancelled;

use super::super::kernel::LANES;
use super::super::tests::{differences, one_band, optics, oracle};
use super::super::{BaseReport, Solution, SolveError, SolveSettings, SolverKind, media, sites, solve};
use super::device::{self, Gpu};
use super::{relax, solve_on, twin};
use crate::gpu::GpuError;

/// Between the GPU and the other solvers, relative L2 over the non-empty sites.
const ALIKE: f64 = 1e-4;

/// Two orders of the same sums in f32; drivers may fuse multiplications with additions.
const ROUNDING: f32 = 1e-5;

fn quiet(_: f64) -> Result<(), Cancelled> {
    Ok(())
}

fn gpu() -> Gpu {
    // The message says what to install.
    device::open(1).unwrap_or_else(|error| panic!("{error}")).remove(0)
}

fn fine(solver: SolverKind) -> SolveSettings {
    SolveSettings { solver, tolerance: 1e-6, ..SolveSettings::default() }
}

fn solved(medium: &Medium, optics: &Optics, settings: &SolveSettings) -> Solution {
    solve_on(&[gpu()], u64::MAX, medium, optics, settings, &quiet).unwrap()
}

fn worst_difference(medium: &Medium, found: &Solution, expected: &Solution) -> f64 {
    let mut worst = 0.0_f64;
    assert_eq!(found.bases.len(), expected.bases.len());
    for ((base, found), (of, expected)) in found.bases.iter().zip(&expected.bases) {
        assert_eq!(base, of);
        for band in 0..found.bands {
            let expected: Vec<f64> = expected.band(band).iter().map(|v| f64::from(*v)).collect();
            worst = worst.max(differences(medium, &found.band(band), &expected).1);
        }
    }
    worst
}

/// A ball in the middle: wood within `wood` sites of the centre, leaves of the density beyond it within `leaf`.
fn ball(lattice: u32, wood: f64, leaf: f64, density: f32) -> Medium {
    let mut medium = media::empty(lattice);
    let middle = f64::from(lattice) / 2.0;
    for index in 0..medium.class.len() as u32 {
        let site = medium.grid.site(index as usize);
        let from_middle = site.map(|c| f64::from(c) + 0.5 - middle);
        let distance = from_middle.iter().map(|d| d * d).sum::<f64>().sqrt();
        if distance < wood {
            media::put(&mut medium, site, Class::Wood, if index % 3 == 0 { 0.5 } else { 1.0 });
        } else if distance < leaf {
            media::put(&mut medium, site, Class::Leaf, density);
        }
    }
    medium
}

#[test]
fn iterations_equal_those_of_the_twin() {
    let medium = ball(16, 2.5, 4.5, 0.4);
    let optics = Optics::paper();
    let sites = sites::find(&medium, usize::MAX);
    assert!(sites.domains[0].echoes.iter().any(|echoes| *echoes != 0));
    let lanes: [(u8, u32); LANES] = [(1, 0), (2, 1), (7, 2), (0, 0), (10, 1), (18, 2), (15, 0), (6, 1)];
    // An odd and an even count end on different sides.
    for count in [1_u32, 5, 8, 12] {
        let gpu = gpu();
        let settings = SolveSettings { tolerance: 1e-9, max_sweeps: count, ..SolveSettings::default() };
        let matter = relax::upload(&gpu, &sites).unwrap();
        let (light, courses) =
            relax::relax(&gpu, &matter, &sites, &optics, &lanes, &settings, &|_, _| Ok(())).unwrap();
        let twin = twin::relax(&sites.domains[0], &optics, &lanes, count as usize);
        assert_eq!(light[0].len(), twin.rows.len());
        for (row, (found, expected)) in light[0].iter().zip(&twin.rows).enumerate() {
            for lane in 0..LANES {
                let (found, expected) = (found.0[lane], expected.0[lane]);
                assert!(
                    (found - expected).abs() < ROUNDING * expected.max(1.0),
                    "{count}, row {row}: {found} {expected}"
                );
            }
        }
        for (lane, course) in courses.iter().enumerate() {
            let [change, norm] = twin.moves[count as usize - 1][lane];
            let expected = (change / norm).sqrt();
            let found = course.residual();
            assert!((found / expected - 1.0).abs() < 1e-3, "{count}, lane {lane}: {found} {expected}");
            assert_eq!(course.report(1, 0, &settings).sweeps, count);
        }
    }
}

#[test]
fn fields_equal_those_of_sweeps() {
    let back = |sigma_a: f64| ClassOptics { sigma_a, g: -1.0 };
    let cases = [
        ("tree 16", media::tree(16, 3), Optics::paper()),
        ("tree 32", media::tree(32, 7), Optics::paper()),
        ("leaf ball", ball(16, 0.0, 5.0, 1.0), Optics::paper()),
        ("thin leaf ball", ball(32, 0.0, 10.0, 1e-4), one_band(1)),
        ("wood ball", ball(16, 4.0, 4.0, 0.0), one_band(0)),
        ("mixed ball", ball(32, 3.0, 8.0, 0.7), Optics::paper()),
        ("forward", ball(16, 1.5, 5.0, 0.8), optics(ClassOptics { sigma_a: 0.05, g: 0.9 }, back(0.4))),
        ("black", ball(16, 1.5, 5.0, 0.8), optics(ClassOptics { sigma_a: 1.0, g: 0.0 }, back(1.0))),
    ];
    for (name, medium, optics) in cases {
        let settings = SolveSettings { max_sweeps: 2000, ..fine(SolverKind::GPU) };
        let found = solved(&medium, &optics, &settings);
        // In solid wood iterations end up going round within rounding errors.
        let is_done = |report: &BaseReport| report.converged || report.residual < f64::from(f32::EPSILON);
        assert!(found.reports.iter().all(is_done), "{name}: {:?}", found.reports);
        let sweeps = SolveSettings { solver: SolverKind::Sweep, tolerance: 1e-7, ..settings };
        let expected = solve(&medium, &optics, &sweeps, &quiet).unwrap();
        let difference = worst_difference(&medium, &found, &expected);
        assert!(difference < ALIKE, "{name}: {difference:e}");
    }
}

#[test]
fn fields_equal_those_of_the_oracle() {
    let medium = media::tree(32, 7);
    let optics = Optics::paper();
    let solution = solved(&medium, &optics, &fine(SolverKind::GPU));
    for (base, band) in [(1, 0), (4, 2), (9, 1), (18, 2), (0, 1)] {
        let expected = oracle(&medium, &optics, band, base);
        let (_, rms) = differences(&medium, &solution.bases[usize::from(base)].1.band(band), &expected);
        assert!(rms < ALIKE, "base {base}, band {band}: {rms:e}");
    }
}

#[test]
fn default_tolerance_buys_fields_alike_and_a_true_error_estimate() {
    let medium = media::tree(32, 2);
    let optics = Optics::paper();
    let found = solved(&medium, &optics, &SolveSettings::default());
    let exact =
        solve(&medium, &optics, &SolveSettings { tolerance: 1e-8, ..fine(SolverKind::Sweep) }, &quiet);
    let exact = exact.unwrap();
    for report in found.reports.iter().filter(|report| report.base > 0) {
        let values =
            |solution: &Solution| solution.bases[usize::from(report.base)].1.band(report.band).to_vec();
        let expected: Vec<f64> = values(&exact).iter().map(|v| f64::from(*v)).collect();
        let (_, error) = differences(&medium, &values(&found), &expected);
        assert!(report.converged && error < ALIKE, "{report:?}: error {error:e}");
        let ratio = report.error_estimate / error;
        assert!((1.0 / 3.0..3.0).contains(&ratio), "{report:?}: error {error:e}");
    }
}

#[test]
fn neither_groups_nor_repetition_change_the_bytes() {
    let medium = media::tree(16, 4);
    // 5 bands and 3 bases: 15 lanes, so that the last of several groups is not full.
    let mut bands = Optics::paper().bands;
    bands.extend(Optics::paper().bands.into_iter().take(2));
    bands[3].leaf.sigma_a = 0.7;
    bands[4].wood.g = 0.3;
    let optics = Optics { bands };
    let bases: BaseSet = [0, 4, 9].into_iter().collect();
    let settings = SolveSettings { bases, ..SolveSettings::default() };
    let gpu = gpu();
    let one_lane = relax_bytes(&medium);
    let run = |bytes: u64| solve_on(from_ref(&gpu), bytes, &medium, &optics, &settings, &quiet).unwrap();
    let whole = run(u64::MAX);
    assert!(whole.reports.len() == 15 && whole.reports.iter().all(|report| report.converged));
    for lanes in [15, 6, 1] {
        assert!(run(lanes * one_lane) == whole, "groups of at most {lanes} lanes differ");
    }
    let expected = SolveSettings { solver: SolverKind::Sweep, tolerance: 1e-7, ..settings.clone() };
    let expected = solve(&medium, &optics, &expected, &quiet).unwrap();
    let difference = worst_difference(&medium, &whole, &expected);
    assert!(difference < ALIKE, "{difference:e}");
}

/// The least that a lane takes: it is what the refusal of one byte less says.
fn relax_bytes(medium: &Medium) -> u64 {
    let count = sites::find(medium, usize::MAX).count;
    match relax::lanes_that_fit(&gpu(), count, 0) {
        Err(GpuError::TooLarge { needed, .. }) => needed,
        other => panic!("no lane fits nothing: {other:?}"),
    }
}

#[test]
fn lanes_that_end_on_different_sides_are_all_fetched() {
    let medium = media::tree(32, 7);
    let optics = Optics::paper();
    let settings = SolveSettings { tolerance: 1e-4, max_sweeps: 49, ..SolveSettings::default() };
    let found = solved(&medium, &optics, &settings);
    let sweeps: Vec<u32> = found.reports.iter().map(|report| report.sweeps).collect();
    assert!(sweeps.contains(&49) && sweeps.iter().any(|sweeps| *sweeps < 49), "{sweeps:?}");
    let expected = solve(&medium, &optics, &fine(SolverKind::Sweep), &quiet).unwrap();
    let difference = worst_difference(&medium, &found, &expected);
    assert!(difference < 1e-3, "{difference:e}");
}

#[test]
fn empty_medium_lets_everything_through() {
    let solution = solved(&media::empty(16), &one_band(0), &SolveSettings::default());
    for (base, field) in &solution.bases {
        let light = if *base == 0 { 18.0 } else { 1.0 };
        assert!(field.values().iter().all(|phi| *phi == light), "base {base}");
    }
    assert!(solution.bases.len() == 19 && solution.reports.iter().all(|report| report.converged));
}

#[test]
fn a_single_solve_that_does_not_fit_is_refused_with_both_numbers() {
    let medium = media::tree(32, 7);
    let gpu = gpu();
    let needed = relax_bytes(&medium);
    let error =
        solve_on(from_ref(&gpu), needed - 1, &medium, &one_band(0), &SolveSettings::default(), &quiet);
    let text = error.unwrap_err().to_string();
    for part in [&gpu.opened.name, &needed.to_string(), &(needed - 1).to_string(), "non-empty sites"] {
        assert!(text.contains(part), "{text:?} should contain {part:?}");
    }
}

#[test]
fn a_lost_gpu_is_an_error() {
    let gpu = gpu();
    gpu.opened.device.destroy();
    let medium = media::tree(16, 3);
    let error = solve_on(from_ref(&gpu), u64::MAX, &medium, &one_band(0), &SolveSettings::default(), &quiet)
        .unwrap_err();
    let is_lost =
        |error: &GpuError| matches!(error, GpuError::Failed { adapter, .. } if *adapter == gpu.opened.name);
    assert!(matches!(&error, SolveError::Gpu(error) if is_lost(error)), "{error:?}");
}

#[test]
fn progress_never_falls() {
    let seen = std::sync::Mutex::new(vec![]);
    let note = |share: f64| {
        seen.lock().unwrap().push(share);
        Ok(())
    };
    let settings = SolveSettings { solver: SolverKind::GPU, ..SolveSettings::default() };
    solve(&media::tree(32, 5), &one_band(0), &settings, &note).unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(seen.windows(2).all(|pair| pair[0] <= pair[1]), "{seen:?}");
    assert!(seen.len() > 4 && seen[0] == 0.0 && *seen.last().unwrap() == 1.0, "{seen:?}");
}

#[test]
fn a_solve_stops_when_it_is_told_to() {
    let medium = media::tree(16, 3);
    let stop = |_| Err(Cancelled);
    let error =
        solve_on(&[gpu()], u64::MAX, &medium, &one_band(0), &SolveSettings::default(), &stop).unwrap_err();
    assert_eq!(error, SolveError::Cancelled(Cancelled));
}

#[test]
fn several_gpus_of_a_kind_share_bases_to_the_same_bytes() {
    // Devices of one adapter: none of them knows of the others.
    let gpus: Vec<Gpu> = (0..3).map(|_| gpu()).collect();
    let (medium, optics) = (ball(16, 2.5, 4.5, 0.4), Optics::paper());
    let by = |gpus: &[Gpu]| solve_on(gpus, u64::MAX, &medium, &optics, &fine(SolverKind::GPU), &quiet);
    assert_eq!(by(&gpus).unwrap(), by(&gpus[..1]).unwrap());
    gpus[2].opened.device.destroy();
    let lost = by(&gpus).unwrap_err();
    assert!(matches!(lost, SolveError::Gpu(GpuError::Failed { .. })), "{lost:?}");
}
