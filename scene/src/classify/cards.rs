//! Materials that are called wood and look like leaves: cards of whole twigs, which exporters call branches, cut by
//! alpha and of a colour that bark has not. And what is green, though nothing else says that it is leaf.

use glam::{DVec3, Vec3};

use crate::alpha::Coverage;
use crate::color::mean_colors;
use crate::mesh::{AlphaMode, Mesh};
use crate::rays::{points, uv};
use crate::sampling::on_triangle;
use crate::texture::{SrgbTable, color};

/// Share of the area that alpha cuts away of such cards, at least.
const MIN_CUT: f64 = 1.0 / 3.0;
/// Linear light that bark throws back of its brightest colour, at most, in the mean of what is left.
const MAX_BARK: f64 = 0.45;
/// The most that bark has, as ratios of linear light: green over red, blue over red, blue over green, red over green.
const MAX_RATIOS: [f64; 4] = [1.1, 1.2, 1.15, 5.0];
/// Green over red and over blue, at least, of what is green.
const MIN_GREEN: f32 = 1.2;
/// Least over largest of red, green and blue in what is white or light grey, which programs write where a material has
/// no colour.
const GREY: f32 = 0.9;
/// Least blue over green of bark that leaves in autumn have not.
const MIN_BLUE: f32 = 0.3;
/// Triangles that are looked at, and points of each.
const LOOKED_AT: usize = 1024;
const POINTS: u32 = 16;

/// The share that alpha cuts away of a material, where it is much and the rest has no colour of bark.
pub(super) fn cut_of_leaves(mesh: &Mesh, material: usize) -> Option<f64> {
    let of = &mesh.materials[material];
    if of.alpha_mode == AlphaMode::Opaque {
        return None;
    }
    let coverage = Coverage::of(mesh, material).ok().filter(|coverage| *coverage != Coverage::Full)?;
    let is_its = |triangle: &usize| mesh.triangle_material[*triangle] as usize == material;
    let triangles: Vec<usize> = (0..mesh.triangles.len()).filter(is_its).collect();
    let table = SrgbTable::new();
    let (mut all, mut left, mut sum) = (0.0, 0.0, DVec3::ZERO);
    for &triangle in triangles.iter().step_by(triangles.len().div_ceil(LOOKED_AT).max(1)) {
        let [a, b, c] = points(mesh, triangle).map(|point| point.as_dvec3());
        let share = (b - a).cross(c - a).length();
        for point in 0..POINTS {
            let weights = on_triangle(triangle as u32, point);
            let uv = uv(mesh, triangle, weights);
            all += share;
            if coverage.present_at(uv) {
                left += share;
                let color = color(of, &mesh.images, &table, uv) * mesh.vertex_color(triangle, weights);
                sum += color.as_dvec3() * share;
            }
        }
    }
    (left > 0.0 && left < (1.0 - MIN_CUT) * all && !is_of_bark(sum / left)).then(|| 1.0 - left / all)
}

/// Colour of a material, as far as it tells leaf from wood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Hue {
    /// White, light grey or a dull yellow, or not asked for: it tells nothing.
    Unclear,
    /// Brown or grey.
    Bark,
    /// Green.
    Green,
    /// Of flowers, fruit, pots, and of leaves in autumn.
    Other,
}

/// Per material, the hue of what alpha leaves in the mean, where it is `asked` for.
pub(super) fn hues(mesh: &Mesh, asked: &[bool]) -> Vec<Hue> {
    if !asked.contains(&true) {
        return vec![Hue::Unclear; asked.len()];
    }
    let seen = |(material, &is_asked): (usize, &bool)| match is_asked {
        true => Coverage::of(mesh, material).unwrap_or(Coverage::Full),
        false => Coverage::Nothing,
    };
    let colors = mean_colors(mesh, &asked.iter().enumerate().map(seen).collect::<Vec<_>>());
    let hue = |color: Vec3| match color {
        color
            if color.max_element() > MAX_BARK as f32 && color.min_element() >= GREY * color.max_element() =>
        {
            Hue::Unclear
        }
        color if color.y > 0.0 && color.y >= MIN_GREEN * color.x.max(color.z) => Hue::Green,
        color if is_of_bark(color.as_dvec3()) && color.z < MIN_BLUE * color.y => Hue::Unclear,
        color if is_of_bark(color.as_dvec3()) => Hue::Bark,
        _ => Hue::Other,
    };
    asked
        .iter()
        .zip(colors)
        .map(|(&is_asked, color)| if is_asked { hue(color) } else { Hue::Unclear })
        .collect()
}

/// Whether a linear colour can be that of bark: grey or brown, and not white. Leaves and blossom are green, bluish,
/// pink, yellow or of a full red.
fn is_of_bark(color: DVec3) -> bool {
    let DVec3 { x: red, y: green, z: blue } = color;
    let pairs = [[green, red], [blue, red], [blue, green], [red, green]];
    color.max_element() <= MAX_BARK
        && pairs.into_iter().zip(MAX_RATIOS).all(|([over, under], most)| over <= most * under)
}
