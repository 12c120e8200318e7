//! What the draws of directions must be in the mean.

use glam::DVec3;

use super::super::draw::{Draw, Even};
use super::super::scatter::Scattering;
use super::*;
use crate::turbid::INCLINATIONS;

const DRAWS: usize = 200_000;

/// Mean and standard error of `DRAWS` numbers.
fn average(mut number: impl FnMut() -> f64) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..DRAWS {
        let value = number();
        sum += value;
        squares += value * value;
    }
    let n = DRAWS as f64;
    let mean = sum / n;
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

/// A direction that is no axis.
fn oblique() -> DVec3 {
    DVec3::new(0.36, -0.48, 0.8)
}

#[test]
fn drawn_directions_have_the_moments_of_their_phase_function() {
    let phases = [
        Phase::ISOTROPIC,
        Phase::HenyeyGreenstein { g: 1e-9 },
        Phase::HenyeyGreenstein { g: 0.7 },
        Phase::HenyeyGreenstein { g: -0.95 },
        Phase::BiLambert { transmitted: 0.0 },
        Phase::BiLambert { transmitted: 1.0 },
        Phase::BiLambert { transmitted: 0.3 },
    ];
    for phase in phases {
        let angles = LeafAngles::spherical();
        let scattering = Scattering::new(&alike(1.0, phase), &angles, None);
        let mut draw = Draw::new(3, 0);
        let met = scattering.meet(0, [1.0, 0.0], oblique(), &mut draw);
        for degree in 1..4 {
            let (found, error) = average(|| {
                let x = scattering.turn(&met, oblique(), &mut draw).dot(oblique());
                [1.0, x, (3.0 * x * x - 1.0) / 2.0, (5.0 * x * x - 3.0) * x / 2.0][degree]
            });
            let expected = phase.moment(degree);
            assert!(
                (found - expected).abs() < ERRORS * error,
                "{phase:?}, degree {degree}: {found} {expected}"
            );
        }
    }
}

#[test]
fn inclined_leaves_send_light_where_their_normals_face() {
    // A facet that reflects sends light along its normal with a mean cosine of 2/3; so the mean of the new direction is
    // 2/3 of the mean normal of the lit sides, weighted by the area shown.
    for angles in [LeafAngles::planophile(), LeafAngles::erectophile()] {
        let scattering = Scattering::new(&alike(1.0, Phase::BiLambert { transmitted: 0.0 }), &angles, None);
        for direction in [oblique(), DVec3::NEG_Y, DVec3::X] {
            let (mut facing, mut shown) = (DVec3::ZERO, 0.0);
            for (bin, share) in angles.shares().iter().enumerate() {
                for i in 0..64 {
                    let up = (bin as f64 + (f64::from(i % 8) + 0.5) / 8.0) / INCLINATIONS as f64;
                    for j in 0..360 {
                        let turn = (f64::from(j) + 0.5).to_radians();
                        let level = (1.0 - up * up).sqrt();
                        let normal = DVec3::new(level * libm::cos(turn), up, level * libm::sin(turn));
                        let cosine = normal.dot(direction);
                        facing -= normal * cosine * *share;
                        shown += cosine.abs() * share;
                    }
                }
            }
            let expected = facing / shown * (2.0 / 3.0);
            for axis in 0..3 {
                let mut draw = Draw::new(4, axis as u64);
                let met = scattering.meet(0, [1.0, 0.0], direction, &mut draw);
                let (found, error) = average(|| scattering.turn(&met, direction, &mut draw)[axis]);
                assert!(
                    (found - expected[axis]).abs() < ERRORS * error + 1e-4,
                    "{direction}, axis {axis}: {found} +- {error}, expected {}",
                    expected[axis]
                );
            }
        }
    }
}

#[test]
fn wood_has_no_inclination() {
    let scatter = alike(1.0, Phase::BiLambert { transmitted: 0.0 });
    let angles = LeafAngles::planophile();
    let scattering = Scattering::new(&scatter, &angles, None);
    let mut draw = Draw::new(7, 0);
    // Straight from above, flat leaves would reflect more of the light straight up.
    let met = scattering.meet(0, [0.0, 1.0], DVec3::NEG_Y, &mut draw);
    let (found, error) = average(|| -scattering.turn(&met, DVec3::NEG_Y, &mut draw).y);
    assert!((found + 4.0 / 9.0).abs() < ERRORS * error, "{found} +- {error}");
    let met = scattering.meet(0, [1.0, 0.0], DVec3::NEG_Y, &mut draw);
    let (found, _) = average(|| -scattering.turn(&met, DVec3::NEG_Y, &mut draw).y);
    assert!(found < -0.5, "{found}");
}

#[test]
fn leaf_and_wood_are_met_by_their_share_of_extinction() {
    let scatter = BandScatter {
        leaf: Scatter { albedo: 1.0, phase: Phase::ISOTROPIC },
        wood: Scatter { albedo: 0.0, phase: Phase::ISOTROPIC },
    };
    let angles = LeafAngles::planophile();
    let scattering = Scattering::new(&scatter, &angles, None);
    let mut draw = Draw::new(5, 0);
    for direction in [DVec3::Y, DVec3::X, oblique()] {
        let leaf = 3.0 * angles.relative(direction.y);
        let (found, error) = average(|| scattering.meet(0, [3.0, 1.0], direction, &mut draw).albedo);
        assert!((found - leaf / (leaf + 1.0)).abs() < ERRORS * error, "{direction}: {found}");
    }
}

#[test]
fn even_points_fill_every_face_of_the_cube_more_evenly_than_chance() {
    const COUNT: usize = 1 << 15;
    let mut points = Even::<5>::new(&mut Draw::new(6, 0));
    let points: Vec<[f64; 5]> = (0..COUNT).map(|_| points.point()).collect();
    for axes in [[0, 1], [0, 2], [1, 2], [0, 3], [2, 3], [3, 4]] {
        let mut counts = [0.0f64; 16 * 16];
        for point in &points {
            let [x, y] = axes.map(|axis| (point[axis] * 16.0) as usize);
            counts[y * 16 + x] += 1.0;
        }
        // Chance would leave a variance of the mean count, 128.
        let squares: Vec<f64> = counts.iter().map(|count| (count - 128.0) * (count - 128.0)).collect();
        assert!(mean(&squares) < 128.0 / 4.0, "axes {axes:?}: {}", mean(&squares));
    }
}
