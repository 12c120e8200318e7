use super::super::LeafModel;
use super::*;

#[test]
fn white_is_one_in_every_band() {
    let ranges = [(400.0, 900.0), (500.0, 500.3), (600.0, 633.5)];
    let ranges = ranges.map(|(low_nm, high_nm)| Range { name: "a".to_owned(), low_nm, high_nm });
    for bands in [Bands::Rgb, Bands::Ranges(ranges.to_vec())] {
        for (name, response) in bands.responses() {
            assert!((mean(&response, |_| 1.0) - 1.0).abs() < 1e-12, "{name}");
        }
    }
}

#[test]
fn a_range_sees_the_plain_mean_and_nothing_outside() {
    let range = Range { name: "a".to_owned(), low_nm: 612.0, high_nm: 655.5 };
    let (_, response) = Bands::Ranges(vec![range]).responses().remove(0);
    assert!((mean(&response, |nm| nm) - (612.0 + 655.5) / 2.0).abs() < 1e-9);
    assert!(response.iter().all(|&(nm, _)| (612.0..655.5).contains(&nm)));
}

/// Chromaticity of D65: x 0.3127, y 0.3290 (ISO 11664-2). The fit of the observer and the cut at 400 nm move it by less
/// than half a thousandth.
#[test]
fn daylight_has_its_white_point() {
    let mut sum = [0.0; 3];
    for step in 0..=76 {
        let nm = 400.0 + 5.0 * f64::from(step);
        for (sum, value) in sum.iter_mut().zip(color_matching(nm)) {
            *sum += value * daylight(nm);
        }
    }
    let all: f64 = sum.iter().sum();
    let (x, y) = (sum[0] / all, sum[1] / all);
    assert!((x - 0.3127).abs() < 5e-4 && (y - 0.3290).abs() < 5e-4, "{x}, {y}");
}

/// The standard observer at its peaks and crossings (CIE 15); the fit's authors give errors of about 1 % of the peak.
#[test]
fn the_observer_s_fit_is_close_to_its_table() {
    for (nm, xyz) in [
        (450.0, [0.3362, 0.0380, 1.7721]),
        (500.0, [0.0049, 0.3230, 0.2720]),
        (555.0, [0.5121, 1.0000, 0.0057]),
        (600.0, [1.0622, 0.6310, 0.0008]),
        (650.0, [0.2835, 0.1070, 0.0000]),
    ] {
        for (fit, table) in color_matching(nm).into_iter().zip(xyz) {
            assert!((fit - table).abs() < 0.03, "{nm}: {fit}, {table}");
        }
    }
}

/// The claim of the module's head. Truth is the colour of the squared spectrum.
#[test]
fn srgb_bands_are_nearer_than_boxes_to_light_scattered_twice() {
    let leaf = LeafModel::default();
    let albedo = |nm| leaf.at(nm).0 + leaf.at(nm).1;
    let boxes = [(600.0, 700.0), (500.0, 600.0), (400.0, 500.0)];
    let boxes = boxes.map(|(low_nm, high_nm)| Range { name: "a".to_owned(), low_nm, high_nm });
    let boxes = Bands::Ranges(boxes.to_vec()).responses();
    for ((band, (_, srgb)), most) in Bands::Rgb.responses().iter().enumerate().zip([0.12, 0.06]) {
        let truth = mean(srgb, |nm| albedo(nm) * albedo(nm));
        let off = |albedo: f64| (albedo * albedo / truth - 1.0).abs();
        let (by_srgb, by_box) = (off(mean(srgb, albedo)), off(mean(&boxes[band].1, albedo)));
        assert!(by_srgb < most && by_box > 2.0 * most, "band {band}: sRGB {by_srgb}, box {by_box}");
    }
}
