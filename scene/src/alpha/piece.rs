//! Questions about a piece of a triangle (a convex polygon in texels): does it touch a present texel,
//! and which share of it is present.

use super::{Cut, TexelBox, Verdict};
use crate::mesh::Wrap;

/// Most lines along which [`Cut::share`] measures.
const LINES: usize = 32;

/// Rows of texels that are ruled out together.
const ROWS: i64 = 8;

/// How far a group of rows looks beyond the piece, texels: more than the rounding of its crossings.
const SLACK: f64 = 1e-6;

impl Cut {
    /// Moves a triangle's texel coordinates by whole turns of a repeated image so that they start near 0.
    pub fn near_origin(&self, texels: &mut [[f64; 2]; 3]) {
        for axis in 0..2 {
            let turn = match self.wrap[axis] {
                Wrap::Clamp => continue,
                Wrap::Repeat => self.size[axis] as f64,
                Wrap::Mirror => 2.0 * self.size[axis] as f64,
            };
            let least = texels.iter().fold(f64::INFINITY, |least, texel| least.min(texel[axis]));
            let shift = libm::floor(least / turn) * turn;
            texels.iter_mut().for_each(|texel| texel[axis] -= shift);
        }
    }

    /// Whether a piece of a triangle whose texels are `within` touches a present texel: in each row of
    /// texels that the piece meets, the texels from its leftmost to its rightmost point in that row
    /// (borders as in [`TexelBox::of`]). A piece that spans two turns of the image or more along an axis
    /// is judged by its box. False for an empty piece.
    pub fn touches(&self, piece: &[[f64; 2]], within: &TexelBox) -> bool {
        let Some(texels) = texels_of(piece, within) else { return false };
        match self.verdict(&texels) {
            Verdict::Absent => return false,
            Verdict::Present => return true,
            Verdict::Mixed => {}
        }
        if self.judged_by_box(&texels) {
            return self.any_in_box(&texels);
        }
        let [first, last] = self.rows_of(&texels);
        // The middle row first: a piece that is half there mostly shows it.
        let middle = first.midpoint(last);
        if self.row_touches(piece, &texels, middle) {
            return true;
        }
        let mut row = first;
        while row <= last {
            let end = (row.div_euclid(ROWS) * ROWS + ROWS - 1).min(last);
            // A group of all rows would tell no more than the box did.
            let absent = || {
                self.extent(piece, row, end).is_some_and(|[low, high]| {
                    let reach = TexelBox::of([low - SLACK, row as f64], [high + SLACK, end as f64]);
                    let group = TexelBox { min: [reach.min[0], row], max: [reach.max[0], end] };
                    self.absent(&group.clamped(&texels))
                })
            };
            if ([row, end] == [first, last] || !absent())
                && (row..=end).any(|row| row != middle && self.row_touches(piece, &texels, row))
            {
                return true;
            }
            row = end + 1;
        }
        false
    }

    /// [`Cut::touches`] without its tables: row by row, texel by texel.
    pub fn touches_by_every_texel(&self, piece: &[[f64; 2]], within: &TexelBox) -> bool {
        let Some(texels) = texels_of(piece, within) else { return false };
        let [first, last] = self.rows_of(&texels);
        let any =
            |row: i64, columns: [i64; 2]| (columns[0]..=columns[1]).any(|column| self.present([column, row]));
        if self.judged_by_box(&texels) {
            return (first..=last).any(|row| any(row, [texels.min[0], texels.max[0]]));
        }
        (first..=last).any(|row| {
            let extent = self.extent(piece, row, row);
            extent.is_some_and(|[low, high]| {
                let span = TexelBox::of([low, 0.0], [high, 0.0]).clamped(&texels);
                any(row, [span.min[0], span.max[0]])
            })
        })
    }

    /// The share of a piece that is present, 0..=1, for a triangle whose texels are `within`: exact along
    /// each of at most 32 lines of constant v (several per row of texels where the rows are few), summed
    /// as a midpoint rule.
    pub fn share(&self, piece: &[[f64; 2]], within: &TexelBox) -> f64 {
        let Some(texels) = texels_of(piece, within) else { return 0.0 };
        match self.verdict(&texels) {
            Verdict::Absent => return 0.0,
            Verdict::Present => return 1.0,
            Verdict::Mixed => {}
        }
        let ends = |axis: usize| {
            piece.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
                [low.min(p[axis]), high.max(p[axis])]
            })
        };
        let ([left, right], [top, bottom]) = (ends(0), ends(1));
        let mut lines = Lines::new();
        let rows = texels.max[1].saturating_sub(texels.min[1]).saturating_add(1);
        if rows <= LINES as i64 {
            let per_row = LINES / rows as usize;
            for row in texels.min[1]..=texels.max[1] {
                lines.add((row as f64).max(top), (row as f64 + 1.0).min(bottom), per_row);
            }
        } else {
            lines.add(top, bottom, LINES);
        }
        lines.cross(piece);
        let (mut present, mut all) = (0.0, 0.0);
        for line in 0..lines.count {
            let (low, high) = (lines.low[line], lines.high[line]);
            if low <= high {
                let row = super::index(lines.y[line]).clamp(texels.min[1], texels.max[1]);
                present += self.present_between(self.wrapped(1, row), low, high) * lines.weight[line];
                all += (high - low) * lines.weight[line];
            }
        }
        if all > 0.0 {
            return (present / all).clamp(0.0, 1.0);
        }
        // No area in the image (a constant uv, or one line of it): the texel in the middle decides.
        let texel = TexelBox::of(
            [left.midpoint(right), top.midpoint(bottom)],
            [left.midpoint(right), top.midpoint(bottom)],
        )
        .clamped(within);
        if self.bit(self.wrapped(0, texel.min[0]), self.wrapped(1, texel.min[1])) { 1.0 } else { 0.0 }
    }

    fn judged_by_box(&self, texels: &TexelBox) -> bool {
        (0..2).any(|axis| {
            let span = texels.max[axis].saturating_sub(texels.min[axis]);
            self.wrap[axis] != Wrap::Clamp && span >= 2 * self.size[axis] as i64
        })
    }

    fn any_in_box(&self, texels: &TexelBox) -> bool {
        let (rows, count) = self.runs(1, texels.min[1], texels.max[1]);
        rows[..count].iter().any(|&(first, last)| {
            (first..=last).any(|row| self.any_in_row(row, texels.min[0], texels.max[0]))
        })
    }

    /// First and last row to look at; beyond the borders of a clamped image lies only its outermost row.
    fn rows_of(&self, texels: &TexelBox) -> [i64; 2] {
        let rows = [texels.min[1], texels.max[1]];
        match self.wrap[1] {
            Wrap::Clamp => rows.map(|row| row.clamp(0, self.size[1] as i64 - 1)),
            _ => rows,
        }
    }

    /// Leftmost and rightmost point of the piece in rows `first..=last`.
    fn extent(&self, piece: &[[f64; 2]], first: i64, last: i64) -> Option<[f64; 2]> {
        let (mut top, mut bottom) = (first as f64, last as f64 + 1.0);
        if self.wrap[1] == Wrap::Clamp {
            top = if first <= 0 { f64::NEG_INFINITY } else { top };
            bottom = if last >= self.size[1] as i64 - 1 { f64::INFINITY } else { bottom };
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut add = |x: f64| (low, high) = (lesser(low, x), greater(high, x));
        let mut a = piece[piece.len() - 1];
        for &b in piece {
            if top <= b[1] && b[1] <= bottom {
                add(b[0]);
            }
            for border in [top, bottom] {
                if (a[1] < border) != (b[1] < border) {
                    add(crossing_x(a, b, border));
                }
            }
            a = b;
        }
        (low <= high).then_some([low, high])
    }

    fn row_touches(&self, piece: &[[f64; 2]], texels: &TexelBox, row: i64) -> bool {
        let Some([low, high]) = self.extent(piece, row, row) else { return false };
        let span = TexelBox::of([low, 0.0], [high, 0.0]).clamped(texels);
        self.any_in_row(self.wrapped(1, row), span.min[0], span.max[0])
    }
}

/// The texels of a piece's box, never beyond the triangle's own.
fn texels_of(piece: &[[f64; 2]], within: &TexelBox) -> Option<TexelBox> {
    let first = *piece.first()?;
    let (mut min, mut max) = (first, first);
    for point in piece {
        for axis in 0..2 {
            min[axis] = min[axis].min(point[axis]);
            max[axis] = max[axis].max(point[axis]);
        }
    }
    Some(TexelBox::of(min, max).clamped(within))
}

/// Where the edge from `a` to `b` crosses the line of constant y; never beyond the edge's ends.
fn crossing_x(a: [f64; 2], b: [f64; 2], y: f64) -> f64 {
    let share = (y - a[1]) / (b[1] - a[1]);
    let x = a[0] + share * (b[0] - a[0]);
    lesser(greater(x, lesser(a[0], b[0])), greater(a[0], b[0]))
}

/// `f64::min` for what is no NaN: one instruction.
fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// `f64::max` for what is no NaN: one instruction.
fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Lines of constant y, and where they enter and leave a piece.
struct Lines {
    y: [f64; LINES],
    /// The distance between lines.
    weight: [f64; LINES],
    /// Above `high` where a line misses the piece.
    low: [f64; LINES],
    high: [f64; LINES],
    count: usize,
}

impl Lines {
    fn new() -> Lines {
        let (low, high) = ([f64::INFINITY; LINES], [f64::NEG_INFINITY; LINES]);
        Lines { y: [0.0; LINES], weight: [0.0; LINES], low, high, count: 0 }
    }

    /// Lines in the middle of `count` equal parts from `from` to `to`; above all lines so far.
    fn add(&mut self, from: f64, to: f64, count: usize) {
        let step = (to - from) / count as f64;
        for i in 0..count {
            self.y[self.count + i] = from + (i as f64 + 0.5) * step;
            self.weight[self.count + i] = step;
        }
        self.count += count;
    }

    fn cross(&mut self, piece: &[[f64; 2]]) {
        let y = &self.y[..self.count];
        let mut a = piece[piece.len() - 1];
        for &b in piece {
            let (upper, lower) = if a[1] < b[1] { (a[1], b[1]) } else { (b[1], a[1]) };
            let until = |end: f64| y.iter().filter(|&&y| y <= end).count();
            let crossed = until(upper)..until(lower);
            let ends = self.low[crossed.clone()].iter_mut().zip(&mut self.high[crossed.clone()]);
            for (&y, (low, high)) in y[crossed].iter().zip(ends) {
                let x = crossing_x(a, b, y);
                (*low, *high) = (lesser(*low, x), greater(*high, x));
            }
            a = b;
        }
    }
}
