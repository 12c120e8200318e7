//! MTL: the colour, opacity and textures of OBJ materials, as exporters write them, with options
//! before file names, spaces in file names, and unknown statements.

use std::path::Path;

use crate::import::error::{ImportError, quoted};
use crate::import::files::{Files, name_of};
use crate::import::known::obj as known;
use crate::import::limits;
use crate::mesh::Wrap;

/// One `newmtl`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mtl {
    /// Name as written.
    pub name: String,
    /// `Kd`, linear.
    pub diffuse: Option<[f32; 3]>,
    /// `d`, or 1 - `Tr`.
    pub opacity: f32,
    /// `map_Kd`.
    pub color_map: Option<Map>,
    /// `map_Ka`, which counts where there is no `map_Kd`.
    pub ambient_map: Option<Map>,
    /// `map_d`, also written `map_opacity`, `map_Tr`.
    pub alpha_map: Option<Map>,
}

/// A texture statement.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Map {
    /// File name as written.
    pub file: String,
    /// `-o u v w`.
    pub offset: [f32; 2],
    /// `-s u v w`.
    pub scale: [f32; 2],
    /// `-clamp on`.
    pub wrap: Wrap,
    /// `-imfchan`: r, g, b, m (matte, the alpha channel), l (luminance) or z.
    pub channel: Option<char>,
}

/// Adds the materials of a file of at most `most_bytes`; its length.
pub(super) fn read(
    files: &mut Files,
    path: &Path,
    most_bytes: u64,
    materials: &mut Vec<Mtl>,
) -> Result<u64, ImportError> {
    let file = name_of(path);
    files.read_lines(path, most_bytes, &mut |files, _, line| parse_line(files, &file, line, materials))
}

fn parse_line(
    files: &mut Files,
    file: &str,
    line: &str,
    materials: &mut Vec<Mtl>,
) -> Result<(), ImportError> {
    let line = line.trim();
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    if keyword.is_empty() || keyword.starts_with('#') {
        return Ok(());
    }
    if keyword == "newmtl" {
        files.limit("materials", materials.len() as u64 + 1, limits::MATERIALS)?;
        let name = files.name("newmtl", rest)?;
        let (diffuse, color_map, ambient_map, alpha_map) = (None, None, None, None);
        materials.push(Mtl { name, diffuse, opacity: 1.0, color_map, ambient_map, alpha_map });
        return Ok(());
    }
    let Some(material) = materials.last_mut() else { return Ok(()) };
    let number =
        || rest.split_whitespace().find_map(|word| word.parse::<f32>().ok()).filter(|x| x.is_finite());
    match keyword.to_ascii_lowercase().as_str() {
        "kd" => material.diffuse = color(rest),
        "d" => material.opacity = number().unwrap_or(material.opacity),
        "tr" => material.opacity = number().map_or(material.opacity, |transparency| 1.0 - transparency),
        "map_kd" => material.color_map = parse_map(rest),
        "map_ka" => material.ambient_map = parse_map(rest),
        "map_d" | "map_opacity" | "map_tr" => material.alpha_map = parse_map(rest),
        lower => {
            if let Some(why) = known::unread(known::MTL, lower, rest) {
                files.warn(format!("{} ({}) is not read: {why}", quoted(keyword), quoted(file)));
            }
        }
    }
    Ok(())
}

/// `r g b` or `r`; other ways (`spectral`, `xyz`) are left out.
fn color(rest: &str) -> Option<[f32; 3]> {
    let mut values = rest.split_whitespace().map(|word| word.parse::<f32>().ok().filter(|x| x.is_finite()));
    let red = values.next()??;
    let green = values.next().flatten().unwrap_or(red);
    let blue = values.next().flatten().unwrap_or(red);
    Some([red, green, blue])
}

/// `[options] file name with spaces`.
fn parse_map(rest: &str) -> Option<Map> {
    let mut map =
        Map { file: String::new(), offset: [0.0; 2], scale: [1.0; 2], wrap: Wrap::Repeat, channel: None };
    let mut rest = rest;
    while let Some((option, after)) = take_word(rest).filter(|(word, _)| is_option(word)) {
        rest = after;
        match option {
            "-o" | "-s" | "-t" => {
                let values = take_numbers(&mut rest, 3);
                let target = match option {
                    "-o" => Some(&mut map.offset),
                    "-s" => Some(&mut map.scale),
                    _ => None,
                };
                if let Some(target) = target {
                    target.iter_mut().zip(values).for_each(|(old, value)| *old = value);
                }
            }
            "-mm" => drop(take_numbers(&mut rest, 2)),
            "-bm" | "-boost" | "-texres" => drop(take_numbers(&mut rest, 1)),
            _ => {
                let Some((value, after)) = take_word(rest) else { break };
                rest = after;
                match option {
                    "-clamp" if value.eq_ignore_ascii_case("on") => map.wrap = Wrap::Clamp,
                    "-imfchan" => map.channel = value.chars().next().map(|c| c.to_ascii_lowercase()),
                    _ => {}
                }
            }
        }
    }
    map.file = rest.trim().trim_matches('"').to_owned();
    (!map.file.is_empty()).then_some(map)
}

/// The file that a line names: a texture that is read, or one of bumps, of gloss, of whatever else.
pub(super) fn map_name(line: &str) -> Option<String> {
    const OTHERS: [&str; 5] = ["bump", "disp", "decal", "refl", "norm"];
    let (keyword, rest) = line.trim().split_once(char::is_whitespace)?;
    let keyword = keyword.to_ascii_lowercase();
    let names_one = keyword.starts_with("map_") || OTHERS.contains(&keyword.as_str());
    Some(parse_map(rest.trim()).filter(|_| names_one)?.file)
}

fn is_option(word: &str) -> bool {
    const OPTIONS: [&str; 13] = [
        "-o", "-s", "-t", "-mm", "-bm", "-boost", "-texres", "-blendu", "-blendv", "-cc", "-clamp",
        "-imfchan", "-type",
    ];
    OPTIONS.contains(&word)
}

fn take_word(text: &str) -> Option<(&str, &str)> {
    let text = text.trim_start();
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    (end > 0).then(|| text.split_at(end))
}

/// Up to `most` numbers. A word that is the last one is the file's name even if it is a number.
fn take_numbers(rest: &mut &str, most: usize) -> Vec<f32> {
    let mut values = Vec::new();
    while values.len() < most {
        let Some((word, after)) = take_word(rest).filter(|(_, after)| !after.trim().is_empty()) else {
            break;
        };
        let Some(value) = word.parse::<f32>().ok().filter(|x| x.is_finite()) else { break };
        values.push(value);
        *rest = after;
    }
    values
}
