use exr::prelude::{ReadChannels, ReadLayers};

use super::*;

fn ramp(width: u32, height: u32, scale: f32) -> Picture {
    let rgb = (0..width * height * 3).map(|at| at as f32 * scale).collect();
    Picture { width, height, rgb }
}

#[test]
fn png_holds_the_tone_mapped_bytes() {
    let picture = ramp(7, 5, 0.02);
    let png = picture.to_png(0.5).unwrap();
    let mut reader = png::Decoder::new(Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    assert_eq!(bytes, picture.tone_mapped(0.5));
}

#[test]
fn exr_holds_the_linear_values() {
    let picture = ramp(7, 5, 0.37);
    let exr = picture.to_exr().unwrap();
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size: exr::prelude::Vec2<usize>, _: &exr::prelude::RgbChannels| {
                (size.width(), vec![0.0f32; size.area() * 3])
            },
            |(width, values): &mut (usize, Vec<f32>),
             at: exr::prelude::Vec2<usize>,
             (r, g, b): (f32, f32, f32)| {
                let first = (at.y() * *width + at.x()) * 3;
                values[first..first + 3].copy_from_slice(&[r, g, b]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(exr))
        .unwrap();
    assert_eq!(read.layer_data.channel_data.pixels.1, picture.rgb);
}

#[test]
fn tone_mapping_rises_from_black_to_white() {
    let values: Vec<f32> = (0..600).map(|at| libm::exp2f(at as f32 / 20.0 - 15.0)).collect();
    let picture = Picture { width: 200, height: 1, rgb: values };
    let bytes = picture.tone_mapped(0.0);
    assert!(bytes.windows(2).all(|pair| pair[0] <= pair[1]));
    assert_eq!((bytes[0], bytes[599]), (0, 255));
    let brighter = picture.tone_mapped(1.0);
    assert!(brighter.iter().zip(&bytes).all(|(a, b)| a >= b));
    assert!(brighter != bytes);
}

#[test]
fn auto_exposure_puts_the_brightest_but_one_in_a_hundred_at_its_mark() {
    // Half of the picture is black; a spark outshines the rest.
    let mut rgb = vec![0.0; 200 * 3];
    rgb.extend([0.05; 197 * 3].iter());
    rgb.extend([900.0, 900.0, 900.0, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2]);
    let picture = Picture { width: 400, height: 1, rgb };
    assert!((picture.auto_exposure() - 2.0).abs() < 1e-5, "{}", picture.auto_exposure());
    let dark = Picture { rgb: vec![0.0; 400 * 3], ..picture };
    assert_eq!(dark.auto_exposure(), 0.0);
}

#[test]
fn a_sheet_holds_its_pictures_from_left_to_right() {
    let pictures = [ramp(2, 3, 1.0), ramp(4, 3, 10.0)];
    let sheet = contact_sheet(&pictures, 1).unwrap();
    assert_eq!((sheet.width, sheet.height), (7, 3));
    let row = &sheet.rgb[7 * 3..14 * 3];
    assert_eq!(row[..6], pictures[0].rgb[6..12]);
    assert_eq!(row[6..9], [0.0; 3]);
    assert_eq!(row[9..], pictures[1].rgb[12..24]);
}

#[test]
fn sheets_that_do_not_fit_are_refused() {
    let message = |pictures: &[Picture]| contact_sheet(pictures, 4).unwrap_err().to_string();
    assert_eq!(message(&[]), "contact sheet: no pictures");
    assert!(message(&[ramp(2, 3, 1.0), ramp(2, 4, 1.0)]).contains("picture 1 is 4 pixels high"));
    assert!(message(&vec![ramp(1_000, 1, 1.0); 17]).contains("17064 x 1 pixels"));
    let short = Picture { rgb: vec![0.0; 5], ..ramp(2, 1, 1.0) };
    assert!(message(&[short]).contains("holds 5 values, expected 6"));
}

#[test]
fn a_difference_has_no_sign_and_needs_one_size() {
    let picture = |width, values: &[f32]| Picture { width, height: 1, rgb: values.to_vec() };
    let (a, b) = (picture(1, &[1.0, 2.0, 0.5]), picture(1, &[1.0, 1.5, 1.0]));
    assert_eq!(a.difference(&b, 10.0).expect("one size"), picture(1, &[0.0, 5.0, 5.0]));
    let wider = picture(2, &[0.0; 6]);
    let error = a.difference(&wider, 10.0).expect_err("two sizes").to_string();
    assert!(error.contains("2 x 1") && error.contains("expected 1 x 1"), "{error}");
}

#[test]
fn layers_are_named_channels_of_one_exr() {
    let (light, direct, cover) = (ramp(7, 5, 0.37), ramp(7, 5, 0.5), ramp(7, 5, 0.01));
    let exr = exr_of(&[("", &light), ("direct", &direct)], Some(&cover)).unwrap();
    let read = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let read = read.first_valid_layer().all_attributes().from_buffered(Cursor::new(exr)).unwrap();
    let channels = &read.layer_data.channel_data.list;
    let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["A", "B", "G", "R", "direct.B", "direct.G", "direct.R"]);
    for (channel, (picture, band)) in channels.iter().zip([
        (&cover, 0),
        (&light, 2),
        (&light, 1),
        (&light, 0),
        (&direct, 2),
        (&direct, 1),
        (&direct, 0),
    ]) {
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        assert_eq!(values, picture.rgb.iter().skip(band).step_by(3).copied().collect::<Vec<f32>>());
    }
    let error = exr_of(&[("", &light), ("x", &ramp(5, 7, 1.0))], None).unwrap_err().to_string();
    assert!(error.contains("5 x 7 pixels, expected 7 x 5"), "{error}");
}

#[test]
fn a_png_with_alpha_has_the_colour_of_what_covers() {
    let cover = Picture { width: 3, height: 1, rgb: [[0.0; 3], [0.5; 3], [1.0; 3]].concat() };
    let covered = [[0.0; 3], [0.1, 0.2, 0.3], [0.2, 0.4, 0.6]];
    let png = Picture { rgb: covered.concat(), ..cover }.to_png_with_alpha(1.0, &cover).unwrap();
    let mut reader = png::Decoder::new(Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let rgb = Picture { width: 1, height: 1, rgb: vec![0.2, 0.4, 0.6] }.tone_mapped(1.0);
    let of = |alpha: u8| [rgb[0], rgb[1], rgb[2], alpha];
    assert_eq!(bytes, [[0; 4], of(128), of(255)].concat());
}
