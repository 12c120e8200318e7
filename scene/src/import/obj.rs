//! Wavefront OBJ and MTL to triangles and materials.
//!
//! Read line by line with code of its own rather than by `tobj`: that crate holds a hundred bytes
//! per face, panics on a `Kd` of fewer than three numbers, refuses continued lines, passes NaN
//! vertices on, keeps texture options inside file names, and its errors know no line.

mod digits;
mod library;
mod mtl;
mod parse;
mod polygon;
mod vertex_colors;

use std::path::Path;

use flb_format::text::url::shown_reference;

use self::library::Library;
use self::mtl::{Map, Mtl};
use super::choice::Choice;
use super::error::ImportError;
use super::files::Files;
use super::gltf::Surfaces;
use super::images::{Coverage, Images, MAX_SOFT, soft_share};
use super::soup::{FileFrame, Soup};
use crate::mesh::{AlphaMode, Filter, Material, Texture};

/// Reads the OBJ at `path`, its MTL files and textures.
pub(super) fn import(
    files: &mut Files,
    path: &Path,
    choice: &Choice,
    frame: FileFrame,
    soup: &mut Soup,
) -> Result<Surfaces, ImportError> {
    let parsed = parse::read(files, path, choice, frame, soup)?;
    let library = Library::read(files, &parsed.libraries)?;
    if !parsed.has_usemtl {
        files.warn("no material is used (usemtl); groups and objects are taken for materials".to_owned());
    }
    let mut images = Images::default();
    let mut materials = Vec::with_capacity(parsed.materials.len());
    for (name, without_uv) in parsed.materials.into_iter().zip(parsed.without_uv) {
        materials.push(match library.find(files, &name) {
            Some((mtl, folders)) => Material { name, ..material(files, &mut images, mtl, &folders)? },
            None => {
                if parsed.has_usemtl {
                    files.warn(format!("the material '{name}' is in no MTL file; taken as white and opaque"));
                }
                Material::opaque(name)
            }
        });
        if let Some(material) =
            materials.last().filter(|material| without_uv > 0 && images.differ_in(material))
        {
            let name = &material.name;
            let faces = if without_uv == 1 { "1 face".to_owned() } else { format!("{without_uv} faces") };
            let have = if without_uv == 1 { "has" } else { "have" };
            files.warn(format!(
                "{faces} of the material '{name}' {have} no texture coordinates (vt), which its texture reads: its \
                 first texel is taken"
            ));
        }
    }
    Ok(Surfaces { materials, images: images.images, parts: parsed.parts })
}

/// What an `mtllib` line of an OBJ names.
pub(super) fn library_names(line: &str) -> Option<&str> {
    let (keyword, names) = line.trim().split_once(char::is_whitespace)?;
    (keyword == "mtllib").then(|| names.trim().trim_matches('"'))
}

/// The file that a line of an MTL names, whatever it is of.
pub(super) fn map_name(line: &str) -> Option<String> {
    mtl::map_name(line)
}
/// With its textures, which are looked for in the folders.
fn material(
    files: &mut Files,
    images: &mut Images,
    mtl: &Mtl,
    folders: &[&Path],
) -> Result<Material, ImportError> {
    let mut material = Material::opaque(mtl.name.clone());
    let place = format!("the material '{}'", mtl.name);
    let map = match (&mtl.color_map, &mtl.ambient_map) {
        (None, Some(map)) => {
            files.warn(format!(
                "{place} has no map_Kd; its map_Ka '{}' is taken as its colour",
                shown_reference(&map.file)
            ));
            Some(map)
        }
        (map, _) => map.as_ref(),
    };
    let color = match map {
        Some(map) => images.get_file(files, &map.file, &place, folders)?.map(|image| (map, image)),
        None => None,
    };
    let alpha = match &mtl.alpha_map {
        Some(map) => images.get_file(files, &map.file, &place, folders)?.map(|image| (map, image)),
        None => None,
    };
    material.color_texture = color.map(|(map, image)| texture(map, image));
    // Kd multiplies its image. Exporters write black beside an image that alone is meant.
    let multiplies =
        |diffuse: &[f32; 3]| color.is_none() || (*diffuse != [0.0; 3] && mtl.color_map.is_some());
    if let Some([r, g, b]) = mtl.diffuse.filter(multiplies) {
        material.base_color = [r, g, b, 1.0];
    }
    if alpha.is_some() && mtl.opacity() > 0.0 && mtl.opacity() < 1.0 {
        files.warn(format!(
            "{place} has an image of what is there (map_d): its d or Tr, {}, is not used",
            mtl.opacity()
        ));
    }
    if mtl.opacity() < 1.0 && alpha.is_none() {
        match mtl.opacity() > 0.0 {
            true => {
                material.base_color[3] = mtl.opacity();
                material.alpha_mode = AlphaMode::Blend;
            }
            false => files
                .warn(format!("{place} is 0 opaque (d or Tr), which would leave nothing; taken as opaque")),
        }
    }
    let cut = AlphaMode::Cut { cutoff: 0.5 };
    match (color, alpha) {
        // Exporters name the colour's own RGBA image.
        (Some((color_map, color)), Some((alpha_map, alpha)))
            if color == alpha && alpha_map.channel.is_none() =>
        {
            if images.images[color as usize].has_cut {
                material.alpha_mode = cut;
                if (color_map.scale, color_map.offset) != (alpha_map.scale, alpha_map.offset) {
                    files.warn(format!(
                        "{place}: map_d and map_Kd place one image differently; as map_Kd says"
                    ));
                }
            } else {
                files.warn(format!(
                    "{place}: map_d names its colour image '{}', which has no alpha; taken as opaque",
                    images.images[color as usize].name
                ));
            }
        }
        (_, Some((map, alpha))) => {
            let coverage = match map.channel {
                Some('r') => Coverage::Channel(0),
                Some('g') => Coverage::Channel(1),
                Some('b') => Coverage::Channel(2),
                Some('m') => Coverage::Channel(3),
                Some('l') => Coverage::Luminance,
                _ if images.images[alpha as usize].has_cut => Coverage::Channel(3),
                _ => Coverage::Luminance,
            };
            let image = images.coverage_of(files, alpha, coverage)?;
            if images.images[image as usize].has_cut {
                material.alpha_texture = Some(texture(map, image));
                material.alpha_mode = cut;
            } else {
                files.warn(format!(
                    "{place}: map_d '{}' cuts nothing; taken as opaque",
                    shown_reference(&map.file)
                ));
            }
        }
        (Some((map, color)), None) if images.images[color as usize].has_cut => {
            match soft_share(&images.images[color as usize]) {
                soft if soft > MAX_SOFT => {
                    files.warn(format!(
                        "{place} has no map_d, and the alpha of '{}' is no outline ({:.0} % of it is neither 0 nor 1); \
                         it is not used",
                        shown_reference(&map.file),
                        100.0 * soft
                    ));
                    if material.alpha_mode != AlphaMode::Opaque {
                        // Its d makes it a share, of which that image is no part.
                        let image = images.without_alpha(files, color)?;
                        material.color_texture = Some(texture(map, image));
                    }
                }
                _ => {
                    files.warn(format!(
                        "{place} has no map_d, but '{}' has an alpha channel; it cuts, unless the material is wood",
                        shown_reference(&map.file)
                    ));
                    material.is_alpha_guessed = true;
                    if material.alpha_mode == AlphaMode::Opaque {
                        material.alpha_mode = cut;
                    }
                }
            }
        }
        _ => {}
    }
    Ok(material)
}

/// OBJ places textures by `uv * scale + offset` with v from the last row up; here v runs down from
/// the first: v' = 1 - ((1 - v) * s + o) = v * s + (1 - s - o).
fn texture(map: &Map, image: u32) -> Texture {
    let ([su, sv], [ou, ov]) = (map.scale, map.offset);
    let transform = [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]];
    Texture { image, wrap: [map.wrap; 2], transform, filter: Filter::Linear }
}

#[cfg(test)]
mod tests;
