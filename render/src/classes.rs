//! What a plant is taken for, as a picture: four views from its sides and from above, each class in a colour of its
//! own.
//!
//! ```text
//! mesh, class per material -class_views-> front | right
//!                                         back  | above
//! ```

use flb_scene::rays::{Ray, RayMesh};
use flb_scene::{MaterialClass, Mesh};
use glam::Vec3;
use rayon::prelude::*;

use crate::RenderError;

/// Colour of leaves, sRGB.
pub const LEAF: [u8; 3] = [72, 160, 64];
/// Colour of wood, sRGB.
pub const WOOD: [u8; 3] = [139, 90, 43];
/// Colour of what is neither leaf nor wood, sRGB.
pub const NEITHER: [u8; 3] = [150, 150, 160];
/// Colour of triangles that no rule decides, sRGB.
pub const UNDECIDED: [u8; 3] = [150, 50, 200];
/// Colour of triangles where alpha leaves nothing, and nothing is behind, sRGB.
pub const CUT: [u8; 3] = [255, 190, 215];
/// Colour of the empty background, sRGB.
pub const EMPTY: [u8; 3] = [255, 255, 255];

/// Rays a pixel along each axis.
const SAMPLES: u32 = 2;

/// Space around the plant, as a share of its longest edge.
const MARGIN: f32 = 0.03;

/// Right, up and towards the eye, of each view.
const VIEWS: [[Vec3; 3]; 4] = [
    [Vec3::X, Vec3::Y, Vec3::Z],
    [Vec3::NEG_Z, Vec3::Y, Vec3::X],
    [Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z],
    [Vec3::X, Vec3::NEG_Z, Vec3::Y],
];

/// 8-bit sRGB of `2 edge` by `2 edge` pixels, `[y][x][band]`: a parallel view from the front (+z), from the right (+x),
/// from the back, and from above. `classes` has an entry a material, `None` for an undecided one.
///
/// # Errors
/// Of [`RayMesh::new`].
pub fn class_views(
    mesh: &Mesh,
    classes: &[Option<MaterialClass>],
    edge: u32,
) -> Result<Vec<u8>, RenderError> {
    if classes.len() != mesh.materials.len() {
        return Err(RenderError::Classes { found: classes.len(), expected: mesh.materials.len() });
    }
    let present = RayMesh::new(mesh, false)?;
    let whole = RayMesh::new(mesh, true)?;
    let middle = 0.5 * (present.min + present.max);
    let longest = (present.max - present.min).max_element().max(f32::MIN_POSITIVE) * (1.0 + 2.0 * MARGIN);
    let seen = |[right, up, back]: [Vec3; 3], x: f32, y: f32| {
        let origin = middle + right * (x * longest) + up * (y * longest) + back * (2.0 * longest);
        let ray = Ray { origin, direction: -back };
        match present.find(ray, f32::INFINITY, None) {
            Some(hit) => {
                let material = mesh.triangle_material[hit.triangle as usize] as usize;
                let facing = present.front(hit.triangle).map_or(1.0, |normal| normal.dot(back).abs());
                shaded(color_of(classes[material]), facing)
            }
            None if whole.find(ray, f32::INFINITY, None).is_some() => CUT.map(f32::from),
            None => EMPTY.map(f32::from),
        }
    };
    let pixel = |at: usize| {
        let (column, row) = (at as u32 % (2 * edge), at as u32 / (2 * edge));
        let view = VIEWS[(2 * (row / edge) + column / edge) as usize];
        let mut sum = [0.0f32; 3];
        for sample in 0..SAMPLES * SAMPLES {
            let along = |at: u32, sample: u32| {
                ((at % edge) as f32 + (sample as f32 + 0.5) / SAMPLES as f32) / edge as f32 - 0.5
            };
            let color = seen(view, along(column, sample % SAMPLES), -along(row, sample / SAMPLES));
            sum.iter_mut().zip(color).for_each(|(sum, value)| *sum += value);
        }
        sum.map(|sum| (sum / (SAMPLES * SAMPLES) as f32 + 0.5) as u8)
    };
    let pixels = (2 * edge as usize) * (2 * edge as usize);
    Ok((0..pixels).into_par_iter().map(pixel).collect::<Vec<_>>().concat())
}

fn color_of(class: Option<MaterialClass>) -> [u8; 3] {
    match class {
        Some(MaterialClass::Leaf) => LEAF,
        Some(MaterialClass::Wood) => WOOD,
        Some(MaterialClass::Neither) => NEITHER,
        None => UNDECIDED,
    }
}

/// Darker where the surface turns away, so that its shape is seen.
fn shaded(color: [u8; 3], facing: f32) -> [f32; 3] {
    color.map(|value| f32::from(value) * (0.55 + 0.45 * facing))
}

#[cfg(test)]
mod tests {
    use flb_scene::mesh::Material;

    use super::*;

    /// A leaf on the left and, nearer to the front, a stem on the right; above both a card of which nothing is left.
    fn plant() -> Mesh {
        let square = |x: f32, y: f32, z: f32| {
            [
                [x, y, z],
                [x + 1.0, y, z],
                [x + 1.0, y + 1.0, z],
                [x, y, z],
                [x + 1.0, y + 1.0, z],
                [x, y + 1.0, z],
            ]
        };
        let positions = [square(0.0, 0.0, 0.0), square(1.0, 0.0, 0.5), square(0.0, 1.0, 0.0)].concat();
        let mut cut = Material::opaque("cut");
        cut.alpha_mode = flb_scene::mesh::AlphaMode::Cut { cutoff: 0.5 };
        cut.base_color[3] = 0.0;
        Mesh {
            normals: vec![[0.0, 0.0, 1.0]; positions.len()],
            uvs: vec![[0.0; 2]; positions.len()],
            triangles: (0..6).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            triangle_material: vec![0, 0, 1, 1, 2, 2],
            positions,
            materials: vec![Material::opaque("leaf"), Material::opaque("stem"), cut],
            ..Mesh::default()
        }
    }

    #[test]
    fn each_class_has_its_colour_from_the_front_and_the_back() {
        const EDGE: u32 = 32;
        let classes = [Some(MaterialClass::Leaf), None, Some(MaterialClass::Leaf)];
        let picture = class_views(&plant(), &classes, EDGE).expect("a sound mesh");
        let at = |x: u32, y: u32| {
            let first = ((y * 2 * EDGE + x) * 3) as usize;
            [picture[first], picture[first + 1], picture[first + 2]]
        };
        assert_eq!([at(8, 24), at(24, 24), at(8, 8), at(24, 8)], [LEAF, UNDECIDED, CUT, EMPTY]);
        assert_eq!([at(8, 24 + EDGE), at(24, 24 + EDGE)], [UNDECIDED, LEAF], "from the back");
        let error = class_views(&plant(), &classes[..2], EDGE).expect_err("a class is missing");
        assert!(error.to_string().contains('2') && error.to_string().contains('3'), "{error}");
    }
}
