//! Physics: what must hold whatever the numbers are.
#![allow(clippy::needless_range_loop, reason = "Indices are directions here.")]

use flb_format::Medium;
use flb_format::direction::{DIRECTIONS, MOVING, WEIGHTS};
use flb_format::matter::{Class, ClassOptics};

use super::super::literal::{self, Until, boundary_of_base};
use super::super::{SolveSettings, media, solve};
use super::{F32_RELATIVE, one_band, optics, oracle, quiet, solved, tight};

const BACK: ClassOptics = ClassOptics { sigma_a: 0.1, g: -1.0 };

#[test]
fn empty_medium_lets_everything_through() {
    let solution = solved(&media::empty(16), &one_band(0));
    assert_eq!(solution.bases.len(), 19);
    for (base, field) in &solution.bases {
        let light = if *base == 0 { 18.0 } else { 1.0 };
        assert!(field.values().iter().all(|phi| *phi == light), "base {base}");
    }
    assert!(solution.reports.iter().all(|report| report.converged));
}

#[test]
fn without_absorption_what_enters_leaves() {
    // At the fixed point: sum over interior sites of (light sent on - light received) = 0, so the light that
    // arrives at boundary sites equals the light that boundary sites send in.
    let medium = media::tree(16, 4);
    let optics = optics(ClassOptics { sigma_a: 0.0, g: 0.4 }, ClassOptics { sigma_a: 0.3, g: -1.0 });
    let until = Until::Settled { change: 1e-13, limit: 50_000 };
    let solution = literal::iterate(&medium, &optics, 0, &boundary_of_base(5), until);
    let (received, lost) = balance(&medium, &optics.bands[0].leaf, &solution.f);
    assert!(lost.abs() < 1e-9 * received, "{lost} of {received}");
    let absorbing = super::optics(ClassOptics { sigma_a: 0.2, g: 0.4 }, BACK);
    let solution = literal::iterate(&medium, &absorbing, 0, &boundary_of_base(5), until);
    let (received, lost) = balance(&medium, &absorbing.bands[0].leaf, &solution.f);
    let absorbed: f64 = (0..medium.density.len())
        .filter(|&i| medium.class[i] == Class::Leaf)
        .map(|i| f64::from(medium.density[i]) * 0.2 * solution.phi[i])
        .sum();
    assert!((lost - absorbed).abs() < 1e-9 * received && absorbed > 0.0, "{lost} {absorbed}");
}

/// Light that enters the interior from the boundary layer, and how much of it does not come out again.
fn balance(medium: &Medium, leaf: &ClassOptics, f: &[[f64; 19]]) -> (f64, f64) {
    let n = medium.grid.lattice as i32;
    let on_boundary = |p: [i32; 3]| p.iter().any(|&c| c == 0 || c == n - 1);
    let (mut entered, mut left) = (0.0, 0.0);
    for index in 0..medium.density.len() {
        let p = medium.grid.site(index).map(|c| c as i32);
        if on_boundary(p) {
            continue;
        }
        for m in 1..19 {
            let at = |sign: i32| [0, 1, 2].map(|axis| p[axis] + sign * DIRECTIONS[m][axis]);
            // Sites next to the boundary are empty: what arrives there goes straight on.
            if on_boundary(at(-1)) {
                entered += f[index][m];
            }
            if on_boundary(at(1)) {
                left += f[index][m];
            }
        }
    }
    assert!((0.0..=1.0).contains(&leaf.sigma_a));
    (entered, entered - left)
}

#[test]
fn pure_absorber_follows_its_product_along_a_column() {
    let mut medium = media::empty(16);
    let densities = [0.3_f32, 0.0, 0.7, 0.05, 1.0, 0.5];
    for (at, density) in densities.into_iter().enumerate() {
        media::put(&mut medium, [5 + at as u32, 8, 8], Class::Leaf, density);
    }
    let solution = solved(&medium, &optics(ClassOptics { sigma_a: 1.0, g: 0.2 }, BACK));
    let phi = solution.bases[1].1.band(0);
    let mut expected = 1.0_f64;
    for x in 1..15 {
        let found = f64::from(phi[medium.grid.index(x, 8, 8)]);
        assert!((found - expected).abs() < 1e-6, "x {x}: {found}, expected {expected}");
        expected *= 1.0 - f64::from(medium.density[medium.grid.index(x, 8, 8)]);
    }
    // Off the column nothing is scattered.
    assert_eq!(phi[medium.grid.index(10, 9, 8)], 1.0);
}

#[test]
fn mirrored_and_permuted_media_give_mirrored_and_permuted_fields() {
    let medium = media::tree(16, 9);
    let last = 15;
    let moves: [(Move<u32>, Move<i32>); 3] = [
        (|p| [15 - p[0], p[1], p[2]], |c| [-c[0], c[1], c[2]]),
        (|p| [p[0], p[1], 15 - p[2]], |c| [c[0], c[1], -c[2]]),
        (|p| [p[1], p[2], p[0]], |c| [c[1], c[2], c[0]]),
    ];
    let optics = one_band(2);
    let original = solved(&medium, &optics);
    for (site, direction) in moves {
        let mut image = media::empty(last + 1);
        each_site(16, |p| {
            let index = medium.grid.index(p[0], p[1], p[2]);
            media::put(&mut image, site(p), medium.class[index], medium.density[index]);
        });
        let solution = solved(&image, &optics);
        for m in 1..=MOVING {
            let image_m = DIRECTIONS.iter().position(|d| *d == direction(DIRECTIONS[m])).unwrap();
            each_site(16, |p| {
                let q = site(p);
                let a = f64::from(original.bases[m].1.value(0, medium.grid.index(p[0], p[1], p[2])));
                let b = f64::from(solution.bases[image_m].1.value(0, medium.grid.index(q[0], q[1], q[2])));
                assert!((a - b).abs() <= F32_RELATIVE * a, "base {m}, site {p:?}: {a} {b}");
            });
        }
    }
}

type Move<T> = fn([T; 3]) -> [T; 3];

fn each_site(lattice: u32, mut visit: impl FnMut([u32; 3])) {
    for z in 0..lattice {
        for y in 0..lattice {
            for x in 0..lattice {
                visit([x, y, z]);
            }
        }
    }
}

#[test]
fn ambient_base_solved_directly_equals_the_sum_of_the_others() {
    let medium = media::tree(16, 11);
    let solution = solved(&medium, &one_band(1));
    let direct = oracle(&medium, &one_band(1), 0, 0);
    for (found, expected) in solution.bases[0].1.values().iter().zip(&direct) {
        assert!((f64::from(*found) - expected).abs() < F32_RELATIVE * expected, "{found} {expected}");
    }
}

#[test]
fn light_grows_from_darkness_with_every_sweep_and_is_never_negative() {
    let medium = media::tree(16, 2);
    // Rounding of phi, at most 2.
    const ROUNDING: f32 = 1e-6;
    let mut before: Option<Vec<f32>> = None;
    for max_sweeps in [1, 2, 4, 8, 16] {
        let settings = SolveSettings { max_sweeps, ..tight() };
        let solution = solve(&medium, &one_band(0), &settings, &quiet).unwrap();
        let phi = solution.bases[12].1.values().into_owned();
        assert!(phi.iter().all(|phi| *phi >= 0.0));
        if let Some(before) = before {
            assert!(phi.iter().zip(&before).all(|(now, before)| *now >= before - ROUNDING));
        }
        before = Some(phi);
    }
}

#[test]
fn one_isotropic_site_scatters_by_the_weights() {
    let mut medium = media::empty(16);
    media::put(&mut medium, [8, 8, 8], Class::Leaf, 0.5);
    let solution = solved(&medium, &optics(ClassOptics { sigma_a: 0.2, g: 0.0 }, BACK));
    let phi = solution.bases[1].1.band(0);
    for m in 2..19 {
        let p = [0, 1, 2].map(|axis| (8 + 3 * DIRECTIONS[m][axis]) as u32);
        let expected = 1.0 + 0.5 * 0.8 * WEIGHTS[m];
        let found = f64::from(phi[medium.grid.index(p[0], p[1], p[2])]);
        assert!((found - expected).abs() < 1e-6, "direction {m}: {found} {expected}");
    }
}

#[test]
fn closed_conservative_and_solid_media_end_finite_and_say_whether_they_converged() {
    let mut shell = media::empty(32);
    let mut solid = media::empty(32);
    each_site(32, |p| {
        if p.iter().all(|c| (8..24).contains(c)) {
            let wall = p.iter().any(|c| *c < 11 || *c >= 21);
            media::put(&mut solid, p, Class::Wood, 1.0);
            media::put(&mut shell, p, Class::Wood, if wall { 1.0 } else { 0.0 });
        }
    });
    let keeps_all = ClassOptics { sigma_a: 0.0, g: -1.0 };
    for (medium, wood) in [(&shell, BACK), (&solid, BACK), (&shell, keeps_all), (&solid, keeps_all)] {
        let settings = SolveSettings { max_sweeps: 40, ..tight() };
        let solution = solve(medium, &optics(BACK, wood), &settings, &quiet).unwrap();
        assert!(solution.bases.iter().all(|(_, f)| f.values().iter().all(|v| v.is_finite() && *v >= 0.0)));
        for report in &solution.reports {
            assert!(report.sweeps <= 40 && report.residual.is_finite());
            assert_eq!(report.converged, report.residual <= TIGHT_ENOUGH);
        }
        if wood.sigma_a == 0.0 {
            // A perfect mirror keeps light out of the middle.
            assert_eq!(solution.bases[1].1.value(0, medium.grid.index(15, 15, 15)), 0.0);
        } else {
            assert!(solution.reports.iter().any(|report| !report.converged));
        }
    }
}

const TIGHT_ENOUGH: f64 = super::TIGHT;
