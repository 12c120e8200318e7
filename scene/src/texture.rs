//! Texture coordinates to colour: bilinear between texel centres, in linear light, or the nearest texel where the file
//! asks for it. What alpha cuts away is
//! asked of [`crate::alpha`], so that a picture cuts a leaf where the medium was cut.

use crate::mesh::{Filter, Image, Material, Texture, Wrap};
use glam::Vec3;

/// sRGB byte to linear light (IEC 61966-2-1), for all 256 of them.
pub struct SrgbTable(pub [f32; 256]);

impl SrgbTable {
    /// Computes it.
    #[allow(clippy::new_without_default, reason = "a table, not a setting")]
    pub fn new() -> Self {
        SrgbTable(std::array::from_fn(|byte| linear(byte as f64 / 255.0) as f32))
    }
}

/// sRGB value, 0 to 1, to linear light (IEC 61966-2-1).
pub fn linear(srgb: f64) -> f64 {
    if srgb <= 0.04045 { srgb / 12.92 } else { libm::pow((srgb + 0.055) / 1.055, 2.4) }
}

/// Linear colour of a material at texture coordinates.
pub fn color(material: &Material, images: &[Image], table: &SrgbTable, uv: [f32; 2]) -> Vec3 {
    let [r, g, b, _] = material.base_color;
    let tint = Vec3::new(r, g, b);
    let image = material.color_texture.and_then(|t| Some((t, images.get(t.image as usize)?)));
    let Some((texture, image)) = image.filter(|(_, i)| i.width > 0 && i.height > 0) else {
        return tint;
    };
    if texture.filter == Filter::Nearest {
        let [r, g, b, _] = nearest(&texture, image, uv).map(|byte| table.0[byte as usize]);
        return tint * Vec3::new(r, g, b);
    }
    let [u, v] = transformed(&texture, uv);
    let x = u * f64::from(image.width) - 0.5;
    let y = v * f64::from(image.height) - 0.5;
    let (x0, y0) = (floor_to_i64(x), floor_to_i64(y));
    let (fx, fy) = ((x - x0 as f64) as f32, (y - y0 as f64) as f32);
    let at = |dx: i64, dy: i64| {
        let x = wrapped(x0 + dx, image.width, texture.wrap[0]);
        let y = wrapped(y0 + dy, image.height, texture.wrap[1]);
        let [r, g, b, _] = texel(image, x, y);
        Vec3::new(table.0[r as usize], table.0[g as usize], table.0[b as usize])
    };
    let top = at(0, 0) * (1.0 - fx) + at(1, 0) * fx;
    let bottom = at(0, 1) * (1.0 - fx) + at(1, 1) * fx;
    tint * (top * (1.0 - fy) + bottom * fy)
}

/// The texel that is nearest to texture coordinates.
pub fn nearest(texture: &Texture, image: &Image, uv: [f32; 2]) -> [u8; 4] {
    if image.width == 0 || image.height == 0 {
        return [255; 4];
    }
    let [x, y] = nearest_place(texture, image, uv);
    texel(image, x as usize, y as usize)
}

/// Column and row of the texel that is nearest to texture coordinates, of an image that has texels.
pub(crate) fn nearest_place(texture: &Texture, image: &Image, uv: [f32; 2]) -> [u32; 2] {
    let [u, v] = transformed(texture, uv);
    let x = wrapped(floor_to_i64(u * f64::from(image.width)), image.width, texture.wrap[0]);
    let y = wrapped(floor_to_i64(v * f64::from(image.height)), image.height, texture.wrap[1]);
    [x as u32, y as u32]
}

/// KHR_texture_transform applied.
fn transformed(texture: &Texture, uv: [f32; 2]) -> [f64; 2] {
    let [u, v] = uv.map(f64::from);
    texture.transform.map(|[a, b, c]| f64::from(a) * u + f64::from(b) * v + f64::from(c))
}

/// The texel that stands for texel `at` of an axis with `count` texels.
fn wrapped(at: i64, count: u32, wrap: Wrap) -> usize {
    let count = i64::from(count);
    let index = match wrap {
        Wrap::Repeat => at.rem_euclid(count),
        Wrap::Clamp => at.clamp(0, count - 1),
        Wrap::Mirror => {
            let pair = at.rem_euclid(2 * count);
            if pair < count { pair } else { 2 * count - 1 - pair }
        }
    };
    index as usize
}

/// Floor, kept far from overflow: coordinates of any finite size are allowed.
fn floor_to_i64(value: f64) -> i64 {
    value.floor().clamp(-1e15, 1e15) as i64
}

fn texel(image: &Image, x: usize, y: usize) -> [u8; 4] {
    let at = (y * image.width as usize + x) * 4;
    match image.rgba.get(at..at + 4) {
        Some(&[r, g, b, a]) => [r, g, b, a],
        _ => [255; 4],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::identity;

    #[test]
    fn colours_are_mixed_or_those_of_the_nearest_texel() {
        let rgba = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]].concat();
        let images = [Image { name: String::new(), width: 3, height: 1, rgba, has_cut: false }];
        let at = |filter: Filter, wrap: Wrap, u: f32| {
            let texture = Texture { filter, ..identity(0, wrap) };
            let material = Material { color_texture: Some(texture), ..Material::opaque("palette") };
            color(&material, &images, &SrgbTable::new(), [u, 0.5]).to_array()
        };
        assert_eq!(at(Filter::Linear, Wrap::Repeat, 1.0 / 3.0), [0.5, 0.5, 0.0]);
        assert_eq!(at(Filter::Nearest, Wrap::Repeat, 0.333), [1.0, 0.0, 0.0]);
        assert_eq!(at(Filter::Nearest, Wrap::Repeat, 0.334), [0.0, 1.0, 0.0]);
        assert_eq!(at(Filter::Nearest, Wrap::Clamp, 7.0), [0.0, 0.0, 1.0]);
        assert_eq!(at(Filter::Nearest, Wrap::Repeat, -0.1), [0.0, 0.0, 1.0]);
    }
}
