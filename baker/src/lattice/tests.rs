use flb_format::Optics;
use super::literal::{self, Until, boundary_of_base};
use super::media;
use super::*;

fn quiet(_: f64) {}

#[test]
fn sweep_reaches_the_oracles_fixed_point() {
    let medium = media::tree(32, 7);
    let optics = Optics::paper();
    let settings = SolveSettings { tolerance: 3e-7, ..Default::default() };
    let solution = solve(&medium, &optics, &settings, &quiet).unwrap();
    for (base, band) in [(1, 0), (4, 2), (9, 1), (16, 0), (18, 2), (0, 1)] {
        let until = Until::Settled { change: 1e-12, limit: 20_000 };
        let oracle = literal::iterate(&medium, &optics, band, &boundary_of_base(base), until);
        let field = solution.bases[usize::from(base)].1.band(band);
        let mut worst = 0.0_f64;
        for (a, b) in field.iter().zip(&oracle.phi) {
            worst = worst.max((f64::from(*a) - b).abs() / b);
        }
        println!("{base} {band} {worst} {:?}", solution.reports[usize::from(base)*3+band as usize]);
        assert!(worst < 1e-5);
    }
}
