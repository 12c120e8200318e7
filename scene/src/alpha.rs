//! Which texels of a material are there: from images and cutoffs to a bit per texel that answers, fast,
//! "does this piece of a triangle touch a present texel" and "which share of it is present".
//!
//! The rule: a point of a surface is present iff the nearest texel of the level-0 image there is, and a
//! texel is present iff `alpha / 255 x base color alpha >= cutoff`. Texel `i` covers `[i, i + 1)` of the
//! axis of `uv' x size`, where `uv'` is the texture's transform applied to uv; wrap modes map any `i` into
//! the image. Where a material names both a colour image and an alpha image, their alphas multiply: the
//! finer image's texels decide, each with the other's nearest texel at its centre; where the two uses
//! differ in wrap or transform, the alpha image alone decides. An image without a cut counts as 1.
//!
//! Where alpha is a share ([`AlphaMode::Blend`]), the same holds with a cutoff that differs from texel to texel, evenly
//! from 0 to 1, so that of texels of 0.4 a scattered 40 % is present.

pub use error::AlphaError;
pub use texels::{TexelBox, index};

use crate::mesh::{AlphaMode, Image, Material, Mesh, Texture, Wrap};

mod clearance;
mod dither;
mod error;
mod piece;
#[cfg(test)]
mod tests;
mod texels;

/// Most groups along an edge of the table of sums; larger images count squares of 2, 4, 8.. texels as one.
const MAX_GROUPS: usize = 512;

/// Largest width and height of an image that cuts.
const MAX_IMAGE_EDGE: u32 = 1 << 16;

/// Presence of a material's surface, texel by texel.
#[derive(Debug, Clone, PartialEq)]
pub enum Coverage {
    /// Every texel is present.
    Full,
    /// No texel is present: every texel lies below the cutoff.
    Nothing,
    /// Some texels are present.
    Cut(Cut),
}

impl Coverage {
    /// The coverage of every material of a mesh; with `ignore_alpha` all of each is there.
    ///
    /// # Errors
    /// As [`Coverage::of`], of the first material that cannot be cut.
    pub fn of_all(mesh: &Mesh, ignore_alpha: bool) -> Result<Vec<Coverage>, AlphaError> {
        let of = |material| if ignore_alpha { Ok(Coverage::Full) } else { Coverage::of(mesh, material) };
        (0..mesh.materials.len()).map(of).collect()
    }

    /// The coverage of one material of a mesh.
    ///
    /// # Errors
    /// A texture that names no image of the mesh, or an image whose bytes do not match its size.
    pub fn of(mesh: &Mesh, material: usize) -> Result<Coverage, AlphaError> {
        Coverage::of_material(mesh, &mesh.materials[material])
    }

    /// The coverage of a material that uses images of a mesh, whether it is one of the mesh or not.
    ///
    /// # Errors
    /// As [`Coverage::of`].
    pub fn of_material(mesh: &Mesh, material: &Material) -> Result<Coverage, AlphaError> {
        if material.alpha_mode == AlphaMode::Opaque {
            return Ok(Coverage::Full);
        }
        let image_of = |use_: Option<Texture>| -> Result<Option<(Texture, &Image)>, AlphaError> {
            let Some(texture) = use_ else { return Ok(None) };
            let image = checked_image(mesh, material, texture)?;
            Ok(image.has_cut.then_some((texture, image)))
        };
        let (color, alpha) = (image_of(material.color_texture)?, image_of(material.alpha_texture)?);
        let same_use = |a: Texture, b: Texture| a.wrap == b.wrap && a.transform == b.transform;
        let found = match (color, alpha) {
            (None, None) => None,
            (Some((texture, image)), None) => Some((texture, image, None)),
            (Some((t, c)), Some((u, a))) if same_use(t, u) => {
                if u64::from(c.width) * u64::from(c.height) > u64::from(a.width) * u64::from(a.height) {
                    Some((t, c, Some(a)))
                } else {
                    Some((t, a, Some(c)))
                }
            }
            (_, Some((texture, image))) => Some((texture, image, None)),
        };
        let factor = material.base_color[3];
        let alpha_at = |fine: &Image, other: Option<&Image>, x: u32, y: u32| {
            let other = other.map_or(1.0, |o| f64::from(alpha_at_center_of(o, fine, x, y)) / 255.0);
            f64::from(alpha_of(fine, x, y)) * (f64::from(factor) / 255.0) * other
        };
        let cut = match (material.alpha_mode, found) {
            (AlphaMode::Opaque, _) => return Ok(Coverage::Full),
            (AlphaMode::Cut { cutoff }, None) => {
                return Ok(if factor >= cutoff { Coverage::Full } else { Coverage::Nothing });
            }
            (AlphaMode::Cut { cutoff }, Some((texture, fine, other))) => {
                let present = |x: u32, y: u32| alpha_at(fine, other, x, y) >= f64::from(cutoff);
                Cut::from_fn(fine.width, fine.height, texture.wrap, texture.transform, present)
            }
            (AlphaMode::Blend, None) => dither::even(material.color_texture, f64::from(factor)),
            (AlphaMode::Blend, Some((texture, fine, other))) => {
                dither::of_texels([fine.width, fine.height], texture, |x, y| alpha_at(fine, other, x, y))
            }
        };
        Ok(cut.simplified())
    }

    /// Whether the surface is there at a texture coordinate of the mesh (the texture's transform not yet
    /// applied). A coordinate that is not finite reads as texel 0 of its axis.
    pub fn present_at(&self, uv: [f32; 2]) -> bool {
        match self {
            Coverage::Full => true,
            Coverage::Nothing => false,
            Coverage::Cut(cut) => cut.present_at(uv),
        }
    }
}

fn checked_image<'a>(mesh: &'a Mesh, material: &Material, texture: Texture) -> Result<&'a Image, AlphaError> {
    let image = mesh.images.get(texture.image as usize).ok_or_else(|| AlphaError::NoSuchImage {
        material: material.name.clone(),
        image: texture.image,
        images: mesh.images.len(),
    })?;
    let edges = 1..=MAX_IMAGE_EDGE;
    let expected = u64::from(image.width) * u64::from(image.height) * 4;
    if !edges.contains(&image.width) || !edges.contains(&image.height) || image.rgba.len() as u64 != expected
    {
        return Err(AlphaError::ImageSize {
            image: image.name.clone(),
            width: image.width,
            height: image.height,
            bytes: image.rgba.len(),
            limit: MAX_IMAGE_EDGE,
        });
    }
    Ok(image)
}

fn alpha_of(image: &Image, x: u32, y: u32) -> u8 {
    image.rgba[(y as usize * image.width as usize + x as usize) * 4 + 3]
}

/// The alpha of `other` at the centre of texel (x, y) of `fine`, both covering the same square.
fn alpha_at_center_of(other: &Image, fine: &Image, x: u32, y: u32) -> u8 {
    let along = |i: u32, size: u32, other: u32| {
        ((2 * u64::from(i) + 1) * u64::from(other) / (2 * u64::from(size))) as u32
    };
    alpha_of(other, along(x, fine.width, other.width), along(y, fine.height, other.height))
}

/// A bit per texel, with three tables that make questions about many texels cheap: the number of present
/// texels left of every 64th texel of a row, and over square groups of texels the summed area and the distance
/// to the nearest present texel.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    size: [usize; 2],
    wrap: [Wrap; 2],
    /// `texel = m * [u, v, 1]`: the texture's transform times the image's size.
    texel_from_uv: [[f64; 3]; 2],
    words_per_row: usize,
    /// `[y][word]`, bit = x % 64.
    words: Vec<u64>,
    /// `[y][word]`: present texels of the row before the word.
    before: Vec<u32>,
    /// Texels along an edge of a group, a power of two.
    group: usize,
    /// Groups along x and y.
    groups: [usize; 2],
    /// `[gy][gx]`, (groups + 1) each way: present texels in the groups above and to the left.
    sums: Vec<u32>,
    /// `[gy][gx]`: how far a group is from present texels, see [`clearance::of_groups`].
    clearance: Vec<u8>,
}

/// Presence of texels in a box, judged by the groups of texels that cover it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// No texel is present.
    Absent,
    /// All texels are present.
    Present,
    /// Cannot be told from the groups.
    Mixed,
}

impl Verdict {
    fn from_counts([present, all]: [u64; 2]) -> Verdict {
        match present {
            0 => Verdict::Absent,
            _ if present == all => Verdict::Present,
            _ => Verdict::Mixed,
        }
    }
}

impl Cut {
    /// A cut from a rule per texel. `transform` as in [`Texture`].
    fn from_fn(
        width: u32,
        height: u32,
        wrap: [Wrap; 2],
        transform: [[f32; 3]; 2],
        present: impl Fn(u32, u32) -> bool,
    ) -> Cut {
        let size = [width as usize, height as usize];
        let words_per_row = size[0].div_ceil(64);
        let group = size[0].max(size[1]).div_ceil(MAX_GROUPS).next_power_of_two();
        let groups = size.map(|edge| edge.div_ceil(group));
        let mut words = vec![0u64; words_per_row * size[1]];
        let mut before = vec![0u32; words_per_row * size[1]];
        let stride = groups[0] + 1;
        let mut sums = vec![0u32; stride * (groups[1] + 1)];
        for y in 0..size[1] {
            let row = &mut words[y * words_per_row..][..words_per_row];
            for x in 0..size[0] {
                if present(x as u32, y as u32) {
                    row[x / 64] |= 1 << (x % 64);
                    sums[(y / group + 1) * stride + x / group + 1] += 1;
                }
            }
            let mut count = 0;
            for (word, before) in row.iter().zip(&mut before[y * words_per_row..]) {
                *before = count;
                count += word.count_ones();
            }
        }
        for gy in 1..=groups[1] {
            for gx in 1..=groups[0] {
                let at = gy * stride + gx;
                // Not negative: the corner sum is part of both others.
                sums[at] += sums[at - 1] + sums[at - stride] - sums[at - stride - 1];
            }
        }
        let empty = |gx: usize, gy: usize| {
            let at = gy * stride + gx;
            let sum = |at: usize| u64::from(sums[at]);
            sum(at + stride + 1) + sum(at) == sum(at + 1) + sum(at + stride)
        };
        let across = [0, 1].map(|axis| wrap[axis] == Wrap::Repeat);
        let mut clearance = clearance::of_groups(groups, across, empty);
        if (0..2).any(|axis| across[axis] && !size[axis].is_multiple_of(group)) {
            // The last group is cut short: what lies beyond it may be nearer.
            clearance.iter_mut().for_each(|clear| *clear = clear.saturating_sub(1));
        }
        let texel_from_uv =
            std::array::from_fn(|axis| transform[axis].map(|entry| f64::from(entry) * size[axis] as f64));
        Cut { size, wrap, texel_from_uv, words_per_row, words, before, group, groups, sums, clearance }
    }

    /// `Full` or `Nothing` where the texels agree.
    fn simplified(self) -> Coverage {
        let [width, height] = self.size;
        match self.sums.last().map_or(0, |&count| count as usize) {
            0 => Coverage::Nothing,
            count if count == width * height => Coverage::Full,
            _ => Coverage::Cut(self),
        }
    }

    /// A texture coordinate of the mesh in texels: texel i covers [i, i + 1). What is not finite reads as 0.
    pub fn texel_from_uv(&self, uv: [f32; 2]) -> [f64; 2] {
        let [u, v] = uv.map(f64::from);
        let texel = self.texel_from_uv.map(|row| row[0] * u + row[1] * v + row[2]);
        texel.map(|c| if c.is_finite() { c } else { 0.0 })
    }

    /// Width and height, in texels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Meaning of texels beyond the edges, along x and y.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// `texel = m * [u, v, 1]`: [`Cut::texel_from_uv`] as a matrix.
    pub fn texel_matrix(&self) -> [[f64; 3]; 2] {
        self.texel_from_uv
    }

    /// A row of texels: texel `x` is bit `x % 64` of word `x / 64`.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.words_per_row..][..self.words_per_row]
    }

    /// Whether the nearest texel is present.
    pub fn present_at(&self, uv: [f32; 2]) -> bool {
        let [x, y] = self.texel_from_uv(uv).map(index);
        self.bit(self.wrapped(0, x), self.wrapped(1, y))
    }

    /// Whether a texel is present, by its unwrapped position.
    #[inline]
    pub fn present(&self, texel: [i64; 2]) -> bool {
        self.bit(self.wrapped(0, texel[0]), self.wrapped(1, texel[1]))
    }

    #[inline]
    fn bit(&self, x: usize, y: usize) -> bool {
        self.words[y * self.words_per_row + x / 64] >> (x % 64) & 1 == 1
    }

    /// The image's texel that an unwrapped position means.
    #[inline]
    fn wrapped(&self, axis: usize, at: i64) -> usize {
        let size = self.size[axis] as i64;
        if (0..size).contains(&at) {
            return at as usize;
        }
        let inside = match self.wrap[axis] {
            Wrap::Clamp => at.clamp(0, size - 1),
            Wrap::Repeat => at.rem_euclid(size),
            Wrap::Mirror => {
                let turn = at.rem_euclid(2 * size);
                turn.min(2 * size - 1 - turn)
            }
        };
        inside as usize
    }

    /// The image's runs of texels (at most three, first..=last) that unwrapped `min..=max` means.
    fn runs(&self, axis: usize, min: i64, max: i64) -> ([(usize, usize); 3], usize) {
        let size = self.size[axis] as i64;
        let mut runs = [(0, 0); 3];
        if min >= 0 && max < size {
            runs[0] = (min as usize, max as usize);
            return (runs, 1);
        }
        if self.wrap[axis] == Wrap::Clamp {
            runs[0] = (self.wrapped(axis, min), self.wrapped(axis, max));
            return (runs, 1);
        }
        let span = max.saturating_sub(min);
        if span >= 2 * size - 1 {
            runs[0] = (0, self.size[axis] - 1);
            return (runs, 1);
        }
        let (mut from, mut count) = (min, 0);
        while from <= max {
            let to = from.saturating_add(size - 1 - from.rem_euclid(size)).min(max);
            let ends = (self.wrapped(axis, from), self.wrapped(axis, to));
            runs[count] = (ends.0.min(ends.1), ends.0.max(ends.1));
            count += 1;
            from = to + 1;
        }
        (runs, count)
    }

    /// Whether any texel of one row is there, columns unwrapped `min..=max`.
    fn any_in_row(&self, y: usize, min: i64, max: i64) -> bool {
        let row = &self.words[y * self.words_per_row..][..self.words_per_row];
        let (runs, count) = self.runs(0, min, max);
        runs[..count].iter().any(|&(first, last)| {
            let (low, high) = (u64::MAX << (first % 64), u64::MAX >> (63 - last % 64));
            let (from, to) = (first / 64, last / 64);
            if from == to {
                return row[from] & low & high != 0;
            }
            row[from] & low != 0 || row[to] & high != 0 || row[from + 1..to].iter().any(|&word| word != 0)
        })
    }

    /// Whether the groups that cover a box of texels show that no texel in it is present.
    #[inline]
    pub fn absent(&self, texels: &TexelBox) -> bool {
        match self.ends_inside(texels) {
            Some([columns, rows]) => self.present_around(columns, rows) == 0,
            None => self.verdict(texels) == Verdict::Absent,
        }
    }

    /// Judges the presence of texels in a box, as far as the groups that cover it can tell.
    pub fn verdict(&self, texels: &TexelBox) -> Verdict {
        if let Some([columns, rows]) = self.ends_inside(texels) {
            return Verdict::from_counts(self.count_around(columns, rows));
        }
        let (columns, column_count) = self.runs(0, texels.min[0], texels.max[0]);
        let (rows, row_count) = self.runs(1, texels.min[1], texels.max[1]);
        let (mut present, mut all) = (0, 0);
        for &rows in &rows[..row_count] {
            for &columns in &columns[..column_count] {
                let count = self.count_around(columns, rows);
                present += count[0];
                all += count[1];
            }
        }
        Verdict::from_counts([present, all])
    }

    /// First and last column and row of a box that lies inside the image.
    #[inline]
    fn ends_inside(&self, texels: &TexelBox) -> Option<[(usize, usize); 2]> {
        let inside = |axis: usize| texels.min[axis] >= 0 && texels.max[axis] < self.size[axis] as i64;
        let ends = |axis: usize| (texels.min[axis] as usize, texels.max[axis] as usize);
        (inside(0) && inside(1)).then(|| [ends(0), ends(1)])
    }

    /// Distance in texels around a texel (unwrapped, along u and v) within which all are surely absent; negative where
    /// the texel itself may be present.
    #[inline]
    pub fn clear_around(&self, texel: [i64; 2]) -> i64 {
        let shift = self.group.trailing_zeros();
        let [gx, gy] = [0, 1].map(|axis| self.wrapped(axis, texel[axis]) >> shift);
        let clear = i64::from(self.clearance[gy * self.groups[0] + gx]);
        (clear - 1) << shift
    }

    /// Present texels of the groups that cover a box inside the image.
    #[inline]
    fn present_around(&self, columns: (usize, usize), rows: (usize, usize)) -> u64 {
        let (stride, shift) = (self.groups[0] + 1, self.group.trailing_zeros());
        let (left, right) = (columns.0 >> shift, (columns.1 >> shift) + 1);
        let (top, bottom) = ((rows.0 >> shift) * stride, ((rows.1 >> shift) + 1) * stride);
        let at = |place: usize| u64::from(self.sums[place]);
        at(bottom + right) + at(top + left) - at(top + right) - at(bottom + left)
    }

    /// The same, and all texels.
    fn count_around(&self, columns: (usize, usize), rows: (usize, usize)) -> [u64; 2] {
        let shift = self.group.trailing_zeros();
        let length = |(first, last): (usize, usize), axis: usize| {
            (((last >> shift) + 1) << shift).min(self.size[axis]) - ((first >> shift) << shift)
        };
        [self.present_around(columns, rows), (length(columns, 0) * length(rows, 1)) as u64]
    }

    /// How long the present part of a row is from one place to another, not before it.
    #[inline]
    fn present_between(&self, y: usize, from: f64, to: f64) -> f64 {
        if from >= 0.0 && to < self.size[0] as f64 {
            return self.present_until(y, to) - self.present_until(y, from);
        }
        self.present_before(y, to) - self.present_before(y, from)
    }

    /// How long the present part of a row is from column 0 to `x` inside the image or on its border.
    #[inline]
    fn present_until(&self, y: usize, x: f64) -> f64 {
        let texel = (x as u32 as usize).min(self.size[0] - 1);
        let at = y * self.words_per_row + texel / 64;
        let word = self.words[at];
        let count = self.before[at] + (word & !(u64::MAX << (texel % 64))).count_ones();
        f64::from(count) + if word >> (texel % 64) & 1 == 1 { x - texel as f64 } else { 0.0 }
    }

    /// How long the present part of a row is from column 0 to `x` (unwrapped; negative to the left).
    fn present_before(&self, y: usize, x: f64) -> f64 {
        let size = self.size[0] as f64;
        let inside = |x: f64| self.present_until(y, x);
        if (0.0..size).contains(&x) {
            return inside(x);
        }
        match self.wrap[0] {
            Wrap::Clamp => {
                let beyond = |texel: usize, length: f64| if self.bit(texel, y) { length } else { 0.0 };
                inside(x.clamp(0.0, size))
                    + beyond(0, x.min(0.0))
                    + beyond(self.size[0] - 1, (x - size).max(0.0))
            }
            Wrap::Repeat => {
                let turns = libm::floor(x / size);
                turns * inside(size) + inside((x - turns * size).clamp(0.0, size))
            }
            Wrap::Mirror => {
                let turns = libm::floor(x / (2.0 * size));
                let rest = (x - turns * 2.0 * size).clamp(0.0, 2.0 * size);
                let row = inside(size);
                let part = if rest <= size { inside(rest) } else { 2.0 * row - inside(2.0 * size - rest) };
                turns * 2.0 * row + part
            }
        }
    }
}
