use flb_render::irradiance::irradiance;
use flb_render::irradiance::{Estimate, SideIrradiance};
use flb_scene::ClassedMesh;
use flb_scene::surface_points::surface_points;

use super::*;

/// Points of one class with the same noise, of an irradiance that rises from point to point, under two suns and the
/// sky.
fn truth(class: MaterialClass, count: usize) -> (Vec<SurfacePoint>, Vec<PointIrradiance>) {
    let points = |k: usize| SurfacePoint { triangle: 0, weights: [0.0; 2], position_m: [k as f32, 0.0, 0.0] };
    let estimate =
        |value: f32| Estimate { mean: [value, 2.0 * value, value], error: [0.0; 3], difference: [0.0; 3] };
    let truth = |k: usize| {
        let base = 0.1 + 0.01 * k as f32;
        let side = |open: f32, share: f32| SideIrradiance {
            open,
            sources: (1..=3).map(|source| estimate(share * base * source as f32)).collect(),
        };
        let open = k as f32 / (count - 1) as f32;
        PointIrradiance {
            class,
            material: 7,
            normal: [0.0, 1.0, 0.0],
            sides: [side(open, 1.5), side(0.0, 0.5)],
        }
    };
    ((0..count).map(points).collect(), (0..count).map(truth).collect())
}

/// Leaves that reflect three times what they transmit in R, as much in G, and nothing in B.
fn surfaces(solid_offset_m: Option<f32>) -> Surfaces {
    Surfaces {
        leaf_reflectance: [0.3, 0.1, 0.0],
        leaf_transmittance: [0.1, 0.1, 0.2],
        wood_reflectance: [0.1; 3],
        solid_offset_m,
    }
}

/// The fluence of these points' leaves to the last digits, times a factor.
fn exact(factor: f32) -> impl Fn(usize, [f32; 3], &mut [f32; 3]) {
    move |source, [k, _, _], phi| {
        let irradiance = (0.1 + 0.01 * k) * (source + 1) as f32;
        *phi = [1.0, 2.0, 1.0].map(|band| 4.0 * factor * irradiance * band);
    }
}

#[test]
fn exact_light_has_no_error_and_a_planted_one_is_found() {
    let (points, truth) = truth(MaterialClass::Leaf, 50);
    let good = compare(&points, &truth, &surfaces(None), &exact(1.0));
    assert!(good.wood.is_none());
    let leaf = good.leaf.expect("leaves");
    let suns = leaf.suns.expect("suns");
    assert_eq!((suns.count, leaf.sky.expect("sky").count), (100, 50));
    assert!(suns.rms.iter().all(|rms| *rms < 1e-6) && suns.percentile_99 < 1e-6, "{suns:?}");
    // Sides get 1.5 and 0.5 of the mean.
    let sides = leaf.sides.expect("sides");
    assert_eq!(sides.count, 300);
    assert!((sides.ratio[0] - 1.0).abs() < 1e-6 && sides.rms[0] > 0.5, "{sides:?}");

    // A viewer of one side sees 3/4 of it and a quarter of the other, so 1.25 and 0.75 of the mean; half of both in G;
    // the other side alone in B. The base rises from 0.1 to 0.59, each source as bright as its number.
    let seen = leaf.seen.expect("seen");
    assert_eq!(seen.count, 300);
    let squares = |power: i32| -> f64 {
        (0..50).map(|k| 0.1 + 0.01 * f64::from(k)).map(|v| if power == 2 { v * v } else { v }).sum::<f64>()
            / 50.0
    };
    let spread = ((14.0 / 3.0) * squares(2)).sqrt() / (2.0 * squares(1));
    for (band, off) in [(0, 0.25), (1, 0.0), (2, 0.5)] {
        assert!((seen.rms[band] - off * spread).abs() < 1e-5, "band {band}: {seen:?}, {spread}");
    }
    let known = leaf.seen_with_sides.expect("seen");
    assert!(known.rms.iter().all(|rms| *rms < 1e-6), "{known:?}");

    let bad = compare(&points, &truth, &surfaces(None), &exact(1.1)).leaf.expect("leaves").sky.expect("sky");
    assert!(bad.ratio.iter().all(|ratio| (ratio - 1.1).abs() < 1e-6), "{bad:?}");
    assert!((bad.rms[2] - 0.1).abs() < 0.02 && bad.percentile_99 < 0.2, "{bad:?}");
    assert_eq!((bad.worst.point_m[0], bad.worst.material, bad.worst.source), (49.0, 7, 2));
}

#[test]
fn wood_is_judged_on_its_open_side() {
    let (points, truth) = truth(MaterialClass::Wood, 20);
    // phi / 2 is 1.5 times the mean of both sides at phi = 3 times it.
    let wood = compare(&points, &truth, &surfaces(None), &exact(0.75)).wood.expect("wood");
    let sky = wood.sky.expect("sky");
    assert!((sky.ratio[0] - 1.0).abs() < 1e-6, "{sky:?}");
    // Off its surface by 0.5 m, a quarter of phi: twice as much is asked for, at another point.
    let away = |source, [x, y, z]: [f32; 3], phi: &mut [f32; 3]| {
        assert_eq!((y, z), (0.5, 0.0));
        exact(1.5)(source, [x, 0.0, 0.0], phi);
    };
    let same = compare(&points, &truth, &surfaces(Some(0.5)), &away).wood.expect("wood").sky.expect("sky");
    assert!((same.ratio[0] - 1.0).abs() < 1e-6, "{same:?}");
    assert!(wood.sides.is_none(), "the inside of wood sees no light");
    let counts = wood.by_openness.map(|group| group.map_or(0, |group| group.count));
    assert_eq!(counts.iter().sum::<usize>(), 60);
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
}

#[test]
fn the_noise_of_the_truth_is_taken_out() {
    let (points, mut truth) = truth(MaterialClass::Leaf, 400);
    // Noise of known size, of both signs.
    for (k, point) in truth.iter_mut().enumerate() {
        for side in &mut point.sides {
            for source in &mut side.sources {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                source.mean = source.mean.map(|mean| mean + sign * 0.05);
                // Both sides have the same noise here, so that their mean has it, too.
                source.difference = [0.05 * std::f32::consts::SQRT_2; 3];
            }
        }
    }
    let sky = compare(&points, &truth, &surfaces(None), &exact(1.0)).leaf.expect("leaves").sky.expect("sky");
    assert!(sky.rms[0] < 1e-3, "{sky:?}");
    assert!((sky.truth_error[0] - 0.05 / 20.0).abs() < 1e-6, "{sky:?}");
}

/// An error of known size is found whatever the number of paths, of the sky and of suns: even first directions make
/// their own error smaller than their spread says.
#[test]
fn an_error_is_found_at_its_size_whatever_the_number_of_paths() {
    let mesh = flb_testkit::grown::mesh(
        &flb_fixtures::grow(flb_fixtures::PlantKind::Oak, 1, 4_000).expect("a good count"),
        [1.0; 4],
    );
    let classes = vec![MaterialClass::Leaf; mesh.materials.len()];
    let classed = ClassedMesh { mesh, classes };
    let points = surface_points(&classed, 300, true).expect("no textures");
    let surfaces = surfaces(None);
    let suns = [[0.3, 1.0, 0.1], [-1.0, 0.4, 0.7]];
    let traced = |samples: u32| {
        let on_mesh = (&classed.mesh, &classed.classes[..]);
        irradiance(on_mesh, surfaces, &points, &suns, samples, &|_| Ok(())).expect("a good mesh")
    };
    let finest = traced(4096);
    // Light that is off by a tenth of the truth, of both signs.
    let light = |source: usize, point_m: [f32; 3], phi: &mut [f32; 3]| {
        let at = points.iter().position(|point| point.position_m == point_m).expect("a point of the mesh");
        let [a, b] = finest[at].sides.each_ref().map(|side| side.sources[source].mean);
        let off = if at % 2 == 0 { 1.1 } else { 0.9 };
        *phi = std::array::from_fn(|band| 2.0 * off * (a[band] + b[band]));
    };
    let rms_against = |truth: &[PointIrradiance]| {
        let leaves = compare(&points, truth, &surfaces, &light).leaf.expect("leaves");
        [leaves.sky, leaves.suns].map(|figures| figures.expect("lit").rms[1])
    };
    let expected = rms_against(&finest);
    for samples in [32, 128, 512] {
        let found = rms_against(&traced(samples));
        for ((name, rms), expected) in ["sky", "suns"].into_iter().zip(found).zip(expected) {
            println!("{samples} paths, {name}: {rms}");
            assert!((rms - expected).abs() < 0.03, "{samples} paths, {name}: {rms}, not {expected}");
        }
    }
}

#[test]
fn nothing_is_judged_without_points_or_in_the_dark() {
    let none = compare(&[], &[], &surfaces(None), &exact(1.0));
    assert!(none.leaf.is_none() && none.wood.is_none());
    let (points, mut truth) = truth(MaterialClass::Leaf, 5);
    for point in &mut truth {
        for side in &mut point.sides {
            side.sources.iter_mut().for_each(|source| source.mean = [0.0; 3]);
        }
    }
    let dark = compare(&points, &truth, &surfaces(None), &exact(1.0)).leaf.expect("leaves");
    assert!(dark.suns.is_none() && dark.sky.is_none());
}
