//! MTL: the colour, opacity and textures of OBJ materials, as exporters write them, with options
//! before file names, spaces in file names, and unknown statements.

use std::path::Path;

use crate::import::error::{ImportError, quoted};
use crate::import::files::{Files, name_of};
use crate::import::known::obj as known;
use crate::import::limits;
use crate::mesh::Wrap;

/// Opacities by `d` and by `Tr` that differ by no more are one.
const SAME_OPACITY: f32 = 1e-3;

/// One `newmtl`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mtl {
    /// Name as written.
    pub name: String,
    /// `Kd`, linear.
    pub diffuse: Option<[f32; 3]>,
    /// Opacity by `d` and by `Tr`, which is 1 less it, each with the line that says it.
    pub opacities: [Option<(f32, u64)>; 2],
    /// `map_Kd`.
    pub color_map: Option<Map>,
    /// `map_Ka`, which counts where there is no `map_Kd`.
    pub ambient_map: Option<Map>,
    /// `map_d`, also written `map_opacity`, `map_Tr`.
    pub alpha_map: Option<Map>,
}

impl Mtl {
    /// Opacity by `d`, else by `Tr`, else 1.
    pub(super) fn opacity(&self) -> f32 {
        self.opacities.into_iter().flatten().next().map_or(1.0, |(opacity, _)| opacity)
    }
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
    /// Options that would change brightness or shape of what is seen.
    pub unread: Vec<&'static str>,
}

/// Adds the materials of a file of at most `most_bytes`; its length.
pub(super) fn read(
    files: &mut Files,
    path: &Path,
    most_bytes: u64,
    materials: &mut Vec<Mtl>,
) -> Result<u64, ImportError> {
    let file = name_of(path);
    files.read_lines(path, most_bytes, &mut |files, number, line| {
        parse_line(files, &Place { file: &file, number }, line, materials)
    })
}

/// A line of a file.
struct Place<'a> {
    file: &'a str,
    number: u64,
}

fn parse_line(
    files: &mut Files,
    place: &Place,
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
        materials.push(Mtl { name, diffuse, opacities: [None; 2], color_map, ambient_map, alpha_map });
        return Ok(());
    }
    let Some(material) = materials.last_mut() else { return Ok(()) };
    let number =
        || rest.split_whitespace().find_map(|word| word.parse::<f32>().ok()).filter(|x| x.is_finite());
    match keyword.to_ascii_lowercase().as_str() {
        "kd" => {
            material.diffuse = color(rest);
            if material.diffuse.is_none() {
                warn_of_value(files, place, keyword, rest, "three numbers; the material stays without it");
            }
        }
        "d" | "tr" => match number() {
            Some(found) => {
                let is_d = keyword.eq_ignore_ascii_case("d");
                let opacity = if is_d { found } else { 1.0 - found };
                material.opacities[usize::from(!is_d)] = Some((opacity, place.number));
                warn_of_contradiction(files, place.file, material.opacities);
            }
            None => warn_of_value(files, place, keyword, rest, "a number; the material stays without it"),
        },
        "map_kd" => material.color_map = read_map(files, place, keyword, rest),
        "map_ka" => material.ambient_map = read_map(files, place, keyword, rest),
        "map_d" | "map_opacity" | "map_tr" => {
            if keyword.eq_ignore_ascii_case("map_tr") {
                let (file, line) = (quoted(place.file), place.number);
                files.warn(format!(
                    "{file}, line {line}: map_Tr is read as map_d is: white is there, black is cut away"
                ));
            }
            material.alpha_map = read_map(files, place, keyword, rest);
        }
        lower => {
            if let Some(why) = known::unread(known::MTL, lower, rest) {
                files.warn(format!("{} ({}) is not read: {why}", quoted(keyword), quoted(place.file)));
            }
        }
    }
    Ok(())
}

/// An opacity by `d` and another by `Tr`. Some exporters write the same number for both, and mean `d`.
fn warn_of_contradiction(files: &mut Files, file: &str, opacities: [Option<(f32, u64)>; 2]) {
    if let [Some((by_d, line_of_d)), Some((by_tr, line_of_tr))] = opacities
        && (by_d - by_tr).abs() > SAME_OPACITY
    {
        files.warn(format!(
            "{}: d in line {line_of_d} says an opacity of {by_d}, Tr in line {line_of_tr} one of {by_tr}: d is taken",
            quoted(file)
        ));
    }
}

/// A statement whose value is of a form that is not read: another way to write a colour (`spectral`, `xyz`), or what
/// the exporter's language made of a number (`0,5`).
fn warn_of_value(files: &mut Files, place: &Place, keyword: &str, rest: &str, expected: &str) {
    let Place { file, number } = place;
    let (file, keyword, rest) = (quoted(file), quoted(keyword), quoted(rest));
    files.warn(format!("line {number} of {file}, {keyword}: found '{rest}', expected {expected}"));
}

/// `r g b` or `r`; `None` for other ways (`spectral`, `xyz`).
fn color(rest: &str) -> Option<[f32; 3]> {
    let words = rest.split_whitespace().take_while(|word| !word.starts_with('#')).take(3);
    let values: Option<Vec<f32>> =
        words.map(|word| word.parse::<f32>().ok().filter(|x| x.is_finite())).collect();
    let values = values?;
    let red = *values.first()?;
    Some([red, values.get(1).copied().unwrap_or(red), values.get(2).copied().unwrap_or(red)])
}

/// A texture; warns of options that would change what is seen of it.
fn read_map(files: &mut Files, place: &Place, keyword: &str, rest: &str) -> Option<Map> {
    let mut map = parse_map(rest);
    let is_alpha = !keyword.to_ascii_lowercase().starts_with("map_k");
    if let Some(map) =
        map.as_mut().filter(|map| map.channel.is_some_and(|channel| !is_alpha || channel == 'z'))
    {
        map.unread.push("-imfchan");
    }
    if let Some(options) = map.as_ref().map(|map| &map.unread).filter(|options| !options.is_empty()) {
        let (file, keyword, options) = (quoted(place.file), quoted(keyword), quoted(&options.join(", ")));
        files.warn(format!("{options} of {keyword} ({file}) is not read: the texture is taken as it is"));
    }
    map
}

/// `[options] file name with spaces`.
fn parse_map(rest: &str) -> Option<Map> {
    let mut map = Map {
        file: String::new(),
        offset: [0.0; 2],
        scale: [1.0; 2],
        wrap: Wrap::Repeat,
        channel: None,
        unread: Vec::new(),
    };
    let mut rest = rest;
    while let Some((option, after)) = take_word(rest).filter(|(word, _)| is_option(word)) {
        rest = after;
        match option {
            "-o" | "-s" | "-t" => {
                let values = take_numbers(&mut rest, 3);
                let target = match option {
                    "-o" => &mut map.offset,
                    "-s" => &mut map.scale,
                    _ if values.iter().all(|value| *value == 0.0) => continue,
                    _ => {
                        map.unread.push("-t");
                        continue;
                    }
                };
                target.iter_mut().zip(values).for_each(|(old, value)| *old = value);
            }
            "-mm" => {
                let values = take_numbers(&mut rest, 2);
                if values.iter().zip([0.0, 1.0]).any(|(value, nothing)| *value != nothing) {
                    map.unread.push("-mm");
                }
            }
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
