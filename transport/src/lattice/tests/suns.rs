//! Linear laws: what the blend of bases at run time rests on.

use flb_format::direction::{MOVING, WEIGHTS, opposite};
use flb_format::matter::{Class, ClassOptics, Optics};
use flb_format::{Medium, sun};

use super::super::balance::{Balance, balances};
use super::super::literal::{self, Until};
use super::super::{collision, media};
use super::{differences, one_band, optics, solved, tight};

#[test]
fn blending_bases_equals_solving_for_that_sun() {
    let medium = media::tree(16, 9);
    let optics = one_band(1);
    let solution = solved(&medium, &optics);
    for (azimuth_deg, elevation_deg) in [(17.0, 33.0), (141.0, 71.0), (262.5, 4.0), (300.0, -48.0)] {
        let blend = sun::blend(sun::towards_sun(azimuth_deg, elevation_deg)).expect("a direction");
        let mut boundary = [0.0; 19];
        let mut blended = vec![0.0_f32; medium.density.len()];
        for (base, weight) in blend.bases.iter().zip(blend.weights) {
            assert!(weight > 0.01, "{blend:?} should need all three");
            boundary[usize::from(*base)] = f64::from(weight);
            let phi = solution.bases[usize::from(*base)].1.band(0);
            blended.iter_mut().zip(phi.iter()).for_each(|(sum, phi)| *sum += weight * phi);
        }
        let until = Until::Settled { change: 1e-13, limit: 50_000 };
        let direct = literal::iterate(&medium, &optics, 0, &boundary, until).phi;
        let (worst, rms) = differences(&medium, &blended, &direct);
        assert!(worst < 1e-4 && rms < 1e-6, "{azimuth_deg} {elevation_deg}: {worst:e} {rms:e}");
    }
}

/// T(i -> j) is what leaves along j of light that comes along i. With `mu_j = w_j Z_j`, Z the sum that normalises the
/// phase function (eq. 2.18), a collision is in balance in detail, `gain_mj mu_j = gain_jm mu_m`, and links are the
/// same both ways. So light runs as well backwards: `mu_i T(i -> j) = mu_j T(-j -> -i)`.
#[test]
fn light_runs_as_well_backwards() {
    let mut leaves = media::tree(16, 6);
    leaves.class.iter_mut().filter(|class| **class == Class::Wood).for_each(|class| *class = Class::Leaf);
    let back = ClassOptics { sigma_a: 0.2, g: -1.0 };
    let forward = ClassOptics { sigma_a: 0.3, g: 0.6 };
    let even = ClassOptics { sigma_a: 0.15, g: 0.0 };
    // Wood gives its rest density back by the weights alone, which is in balance with even scattering only.
    let tree = media::tree(16, 6);
    for (medium, leaf) in [(&leaves, forward), (&tree, even)] {
        let worst = worst_asymmetry(medium, &optics(leaf, back), leaf.g);
        assert!(worst < 1e-5, "g = {}: {worst:e}", leaf.g);
    }
    // The law tells wrong weights from right ones.
    assert!(worst_asymmetry(&leaves, &optics(forward, back), 0.0) > 1e-3);
}

/// The largest `|mu_i T(i -> j) - mu_j T(-j -> -i)|` as a share of the largest `mu_i T(i -> j)` between different
/// directions.
fn worst_asymmetry(medium: &Medium, optics: &Optics, g: f64) -> f64 {
    let phase = collision::phase(g);
    let mu = |j: usize| WEIGHTS[j] * WEIGHTS[j] / phase[j][j];
    let found = balances(medium, optics, &tight()).unwrap();
    let of_base = |base: usize| -> &Balance {
        found.iter().find(|balance| usize::from(balance.base) == base).expect("every direction is solved")
    };
    let flow = |i: usize, j: usize| mu(i) * of_base(i).left_along[j - 1];
    let pairs = || (1..=MOVING).flat_map(|i| (1..=MOVING).map(move |j| (i, j))).filter(|(i, j)| i != j);
    let largest = pairs().map(|(i, j)| flow(i, j)).fold(0.0, f64::max);
    let off = |(i, j): (usize, usize)| (flow(i, j) - flow(opposite(j), opposite(i))).abs();
    pairs().map(off).fold(0.0, f64::max) / largest
}
