//! One material that serves several things becomes several: an atlas for trunk and leaves, a texture that lets light
//! through in places, vertices that are more or less there.
//!
//! ```text
//! triangles with material, part and colours -split-> materials of one kind each; parts with what they use
//! ```
//!
//! A part tells by its names whether it is leaf or wood; it has a say where the names of a material and of its texture
//! have none. What is decided here depends on the file and on [`ImportSettings`](crate::ImportSettings) alone, so that
//! a renderer that reads the mesh again finds the same materials.

use std::collections::{BTreeMap, HashMap};

use super::blend::split_points;
use super::error::ImportError;
use super::files::Files;
use super::limits;
use super::soup::{Finished, area};
use super::split_patterns::SplitPatterns;
use super::things::{Things, told_of_material, told_of_part};
use super::uses;
use crate::MaterialClass;
use crate::classify::words::{Told, is_of_several};
use crate::mesh::{AlphaMode, Image, Material, Mesh, Part, Texture};
use crate::rays::uv;
use crate::sampling::on_triangle;
use crate::texture;

/// Points of a triangle at which a texture of what passes is read.
const POINTS: u32 = 16;

/// Mean shares that pass below this are nothing: the border of what is opaque in an image.
const MIN_PASSING: f64 = 0.02;

/// Steps of the alpha of vertices.
const ALPHA_LEVELS: f32 = 32.0;

/// What tells triangles of one material apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Key {
    material: u32,
    /// What the names of the part say; the same for all where the material itself says something.
    told: u8,
    /// Which patterns of parts are met, a bit each.
    patterns: u64,
    /// Whether the texture of what passes lets some light through.
    passes: bool,
    /// Of the vertices, over [`ALPHA_LEVELS`].
    alpha: u8,
}

/// Sums over the triangles of a key, where a texture tells what passes.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    area_m2: f64,
    /// Area times what passes.
    passing_m2: f64,
    /// The same times its colour.
    tinted_m2: [f64; 3],
}

/// Splits materials, and fills in what each part uses. `parts` are those of `finished`.
pub(super) fn split(
    files: &Files,
    finished: Finished,
    materials: Vec<Material>,
    mut parts: Vec<Part>,
    patterns: &SplitPatterns,
) -> Result<Mesh, ImportError> {
    let Finished { mut mesh, triangle_part, alphas, mut lent } = finished;
    let mut tells = Tells::of(&mesh, &materials, &parts, &triangle_part);
    lent.retain(|lent| {
        let index = mesh.triangle_material[lent.triangle as usize];
        let mut of = |part: u32| {
            tells.about((index, &materials[index as usize]), (part, parts.get(part as usize)), patterns)
        };
        of(triangle_part[lent.triangle as usize]) == of(lent.part)
    });
    let mut sums: BTreeMap<Key, Sums> = BTreeMap::new();
    let mut distinct: Vec<Key> = Vec::new();
    let mut places: HashMap<Key, u32> = HashMap::new();
    // Of the triangle before, where its material and part alone tell it: most triangles are as the one before them.
    let mut last: Option<(u32, u32, u32)> = None;
    let mut slots = std::mem::take(&mut mesh.triangle_material);
    for (triangle, slot) in slots.iter_mut().enumerate() {
        let (index, part) = (*slot, triangle_part.get(triangle).copied().unwrap_or(0));
        if let Some((_, _, place)) = last.filter(|(known, of, _)| (*known, *of) == (index, part)) {
            *slot = place;
            continue;
        }
        let material = &materials[index as usize];
        let (told, patterns) = tells.about((index, material), (part, parts.get(part as usize)), patterns);
        let corners = mesh.triangles[triangle].map(|vertex| vertex as usize);
        let means = |texture| mean_of(&mesh, texture, triangle);
        let share = material.passing_texture.map(|texture| means(texture)[3]);
        let tint = material.passing_color_texture.map(means);
        let acts = !alphas.is_empty() && material.alpha_mode != AlphaMode::Opaque;
        let alpha = if acts { corners.iter().map(|&vertex| alphas[vertex]).sum::<f32>() / 3.0 } else { 1.0 };
        let key = Key {
            material: index,
            told,
            patterns,
            passes: share.is_none_or(|share| share >= MIN_PASSING),
            alpha: (alpha * ALPHA_LEVELS + 0.5) as u8,
        };
        let sum = sums.entry(key).or_default();
        if share.is_some() || tint.is_some() {
            let share = share.unwrap_or(1.0);
            let area_m2 = area(mesh.corners_m(triangle));
            sum.area_m2 += area_m2;
            sum.passing_m2 += area_m2 * share;
            let tint = tint.unwrap_or([1.0; 4]);
            sum.tinted_m2 = std::array::from_fn(|band| sum.tinted_m2[band] + area_m2 * share * tint[band]);
        }
        let place = *places.entry(key).or_insert_with(|| {
            distinct.push(key);
            distinct.len() as u32 - 1
        });
        *slot = place;
        last = (share.is_none() && tint.is_none() && !acts).then_some((index, part, place));
    }
    // Materials without triangles stay, at their place.
    for material in 0..materials.len() as u32 {
        if sums
            .range(Key { material, told: 0, patterns: 0, passes: false, alpha: 0 }..)
            .next()
            .map(|(key, _)| key.material)
            != Some(material)
        {
            let key = Key { material, told: 0, patterns: 0, passes: true, alpha: ALPHA_LEVELS as u8 };
            sums.insert(key, Sums::default());
        }
    }
    files.limit("materials, split by what they serve", sums.len() as u64, limits::MATERIALS)?;
    let number: BTreeMap<Key, u32> = sums.keys().copied().zip(0..).collect();
    let all = sums.iter().map(|(key, sums)| {
        let material = of_key(&materials[key.material as usize], key, sums, &mesh.images);
        let is_told_by_parts = key.told != 0 && tells.is_shared[key.material as usize];
        Material { is_told_by_parts, ..material }
    });
    mesh.materials = all.collect();
    let numbers: Vec<u32> = distinct.iter().map(|key| number[key]).collect();
    slots.iter_mut().for_each(|slot| *slot = numbers[*slot as usize]);
    mesh.triangle_material = slots;
    split_points(&mut mesh);
    files.limit("materials, split by what they show", mesh.materials.len() as u64, limits::MATERIALS)?;
    uses::fill(&mesh, &triangle_part, &lent, &mut parts);
    parts.retain(|part| part.uses.iter().any(|used| used.triangles > 0));
    mesh.parts = parts;
    Ok(mesh)
}

fn of_key(material: &Material, key: &Key, sums: &Sums, images: &[Image]) -> Material {
    let mut material = material.clone();
    if material.passing_texture.take().is_some() && sums.area_m2 > 0.0 {
        let mean = if key.passes { (sums.passing_m2 / sums.area_m2) as f32 } else { 0.0 };
        material.diffuse_transmission = material.diffuse_transmission.map(|factor| factor * mean);
    }
    if material.passing_color_texture.take().is_some() && sums.passing_m2 > 0.0 {
        let mean = sums.tinted_m2.map(|tinted| (tinted / sums.passing_m2) as f32);
        let factor = material.transmission_color.unwrap_or([1.0; 3]);
        material.transmission_color = Some(std::array::from_fn(|band| factor[band] * mean[band]));
    }
    material.base_color[3] *= f32::from(key.alpha) / ALPHA_LEVELS;
    let cuts = |texture: Texture| images.get(texture.image as usize).is_some_and(|image| image.has_cut);
    let is_whole = match material.alpha_mode {
        AlphaMode::Opaque => true,
        AlphaMode::Cut { cutoff } => material.base_color[3] >= cutoff,
        AlphaMode::Blend => material.base_color[3] >= 1.0,
    };
    if is_whole && ![material.color_texture, material.alpha_texture].into_iter().flatten().any(cuts) {
        material.alpha_mode = AlphaMode::Opaque;
        material.base_color[3] = 1.0;
    }
    material
}

/// Per material and part: what the part's names say where the material's do not, and which patterns it meets.
struct Tells {
    by_itself: Vec<Option<Told>>,
    /// Materials that are an atlas by their name, and that parts of leaf and parts of wood wear.
    is_shared: Vec<bool>,
    by_part: Vec<u8>,
    things: Things,
    known: HashMap<(u32, u32), (u8, u64)>,
}

impl Tells {
    fn of(mesh: &Mesh, materials: &[Material], parts: &[Part], triangle_part: &[u32]) -> Tells {
        let by_itself: Vec<Option<Told>> =
            materials.iter().map(|material| told_of_material(&mesh.images, material)).collect();
        let by_part: Vec<u8> =
            parts.iter().map(|part| told_of_part(part).map_or(0, |(told, _)| code(&told))).collect();
        let is_atlas: Vec<bool> = materials.iter().map(|material| is_of_several(&material.name)).collect();
        let mut worn_by = vec![[false; 2]; materials.len()];
        if is_atlas.contains(&true) {
            for (&part, &material) in triangle_part.iter().zip(&mesh.triangle_material) {
                if let Some(class @ 1..=2) = by_part.get(part as usize) {
                    worn_by[material as usize][usize::from(*class) - 1] = true;
                }
            }
        }
        let used = || {
            let mut used: Vec<Vec<u32>> = vec![Vec::new(); parts.len()];
            for (&part, &material) in triangle_part.iter().zip(&mesh.triangle_material) {
                let used = &mut used[part as usize];
                if !used.contains(&material) {
                    used.push(material);
                }
            }
            used
        };
        Tells {
            things: Things::of(&by_itself, parts, used),
            by_itself,
            is_shared: is_atlas
                .iter()
                .zip(worn_by)
                .map(|(&is_atlas, by)| is_atlas && by == [true; 2])
                .collect(),
            by_part,
            known: HashMap::new(),
        }
    }

    fn about(
        &mut self,
        material: (u32, &Material),
        part: (u32, Option<&Part>),
        patterns: &SplitPatterns,
    ) -> (u8, u64) {
        let Some(found) = part.1 else { return (0, 0) };
        let (by_itself, is_shared) = (&self.by_itself, &self.is_shared);
        let (by_part, things) = (&self.by_part, &self.things);
        *self.known.entry((material.0, part.0)).or_insert_with(|| {
            let told = match by_itself[material.0 as usize] {
                Some(Told::Class(..)) if is_shared[material.0 as usize] || things.has(part.0) => {
                    by_part[part.0 as usize]
                }
                Some(_) => 0,
                None => by_part[part.0 as usize],
            };
            (told, patterns.met(&material.1.name, found))
        })
    }
}

fn code(told: &Told) -> u8 {
    match told {
        Told::Class(MaterialClass::Leaf, _) => 1,
        Told::Class(..) => 2,
        Told::Foreign(_) => 3,
        Told::Both(_) | Told::Unsure(_) | Told::Nothing => 0,
    }
}

/// Means over a triangle of a texture: linear R, G and B, and alpha, 0 to 1.
fn mean_of(mesh: &Mesh, texture: Texture, triangle: usize) -> [f64; 4] {
    let Some(image) = mesh.images.get(texture.image as usize) else { return [1.0; 4] };
    let mut sums = [0.0f64; 4];
    for point in 0..POINTS {
        let uv = uv(mesh, triangle, on_triangle(triangle as u32, point));
        let [r, g, b, alpha] = texture::nearest(&texture, image, uv).map(|value| f64::from(value) / 255.0);
        let values = [texture::linear(r), texture::linear(g), texture::linear(b), alpha];
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
    }
    sums.map(|sum| sum / f64::from(POINTS))
}
