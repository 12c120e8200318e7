//! Which voxels that a cut triangle touches hold something of it: the rule, and shortcuts that prove what it
//! will answer.
//!
//! On the triangle's plane the texel is an affine function of the place, so for the part inside a voxel
//! - one point of it whose texel is there proves the voxel occupied. The plane's point on the voxel's diagonal
//!   lies in every voxel that the plane meets, as far from the middle along each axis; what room that leaves
//!   to the voxel's faces holds more points around it;
//! - a box of texels around the part that is all absent decides as well; most are seen for a whole column of
//!   voxels, or a square of columns, by one look-up of how far the texel in its middle is from any that is there.
//!
//! All keep `MARGIN` texels away from where rounding could matter; [`Shortcuts::new`] bounds the rounding and
//! gives none for a triangle (a sliver, a huge image) where the bound exceeds it. What they leave open is
//! clipped.

use std::cell::RefCell;

use super::clips::{Clips, GROWN};
use super::overlap::SQUARE;
use super::piece::{MAX_POINTS, PiecePoint, cross};
use super::triangle::{CutTriangle, Snapped, UNITS};
use flb_scene::alpha::{TexelBox, index};

#[cfg(test)]
mod tests;

/// How far shortcuts stay away from borders of texels, texels.
const MARGIN: f64 = 1e-3;

/// Decides whether the part of a cut triangle inside a voxel is there.
pub(super) struct Cutter<'a> {
    triangle: &'a CutTriangle<'a>,
    clips: RefCell<&'a mut Clips>,
    shortcuts: Option<Shortcuts>,
}

impl<'a> Cutter<'a> {
    /// `along` is the axis along which [`Cutter::absent_in`] looks, the steepest of the triangle.
    pub(super) fn new(
        snapped: &Snapped,
        triangle: &'a CutTriangle<'a>,
        along: usize,
        clips: &'a mut Clips,
    ) -> Cutter<'a> {
        let points: [PiecePoint; 3] = std::array::from_fn(|i| PiecePoint {
            at: snapped.vertices[i].map(|c| c as f64 / UNITS as f64),
            texel: triangle.texels[i],
        });
        let shortcuts = Shortcuts::new(snapped, &points, along);
        clips.take(points);
        Cutter { triangle, clips: RefCell::new(clips), shortcuts }
    }

    /// The rule itself: the triangle clipped to the grown voxel touches a present texel.
    pub(super) fn touches(&self, voxel: [i64; 3], touches: impl Fn(&[[f64; 2]], &TexelBox) -> bool) -> bool {
        let mut clips = self.clips.borrow_mut();
        let piece = clips.within(voxel);
        touches(piece.texels(&mut [[0.0; 2]; MAX_POINTS]), &self.triangle.within)
    }

    /// The same for a voxel that the triangle touches, without clipping where a shortcut decides.
    pub(super) fn present_in(&self, voxel: [i64; 3]) -> bool {
        let cut = self.triangle.cut;
        if let Some(shortcuts) = &self.shortcuts {
            let place = shortcuts.place_of(voxel);
            let first = shortcuts.first_sample(place);
            let present = |sample: Sample| texel_of(sample).is_some_and(|texel| cut.present(texel));
            if present(first) {
                return true;
            }
            let texels = shortcuts.texels_around(place);
            if cut.absent(&texels.clamped(&self.triangle.within)) {
                return false;
            }
            if shortcuts.samples_around(first, place).any(present) {
                return true;
            }
        }
        self.touches(voxel, |piece, within| cut.touches(piece, within))
    }

    /// Whether a column, or a square of at most [`SQUARE`] columns, surely holds nothing of the triangle that is
    /// there; its first and last voxels along the two axes after `along`.
    pub(super) fn absent_in(&self, square: [[i64; 2]; 2]) -> bool {
        self.shortcuts.as_ref().is_some_and(|shortcuts| {
            let [column, whole] = shortcuts.texels_to_end;
            let to_end = if square.iter().all(|[first, last]| first == last) { column } else { whole };
            self.triangle.cut.clear_around(shortcuts.middle_texel(square)) >= to_end
        })
    }
}

/// Affine functions of a voxel's place that stand in for clipping.
struct Shortcuts {
    /// Position of a vertex: places are taken from here, to the voxel's centre.
    anchor: [f64; 3],
    /// At the plane's point on the voxel's diagonal.
    sample: [Affine; 4],
    /// How far that point lies from the voxel's middle along each axis, voxels.
    off_middle: Affine,
    /// What other samples add to it, per voxel of room.
    around: [Sample; 8],
    /// Texels along u and v as functions that agree on the plane, each without slope along one axis, the one
    /// that varies least first; and how much each varies from the voxel's middle to its end, at most.
    texel: [[Affine; 3]; 2],
    reach: [[f64; 3]; 2],
    /// The axis of columns; texels as functions of the places along the two axes after it.
    along: usize,
    column: [Affine; 2],
    /// How far they reach from the middle of a column, and of a square of them, along u or v, whichever is more,
    /// rounded up.
    texels_to_end: [i64; 2],
    /// Smallest and largest texel coordinates of the triangle.
    ends: [[f64; 2]; 2],
}

/// Of a sample: its texel along u and v, its shares of the second and third vertex (barycentric).
type Sample = [f64; 4];

/// `offset + slope . place`
#[derive(Clone, Copy)]
struct Affine {
    offset: f64,
    slope: [f64; 3],
}

impl Affine {
    fn at(&self, place: [f64; 3]) -> f64 {
        self.offset + dot(self.slope, place)
    }
}

/// Least barycentric coordinate of a sample.
const INSIDE: f64 = 1e-6;

impl Shortcuts {
    /// `None` for a triangle so thin, or with texels so many, that rounding could come near the margins.
    ///
    /// With edges e and f from the anchor, normal n = e x f and differences du, dv of a function along them, its
    /// gradient in the plane is `(du (f x n) + dv (n x e)) / n^2`. Its rounding is at most a few ulp of
    /// `steep = (|du| |f| + |dv| |e|) / |n|`, and so that of the function within the triangle a few ulp of
    /// `steep x length`. The clip itself errs by a few ulp of the texels, and along its planes by 1e-12 voxel.
    fn new(snapped: &Snapped, points: &[PiecePoint; 3], along: usize) -> Option<Shortcuts> {
        /// Some tens of ulp, ten times over.
        const ROUNDING: f64 = 1e-13;
        /// Least height of a triangle, voxels: 1e-6 of it is far more than the rounding of the clip.
        const MIN_HEIGHT: f64 = 1e-2;
        /// Least sum or difference of two ways within a cube of edge 2 that still is a way within the plane: far
        /// more than their rounding.
        const MIN_BETWEEN: f64 = 1.0 / 16.0;
        let v = &snapped.vertices;
        let edge = |to: usize| -> [i64; 3] { std::array::from_fn(|axis| v[to][axis] - v[0][axis]) };
        let (e, f) = (edge(1), edge(2));
        // Edges < 2^28 units: exact.
        let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
        let n = normal.map(|c| c as f64 / (UNITS * UNITS) as f64);
        let [e, f] = [e, f].map(|edge| edge.map(|c| c as f64 / UNITS as f64));
        let [e_length, f_length, n_length] = [e, f, n].map(|c| dot(c, c).sqrt());
        let length = e_length + f_length;
        if n_length < MIN_HEIGHT * length {
            return None;
        }
        let (along_e, along_f) = (cross(f, n), cross(n, e));
        let square = n_length * n_length;
        let gradient = |du: f64, dv: f64| -> [f64; 3] {
            std::array::from_fn(|i| (du * along_e[i] + dv * along_f[i]) / square)
        };
        // A point of the plane moves along the normal for free.
        let with_normal =
            |g: [f64; 3], share: f64| -> [f64; 3] { std::array::from_fn(|i| g[i] - share * n[i]) };
        let signs = n.map(|c| if c < 0.0 { -1.0 } else { 1.0 });
        let along_diagonal = |g: [f64; 3]| with_normal(g, dot(g, signs) / dot(n, signs));
        let none = Affine { offset: 0.0, slope: [0.0; 3] };
        let (mut column, mut texel, mut reach, mut ends) =
            ([none; 2], [[none; 3]; 2], [[0.0; 3]; 2], [[0.0; 2]; 2]);
        let mut gradients = [[0.0; 3], [0.0; 3], gradient(1.0, 0.0), gradient(0.0, 1.0)];
        for axis in 0..2 {
            let [a, b, c] = [points[0], points[1], points[2]].map(|point| point.texel[axis]);
            let (du, dv) = (b - a, c - a);
            let steep = (du.abs() * f_length + dv.abs() * e_length) / n_length;
            let most = a.abs().max(b.abs()).max(c.abs());
            let rounding = ROUNDING * (steep * (length + 2.0) + most);
            if rounding.is_nan() || rounding >= MARGIN / 2.0 {
                return None;
            }
            let g = gradient(du, dv);
            gradients[axis] = g;
            // The bounds that all three give together are those of the plane's part in the voxel: the dual of
            // that linear program has its optimum at one of them.
            let mut functions = [0, 1, 2].map(|i| match n[i] != 0.0 {
                true => with_normal(g, g[i] / n[i]),
                false => g,
            });
            let variation = |g: &[f64; 3]| g[0].abs() + g[1].abs() + g[2].abs();
            functions.sort_by(|a, b| variation(a).total_cmp(&variation(b)));
            column[axis] = Affine { offset: a, slope: with_normal(g, g[along] / n[along]) };
            texel[axis] = functions.map(|slope| Affine { offset: a, slope });
            // Along a small component of the normal a function may be far steeper than the gradient, and its
            // rounding with it.
            reach[axis] = functions.map(|slope| {
                let rounding = ROUNDING * (variation(&slope) * (length + 2.0) + most);
                (0.5 + 2.0 * GROWN) * variation(&slope) + MARGIN + rounding
            });
            ends[0][axis] = a.min(b).min(c);
            ends[1][axis] = a.max(b).max(c);
        }
        let offsets = [points[0].texel[0], points[0].texel[1], 0.0, 0.0];
        let sample =
            std::array::from_fn(|i| Affine { offset: offsets[i], slope: along_diagonal(gradients[i]) });
        let off_middle = Affine { offset: 0.0, slope: n.map(|c| c / dot(n, signs)) };
        // Towards more u and more v, and between the two, as far as a cube of edge 2 lets them go. Where u and v
        // run along one line, what is left between them is rounding that may leave the plane: no way at all.
        let to_cube = |d: [f64; 3], least: f64| {
            let most = d[0].abs().max(d[1].abs()).max(d[2].abs());
            if most > least { d.map(|c| c / most) } else { [0.0; 3] }
        };
        let [u, v] = [to_cube(gradients[0], 0.0), to_cube(gradients[1], 0.0)];
        let between = |sign: f64| to_cube(std::array::from_fn(|i| u[i] + sign * v[i]), MIN_BETWEEN);
        let ways = [u, v, between(1.0), between(-1.0)];
        let around = std::array::from_fn(|i| {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            gradients.map(|g| sign * dot(g, ways[i / 2]))
        });
        let texels_to_end = [1, SQUARE].map(|columns| {
            let half = columns as f64 / 2.0 + 2.0 * GROWN;
            let reach = column.map(|of| dot(of.slope.map(f64::abs), [half; 3]) + MARGIN);
            -index(-reach[0].max(reach[1]))
        });
        Some(Shortcuts {
            texels_to_end,
            anchor: points[0].at,
            sample,
            off_middle,
            around,
            texel,
            reach,
            along,
            column,
            ends,
        })
    }

    /// A voxel's place.
    fn place_of(&self, voxel: [i64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| voxel[axis] as f64 + 0.5 - self.anchor[axis])
    }

    /// At the plane's point on the voxel's diagonal. The plane must meet the voxel.
    fn first_sample(&self, place: [f64; 3]) -> Sample {
        self.sample.map(|of| of.at(place))
    }

    /// At more points of the plane in the voxel.
    fn samples_around(&self, first: Sample, place: [f64; 3]) -> impl Iterator<Item = Sample> {
        let room = 0.5 - self.off_middle.at(place).abs();
        self.around.iter().map(move |add| std::array::from_fn(|i| first[i] + room * add[i]))
    }

    /// The texel in the middle of a square of columns.
    fn middle_texel(&self, square: [[i64; 2]; 2]) -> [i64; 2] {
        let axes = [1, 2].map(|i| (self.along + i) % 3);
        let middle = |i: usize| (square[i][0] + square[i][1] + 1) as f64 / 2.0 - self.anchor[axes[i]];
        let (p, q) = (middle(0), middle(1));
        self.column.map(|of| index(of.offset + of.slope[axes[0]] * p + of.slope[axes[1]] * q))
    }

    /// A box of texels that holds those of the triangle's part in the voxel.
    fn texels_around(&self, place: [f64; 3]) -> TexelBox {
        self.texel_box(std::array::from_fn(|axis| {
            let each = self.texel[axis].iter().zip(&self.reach[axis]);
            each.fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], (texel, reach)| {
                let middle = texel.at(place);
                [low.max(middle - reach), high.min(middle + reach)]
            })
        }))
    }

    /// From low and high ends along u and v, never beyond the triangle's.
    fn texel_box(&self, [u, v]: [[f64; 2]; 2]) -> TexelBox {
        let low = |[low, _]: [f64; 2], axis: usize| index(low.max(self.ends[0][axis]));
        let high = |[_, high]: [f64; 2], axis: usize| -index(-high.min(self.ends[1][axis])) - 1;
        let min = [low(u, 0), low(v, 1)];
        TexelBox { min, max: [high(u, 0).max(min[0]), high(v, 1).max(min[1])] }
    }
}

/// A sample's texel, if the sample lies in the triangle, clear of the borders of triangle and texel.
fn texel_of([u, v, second, third]: Sample) -> Option<[i64; 2]> {
    if second < INSIDE || third < INSIDE || 1.0 - second - third < INSIDE {
        return None;
    }
    let texel = [index(u), index(v)];
    let clear = |at: f64, texel: i64| (MARGIN..=1.0 - MARGIN).contains(&(at - texel as f64));
    (clear(u, texel[0]) && clear(v, texel[1])).then_some(texel)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
