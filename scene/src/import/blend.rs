//! Texture coordinates for surfaces that are there in part, the same part everywhere, and that have no image, or one
//! point of it: a dither asks where on the surface it is.

use std::collections::{BTreeMap, HashMap};

use super::soup::area;
use crate::mesh::{AlphaMode, Filter, Image, Material, Mesh, Texture, Wrap};
use crate::texture;

/// From a point to texture coordinates, in turns over the longest edge of the mesh: two directions that lie along no
/// axis, so that neither a wall nor a level leaf falls on a line.
const TURNS: [[f32; 3]; 2] = [[16.0, 5.07, 8.49], [4.33, 15.7, -9.79]];

/// A triangle that takes up less of an image than this, in texels of the dither, is there or not as a whole, whatever
/// share its alpha is.
const FEW_TEXELS: f64 = 16.0;

/// Texels along an edge of an image, at least, as the dither counts them.
const MIN_EDGE: u32 = 128;

/// Most points of images that one material shows by itself, as palettes do. More are a surface in small triangles,
/// over which the dither is even again.
const MAX_POINTS: usize = 256;

const AS_THEY_ARE: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Least share of a material's area that shows single points, for it to be so meant.
const MIN_SHARE: f64 = 0.05;

/// Gives triangles whose alpha is a share, and that show one point of an image, as those of palettes do, materials of
/// their own with the colour and the alpha of that point.
pub(super) fn split_points(mesh: &mut Mesh) {
    let shown = |material: &Material| material.alpha_texture.or(material.color_texture);
    let is_share = |material: &Material| material.alpha_mode == AlphaMode::Blend && shown(material).is_some();
    if !mesh.materials.iter().any(is_share) {
        return;
    }
    let mut found: BTreeMap<u32, Shown> = BTreeMap::new();
    for triangle in 0..mesh.triangles.len() as u32 {
        let index = mesh.triangle_material[triangle as usize];
        let material = &mesh.materials[index as usize];
        let Some(texture) = shown(material).filter(|_| is_share(material)) else { continue };
        let corners = mesh.corners_m(triangle as usize);
        let (of_it, area_m2) = (found.entry(index).or_default(), area(corners));
        of_it.area_m2 += area_m2;
        of_it.triangles += 1;
        if of_it.points.len() > MAX_POINTS || texels_of(mesh, texture, triangle) >= FEW_TEXELS {
            continue;
        }
        let point = point_of(mesh, material, triangle);
        // Of what is there as a whole, or not at all, each triangle is.
        if (0.001..0.999).contains(&(material.base_color[3] * f32::from(point.alpha) / 255.0)) {
            of_it.points_m2 += area_m2;
            of_it.points.entry(point).or_default().push(triangle);
        }
    }
    for (index, Shown { points, triangles, area_m2, points_m2 }) in found {
        if points.len() > MAX_POINTS || points_m2 < MIN_SHARE * area_m2 {
            continue;
        }
        // A material that shows nothing else becomes that of its last point.
        let mut left = triangles;
        for (point, triangles) in points {
            left -= triangles.len();
            let image = even_image(mesh, point.alpha);
            let material = mesh.materials[index as usize].clone();
            let alpha =
                Texture { image, wrap: [Wrap::Repeat; 2], transform: AS_THEY_ARE, filter: Filter::Nearest };
            let color_texture = material.color_texture.map(|texture| {
                let image = &mesh.images[texture.image as usize];
                let at = |axis: usize, edge: u32| (point.texel[axis] as f32 + 0.5) / edge as f32;
                let transform = [[0.0, 0.0, at(0, image.width)], [0.0, 0.0, at(1, image.height)]];
                Texture { transform, ..texture }
            });
            let material = Material { color_texture, alpha_texture: Some(alpha), ..material };
            let number = if left == 0 { index } else { mesh.materials.len() as u32 };
            match mesh.materials.get_mut(number as usize) {
                Some(whole) => *whole = material,
                None => mesh.materials.push(material),
            }
            triangles.iter().for_each(|&triangle| mesh.triangle_material[triangle as usize] = number);
        }
    }
}

/// What triangles of a material show of its images.
#[derive(Default)]
struct Shown {
    points: BTreeMap<Point, Vec<u32>>,
    triangles: usize,
    area_m2: f64,
    points_m2: f64,
}

/// A texel of the colour's image, and the alpha of all images there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Point {
    texel: [u32; 2],
    alpha: u8,
}

/// The point that the middle of a triangle shows.
fn point_of(mesh: &Mesh, material: &Material, triangle: u32) -> Point {
    let corners = mesh.triangles[triangle as usize].map(|vertex| mesh.uvs[vertex as usize]);
    let middle = [0, 1].map(|axis| corners.iter().map(|uv| uv[axis]).sum::<f32>() / 3.0);
    let alpha_in = |texture: Option<Texture>| {
        let found = texture.and_then(|texture| Some((texture, mesh.images.get(texture.image as usize)?)));
        found.map_or(255, |(texture, image)| u32::from(texture::nearest(&texture, image, middle)[3]))
    };
    let alpha = (alpha_in(material.color_texture) * alpha_in(material.alpha_texture) + 127) / 255;
    let texel = material.color_texture.and_then(|texture| {
        Some(texture::nearest_place(&texture, mesh.images.get(texture.image as usize)?, middle))
    });
    Point { texel: texel.unwrap_or_default(), alpha: alpha as u8 }
}

/// Area of a triangle in texels of the dither.
fn texels_of(mesh: &Mesh, texture: Texture, triangle: u32) -> f64 {
    let Some(image) = mesh.images.get(texture.image as usize) else { return f64::INFINITY };
    let edges = [image.width, image.height].map(|edge| f64::from(edge.max(MIN_EDGE)));
    let [a, b, c] = mesh.triangles[triangle as usize].map(|vertex| {
        let [u, v] = mesh.uvs[vertex as usize].map(f64::from);
        let placed = texture.transform.map(|[p, q, _]| f64::from(p) * u + f64::from(q) * v);
        [placed[0] * edges[0], placed[1] * edges[1]]
    });
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
}

/// An image of one texel with that alpha.
fn even_image(mesh: &mut Mesh, alpha: u8) -> u32 {
    let rgba = vec![255, 255, 255, alpha];
    let is_it = |image: &Image| image.has_cut && (image.width, image.height) == (1, 1) && image.rgba == rgba;
    let found = mesh.images.iter().position(is_it);
    found.unwrap_or_else(|| {
        // It decides even where it is whole: the factor of the material multiplies it.
        let name = format!("alpha {alpha} of 255");
        mesh.images.push(Image { name, width: 1, height: 1, rgba, has_cut: true });
        mesh.images.len() - 1
    }) as u32
}

/// Whether all of a material's surface has one colour and one alpha, so that its texture coordinates may be any.
fn is_even(mesh: &Mesh, material: &Material) -> bool {
    let one_texel = |texture: Texture| {
        let image = mesh.images.get(texture.image as usize);
        texture.transform == AS_THEY_ARE && image.is_some_and(|image| (image.width, image.height) == (1, 1))
    };
    let one_point = |texture: Texture| texture.transform.iter().all(|[u, v, _]| [*u, *v] == [0.0; 2]);
    match (material.color_texture, material.alpha_texture) {
        (None, None) => true,
        (color, Some(alpha)) => one_texel(alpha) && color.is_none_or(one_point),
        (Some(_), None) => false,
    }
}

/// Gives their vertices texture coordinates by where they stand; those that another material shares are doubled.
pub(super) fn place_blends(mut mesh: Mesh) -> Mesh {
    let is_placed: Vec<bool> = mesh
        .materials
        .iter()
        .map(|material| material.alpha_mode == AlphaMode::Blend && is_even(&mesh, material))
        .collect();
    if !is_placed.contains(&true) {
        return mesh;
    }
    let Some(bounds) = mesh.bounds() else { return mesh };
    let longest =
        (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(f64::MIN_POSITIVE, f64::max) as f32;
    let is_of = |triangle: usize| is_placed[mesh.triangle_material[triangle] as usize];
    let mut is_shared = vec![false; mesh.positions.len()];
    for triangle in (0..mesh.triangles.len()).filter(|&triangle| !is_of(triangle)) {
        mesh.triangles[triangle].iter().for_each(|&vertex| is_shared[vertex as usize] = true);
    }
    let mut doubles: HashMap<u32, u32> = HashMap::new();
    for triangle in
        (0..mesh.triangles.len()).filter(|&triangle| is_placed[mesh.triangle_material[triangle] as usize])
    {
        for corner in 0..3 {
            let vertex = mesh.triangles[triangle][corner];
            let vertex = match is_shared[vertex as usize] {
                true => *doubles.entry(vertex).or_insert_with(|| {
                    mesh.positions.push(mesh.positions[vertex as usize]);
                    mesh.normals.push(mesh.normals[vertex as usize]);
                    mesh.uvs.push([0.0; 2]);
                    if !mesh.colors.is_empty() {
                        mesh.colors.push(mesh.colors[vertex as usize]);
                    }
                    is_shared.push(false);
                    mesh.positions.len() as u32 - 1
                }),
                false => vertex,
            };
            mesh.triangles[triangle][corner] = vertex;
            let point = mesh.positions[vertex as usize];
            mesh.uvs[vertex as usize] =
                TURNS.map(|row| (0..3).map(|axis| row[axis] * (point[axis] / longest)).sum());
        }
    }
    mesh
}
