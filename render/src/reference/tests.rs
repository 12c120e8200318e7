use std::f32::consts::{FRAC_1_PI, PI};

use crate::reference::Reference;
use crate::tests::{Setup, add_quad, at, dark, material, oak, plain, reference, render, wall};
use crate::*;
use flb_scene::{MaterialClass, Mesh};

/// Sums of a few products in f32.
const ROUNDING: f32 = 1e-5;
/// Standard errors that chance may lie off: one pixel in 15,000.
const SIGMAS: f32 = 4.0;

fn gray(reflectance: f32, transmittance: f32) -> Surfaces {
    Surfaces {
        leaf_reflectance: [reflectance; 3],
        leaf_transmittance: [transmittance; 3],
        wood_reflectance: [reflectance + transmittance; 3],
        solid_offset_m: None,
    }
}

/// Under an even sky of radiance 1, no sun.
fn under_sky(surfaces: Surfaces) -> Setup {
    Setup {
        samples: 8,
        sun_strength: 0.0,
        ambient: 4.0 * PI,
        indirect: Indirect::On,
        shading: Shading::Physical(surfaces),
        ..plain()
    }
}

fn trace(mesh: &Mesh, settings: &Setup) -> Reference {
    let classes = match mesh.materials.len() {
        1 => vec![MaterialClass::Leaf],
        _ => vec![MaterialClass::Wood, MaterialClass::Leaf],
    };
    reference(mesh, &classes, settings).unwrap()
}

/// The oak without its textures, so that every leaf is the mean leaf.
fn plain_oak() -> Mesh {
    let mut mesh = oak(4_000);
    mesh.materials = vec![material("wood", [0.3; 3]), material("leaf", [0.3; 3])];
    mesh
}

#[test]
fn a_white_leaf_in_an_even_sky_cannot_be_seen() {
    let mesh = wall(material("leaf", [0.5; 3]), vec![], 1.0);
    for (reflectance, transmittance) in [(1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.25, 0.75)] {
        let found = trace(&mesh, &under_sky(gray(reflectance, transmittance)));
        assert_eq!(at(&found.picture, 16, 16), [1.0; 3]);
    }
    // The shading agrees: the fluence of that sky is 4 pi times its radiance.
    let everywhere = |_: [f32; 3], phi: &mut [f32; 3]| *phi = [4.0 * PI; 3];
    let shaded = render(&mesh, &[MaterialClass::Leaf], &everywhere, &under_sky(gray(0.5, 0.5))).unwrap();
    assert!((at(&shaded, 16, 16)[0] - 1.0).abs() < ROUNDING);
}

/// Light that a white plant holds back for longer than a path is followed.
const LOST: f32 = 0.01;

#[test]
fn a_white_plant_in_an_even_sky_cannot_be_seen_and_a_gray_one_is_darker() {
    let mesh = plain_oak();
    let everywhere = |_: [f32; 3], phi: &mut [f32; 3]| *phi = [4.0 * PI; 3];
    let white = under_sky(gray(0.5, 0.5));
    // As leaves in an even fluence both materials send out 1: the share of each pixel that is plant.
    let share = render(&mesh, &[MaterialClass::Leaf; 2], &everywhere, &white).unwrap();
    let sum = |picture: &Picture| picture.rgb.iter().sum::<f32>();
    let mut darker = sum(&share) * (1.0 + ROUNDING);
    for (surfaces, least) in [(gray(0.5, 0.5), 1.0 - LOST), (gray(0.4, 0.4), 0.3), (gray(0.05, 0.03), 0.02)] {
        let found = trace(&mesh, &under_sky(surfaces)).picture;
        for (at, (&found, &share)) in found.rgb.iter().zip(&share.rgb).enumerate() {
            assert!(found <= share + ROUNDING, "value {at}: {found} of {share}");
        }
        assert!(sum(&found) > least * sum(&share), "{} of {}", sum(&found), sum(&share));
        assert!(sum(&found) < darker, "{} below {darker}", sum(&found));
        darker = 0.9 * sum(&found);
    }
}

#[test]
fn the_first_hit_of_the_sun_is_that_of_the_shading_and_the_rest_is_added() {
    let mesh = oak(4_000);
    let classes = [MaterialClass::Wood, MaterialClass::Leaf];
    let settings = Setup {
        sun: [0.5, 0.6, -0.3],
        samples: 4,
        ambient: 0.3,
        ground: true,
        sky: true,
        view_elevation_deg: 15.0,
        ..under_sky(gray(0.1, 0.2))
    };
    let settings = Setup { sun_strength: 1.5, ..settings };
    let part = |indirect: Indirect| Setup { indirect, ..settings.clone() };
    let off = trace(&mesh, &part(Indirect::Off)).picture;
    assert_eq!(off, render(&mesh, &classes, &dark, &part(Indirect::Off)).unwrap());
    let only = trace(&mesh, &part(Indirect::Only)).picture;
    let on = trace(&mesh, &part(Indirect::On)).picture;
    assert!(off.rgb.iter().any(|&v| v > 0.03) && only.rgb.iter().any(|&v| v > 0.01));
    for (at, &on) in on.rgb.iter().enumerate() {
        let sum = off.rgb[at] + only.rgb[at];
        assert!((on - sum).abs() < ROUNDING, "value {at}: {on} is not {} + {}", off.rgb[at], only.rgb[at]);
    }
}

/// Two sheets that face each other, 2 and 1.6 m square, half a metre apart; the sun stands behind the
/// northern one and the camera before the southern one, which hides and shades the northern one's middle.
const SHEETS_Z: [f32; 2] = [-GAP, 0.0];
const GAP: f32 = 0.5;
const SHEET_HALF: [f32; 2] = [1.0, 0.8];

fn sheets() -> Mesh {
    let mut mesh = Mesh { materials: vec![material("leaf", [1.0; 3])], ..Mesh::default() };
    for (z, half) in SHEETS_Z.into_iter().zip(SHEET_HALF) {
        add_quad(&mut mesh, 0, [-half, -half, z], [[2.0 * half, 0.0, 0.0], [0.0, 2.0 * half, 0.0]], 1.0);
    }
    mesh
}

fn behind_sheets(samples: u32) -> Setup {
    Setup {
        samples,
        sun: [0.0, 0.0, -1.0],
        ambient: 0.0,
        indirect: Indirect::Only,
        shading: Shading::Physical(SHEET),
        ..plain()
    }
}

/// From no reflection at all to light that goes to and fro for long.
const SHEET: Surfaces = Surfaces {
    leaf_reflectance: [0.0, 0.5, 0.9],
    leaf_transmittance: [0.5, 0.4, 0.1],
    wood_reflectance: [0.0; 3],
    solid_offset_m: None,
};

/// Patches along an edge of a sheet, and what so few of them put off at most.
const PATCHES: usize = 32;
const COARSENESS: f32 = 0.003;
/// Times that light goes to and fro; less than a fifth of it comes back.
const ROUNDS: usize = 12;

/// Middles of a sheet's patches.
fn patches(sheet: usize) -> Vec<[f32; 2]> {
    let step = patch_edge(sheet);
    let along = |i: usize| -SHEET_HALF[sheet] + (i as f32 + 0.5) * step;
    (0..PATCHES * PATCHES).map(|i| [along(i % PATCHES), along(i / PATCHES)]).collect()
}

fn patch_edge(sheet: usize) -> f32 {
    2.0 * SHEET_HALF[sheet] / PATCHES as f32
}

/// Irradiance at a place of one sheet from what the patches of the other, `sheet`, send out: cos^2 / (pi d^2)
/// for each, with d cos = GAP.
fn irradiance(place: [f32; 2], sheet: usize, exitance: &[f32]) -> f32 {
    let area = patch_edge(sheet) * patch_edge(sheet);
    let received = |(patch, exitance): ([f32; 2], &f32)| {
        let [x, y] = [0, 1].map(|axis| patch[axis] - place[axis]);
        let squared = x * x + y * y + GAP * GAP;
        exitance * FRAC_1_PI * area * GAP * GAP / (squared * squared)
    };
    patches(sheet).into_iter().zip(exitance).map(received).sum()
}

/// What the northern sheet's patches send south, by exchange between patches (radiosity): the sun through the
/// sheet, and what comes back from the southern one.
fn sent_south(band: usize) -> Vec<f32> {
    let (r, t) = (SHEET.leaf_reflectance[band], SHEET.leaf_transmittance[band]);
    let mut north = vec![t; PATCHES * PATCHES];
    for _ in 0..ROUNDS {
        let south: Vec<f32> = patches(1).into_iter().map(|p| r * irradiance(p, 0, &north)).collect();
        north = patches(0).into_iter().map(|p| t + r * irradiance(p, 1, &south)).collect();
    }
    north
}

/// Where the middle of a pixel lies on the southern sheet.
fn place_of(mesh: &Mesh, settings: &Setup, x: u32, y: u32) -> [f32; 2] {
    let place = |p: [f32; 3], phi: &mut [f32; 3]| *phi = [p[0] + 5.0, p[1] + 5.0, 1.0 - p[2].abs()];
    let settings = Setup { samples: 1, shading: Shading::Paper, indirect_scale: 1.0, ..settings.clone() };
    let [px, py, on_sheet] = at(&render(mesh, &[MaterialClass::Leaf], &place, &settings).unwrap(), x, y);
    assert!(on_sheet > 0.99, "pixel {x}, {y} does not show the southern sheet");
    [px - 5.0, py - 5.0]
}

#[test]
fn light_between_two_leaves_is_that_of_the_exchange_between_patches() {
    let mesh = sheets();
    let settings = Setup { width: 12, height: 12, ..behind_sheets(4_096) };
    let found = trace(&mesh, &settings);
    for band in 0..3 {
        let north = sent_south(band);
        let transmittance = SHEET.leaf_transmittance[band];
        let (mut sum, mut expected_sum, mut variance) = (0.0, 0.0, 0.0);
        for (x, y) in (3..9).flat_map(|y| (3..9).map(move |x| (x, y))) {
            let arriving = irradiance(place_of(&mesh, &settings, x, y), 0, &north);
            let expected = transmittance * FRAC_1_PI * arriving;
            let error = found.standard_error[((y * 12 + x) * 3) as usize + band];
            let value = at(&found.picture, x, y)[band];
            let off = (value - expected).abs();
            assert!(
                off < SIGMAS * error + COARSENESS * expected,
                "band {band}: {value}, not {expected} +- {error}"
            );
            sum += value;
            expected_sum += expected;
            variance += error * error;
        }
        let (off, error) = ((sum - expected_sum).abs(), variance.sqrt());
        assert!(error < 0.01 * expected_sum, "{expected_sum} +- {error}");
        assert!(
            off < SIGMAS * error + COARSENESS * expected_sum,
            "band {band}: {sum}, not {expected_sum} +- {error}"
        );
    }
}

#[test]
fn the_standard_error_is_how_far_pictures_lie_off() {
    let mesh = sheets();
    let [rough, fine, exact] = [64, 256, 4_096]
        .map(|samples| trace(&mesh, &Setup { width: 12, height: 12, ..behind_sheets(samples) }));
    // Inside the sheet, where no edge adds its own.
    let inside = || (3..9).flat_map(|y| (3..9).map(move |x| (y * 12 + x) * 3 + 1));
    let rms =
        |values: &dyn Fn(usize) -> f32| (inside().map(|i| values(i) * values(i)).sum::<f32>() / 36.0).sqrt();
    let stated = rms(&|i| rough.standard_error[i]);
    let found = rms(&|i| rough.picture.rgb[i] - exact.picture.rgb[i]);
    // 36 pixels tell a deviation to 12 %; three times that.
    assert!((found / stated - 1.0).abs() < 0.36, "found {found}, stated {stated}");
    let halved = stated / rms(&|i| fine.standard_error[i]);
    assert!((halved - 2.0).abs() < 0.2, "four times the samples, error by {halved}");
    let [r, g, b] = rough.mean_standard_error();
    let mean: f32 = rough.standard_error.iter().sum::<f32>() / rough.standard_error.len() as f32;
    assert!(
        ((r + g + b) / 3.0 - f64::from(mean)).abs() < 1e-6 * f64::from(mean) + 1e-9,
        "{r} {g} {b}, {mean}"
    );
}

#[test]
fn threads_do_not_change_a_reference() {
    let mesh = oak(2_000);
    let settings = Setup { samples: 3, sun_strength: 1.0, ..under_sky(gray(0.2, 0.3)) };
    let found = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trace(&mesh, &settings))
    });
    assert!(found[0].picture.rgb.iter().any(|&v| v > 0.1));
    assert_eq!(found[0], found[1]);
    assert_eq!(found[0], found[2]);
}

#[test]
fn a_reference_without_surfaces_or_without_an_error_is_refused() {
    let mesh = wall(material("wall", [1.0; 3]), vec![], 1.0);
    let refused =
        |settings: Setup| reference(&mesh, &[MaterialClass::Leaf], &settings).unwrap_err().to_string();
    let paper = Setup { shading: Shading::Paper, ..behind_sheets(4) };
    assert!(refused(paper).starts_with("render setting `shading` is paper, expected physical"));
    assert!(refused(behind_sheets(1)).starts_with("render setting `samples` is 1, expected 2 or more"));
    assert!(refused(behind_sheets(5_000)).contains("`samples` is 5000, expected 1..=4096"));
    let error = reference(&mesh, &[], &behind_sheets(2)).unwrap_err();
    assert!(matches!(error, RenderError::Classes { found: 0, expected: 1 }), "{error}");
}
