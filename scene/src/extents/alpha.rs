//! Whether alpha cuts what it is meant to cut: not all of a material, not a trunk by a map of gloss, and leaves by
//! their outline.

use std::collections::BTreeMap;

use super::Doubt;
use crate::alpha::Coverage;
use crate::import::{MAX_SOFT, area, soft_share};
use crate::mesh::{AlphaMode, Image, Material};
use crate::rays::uv;
use crate::sampling::on_triangle;
use crate::texture::nearest;
use crate::{ClassedMesh, MaterialClass, Mesh};

/// Alpha that leaves less than this share of a material is doubted: cards of needles keep several hundredths.
const MIN_LEFT: f64 = 0.01;
/// Triangles of a material that are looked at first, and points of each: most plants show enough there.
const LOOKED_AT: usize = 1024;
const POINTS: u32 = 16;
/// An outline of leaves cuts this share of their cards at least.
const MIN_OUTSIDE: f64 = 0.15;
/// Alpha at which an outline is taken that its material does not use.
const CUTOFF: f32 = 0.5;

/// Edge of an image that has a border, texels.
const MIN_EDGE: usize = 16;
/// Share of the border's texels that are flat where it is a background's.
const MIN_BORDER: f64 = 0.97;
/// Difference of a flat colour from black or white, of 255.
const NOISE: u8 = 12;
/// A material that shows more than this of its background shows nothing else: white is its colour.
const MAX_BACKGROUND: f64 = 0.95;

/// Doubts of that kind. `triangles` are those of each material of leaf or wood.
pub(super) fn doubts(plant: &ClassedMesh, triangles: &[Vec<u32>]) -> Vec<Doubt> {
    let used = triangles.iter().enumerate().filter(|(_, of_it)| !of_it.is_empty());
    let found = used
        .filter_map(|(index, triangles)| of_material(&plant.mesh, index, plant.classes[index], triangles));
    // Of a material that was split by the alpha of its vertices one is told, of all its parts.
    let mut cut_away: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    let mut doubts = Vec::new();
    for doubt in found {
        match doubt {
            Doubt::CutAway { material, area_m2, left } => {
                let sums = cut_away.entry(material).or_default();
                *sums = [sums[0] + area_m2, sums[1] + left * area_m2];
            }
            other => doubts.push(other),
        }
    }
    let told = |(material, [area_m2, left_m2]): (String, [f64; 2])| Doubt::CutAway {
        material,
        area_m2,
        left: left_m2 / area_m2,
    };
    cut_away.into_iter().map(told).chain(doubts).collect()
}

fn of_material(mesh: &Mesh, index: usize, class: MaterialClass, triangles: &[u32]) -> Option<Doubt> {
    let material = &mesh.materials[index];
    if material.alpha_mode == AlphaMode::Opaque {
        return (class == MaterialClass::Leaf)
            .then(|| uncut(mesh, material, triangles).or_else(|| background(mesh, material, triangles)))?;
    }
    let coverage = Coverage::of(mesh, index).ok().filter(|coverage| *coverage != Coverage::Full)?;
    cut_away(mesh, material, &coverage, triangles)
        .or_else(|| (class == MaterialClass::Wood).then(|| gloss(mesh, material, &coverage, triangles))?)
}

/// Whether alpha leaves next to nothing: by all texels of an image, or by those that triangles show.
fn cut_away(mesh: &Mesh, material: &Material, coverage: &Coverage, triangles: &[u32]) -> Option<Doubt> {
    let [left_m2, area_m2] = left_of(mesh, coverage, some(triangles));
    if left_m2 >= MIN_LEFT * area_m2 {
        return None;
    }
    let [left_m2, area_m2] = left_of(mesh, coverage, triangles.iter().copied());
    (area_m2 > 0.0 && left_m2 < MIN_LEFT * area_m2).then(|| Doubt::CutAway {
        material: material.name.clone(),
        area_m2,
        left: left_m2 / area_m2,
    })
}

/// Whether wood is cut by a channel that is no outline.
fn gloss(mesh: &Mesh, material: &Material, coverage: &Coverage, triangles: &[u32]) -> Option<Doubt> {
    let image = image_of(mesh, material).filter(|image| image.has_cut && soft_share(image) > MAX_SOFT)?;
    let [left_m2, area_m2] = left_of(mesh, coverage, some(triangles));
    let cut = 1.0 - left_m2 / area_m2;
    // Of one point of an image that image is told, which its maker knows.
    let of_color = material.color_texture.and_then(|texture| mesh.images.get(texture.image as usize));
    let told = of_color.filter(|_| (image.width, image.height) == (1, 1)).unwrap_or(image);
    (cut >= MIN_OUTSIDE).then(|| Doubt::WoodCut {
        material: material.name.clone(),
        image: told.name.clone(),
        cut,
    })
}

/// Whether leaves are whole though their image has an outline.
fn uncut(mesh: &Mesh, material: &Material, triangles: &[u32]) -> Option<Doubt> {
    let image = image_of(mesh, material).filter(|image| image.has_cut && soft_share(image) <= MAX_SOFT)?;
    let cut = Material { alpha_mode: AlphaMode::Cut { cutoff: CUTOFF }, ..material.clone() };
    let coverage = Coverage::of_material(mesh, &cut).ok()?;
    let [left_m2, area_m2] = left_of(mesh, &coverage, some(triangles));
    let outside = 1.0 - left_m2 / area_m2;
    (outside >= MIN_OUTSIDE).then(|| Doubt::Uncut {
        material: material.name.clone(),
        image: image.name.clone(),
        outside,
    })
}

/// Whether leaves show the background of an image that lost its alpha: flat black or white all around its border.
fn background(mesh: &Mesh, material: &Material, triangles: &[u32]) -> Option<Doubt> {
    let texture = material.color_texture?;
    let image = mesh.images.get(texture.image as usize).filter(|image| !image.has_cut)?;
    let [width, height] = [image.width as usize, image.height as usize];
    if width < MIN_EDGE || height < MIN_EDGE {
        return None;
    }
    let rgb = |x: usize, y: usize| [0, 1, 2].map(|band| image.rgba[4 * (y * width + x) + band]);
    let border = (0..width).flat_map(|x| [(x, 0), (x, height - 1)]);
    let border = border.chain((0..height).flat_map(|y| [(0, y), (width - 1, y)]));
    let (black, white, all) = border.fold((0, 0, 0), |(black, white, all), (x, y)| {
        let color = rgb(x, y);
        (black + usize::from(is_flat(color, 0)), white + usize::from(is_flat(color, u8::MAX)), all + 1)
    });
    let flat = if black > white { 0 } else { u8::MAX };
    if (black.max(white) as f64) < MIN_BORDER * all as f64 {
        return None;
    }
    let (mut shown, mut looked) = (0.0, 0.0);
    for triangle in some(triangles) {
        let shows = |point: &u32| {
            let [r, g, b, _] =
                nearest(&texture, image, uv(mesh, triangle as usize, on_triangle(triangle, *point)));
            is_flat([r, g, b], flat)
        };
        let area_m2 = area(mesh.corners_m(triangle as usize));
        shown += area_m2 * (0..POINTS).filter(shows).count() as f64 / f64::from(POINTS);
        looked += area_m2;
    }
    let share = shown / looked;
    (MIN_OUTSIDE..=MAX_BACKGROUND).contains(&share).then(|| Doubt::Background {
        material: material.name.clone(),
        image: image.name.clone(),
        share,
    })
}

/// Whether a colour is black (0) or white (255), but for the noise of JPEG.
fn is_flat(rgb: [u8; 3], flat: u8) -> bool {
    rgb.iter().all(|value| value.abs_diff(flat) <= NOISE)
}

fn image_of<'m>(mesh: &'m Mesh, material: &Material) -> Option<&'m Image> {
    mesh.images.get(material.alpha_texture.or(material.color_texture)?.image as usize)
}

/// Some of many triangles, even over their list.
pub(super) fn some(triangles: &[u32]) -> impl Iterator<Item = u32> + '_ {
    triangles.iter().copied().step_by(triangles.len().div_ceil(LOOKED_AT).max(1))
}

/// Area of triangles that is there, and of all of them, square metres.
fn left_of(mesh: &Mesh, coverage: &Coverage, triangles: impl Iterator<Item = u32>) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for triangle in triangles {
        let corners = mesh.triangles[triangle as usize].map(|vertex| vertex as usize);
        let uvs = corners.map(|vertex| mesh.uvs.get(vertex).copied().unwrap_or_default());
        let is_there = |point: &u32| {
            let [u, v] = on_triangle(triangle, *point);
            let weights = [1.0 - u - v, u, v];
            coverage.present_at([0, 1].map(|axis| (0..3).map(|k| weights[k] * uvs[k][axis]).sum()))
        };
        let share = (0..POINTS).filter(is_there).count() as f64 / f64::from(POINTS);
        let area_m2 = area(mesh.corners_m(triangle as usize));
        sums[0] += share * area_m2;
        sums[1] += area_m2;
    }
    sums
}
