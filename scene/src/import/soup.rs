//! Collects triangles from a file and makes a [`Mesh`] of them: model space, no degenerate or
//! coincident triangles, every vertex used, every normal of unit length.

use super::error::ImportError;
use super::files::Files;
use super::limits;
use super::points::{Points, Reach, Stored, check_steps};
use crate::mesh::Mesh;

/// Axis of an input that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Up {
    /// Up is +Y, as in glTF.
    Y,
    /// Up is +Z, as in many modelling programs: (x, y, z) becomes (x, z, -y).
    Z,
}

impl Up {
    /// The word of files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Up::Y => "y",
            Up::Z => "z",
        }
    }
}

/// From the file's axes and units to model space.
#[derive(Debug, Clone, Copy)]
pub(super) struct FileFrame {
    /// Axis that points up in the file.
    pub up: Up,
    /// Metres per unit of the file.
    pub unit_m: f64,
    /// Whether the unit was stated, and is not the default.
    pub is_unit_stated: bool,
}

impl FileFrame {
    /// A point of the file in model space.
    pub(super) fn place(&self, point: [f64; 3]) -> [f64; 3] {
        self.turn(point).map(|x| x * self.unit_m)
    }

    /// A direction of the file in model space.
    pub(super) fn turn(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self.up {
            Up::Y => [x, y, z],
            Up::Z => [x, z, -y],
        }
    }
}

/// A vertex as a file gives it, in model space.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Vertex {
    /// Metres.
    pub position: [f64; 3],
    /// Normal of any length. Zeros for one to compute.
    pub normal: [f64; 3],
    /// glTF's convention.
    pub uv: [f32; 2],
    /// Linear, R, G, B and alpha; `None` for white.
    pub color: Option<[f32; 4]>,
}

/// Triangles as they come from a file. A zero normal is one to compute.
#[derive(Default)]
pub(super) struct Soup {
    /// Model space, metres, before an offset is taken off.
    points: Points,
    /// Around all of them.
    reach: Reach,
    /// As long as `points`.
    normals: Vec<[f32; 3]>,
    /// As long as `points`.
    uvs: Vec<[f32; 2]>,
    /// Whether all vertices are white.
    ignores_colors: bool,
    /// As long as `points`, or empty where all are white.
    colors: Vec<[f32; 4]>,
    /// `points` as f32, less the offset: only once all are there.
    positions: Vec<[f32; 3]>,
    /// Indices into `points`.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle, as long as `triangles`.
    pub triangle_material: Vec<u32>,
    /// Ascending: which part the triangles from one on belong to.
    runs: Vec<Run>,
}

/// Triangles of one part.
#[derive(Debug, Clone, Copy)]
struct Run {
    first: u32,
    part: u32,
}

const WHITE: [f32; 4] = [1.0; 4];

/// What a colour is to be.
pub(super) const WITHIN: &str = "expected shares from 0 to 1: no surface sends out more light than it gets";

/// Whether R, G or B is no share of light, but for rounding.
pub(super) fn is_beyond([r, g, b, _]: &[f32; 4]) -> bool {
    [r, g, b].into_iter().any(|share| !(0.0..=1.01).contains(share))
}

/// What a soup becomes.
pub(super) struct Finished {
    /// Mesh, its `materials`, `images`, `sources`, `warnings`, `notes` and `parts` empty.
    pub mesh: Mesh,
    /// Part of each triangle; empty where no part was begun.
    pub triangle_part: Vec<u32>,
    /// Factor on the alpha of its material at each vertex, from 0 to 1; empty where all are 1.
    pub alphas: Vec<f32>,
    /// Triangles that parts have in common with others.
    pub lent: Vec<Lent>,
}

/// A triangle that a part had, too, exactly where another part has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lent {
    /// The part that lost it.
    pub part: u32,
    /// The one that stays.
    pub triangle: u32,
}

/// A triangle counts as having no area where its area is below this share of its longest edge
/// squared: the rounding of f32 coordinates makes such slivers from points on a line.
const SLIVER: f64 = 1e-7;

/// Memory that [`Soup::finish`] takes per vertex: an order, a number of its point, sums and normals of points.
const VERTEX_CLEANING_BYTES: usize = 48;
/// And per triangle: a flag and a key, a part.
const TRIANGLE_CLEANING_BYTES: usize = 21;

impl Soup {
    /// Nothing yet; all vertices are to be white, or as their file says.
    pub(super) fn new(ignores_colors: bool) -> Soup {
        Soup { ignores_colors, ..Soup::default() }
    }

    /// Adds a vertex; its index. A normal, texture coordinate or colour that is not finite counts as missing. `place`
    /// is asked for where a position is not finite.
    pub(super) fn push_vertex(
        &mut self,
        files: &mut Files,
        vertex: Vertex,
        place: impl Fn() -> String,
    ) -> Result<u32, ImportError> {
        let Vertex { position, normal, uv, color } = vertex;
        if !position.iter().all(|x| (*x as f32).is_finite()) {
            return Err(ImportError::NotFinite { file: files.file.clone(), place: place(), value: position });
        }
        let before = self.points.len();
        files.limit("vertices", before as u64 + 1, limits::VERTICES)?;
        self.reach.add(position);
        self.points.push(files, "vertices", position)?;
        if self.points.is_precise() && self.reach.is_settled() {
            self.points.settle(files);
        }
        files.push("vertices", &mut self.normals, unit(normal).unwrap_or_default())?;
        let uv = if uv.iter().all(|x| x.is_finite()) {
            uv
        } else {
            files.warn("texture coordinates that are not numbers were set to 0".to_owned());
            [0.0; 2]
        };
        files.push("vertices", &mut self.uvs, uv)?;
        let color = color.filter(|_| !self.ignores_colors).unwrap_or(WHITE);
        if !color.iter().all(|x| x.is_finite()) {
            files.warn("colours of vertices that are not numbers were set to white".to_owned());
        } else if color != WHITE {
            // The vertices so far are white.
            while self.colors.len() < before {
                files.push("colours of vertices", &mut self.colors, WHITE)?;
            }
            files.push("colours of vertices", &mut self.colors, color.map(|x| x.max(0.0)))?;
        }
        if !self.colors.is_empty() && self.colors.len() == before {
            files.push("colours of vertices", &mut self.colors, WHITE)?;
        }
        Ok(before as u32)
    }

    /// Adds a triangle over vertices that were pushed before.
    pub(super) fn push_triangle(
        &mut self,
        files: &mut Files,
        corners: [u32; 3],
        material: u32,
    ) -> Result<(), ImportError> {
        files.limit("triangles", self.triangles.len() as u64 + 1, limits::TRIANGLES)?;
        files.push("triangles", &mut self.triangles, corners)?;
        files.push("triangles", &mut self.triangle_material, material)
    }

    /// Triangles that come from here on are of this part.
    pub(super) fn begin_part(&mut self, files: &mut Files, part: u32) -> Result<(), ImportError> {
        let first = self.triangles.len() as u32;
        match self.runs.last_mut() {
            Some(last) if last.part == part => Ok(()),
            Some(last) if last.first == first => {
                last.part = part;
                Ok(())
            }
            _ => files.push("parts", &mut self.runs, Run { first, part }),
        }
    }

    /// An error where the steps of the numbers that the file holds are near the edges of the triangles.
    pub(super) fn check_steps(&self, files: &Files, place: &str, stored: Stored) -> Result<(), ImportError> {
        let corners = self.triangles.iter().map(|corners| corners.map(|at| self.points.get(at as usize)));
        check_steps(files, place, &self.reach, stored, corners)
    }

    /// Changes the colours of all vertices, if there are any but white.
    pub(super) fn map_colors(&mut self, of: impl Fn([f32; 4]) -> [f32; 4]) {
        self.colors.iter_mut().for_each(|color| *color = of(*color));
    }

    /// The colours of all vertices, if there are any but white.
    pub(super) fn colors(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        self.colors.iter().copied()
    }

    /// Takes off the offset, `asked` or the one that a far plant needs, and cleans up.
    pub(super) fn finish(
        mut self,
        files: &mut Files,
        asked: Option<[f64; 3]>,
    ) -> Result<Finished, ImportError> {
        if let Some([r, g, b, _]) = self.colors.iter().find(|color| is_beyond(color)) {
            files.warn(format!("a vertex has the colour {r} {g} {b}, {WITHIN}"));
        }
        let offset_m = asked.unwrap_or_else(|| self.reach.offset());
        self.positions = std::mem::take(&mut self.points).into_f32(offset_m);
        let read = self.triangles.len();
        let cleaning = VERTEX_CLEANING_BYTES * self.positions.len() + TRIANGLE_CLEANING_BYTES * read;
        files.room_for("the cleaning of triangles", cleaning as u64)?;
        let flat = self.drop_flat();
        if flat > 0 {
            files.warn(format!("dropped {flat} of {read} triangles that have no area"));
        }
        let points = self.point_ids();
        let (doubled, lent) = self.drop_coincident(&points);
        if doubled > 0 {
            files.warn(format!(
                "dropped {doubled} of {read} triangles that lie exactly on another one (their area counts once)"
            ));
        }
        if self.triangles.is_empty() {
            let detail = match read {
                0 => match files.notes() {
                    [] => "the file has none".to_owned(),
                    // What a file hides is told by notes, which begin with its name.
                    notes => {
                        let told =
                            notes.iter().filter_map(|note| note.strip_prefix(&format!("{}: ", files.file)));
                        format!("it shows none: {}", told.collect::<Vec<_>>().join("; "))
                    }
                },
                _ => format!("{read} were read, none of which has an area"),
            };
            return Err(ImportError::NoTriangles { file: files.file.clone(), detail });
        }
        self.fill_normals(&points);
        self.drop_unused_vertices();
        let triangle_part = self.parts_of_triangles();
        let mesh = Mesh {
            positions: self.positions,
            normals: self.normals,
            uvs: self.uvs,
            triangles: self.triangles,
            triangle_material: self.triangle_material,
            colors: self.colors.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect(),
            offset_m,
            ..Mesh::default()
        };
        let alphas = match self.colors.iter().all(|color| color[3] == 1.0) {
            true => Vec::new(),
            false => self.colors.into_iter().map(|color| color[3].min(1.0)).collect(),
        };
        Ok(Finished { mesh, triangle_part, alphas, lent })
    }

    /// The part of one triangle.
    fn part_of(&self, triangle: u32) -> Option<u32> {
        let begun = self.runs.partition_point(|run| run.first <= triangle);
        Some(self.runs[begun.checked_sub(1)?].part)
    }

    /// The part of each triangle; empty where no part was begun.
    fn parts_of_triangles(&self) -> Vec<u32> {
        let mut parts = Vec::with_capacity(self.triangles.len());
        for (at, run) in self.runs.iter().enumerate() {
            let end = self.runs.get(at + 1).map_or(self.triangles.len(), |next| next.first as usize);
            parts.resize(end, run.part);
        }
        parts
    }

    fn corners(&self, triangle: [u32; 3]) -> [[f64; 3]; 3] {
        triangle.map(|index| self.positions[index as usize].map(f64::from))
    }

    fn drop_flat(&mut self) -> usize {
        let keep: Vec<bool> = self.triangles.iter().map(|&t| !is_flat(self.corners(t))).collect();
        self.keep_triangles(&keep)
    }

    /// Per vertex the number of its position; equal positions have equal numbers.
    fn point_ids(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.positions.len() as u32).collect();
        let bits = |vertex: u32| self.positions[vertex as usize].map(f32::to_bits);
        order.sort_unstable_by_key(|&vertex| (bits(vertex), vertex));
        let mut ids = vec![0u32; order.len()];
        let mut id = 0;
        for pair in order.windows(2) {
            id += u32::from(bits(pair[0]) != bits(pair[1]));
            ids[pair[1] as usize] = id;
        }
        ids
    }

    /// Of triangles of one material over the same three positions, in any order, only the first stays. What to do with
    /// those of several materials, classes decide ([`crate::sheets`]).
    fn drop_coincident(&mut self, points: &[u32]) -> (usize, Vec<Lent>) {
        let key = |triangle: [u32; 3]| {
            let mut key = triangle.map(|vertex| points[vertex as usize]);
            key.sort_unstable();
            key
        };
        let mut order: Vec<([u32; 3], u32)> =
            (0u32..).zip(&self.triangles).map(|(i, &triangle)| (key(triangle), i)).collect();
        order.sort_unstable();
        let mut keep = vec![true; order.len()];
        let mut lent = Vec::new();
        let material = |triangle: u32| self.triangle_material[triangle as usize];
        for same in order.chunk_by_mut(|a, b| a.0 == b.0).filter(|same| same.len() > 1) {
            same.sort_unstable_by_key(|&(_, triangle)| (material(triangle), triangle));
            for same in same.chunk_by(|a, b| material(a.1) == material(b.1)) {
                let [(_, first), others @ ..] = same else { continue };
                for (_, other) in others {
                    keep[*other as usize] = false;
                    match (self.part_of(*first), self.part_of(*other)) {
                        (Some(of_first), Some(part)) if of_first != part => {
                            lent.push(Lent { part, triangle: *first })
                        }
                        _ => {}
                    }
                }
            }
        }
        // Numbers among what stays.
        lent.sort_unstable_by_key(|lent| lent.triangle);
        let (mut at, mut left) = (0, 0);
        for lent in &mut lent {
            left += keep[at..lent.triangle as usize].iter().filter(|keep| **keep).count();
            at = lent.triangle as usize;
            lent.triangle = left as u32;
        }
        (self.keep_triangles(&keep), lent)
    }

    fn keep_triangles(&mut self, keep: &[bool]) -> usize {
        let before = self.triangles.len();
        let (mut at, mut left) = (0, 0);
        for run in &mut self.runs {
            left += keep[at..run.first as usize].iter().filter(|keep| **keep).count();
            at = run.first as usize;
            run.first = left as u32;
        }
        let mut kept = keep.iter();
        self.triangles.retain(|_| *kept.next().expect("one flag per triangle"));
        let mut kept = keep.iter();
        self.triangle_material.retain(|_| *kept.next().expect("one flag per triangle"));
        before - self.triangles.len()
    }

    /// Missing normals become the area-weighted mean of the triangles around the position.
    fn fill_normals(&mut self, points: &[u32]) {
        if self.normals.iter().all(|normal| *normal != [0.0; 3]) {
            return;
        }
        let count = points.iter().max().map_or(0, |&last| last as usize + 1);
        let mut sums = vec![[0.0f64; 3]; count];
        for &triangle in &self.triangles {
            let normal = cross_of(self.corners(triangle));
            for vertex in triangle {
                let sum = &mut sums[points[vertex as usize] as usize];
                *sum = std::array::from_fn(|axis| sum[axis] + normal[axis]);
            }
        }
        // Where the faces around a position cancel out, its first face decides.
        let mut first = vec![[0.0f32; 3]; self.positions.len()];
        for &triangle in self.triangles.iter().rev() {
            let normal = unit(cross_of(self.corners(triangle))).unwrap_or([0.0, 1.0, 0.0]);
            for vertex in triangle {
                first[vertex as usize] = normal;
            }
        }
        for (vertex, normal) in self.normals.iter_mut().enumerate() {
            if *normal == [0.0; 3] {
                *normal = unit(sums[points[vertex] as usize]).unwrap_or(first[vertex]);
            }
        }
    }

    fn drop_unused_vertices(&mut self) {
        let mut new_index = vec![u32::MAX; self.positions.len()];
        for &vertex in self.triangles.iter().flatten() {
            new_index[vertex as usize] = 0;
        }
        for (new, index) in new_index.iter_mut().filter(|index| **index == 0).enumerate() {
            *index = new as u32;
        }
        for vertex in self.triangles.iter_mut().flatten() {
            *vertex = new_index[*vertex as usize];
        }
        retain_used(&mut self.positions, &new_index);
        retain_used(&mut self.normals, &new_index);
        retain_used(&mut self.uvs, &new_index);
        if !self.colors.is_empty() {
            retain_used(&mut self.colors, &new_index);
        }
    }
}

fn retain_used<T>(values: &mut Vec<T>, new_index: &[u32]) {
    let mut index = new_index.iter();
    values.retain(|_| *index.next().expect("one index per vertex") != u32::MAX);
    values.shrink_to_fit();
}

/// Twice the area, along the normal of the side from which the corners run counter-clockwise.
fn cross_of([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let u: [f64; 3] = std::array::from_fn(|axis| b[axis] - a[axis]);
    let v: [f64; 3] = std::array::from_fn(|axis| c[axis] - a[axis]);
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Area of a triangle.
pub fn area(corners: [[f64; 3]; 3]) -> f64 {
    0.5 * length_squared(cross_of(corners)).sqrt()
}

fn is_flat(corners: [[f64; 3]; 3]) -> bool {
    let [a, b, c] = corners;
    let edge =
        |from: [f64; 3], to: [f64; 3]| length_squared(std::array::from_fn(|axis| to[axis] - from[axis]));
    let longest = edge(a, b).max(edge(b, c)).max(edge(c, a));
    area(corners) <= SLIVER * longest
}

fn length_squared([x, y, z]: [f64; 3]) -> f64 {
    x * x + y * y + z * z
}

/// `vector` at length 1; `None` if it is zero or not finite.
fn unit(vector: [f64; 3]) -> Option<[f32; 3]> {
    // Scaled first: the square of a tiny length would vanish.
    let largest = vector.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    if !largest.is_finite() || largest == 0.0 || vector.iter().any(|x| x.is_nan()) {
        return None;
    }
    let scaled = vector.map(|x| x / largest);
    let length = length_squared(scaled).sqrt();
    Some(scaled.map(|x| (x / length) as f32))
}

#[cfg(test)]
mod tests;
