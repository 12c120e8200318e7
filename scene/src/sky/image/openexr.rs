//! Skies of OpenEXR files: the data window is placed in the display window, which is the sphere. What the file does not
//! hold of that is black.

use std::io::Cursor;

use exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds, Text};
use exr::prelude::{ReadChannels, ReadLayers, Vec2};

use super::{Faults, Raw};
use crate::sky::primaries::{self, ToSrgb};

/// Attributes that name a colour space, for want of chromaticities.
const SPACES: [&str; 2] = ["colorInteropID", "oiio:ColorSpace"];

pub(super) fn read(bytes: &[u8], faults: &Faults) -> Result<Raw, super::SkyError> {
    let damaged = |error: exr::error::Error| faults.damaged(error.to_string());
    let meta = exr::meta::MetaData::read_from_buffered(bytes, false).map_err(damaged)?;
    for header in &meta.headers {
        let (window, data) = (header.shared_attributes.display_window, header.layer_size);
        faults.check_size(window.size.width(), window.size.height())?;
        faults.check_most(data.width(), data.height())?;
    }
    let names_of = |header: &exr::meta::header::Header| -> Vec<String> {
        header.channels.list.iter().map(|channel| channel.name.to_string()).collect()
    };
    let has_colors =
        |names: &Vec<String>| ["R", "G", "B"].iter().all(|band| names.iter().any(|name| name == band));
    if !meta.headers.iter().map(names_of).any(|names| has_colors(&names)) {
        let found: Vec<String> = meta.headers.iter().flat_map(names_of).collect();
        return Err(faults.header(&format!("channels {}", found.join(", ")), "channels R, G and B"));
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0_f32; 3]; size.area()]),
            |(width, pixels): &mut (usize, Vec<[f32; 3]>), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(damaged)?;
    let window = image.attributes.display_window;
    let data = IntegerBounds::new(image.layer_data.attributes.layer_position, image.layer_data.size);
    let attributes = [&image.attributes.other, &image.layer_data.attributes.other];
    let named = || {
        SPACES.into_iter().find_map(|attribute| {
            let found = attributes.iter().find_map(|found| found.get(&Text::from(attribute)));
            let Some(AttributeValue::Text(space)) = found else { return None };
            primaries::of_name(&space.to_string()).map(|found| (found, attribute))
        })
    };
    let to_srgb = match &image.attributes.chromaticities {
        Some(found) => faults.to_srgb(&primaries(found), "chromaticities")?,
        None => match named() {
            Some((found, attribute)) => faults.to_srgb(&found, attribute)?,
            None => ToSrgb::SAME,
        },
    };
    let pixels = image.layer_data.channel_data.pixels.1;
    let size = [window.size.width(), window.size.height()];
    let pixels = if data == window { pixels } else { placed(&pixels, data, window) };
    Ok(Raw { size, pixels, to_srgb })
}

fn primaries(Chromaticities { red, green, blue, white }: &Chromaticities) -> [[f64; 2]; 4] {
    [red, green, blue, white].map(|Vec2(x, y)| [f64::from(*x), f64::from(*y)])
}

/// Pixels of one window where they lie in another.
fn placed(pixels: &[[f32; 3]], data: IntegerBounds, window: IntegerBounds) -> Vec<[f32; 3]> {
    let width = window.size.width();
    let mut whole = vec![[0.0; 3]; window.size.area()];
    // Wide enough for any two corners of 32 bits.
    let from =
        |axis: fn(&Vec2<i32>) -> i32| i64::from(axis(&data.position)) - i64::from(axis(&window.position));
    let [left, top] = [from(|at| at.0), from(|at| at.1)];
    for (row, line) in (0..).zip(pixels.chunks_exact(data.size.width())) {
        let y = top + row;
        if !(0..window.size.height() as i64).contains(&y) {
            continue;
        }
        for (column, pixel) in (0..).zip(line) {
            let x = left + column;
            if (0..width as i64).contains(&x) {
                whole[y as usize * width + x as usize] = *pixel;
            }
        }
    }
    whole
}
