use super::matter::matter_at;
use super::*;

/// PROSPECT-D of the PyPI package `prosail` 2.0.5 for the same leaves: structure, chlorophyll, carotenoids,
/// anthocyanins, water, dry matter, then R and T at 450, 550, 650, 800 and 900 nm, to 6 digits.
type Known = ([f64; 6], [(f64, f64); 5]);
const PROSPECT_D: [Known; 4] = [
    (
        [1.5, 40.0, 8.0, 0.0, 0.01, 0.009],
        [
            (0.041251, 0.001399),
            (0.151167, 0.150253),
            (0.045496, 0.025203),
            (0.442543, 0.474635),
            (0.441550, 0.474204),
        ],
    ),
    (
        [1.0, 10.0, 3.0, 0.0, 0.004, 0.002],
        [
            (0.049532, 0.075364),
            (0.240494, 0.426277),
            (0.104702, 0.239304),
            (0.368804, 0.611396),
            (0.368218, 0.611320),
        ],
    ),
    (
        [2.3, 80.0, 15.0, 4.0, 0.02, 0.015],
        [
            (0.041034, 0.000005),
            (0.095191, 0.022724),
            (0.039372, 0.001276),
            (0.523301, 0.344986),
            (0.521625, 0.344056),
        ],
    ),
    (
        [1.2, 2.0, 10.0, 12.0, 0.008, 0.005],
        [
            (0.041904, 0.011256),
            (0.063033, 0.086392),
            (0.268963, 0.388775),
            (0.402249, 0.549905),
            (0.401373, 0.549541),
        ],
    ),
];

fn leaf([structure, chlorophyll, carotenoids, anthocyanins, water, dry]: [f64; 6]) -> LeafModel {
    LeafModel {
        structure,
        chlorophyll_ug_cm2: chlorophyll,
        carotenoids_ug_cm2: carotenoids,
        anthocyanins_ug_cm2: anthocyanins,
        water_cm: water,
        dry_matter_g_cm2: dry,
    }
}

#[test]
fn spectra_are_those_of_prospect_d() {
    for (parameters, known) in PROSPECT_D {
        for (nm, known) in [450.0, 550.0, 650.0, 800.0, 900.0].into_iter().zip(known) {
            let found = leaf(parameters).at(nm);
            let off = (found.0 - known.0).abs().max((found.1 - known.1).abs());
            assert!(off < 1e-6, "{parameters:?} at {nm} nm: {found:?}, {known:?}");
        }
    }
}

#[test]
fn the_default_leaf_is_the_common_one_of_the_measurements() {
    // PROSPECT-D at common values, as another implementation prints it, to 3 digits.
    for (nm, r, t) in [(450.0, 0.041, 0.001), (550.0, 0.151, 0.150), (650.0, 0.046, 0.025)] {
        let found = LeafModel::default().at(nm);
        assert!((found.0 - r).abs() < 0.0006 && (found.1 - t).abs() < 0.0006, "{nm}: {found:?}");
    }
}

#[test]
fn a_leaf_without_matter_absorbs_nothing() {
    for structure in [1.0, 1.7, 3.0] {
        for nm in [400.0, 553.0, 680.0, 900.0] {
            let (r, t) = leaf([structure, 0.0, 0.0, 0.0, 0.0, 0.0]).at(nm);
            assert!((r + t - 1.0).abs() < 1e-12, "{structure}, {nm}: {r} + {t}");
        }
    }
}

#[test]
fn more_chlorophyll_darkens_red() {
    // A plain range: sRGB's red sees green negatively, so there dark leaves redden a little as they turn grey.
    let range = Range { name: "red".to_owned(), low_nm: 600.0, high_nm: 680.0 };
    let bands = Bands::Ranges(vec![range]);
    let red = |chlorophyll_ug_cm2| {
        let leaf = LeafModel { chlorophyll_ug_cm2, ..LeafModel::default() };
        leaf.surfaces(&bands).bands[0].leaf
    };
    for (less, more) in [(0.0, 5.0), (5.0, 20.0), (20.0, 80.0), (80.0, 300.0)] {
        let (pale, dark) = (red(less), red(more));
        assert!(dark.reflectance < pale.reflectance, "{less} to {more}: {pale:?}, {dark:?}");
        assert!(dark.transmittance < pale.transmittance, "{less} to {more}: {pale:?}, {dark:?}");
    }
}

#[test]
fn anthocyanins_turn_a_pale_leaf_red() {
    let surfaces = LeafModel { chlorophyll_ug_cm2: 3.0, anthocyanins_ug_cm2: 10.0, ..LeafModel::default() }
        .surfaces(&Bands::Rgb);
    let [r, g, b] = [0, 1, 2].map(|band| surfaces.bands[band].leaf.reflectance);
    assert!(r > 2.0 * g && r > 2.0 * b, "{r}, {g}, {b}");
}

#[test]
fn surfaces_stay_in_range_for_all_leaves_and_bands() {
    let near_infrared = Range { name: "NIR".to_owned(), low_nm: 750.0, high_nm: 900.0 };
    let mut clipped = [false; 2];
    for structure in [1.0, 1.5, 5.0] {
        for (chlorophyll, carotenoids, anthocyanins) in
            [(0.0, 0.0, 0.0), (0.0, 20.0, 0.0), (0.0, 100.0, 10.0), (40.0, 8.0, 0.0), (300.0, 100.0, 100.0)]
        {
            let leaf = leaf([structure, chlorophyll, carotenoids, anthocyanins, 0.0, 0.0]);
            for bands in [Bands::Rgb, Bands::Ranges(vec![near_infrared.clone()])] {
                for band in leaf.surfaces(&bands).bands {
                    let LeafSurface { reflectance: r, transmittance: t } = band.leaf;
                    assert!(r >= 0.0 && t >= 0.0 && r + t <= 1.0, "{leaf:?}: {band:?}");
                    clipped[0] |= t == 0.0;
                    clipped[1] |= r + t > 1.0 - 1e-15 && carotenoids > 0.0;
                }
            }
        }
    }
    assert_eq!(clipped, [true; 2], "some colours are cut at 0, some at 1");
}

#[test]
fn matter_is_linear_between_rows_and_ends_with_the_table() {
    let (low, middle, high) = (matter_at(650.0), matter_at(652.0), matter_at(655.0));
    let wanted = low.chlorophyll * 0.6 + high.chlorophyll * 0.4;
    assert!((middle.chlorophyll - wanted).abs() < 1e-15, "{middle:?}");
    assert_eq!((low.index, low.water), (1.4473, 3.315e-3));
    assert_eq!(matter_at(380.0), matter_at(400.0));
    assert_eq!(matter_at(1000.0), matter_at(900.0));
    assert_eq!(matter_at(900.0).water, 6.407e-2);
}

#[test]
fn bark_is_linear_between_measured_bands() {
    assert_eq!(bark_reflectance(400.0), 0.091);
    assert_eq!(bark_reflectance(900.0), 0.393);
    assert_eq!(bark_reflectance(443.0), 0.091);
    assert!((bark_reflectance((560.4 + 665.3) / 2.0) - 0.143).abs() < 1e-12);
}

#[test]
fn knapp_and_carter_s_bands_are_red_green_and_blue() {
    let surfaces = knapp_carter();
    let names: Vec<&str> = surfaces.bands.iter().map(|band| band.name.as_str()).collect();
    assert_eq!(names, ["R", "G", "B"]);
}

/// The values that docs/book/src/bake.md states, to their last digit.
#[test]
fn surfaces_in_rgb_are_those_of_the_book() {
    let close = |found: f64, stated: f64| assert!((found - stated).abs() <= 0.0005, "{found}, {stated}");
    for (surfaces, stated) in [
        (knapp_carter(), [(0.070, 0.055), (0.125, 0.150), (0.040, 0.020)]),
        (LeafModel::default().surfaces(&Bands::Rgb), [(0.065, 0.057), (0.126, 0.122), (0.033, 0.000)]),
    ] {
        for ((band, leaf), wood) in surfaces.bands.iter().zip(stated).zip([0.153, 0.123, 0.090]) {
            close(band.leaf.reflectance, leaf.0);
            close(band.leaf.transmittance, leaf.1);
            close(band.wood.reflectance, wood);
        }
    }
}
