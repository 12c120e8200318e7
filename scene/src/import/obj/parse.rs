//! The lines of an OBJ: vertices, faces, and which material is on.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::digits::Digits;
use super::polygon::Triangulator;
use super::vertex_colors;
use crate::import::choice::{Choice, labels};
use crate::import::error::{ImportError, quoted};
use crate::import::files::Files;
use crate::import::known::obj as known;
use crate::import::limits;
use crate::import::points::{Points, Stored};
use crate::import::soup::{FileFrame, Soup, Vertex};
use crate::mesh::Part;
use crate::unit::unit_in_comment;

/// What an OBJ says besides its triangles.
#[derive(Default)]
pub(super) struct Parsed {
    /// `mtllib` names in order.
    pub libraries: Vec<String>,
    /// Material names in order of first use; the triangles' materials are indices into it.
    pub materials: Vec<String>,
    /// Whether any `usemtl` was there; otherwise the names are those of groups and objects.
    pub has_usemtl: bool,
    /// Groups and objects that have faces, in order of their first.
    pub parts: Vec<Part>,
    /// Faces with corners without texture coordinates, by material.
    pub without_uv: Vec<u64>,
}

/// Memory of an entry of a table that has just grown, and of the one that it grew from.
const CORNER_BYTES: u64 = 58;

/// One corner of a face: position, texture coordinate and normal by number; `u32::MAX` is none.
type Corner = [u32; 3];

struct Reader<'a> {
    soup: &'a mut Soup,
    frame: FileFrame,
    /// In model space: what an f32 then holds needs no more memory, in any unit of a file.
    positions: Points,
    /// Whether all coordinates of `v` lines are f32s, as in a file whose maker held them so.
    are_f32: bool,
    digits: Digits,
    /// As long as `positions`, or empty where no `v` has a colour; as written.
    colors: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Number in the soup of each corner met so far.
    corners: HashMap<Corner, u32>,
    triangulator: Triangulator,
    parsed: Parsed,
    choice: &'a Choice,
    /// Names of the group and of the object that are on.
    group: String,
    object: String,
    /// The one of the two that came last: the material's name where there is no `usemtl`.
    last_name: String,
    /// The part that is on, once a face has asked for it: its number, and whether it is read.
    part: Option<(u32, bool)>,
    part_numbers: HashMap<[String; 2], (u32, bool)>,
    material: Option<u32>,
    by_name: HashMap<String, u32>,
    /// Unit that a comment tells.
    unit: Option<&'static str>,
    /// Statements that are not read: how often, and why not.
    unread: BTreeMap<String, (u64, &'static str)>,
}

/// Reads the OBJ at `path` into `soup`.
pub(super) fn read(
    files: &mut Files,
    path: &Path,
    choice: &Choice,
    frame: FileFrame,
    soup: &mut Soup,
) -> Result<Parsed, ImportError> {
    let mut reader = Reader {
        soup,
        frame,
        positions: Points::default(),
        are_f32: true,
        digits: Digits::NONE,
        colors: Vec::new(),
        uvs: Vec::new(),
        normals: Vec::new(),
        corners: HashMap::new(),
        triangulator: Triangulator::new(),
        parsed: Parsed::default(),
        choice,
        group: String::new(),
        object: String::new(),
        last_name: String::new(),
        part: None,
        part_numbers: HashMap::new(),
        material: None,
        by_name: HashMap::new(),
        unit: None,
        unread: BTreeMap::new(),
    };
    files.read_lines(path, limits::OBJ_BYTES, &mut |files, number, line| reader.line(files, number, line))?;
    let Reader { positions, colors, uvs, normals, corners, are_f32, digits, .. } = &reader;
    let held_bytes = CORNER_BYTES * corners.len() as u64
        + positions.held_bytes()
        + (size_of::<[f32; 3]>() * (colors.capacity() + normals.capacity())) as u64
        + (size_of::<[f32; 2]>() * uvs.capacity()) as u64;
    files.release(held_bytes);
    if *are_f32 {
        reader.soup.check_steps(files, "the v lines", Stored::F32)?;
    }
    if let Some(step) = digits.step() {
        reader.soup.check_steps(files, "the v lines", Stored::Digits(step * frame.unit_m))?;
    }
    choice.check(&files.file, labels(&reader.parsed.parts))?;
    if !colors.is_empty() {
        vertex_colors::to_light(files, reader.soup);
    }
    if let Some(unit) = reader.unit.filter(|unit| *unit != "m" && !frame.is_unit_stated) {
        files.warn(format!(
            "a comment tells the unit {unit}, and comments are not read: numbers are taken for metres; --unit {unit} \
             takes them for {unit}"
        ));
    }
    for (keyword, (count, why)) in reader.unread {
        let times = if count == 1 { String::new() } else { format!(" ({count} times)") };
        files.warn(format!("{}{times} is not read: {why}", quoted(&keyword)));
    }
    Ok(reader.parsed)
}

impl Reader<'_> {
    fn line(&mut self, files: &mut Files, number: u64, line: &str) -> Result<(), ImportError> {
        let mut words = line.split_whitespace();
        let rest = |keyword: &str| line.trim_start()[keyword.len()..].trim().to_owned();
        match words.next() {
            Some("v") => {
                let (value, count): ([f64; 7], usize) = numbers(files, number, "v", words, 3, None)?;
                let [x, y, z, ..] = value;
                let before = self.positions.len();
                let (point, placed) = ([x, y, z], self.frame.place([x, y, z]));
                if !point.iter().chain(&placed).all(|x| (*x as f32).is_finite()) {
                    let (place, value) = (format!("line {number}, vertex {}", before + 1), point);
                    return Err(ImportError::NotFinite { file: files.file.clone(), place, value });
                }
                files.limit("v lines", before as u64 + 1, limits::VERTICES)?;
                self.positions.push(files, "v lines", placed)?;
                self.digits.add(point);
                self.are_f32 &= point.iter().all(|x| f64::from(*x as f32) == *x);
                // Of four numbers the last is a weight, of six or more the fourth to sixth are a colour.
                if count == 4 && value[3] != 1.0 {
                    self.leave_out("the fourth number of v", "a weight is of curves, not of triangles");
                }
                if count == 5 {
                    self.leave_out(
                        "the fourth and fifth number of v",
                        "they are neither a weight nor a colour",
                    );
                }
                if count == 7 && value[6] != 1.0 {
                    self.leave_out("the seventh number of v", "behind a colour nothing is expected");
                }
                if count >= 6 || !self.colors.is_empty() {
                    while self.colors.len() < before {
                        files.push("colours of v lines", &mut self.colors, [1.0; 3])?;
                    }
                    let color = if count >= 6 { [3, 4, 5].map(|at| value[at] as f32) } else { [1.0; 3] };
                    files.push("colours of v lines", &mut self.colors, color)?;
                }
            }
            // Values that are not finite are dealt with where a corner uses them.
            Some("vt") => {
                let (value, _): ([f64; 2], usize) = numbers(files, number, "vt", words, 1, NO_NUMBER)?;
                push(files, "vt lines", &mut self.uvs, value.map(|x| x as f32))?;
            }
            Some("vn") => {
                let (value, _): ([f64; 3], usize) = numbers(files, number, "vn", words, 3, NO_NUMBER)?;
                push(files, "vn lines", &mut self.normals, value.map(|x| x as f32))?;
            }
            Some("f" | "fo") => self.face(files, number, words)?,
            Some("mtllib") => {
                files.limit("mtllib lines", self.parsed.libraries.len() as u64 + 1, limits::LIBRARIES)?;
                let names = rest("mtllib");
                let place = format!("line {number}, mtllib: bytes of a file's name");
                files.limit(place, names.len() as u64, limits::URI_BYTES)?;
                self.parsed.libraries.push(names);
            }
            Some("usemtl") => {
                // Triangles so far were filed by group, for want of a material.
                self.parsed.has_usemtl = true;
                let name = rest("usemtl");
                let name = files.name(format!("line {number}, usemtl"), &name)?;
                self.material = Some(self.material_number(files, name)?);
            }
            Some(keyword @ ("g" | "o")) => {
                let name = files.name(format!("line {number}, {keyword}"), &rest(keyword))?;
                self.last_name.clone_from(&name);
                if keyword == "o" {
                    // An object has groups of its own.
                    self.group.clear();
                    self.object = name;
                } else {
                    self.group = name;
                }
                self.part = None;
                if !self.parsed.has_usemtl {
                    self.material = None;
                }
            }
            Some("#MRGB") => self.leave_out("#MRGB", "colours of vertices are those after x y z of `v`"),
            Some(comment) if comment.starts_with('#') => {
                self.unit = self.unit.or_else(|| unit_in_comment(line))
            }
            Some(keyword) => {
                if let Some(why) = known::unread(known::OBJ, keyword, "") {
                    self.leave_out(keyword, why);
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Counts something that is not read.
    fn leave_out(&mut self, what: &str, why: &'static str) {
        if let Some((count, _)) = self.unread.get_mut(what) {
            *count += 1;
        } else if self.unread.len() < limits::WARNINGS {
            self.unread.insert(what.to_owned(), (1, why));
        }
    }

    fn material_number(&mut self, files: &Files, name: String) -> Result<u32, ImportError> {
        let name = if name.is_empty() { "default".to_owned() } else { name };
        if let Some(&known) = self.by_name.get(&name) {
            return Ok(known);
        }
        let index = self.parsed.materials.len() as u32;
        files.limit("materials", u64::from(index) + 1, limits::MATERIALS)?;
        self.parsed.materials.push(name.clone());
        self.parsed.without_uv.push(0);
        self.by_name.insert(name, index);
        Ok(index)
    }

    /// Begins the part that is on, if it is not yet; whether its faces are read.
    fn begin_part(&mut self, files: &mut Files) -> Result<bool, ImportError> {
        if let Some((_, is_read)) = self.part {
            return Ok(is_read);
        }
        let key = [self.group.clone(), self.object.clone()];
        let (part, is_read) = match self.part_numbers.get(&key) {
            Some(&known) => known,
            None => {
                let names: Vec<String> = key.iter().filter(|name| !name.is_empty()).cloned().collect();
                let is_read = !self.choice.is_made() || self.choice.means(names.iter().map(String::as_str));
                let bytes = names.iter().map(|name| 2 * name.len() as u64 + 128).sum::<u64>() + 160;
                files.limit("groups", self.part_numbers.len() as u64 + 1, limits::NODE_VISITS)?;
                files.hold("groups", bytes)?;
                let part = (self.parsed.parts.len() as u32, is_read);
                self.parsed.parts.push(Part { names, ..Part::default() });
                self.part_numbers.insert(key, part);
                part
            }
        };
        self.part = Some((part, is_read));
        if is_read {
            self.soup.begin_part(files, part)?;
        }
        Ok(is_read)
    }

    fn face<'w>(
        &mut self,
        files: &mut Files,
        number: u64,
        words: impl Iterator<Item = &'w str>,
    ) -> Result<(), ImportError> {
        let mut corners: Vec<Corner> = Vec::new();
        for word in words.take_while(|word| !word.starts_with('#')) {
            corners.push(self.corner(files, number, word)?);
            if corners.len() as u64 > limits::POLYGON_CORNERS {
                let what = format!("line {number}: corners of a face");
                files.limit(what, corners.len() as u64, limits::POLYGON_CORNERS)?;
            }
        }
        // Some exporters repeat the first corner at the end.
        if corners.len() > 3 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() < 3 {
            files.warn("faces of fewer than 3 corners are ignored".to_owned());
            return Ok(());
        }
        if !self.begin_part(files)? {
            return Ok(());
        }
        let material = match self.material {
            Some(material) => material,
            None => {
                let material = self.material_number(files, self.last_name.clone())?;
                *self.material.insert(material)
            }
        };
        self.parsed.without_uv[material as usize] +=
            u64::from(corners.iter().any(|corner| corner[1] == u32::MAX));
        let mut vertices = Vec::with_capacity(corners.len());
        for &corner in &corners {
            vertices.push(self.vertex(files, corner)?);
        }
        let points: Vec<[f64; 3]> = corners.iter().map(|c| self.positions.get(c[0] as usize)).collect();
        for triangle in self.triangulator.triangulate(&points).as_chunks::<3>().0 {
            self.soup.push_triangle(files, triangle.map(|corner| vertices[corner as usize]), material)?;
        }
        if self.triangulator.work > limits::POLYGON_WORK {
            let what = format!("line {number}: corners of concave faces, squared");
            files.limit(what, self.triangulator.work, limits::POLYGON_WORK)?;
        }
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`; numbers from 1, or from -1 backwards.
    fn corner(&self, files: &Files, number: u64, word: &str) -> Result<Corner, ImportError> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let names = ["v", "vt", "vn"];
        let mut corner = [u32::MAX; 3];
        let mut parts = word.split('/');
        for ((slot, count), name) in corner.iter_mut().zip(counts).zip(names) {
            let part = parts.next().unwrap_or("");
            if part.is_empty() && name != "v" {
                continue;
            }
            let index = part.parse::<i64>().ok().and_then(|index| match index {
                1.. => Some(index - 1),
                ..0 => Some(count as i64 + index),
                0 => None,
            });
            match index.filter(|index| (0..count as i64).contains(index)) {
                Some(index) => *slot = index as u32,
                None => {
                    let place = format!("line {number}, face corner '{word}'");
                    let expected = format!("1..={count} or -{count}..=-1 ({name} so far)");
                    return Err(files.malformed(place, format!("{name} '{part}'"), expected));
                }
            }
        }
        Ok(corner)
    }

    fn vertex(&mut self, files: &mut Files, corner: Corner) -> Result<u32, ImportError> {
        if let Some(&known) = self.corners.get(&corner) {
            return Ok(known);
        }
        let [at, uv, normal] = corner.map(|index| index as usize);
        // OBJ counts v upwards from the image's last row.
        let uv = self.uvs.get(uv).map_or([0.0; 2], |&[u, v]| [u, 1.0 - v]);
        let normal = self.normals.get(normal).map_or([0.0; 3], |normal| normal.map(f64::from));
        let normal = self.frame.turn(normal);
        if !normal.iter().all(|x| x.is_finite()) {
            files.warn(
                "normals that are not numbers were left out; those of the triangles stand for them"
                    .to_owned(),
            );
        }
        let color = self.colors.get(at).map(|&[r, g, b]| [r, g, b, 1.0]);
        let vertex = Vertex { position: self.positions.get(at), normal, uv, color };
        let place = || format!("vertex {}", at + 1);
        let vertex = self.soup.push_vertex(files, vertex, place)?;
        files.hold("corners of faces", CORNER_BYTES)?;
        self.corners.insert(corner, vertex);
        Ok(vertex)
    }
}

/// What stands for a word that is no number in a normal or a texture coordinate: the shape does not depend on them, and
/// exporters write what they cannot divide in the words of their C library (`-1.#IND`, `nan(ind)`).
const NO_NUMBER: Option<f64> = Some(f64::NAN);

/// The first `N` numbers of a line, of which `needed` have to be there, and how many are there; the rest is 0.
/// `instead` stands for a word that is no number, which is an error without it among those that are needed, and the end
/// behind them.
fn numbers<'w, const N: usize>(
    files: &Files,
    number: u64,
    keyword: &str,
    words: impl Iterator<Item = &'w str>,
    needed: usize,
    instead: Option<f64>,
) -> Result<([f64; N], usize), ImportError> {
    let mut values = [0.0; N];
    let mut count = 0;
    for (value, word) in values.iter_mut().zip(words.take_while(|word| !word.starts_with('#'))) {
        *value = match word.parse().ok().or(instead) {
            Some(parsed) => parsed,
            None if count >= needed => break,
            None => {
                let place = format!("line {number}, {keyword}");
                return Err(files.malformed(place, format!("'{word}'"), "a number"));
            }
        };
        count += 1;
    }
    if count < needed {
        let place = format!("line {number}, {keyword}");
        return Err(files.malformed(place, format!("{count} numbers"), format!("at least {needed}")));
    }
    Ok((values, count))
}

fn push<T>(files: &mut Files, what: &str, values: &mut Vec<T>, value: T) -> Result<(), ImportError> {
    files.limit(what, values.len() as u64 + 1, limits::VERTICES)?;
    files.push(what, values, value)
}
