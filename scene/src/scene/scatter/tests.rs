use std::f64::consts::TAU;

use super::*;

fn plot(amount: Amount) -> Plot {
    Plot { area_m: [200.0, 100.0], amount, density: None, seed: 1 }
}

fn grey(columns: u32, values: &[f32]) -> Option<Grey> {
    Some(Grey { columns, rows: values.len() as u32 / columns, values: values.to_vec() })
}

fn nearest_pair(points: &[[f64; 2]]) -> f64 {
    let distance = |a: &[f64; 2], b: &[f64; 2]| libm::hypot(a[0] - b[0], a[1] - b[1]);
    let pairs = points.iter().enumerate().flat_map(|(i, a)| points[..i].iter().map(move |b| distance(a, b)));
    pairs.fold(f64::INFINITY, f64::min)
}

/// Mean power of the longest waves that fit into a rectangle around the origin, as a share of that of points that lie
/// anywhere.
fn low_frequencies(points: &[[f64; 2]], area_m: [f64; 2]) -> f64 {
    let waves: Vec<[f64; 2]> = (-4..=4)
        .flat_map(|x| (1..=4).map(move |z| [f64::from(x) / area_m[0], f64::from(z) / area_m[1]]))
        .collect();
    let power = |wave: &[f64; 2]| {
        let (mut sin, mut cos) = (0.0, 0.0);
        for point in points {
            let (s, c) = libm::sincos(TAU * (wave[0] * point[0] + wave[1] * point[1]));
            (sin, cos) = (sin + s, cos + c);
        }
        (sin * sin + cos * cos) / points.len() as f64
    };
    waves.iter().map(power).sum::<f64>() / waves.len() as f64
}

#[test]
fn as_many_points_as_were_asked_for_keep_their_distance_within_the_area() {
    for count in [1, 2, 3, 17, 500, 3000] {
        let spots = scatter(&plot(Amount::Count(count))).expect("it is sound");
        assert_eq!(spots.points_m.len(), count);
        assert!(spots.points_m.iter().all(|[x, z]| x.abs() <= 100.0 && z.abs() <= 50.0));
        assert!(nearest_pair(&spots.points_m) >= spots.spacing_m, "{count}");
        // Not much below what such a number can keep at best, in a honeycomb.
        let best = (2.0 / 3.0f64.sqrt() * 20_000.0 / count as f64).sqrt();
        assert!(spots.spacing_m > 0.6 * best || count < 17, "{count}: {} of {best}", spots.spacing_m);
    }
}

#[test]
fn points_at_a_spacing_leave_no_room_for_many_more() {
    let spots = scatter(&plot(Amount::Spacing(3.0))).expect("it is sound");
    let (count, nearest) = (spots.points_m.len() as f64, nearest_pair(&spots.points_m));
    assert!((3.0..3.1).contains(&nearest), "{nearest}");
    let fill = count * 9.0 / 20_000.0;
    assert!((0.6..0.72).contains(&fill), "{fill}");
}

#[test]
fn low_frequencies_are_far_below_those_of_white_noise() {
    let spots = scatter(&plot(Amount::Count(3000))).expect("it is sound");
    let mut draw = Pcg64Mcg::seed_from_u64(5);
    let white: Vec<[f64; 2]> =
        (0..3000).map(|_| [200.0 * unit(&mut draw) - 100.0, 100.0 * unit(&mut draw) - 50.0]).collect();
    let (blue, white) =
        (low_frequencies(&spots.points_m, [200.0, 100.0]), low_frequencies(&white, [200.0, 100.0]));
    assert!(white > 0.6, "{white}");
    assert!(blue < 0.2, "{blue} for {white}");
}

#[test]
fn a_density_map_thins_evenly_and_leaves_black_empty() {
    // A quarter in the left half, all in the right one but for its lower quarter.
    let density = grey(4, &[0.2, 0.2, 0.8, 0.8, 0.2, 0.2, 0.0, 0.0]);
    let many = Plot { density: density.clone(), ..plot(Amount::Count(2000)) };
    let spots = scatter(&many).expect("it is sound");
    assert_eq!(spots.points_m.len(), 2000);
    assert!(nearest_pair(&spots.points_m) >= spots.spacing_m);
    let count = |x: [f64; 2], z: [f64; 2]| {
        let is_in = |p: &&[f64; 2]| p[0] >= x[0] && p[0] < x[1] && p[1] >= z[0] && p[1] < z[1];
        spots.points_m.iter().filter(is_in).count() as f64
    };
    // Between the middles of two pixels the picture goes over from one to the other.
    let dark = count([-100.0, -25.0], [-50.0, 50.0]) / 7500.0;
    let light = count([25.0, 100.0], [-50.0, -25.0]) / 1875.0;
    assert!((light / dark - 4.0).abs() < 0.5, "{light} for {dark}");
    assert_eq!(count([25.0, 100.0], [25.0, 50.0]), 0.0);
    let left: Vec<[f64; 2]> = spots.points_m.iter().copied().filter(|p| p[0] < -25.0).collect();
    let centerd: Vec<[f64; 2]> = left.iter().map(|p| [p[0] + 62.5, p[1]]).collect();
    let low = low_frequencies(&centerd, [75.0, 100.0]);
    assert!(low < 0.35, "{low}");
    let spaced = scatter(&Plot { density, ..plot(Amount::Spacing(3.0)) }).expect("it is sound");
    assert!(nearest_pair(&spaced.points_m) >= 3.0 && spaced.points_m.len() > 400);
}

#[test]
fn a_strip_is_filled_in_a_row() {
    let strip = Plot { area_m: [1e6, 1e-3], ..plot(Amount::Count(20_000)) };
    let spots = scatter(&strip).expect("it is sound");
    assert!(spots.points_m.len() == 20_000 && spots.spacing_m > 20.0, "{}", spots.spacing_m);
    let row = scatter(&Plot { area_m: [1e-3, 1000.0], ..plot(Amount::Spacing(1.0)) }).expect("it is sound");
    assert!((600..=1001).contains(&row.points_m.len()), "{}", row.points_m.len());
}

#[test]
fn the_seed_alone_chooses_the_points() {
    let of = |seed: u64| scatter(&Plot { seed, ..plot(Amount::Count(100)) }).expect("it is sound");
    assert_eq!(of(1), of(1));
    assert_ne!(of(1), of(2));
}

#[test]
fn what_cannot_be_scattered_is_refused_with_what_was_found() {
    // Points that are found all the same are too many to print.
    let refusal =
        |plot: Plot| scatter(&plot).map(|spots| spots.points_m.len()).expect_err("it is refused").to_string();
    let count = plot(Amount::Count(10));
    for (plot, expected) in [
        (
            Plot { area_m: [0.0, 5.0], ..count.clone() },
            "area is [0.0, 5.0], expected edges of 0.001 to 1e7 m",
        ),
        (Plot { area_m: [f64::NAN, 5.0], ..count.clone() }, "area is [NaN, 5.0]"),
        (plot(Amount::Count(0)), "count is 0, expected 1 plant or more"),
        (plot(Amount::Count(2_000_000)), "plants: 2000000 is over the limit of 1048576"),
        (plot(Amount::Spacing(-1.0)), "spacing is -1, expected a distance above 0"),
        (plot(Amount::Spacing(0.01)), "plants at that spacing: 140000000 is over the limit"),
        (
            Plot { area_m: [1e7, 1e-3], ..plot(Amount::Spacing(0.2)) },
            "plants at that spacing: 50000001 is over the limit",
        ),
        (Plot { density: grey(2, &[0.0; 4]), ..count.clone() }, "the density map is black all over"),
        (
            Plot {
                density: grey(4, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
                ..plot(Amount::Count(1_048_576))
            },
            "plants before thinning by the density map: 8388608",
        ),
    ] {
        let message = refusal(plot);
        assert!(message.contains(expected), "{message} for {expected}");
    }
}
