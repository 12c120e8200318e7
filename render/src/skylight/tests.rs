use std::f32::consts::{FRAC_1_PI, PI};

use flb_scene::sky::Sky;

use crate::tests::{Setup, at, material, plain, reference, render, sky_image, wall};
use crate::*;
use flb_scene::MaterialClass;

/// White leaves that only reflect.
const WHITE: Surfaces = Surfaces {
    leaf_reflectance: [1.0; 3],
    leaf_transmittance: [0.0; 3],
    wood_reflectance: [1.0; 3],
    solid_offset_m: None,
};

fn under(dome: Sky, samples: u32) -> Setup {
    let (shading, dome) = (Shading::Physical(WHITE), Some(dome));
    Setup { samples, sun_strength: 0.0, shading, dome, indirect: Indirect::Only, ..plain() }
}

/// An image, dim but for one pixel.
fn image(bright: f32) -> Sky {
    sky_image(|x, y| if (x, y) == (3, 20) { (bright, bright, bright / 2.0) } else { (0.5, 0.5, 0.5) })
}

/// Radiance of the wall, which faces the south (+Z), by the sum over the sky's parts.
fn expected(sky: &Sky) -> [f32; 3] {
    let (image, scale) = sky.image().unwrap();
    let [width, height] = image.size();
    let mut sum = [0.0; 3];
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let south = image.towards(x as f64 + 0.5, y as f64 + 0.5)[2].max(0.0) * image.solid_angle(y) as f32;
        (0..3).for_each(|band| sum[band] += image.pixel(x, y)[band] * scale * south * FRAC_1_PI);
    }
    sum
}

#[test]
fn a_wall_sends_out_what_an_image_with_a_small_sun_gives_it() {
    let mesh = wall(material("leaf", [0.5; 3]), vec![], 1.0);
    for bright in [0.5, 60.0, 20_000.0] {
        let sky = image(bright);
        let expected = expected(&sky);
        let found = reference(&mesh, &[MaterialClass::Leaf], &under(sky, 1024)).unwrap();
        let pixel = at(&found.picture, 16, 16);
        let error = found.standard_error[(16 * 32 + 16) * 3];
        assert!(error < 0.05 * expected[0], "{bright}: noise {error} of {}", expected[0]);
        for band in 0..3 {
            let off = (pixel[band] - expected[band]).abs();
            // The sum stands for the middles of pixels.
            assert!(off < 4.0 * error + 0.01 * expected[band], "{bright}: {pixel:?}, expected {expected:?}");
        }
    }
}

#[test]
fn an_even_image_is_the_even_sky() {
    let mesh = wall(material("leaf", [0.5; 3]), vec![], 1.0);
    let found = reference(&mesh, &[MaterialClass::Leaf], &under(image(0.5), 16)).unwrap();
    let (pixel, radiance) = (at(&found.picture, 16, 16), 1.0 / (4.0 * PI));
    assert!(pixel.iter().all(|band| (band / radiance - 1.0).abs() < 1e-3), "{pixel:?} and {radiance}");
}

#[test]
fn the_sun_has_its_colour_and_a_dome_is_not_for_the_paper_shading() {
    let mesh = wall(material("leaf", [0.5; 3]), vec![], 1.0);
    let dome = Sky::clear([0.0, 0.5, 1.0], 3.0).unwrap();
    let settings = Setup {
        sun: [0.0, 0.5, 1.0],
        sun_strength: 1.0,
        sun_color: [1.0, 0.5, 0.25],
        indirect: Indirect::Off,
        ..under(dome, 2)
    };
    let pixel = at(&reference(&mesh, &[MaterialClass::Leaf], &settings).unwrap().picture, 16, 16);
    assert!(
        (pixel[0] / pixel[1] - 2.0).abs() < 1e-5 && (pixel[0] / pixel[2] - 4.0).abs() < 1e-5,
        "{pixel:?}"
    );
    let paper = Setup { shading: Shading::Paper, ..settings };
    let error = render(&mesh, &[MaterialClass::Leaf], &|_, _| (), &paper).unwrap_err().to_string();
    assert!(error.contains("dome") && error.contains("physical"), "{error}");
}
