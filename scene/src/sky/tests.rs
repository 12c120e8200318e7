//! Skies by what is known of them: their colours and strengths, what they sum to, and what no sky may be.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use super::*;
use flb_format::sun::towards_sun;

fn clear(elevation_deg: f64, turbidity: f64) -> Sky {
    Sky::clear(towards_sun(135.0, elevation_deg), turbidity).expect("a sky")
}

fn up(sky: &Sky, elevation_deg: f64, azimuth_deg: f64) -> [f32; 3] {
    sky.radiance(towards_sun(azimuth_deg, elevation_deg).map(|c| c as f32))
}

#[test]
fn the_sun_overhead_in_clear_air_is_the_unit_and_reddens_as_it_sinks() {
    let sun = |elevation| clear(elevation, 3.0).sun().expect("a clear sky has a sun");
    assert!((luminance(sun(90.0)) - 1.0).abs() < 1e-4, "{:?}", sun(90.0));
    let mut last = sun(90.0);
    for elevation in [60.0, 40.0, 20.0, 10.0, 5.0, 2.0, 0.5] {
        let now = sun(elevation);
        assert!(luminance(now) < luminance(last), "{elevation}: {now:?} after {last:?}");
        // The last suns are redder than any blue of sRGB can tell.
        assert!(now[1] / now[0] < last[1] / last[0], "{elevation}: {now:?} after {last:?}");
        assert!(now[2] / now[0] < last[2] / last[0] || last[2] == 0.0, "{elevation}: {now:?} after {last:?}");
        last = now;
    }
    assert!(sun(-0.3) == [0.0; 3] && luminance(sun(0.0)) > 0.0);
    let hazy = clear(90.0, 8.0).sun().expect("a sun");
    assert!(luminance(hazy) < 0.8, "haze takes light from the sun: {hazy:?}");
}

#[test]
fn the_sky_is_blue_brightest_at_the_sun_and_as_strong_as_measured_ones() {
    for elevation in [10.0, 30.0, 60.0] {
        let sky = clear(elevation, 3.0);
        let away = up(&sky, 80.0, 315.0);
        assert!(away[2] > 1.3 * away[0], "{elevation}: blue away from the sun, {away:?}");
        let (near, far) = (up(&sky, elevation, 135.0), up(&sky, elevation, 315.0));
        assert!(luminance(near) > 2.0 * luminance(far), "{elevation}: {near:?} and {far:?}");
    }
    // A tenth to a half of the sun overhead, on level ground.
    for elevation in [20.0, 40.0, 60.0] {
        let sky = clear(elevation, 3.0);
        let level: f64 =
            sky.patches().iter().map(|p| f64::from(luminance(p.fluence)) * p.towards[1].max(0.0)).sum();
        assert!((0.1..0.5).contains(&level), "{elevation}: {level}");
    }
}

#[test]
fn every_sun_and_turbidity_gives_finite_light_of_no_negative_part() {
    for turbidity in [2.0, 3.0, 6.0, 10.0] {
        for elevation in [-90.0, -30.0, -18.0, -12.5, -6.0, -0.1, 0.0, 0.1, 3.0, 45.0, 89.99, 90.0] {
            let sky = clear(elevation, turbidity);
            for up_deg in [-90.0, -1.0, 0.0, 0.01, 5.0, 45.0, 90.0] {
                for azimuth in [0.0, 134.9, 135.0, 315.0] {
                    for light in [up(&sky, up_deg, azimuth), sky.sun().expect("a sun")] {
                        let fine = light.iter().all(|band| band.is_finite() && *band >= 0.0);
                        assert!(fine, "turbidity {turbidity}, sun {elevation}, at {up_deg}: {light:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn dusk_fades_without_a_step_and_night_is_dark() {
    let fluence = |elevation: f64| luminance(clear(elevation, 3.0).fluence());
    let mut last = fluence(1.0);
    for step in 1..=80 {
        let now = fluence(1.0 - 0.25 * f64::from(step));
        assert!(now <= last && now >= last * 0.3 || last < 1e-6, "step {step}: {now} after {last}");
        last = now;
    }
    assert_eq!(clear(-18.0, 3.0).fluence(), [0.0; 3]);
    // 3.4 lux of 93 thousand at the end of civil twilight, by measured tables; within a factor of 3.
    let level = fluence(-6.0) / 4.0;
    assert!((1.2e-5..1.1e-4).contains(&level), "{level}");
}

#[test]
fn patches_share_the_whole_sphere_and_keep_the_light() {
    let sky = clear(30.0, 3.0);
    let patches = sky.patches();
    assert_eq!(patches.len(), 184);
    let whole: f64 = patches.iter().map(|patch| patch.solid_angle).sum();
    assert!((whole - 4.0 * PI).abs() < 1e-9, "{whole}");
    assert!(patches.iter().all(|p| (p.towards.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-9));
    // The irradiance on planes that face any way, summed in another way: by radiance at many points.
    for normal in [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-0.6, 0.0, 0.8], [0.0, -1.0, 0.0]] {
        let cosine = |s: [f64; 3]| (0..3).map(|axis| s[axis] * normal[axis]).sum::<f64>().max(0.0);
        let by_patches: f64 =
            patches.iter().map(|p| f64::from(luminance(p.fluence)) * cosine(p.towards)).sum();
        let (rings, around) = (300, 600);
        let mut direct = 0.0;
        for ring in 0..rings {
            let y = (f64::from(ring) + 0.5) / f64::from(rings) * 2.0 - 1.0;
            let level = libm::sqrt(1.0 - y * y);
            for step in 0..around {
                let (sin, cos) = libm::sincos(2.0 * PI * (f64::from(step) + 0.5) / f64::from(around));
                let s = [level * cos, y, level * sin];
                direct += f64::from(luminance(sky.radiance(s.map(|c| c as f32)))) * cosine(s);
            }
        }
        direct *= 4.0 * PI / f64::from(rings * around);
        assert!((by_patches / direct - 1.0).abs() < 0.02, "{normal:?}: {by_patches} and {direct}");
    }
}

#[test]
fn an_image_has_north_in_its_middle_east_at_its_right_and_fluence_1() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.exr");
    // Bright to the east, a little above the horizon.
    let light = |x: usize, y: usize| if (x, y) == (12, 3) { (8.0, 4.0, 2.0) } else { (0.25, 0.5, 1.0) };
    write_exr(&path, [16, 8], light);
    let image = Arc::new(SkyImage::read(&path).expect("an image"));
    let sky = Sky::of_image(image.clone());
    assert!((luminance(sky.fluence()) - 1.0).abs() < 1e-3, "{:?}", sky.fluence());
    let east = sky.radiance(towards_sun(95.0, 11.0).map(|c| c as f32));
    let west = sky.radiance(towards_sun(265.0, 11.0).map(|c| c as f32));
    assert!((east[0] / west[0] - 32.0).abs() < 1e-3, "{east:?} {west:?}");
    for (x, y) in [(0, 0), (3, 2), (12, 3), (15, 7)] {
        let middle = image.towards(x as f64 + 0.5, y as f64 + 0.5);
        assert_eq!(image.radiance(middle), image.pixel(x, y), "({x}, {y})");
        let smooth = image.smooth(middle);
        assert!((0..3).all(|band| (smooth[band] - image.pixel(x, y)[band]).abs() < 1e-4), "{smooth:?}");
    }
    let brightest =
        sky.patches().iter().max_by(|a, b| a.fluence[0].total_cmp(&b.fluence[0])).expect("patches");
    assert!(brightest.towards[0] > 0.8 && brightest.towards[1] > 0.0, "{brightest:?}");
    assert_eq!(
        sky.times(0.5).radiance([0.0, 1.0, 0.0]),
        sky.radiance([0.0, 1.0, 0.0]).map(|band| band * 0.5)
    );
}

#[test]
fn a_radiance_file_is_read_like_the_exr_of_the_same_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.hdr");
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    // Mantissas over 256 times 2^(exponent - 128).
    (0..32u8).for_each(|at| bytes.extend([128, 64, at, 130]));
    std::fs::write(&path, &bytes).expect("written");
    let image = SkyImage::read(&path).expect("an image");
    assert_eq!(image.size(), [8, 4]);
    let pixel = image.pixel(5, 1);
    assert!((pixel[0] - 2.0).abs() < 0.02 && (pixel[1] - 1.0).abs() < 0.02, "{pixel:?}");
    std::fs::write(&path, &bytes[..bytes.len() - 3]).expect("written");
    says(SkyImage::read(&path).expect_err("cut"), &["sky.hdr", "is no whole image"]);
}

#[test]
fn what_is_no_sky_is_refused_with_file_place_found_and_expected() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bad.exr");
    let read = |size, light: &(dyn Fn(usize, usize) -> (f32, f32, f32) + Sync)| {
        write_exr(&path, size, light);
        SkyImage::read(&path).expect_err("a bad sky")
    };
    says(read([4, 4], &|_, _| (1.0, 1.0, 1.0)), &["bad.exr", "4 x 4", "twice the height"]);
    says(
        read([8194, 4097], &|_, _| (1.0, 1.0, 1.0)),
        &["bad.exr", "columns: 8194 is over the limit of 8192"],
    );
    says(read([8, 4], &|_, _| (1e-44, 1e-44, 1e-44)), &["bad.exr", "mean luminance", "expected 1e-30"]);
    let with = |found: f32| move |x: usize, y: usize| (1.0, if (x, y) == (2, 1) { found } else { 1.0 }, 1.0);
    says(read([8, 4], &with(f32::NAN)), &["bad.exr", "pixel (2, 1) band G is NaN", "finite"]);
    says(read([8, 4], &with(-0.5)), &["pixel (2, 1) band G is -0.5", "0 or more"]);
    says(read([8, 4], &with(f32::INFINITY)), &["pixel (2, 1) band G is inf", "finite"]);
    says(read([8, 4], &with(65_504.0)), &["is 65504", "half precision", "--sun"]);
    says(read([8, 4], &|_, _| (0.0, 0.0, 0.0)), &["bad.exr", "black"]);
    let whole = std::fs::read(&path).expect("read");
    for (bytes, words) in [
        (&b"\x89PNG\r\n"[..], &["89 50 4e 47", "expected an OpenEXR"][..]),
        (&b""[..], &["begins with nothing"][..]),
        (&whole[..whole.len() / 2], &["is no whole image"][..]),
        (&b"#?RADIANCE\n"[..], &["is no whole image"][..]),
    ] {
        std::fs::write(&path, bytes).expect("written");
        says(SkyImage::read(&path).expect_err("a bad sky"), words);
    }
    let gone = SkyImage::read(&folder.path().join("gone.exr")).expect_err("no file");
    says(gone, &["gone.exr", "cannot be read"]);
    says(Sky::clear([0.0, f64::NAN, 1.0], 3.0).expect_err("no direction"), &["NaN", "direction"]);
    says(Sky::clear([0.0; 3], 3.0).expect_err("no direction"), &["direction"]);
    for turbidity in [1.9, 10.1, f64::NAN] {
        says(Sky::clear([0.0, 1.0, 0.0], turbidity).expect_err("no air"), &["turbidity", "2", "10"]);
    }
}

/// An EXR whose windows and chromaticities are given. Windows are left, top, width, height.
fn write_windows(
    path: &Path,
    [data, display]: [[i32; 4]; 2],
    chromaticities: Option<[[f32; 2]; 4]>,
    light: impl Fn(usize, usize) -> (f32, f32, f32) + Sync,
) {
    use exr::meta::attribute::{Chromaticities, IntegerBounds};
    use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage};
    let [left, top, width, height] = data;
    let pixels = SpecificChannels::rgb(|at: Vec2<usize>| light(at.x(), at.y()));
    let attributes = LayerAttributes { layer_position: Vec2(left, top), ..LayerAttributes::named("sky") };
    let size = (width as usize, height as usize);
    let layer = Layer::new(size, attributes, Encoding::UNCOMPRESSED, pixels);
    let mut image = Image::from_layer(layer);
    let [left, top, width, height] = display;
    image.attributes.display_window = IntegerBounds::new((left, top), (width as usize, height as usize));
    image.attributes.chromaticities = chromaticities.map(|[red, green, blue, white]| {
        let of = |[x, y]: [f32; 2]| Vec2(x, y);
        Chromaticities { red: of(red), green: of(green), blue: of(blue), white: of(white) }
    });
    image.write().to_file(path).expect("written");
}

#[test]
fn a_data_window_is_placed_in_the_display_window_and_the_rest_is_black() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cropped.exr");
    let light = |x: usize, y: usize| (1.0 + x as f32, 1.0 + y as f32, 3.0);
    // The lower half is cut off, and two columns at the left.
    write_windows(&path, [[-6, 10, 14, 4], [-8, 10, 16, 8]], None, light);
    let image = SkyImage::read(&path).expect("a sky");
    assert_eq!(image.size(), [16, 8]);
    assert_eq!(image.pixel(2, 0), [1.0, 1.0, 3.0]);
    assert_eq!(image.pixel(15, 3), [14.0, 4.0, 3.0]);
    assert_eq!([image.pixel(1, 0), image.pixel(2, 4), image.pixel(15, 7)], [[0.0; 3]; 3]);
    // More than is shown on every side.
    write_windows(&path, [[-1, -2, 18, 12], [0, 0, 16, 8]], None, light);
    let image = SkyImage::read(&path).expect("a sky");
    assert_eq!(
        (image.size(), image.pixel(0, 0), image.pixel(15, 7)),
        ([16, 8], [2.0, 3.0, 3.0], [17.0, 10.0, 3.0])
    );
    write_windows(&path, [[0, 0, 16, 8], [0, 0, 20, 8]], None, light);
    says(SkyImage::read(&path).expect_err("no sphere"), &["cropped.exr", "20 x 8", "twice the height"]);
    write_windows(&path, [[100, 100, 16, 8], [0, 0, 16, 8]], None, light);
    says(SkyImage::read(&path).expect_err("nothing of it is shown"), &["cropped.exr", "black"]);
}

#[test]
fn an_exr_of_other_channels_is_refused_with_their_names() {
    use exr::prelude::{SpecificChannels, WritableImage};
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("gray.exr");
    let channels = SpecificChannels::build().with_channel("Y").with_pixel_fn(|_| (0.5_f32,));
    exr::prelude::Image::from_channels((8, 4), channels).write().to_file(&path).expect("written");
    says(
        SkyImage::read(&path).expect_err("no colours"),
        &["gray.exr", "channels Y", "expected channels R, G and B"],
    );
}

#[test]
fn primaries_of_an_exr_become_those_of_srgb_or_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wide.exr");
    let window = [[0, 0, 8, 4]; 2];
    let with =
        |chromaticities| {
            write_windows(&path, window, chromaticities, |x, _| {
                if x == 0 { (0.0, 1.0, 0.0) } else { (1.0, 0.5, 0.5) }
            });
            SkyImage::read(&path)
        };
    let srgb = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];
    let plain = with(None).expect("a sky");
    assert_eq!(with(Some(srgb)).expect("a sky"), plain);
    let rec2020 = [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], [0.3127, 0.3290]];
    let wide = with(Some(rec2020)).expect("a sky");
    let near =
        |found: [f32; 3], expected: [f32; 3]| (0..3).all(|band| (found[band] - expected[band]).abs() < 2e-3);
    assert!(near(wide.pixel(3, 1), [1.3302, 0.4377, 0.4909]), "{:?}", wide.pixel(3, 1));
    assert!(near(wide.pixel(0, 1), [0.0, 1.1329, 0.0]), "{:?}", wide.pixel(0, 1));
    let line = [[0.3, 0.3], [0.4, 0.4], [0.2, 0.2], [0.3127, 0.3290]];
    says(with(Some(line)).expect_err("no colours"), &["wide.exr", "chromaticities", "0.4"]);
}

#[test]
fn a_colour_space_that_an_exr_names_is_read_where_it_has_no_chromaticities() {
    use exr::prelude::{AttributeValue, Image, SpecificChannels, Text, Vec2, WritableImage};
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("named.exr");
    let with = |attribute: &str, space: &str| {
        let pixels = SpecificChannels::rgb(|_: Vec2<usize>| (1.0_f32, 0.5_f32, 0.5_f32));
        let mut image = Image::from_channels((8, 4), pixels);
        let text = AttributeValue::Text(Text::from(space));
        image.layer_data.attributes.other.insert(Text::from(attribute), text);
        image.write().to_file(&path).expect("written");
        SkyImage::read(&path).expect("a sky").pixel(3, 1)
    };
    let near =
        |found: [f32; 3], expected: [f32; 3]| (0..3).all(|band| (found[band] - expected[band]).abs() < 2e-3);
    for (attribute, space) in
        [("colorInteropID", "lin_rec2020_scene"), ("oiio:ColorSpace", "Linear Rec.2020")]
    {
        let found = with(attribute, space);
        assert!(near(found, [1.3302, 0.4377, 0.4909]), "{space}: {found:?}");
    }
    // ACEScg to linear sRGB, as published: its rows, by Bradford.
    let of_rows = |[a, b, c]: [f32; 3]| a + 0.5 * (b + c);
    let expected =
        [[1.70505, -0.62179, -0.08326], [-0.13026, 1.14080, -0.01055], [-0.02400, -0.12897, 1.15297]]
            .map(of_rows);
    for space in ["ACEScg", "lin_ap1_scene", "ACES - ACEScg"] {
        assert!(near(with("oiio:ColorSpace", space), expected), "{space}");
    }
    for space in ["Linear", "lin_rec709_scene", "scene_linear", "data"] {
        assert_eq!(with("colorInteropID", space), [1.0, 0.5, 0.5], "{space}");
    }
}

/// A Radiance file of 8 x 4 pixels, which are all different, with these lines in its header.
fn radiance(header: &str, size: &str, order: impl Fn(usize) -> (usize, usize)) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{header}\n{size}\n").into_bytes();
    for at in 0..32 {
        let (x, y) = order(at);
        bytes.extend([(16 * x + 8) as u8, (64 * y + 8) as u8, 128, 129]);
    }
    bytes
}

#[test]
fn a_radiance_file_may_list_its_pixels_in_any_of_eight_orders() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.hdr");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).expect("written");
        SkyImage::read(&path)
    };
    let expected = read(&radiance("", "-Y 4 +X 8", |at| (at % 8, at / 8))).expect("a sky");
    assert!(expected.pixel(7, 0)[0] > 10.0 * expected.pixel(0, 0)[0], "x to the right");
    for (size, order) in [
        ("+Y 4 +X 8", &(|at: usize| (at % 8, 3 - at / 8)) as &dyn Fn(usize) -> (usize, usize)),
        ("-Y 4 -X 8", &|at| (7 - at % 8, at / 8)),
        ("+Y 4 -X 8", &|at| (7 - at % 8, 3 - at / 8)),
        ("+X 8 -Y 4", &|at| (at / 4, at % 4)),
        ("-X 8 -Y 4", &|at| (7 - at / 4, at % 4)),
        ("+X 8 +Y 4", &|at| (at / 4, 3 - at % 4)),
        ("-X 8 +Y 4", &|at| (7 - at / 4, 3 - at % 4)),
    ] {
        assert_eq!(read(&radiance("", size, order)).expect(size), expected, "{size}");
    }
    for size in ["-Y 4 +Y 8", "-Z 4 +X 8", "-Y 4", "-Y four +X 8", "4 8", "-Y 4 +X 8 9"] {
        let error = read(&radiance("", size, |at| (at % 8, at / 8))).expect_err(size);
        says(error, &["sky.hdr", "in its header", "-Y 1024 +X 2048"]);
    }
}

#[test]
fn a_radiance_header_tells_primaries_and_corrections() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.hdr");
    let read = |header: &str| {
        std::fs::write(&path, radiance(header, "-Y 4 +X 8", |at| (at % 8, at / 8))).expect("written");
        SkyImage::read(&path)
    };
    let plain = read("").expect("a sky");
    for header in [
        "EXPOSURE=4\n",
        "# PRIMARIES=1 2 3\n",
        "GAMMA=1\nPRIMARIES=0 0 0 0 0 0 0 0\n",
        "PRIMARIES= .640 .330 .300 .600 .150 .060 .3127 .3290\nVIEW= -vta\n",
    ] {
        assert_eq!(read(header).expect(header), plain, "{header}");
    }
    let corrected = read("COLORCORR= 2 1 1\nCOLORCORR=1 1 4\n").expect("a sky");
    let [[r, g, b], [r2, g2, b2]] = [plain.pixel(5, 2), corrected.pixel(5, 2)];
    assert!((r / r2, g / g2, b / b2) == (2.0, 1.0, 4.0), "{:?}", corrected.pixel(5, 2));
    let own = read("PRIMARIES= .640 .330 .290 .600 .150 .060 .333 .333\n").expect("a sky");
    assert_ne!(own, plain);
    let wide = read("PRIMARIES= .708 .292 .170 .797 .131 .046 .3127 .3290\n").expect("a sky");
    let [r, g, b] = plain.pixel(7, 1);
    let expected = 1.6605 * r - 0.5876 * g - 0.0728 * b;
    assert!((wide.pixel(7, 1)[0] - expected).abs() < 5e-3, "{:?} for {expected}", wide.pixel(7, 1));
    for (header, words) in [
        ("PRIMARIES=1 2 3\n", "eight numbers"),
        ("PRIMARIES=.3 .3 .4 .4 .2 .2 .33 .33\n", "PRIMARIES"),
        ("COLORCORR=0 1 1\n", "three numbers"),
        ("GAMMA=2.2\n", "linear light"),
        ("FORMAT=8-bit\n", "32-bit_rle_rgbe"),
    ] {
        says(read(header).expect_err(header), &["sky.hdr", words]);
    }
}

#[test]
fn a_file_that_is_too_large_is_not_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("huge.exr");
    let file = std::fs::File::create(&path).expect("a file");
    // It takes no room on the disk.
    file.set_len(10 << 30).expect("a long file");
    let start = std::time::Instant::now();
    says(
        SkyImage::read(&path).expect_err("too large"),
        &["huge.exr", "bytes of the file: 10737418240 is over the limit"],
    );
    assert!(start.elapsed().as_secs_f64() < 1.0, "{:?}", start.elapsed());
}

fn says(error: SkyError, words: &[&str]) {
    let text = error.to_string();
    assert!(words.iter().all(|word| text.contains(word)), "{text:?} without one of {words:?}");
}

fn write_exr(
    path: &Path,
    [width, height]: [usize; 2],
    light: impl Fn(usize, usize) -> (f32, f32, f32) + Sync,
) {
    let pixels = |at: exr::prelude::Vec2<usize>| light(at.x(), at.y());
    exr::prelude::write_rgb_file(path, width, height, |x, y| pixels(exr::prelude::Vec2(x, y)))
        .expect("written");
}
