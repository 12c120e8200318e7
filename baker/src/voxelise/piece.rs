//! Pieces of a triangle: convex polygons that planes cut off, with texels that go along.

/// A point of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PiecePoint {
    /// Position, in the unit of the caller's planes.
    pub at: [f64; 3],
    /// Texels.
    pub texel: [f64; 2],
}

/// Most points of a piece: a triangle cut by a box has at most 9.
pub(super) const MAX_POINTS: usize = 10;

/// A convex polygon.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    points: [PiecePoint; MAX_POINTS],
    len: usize,
}

impl Piece {
    /// No points at all.
    pub(super) const EMPTY: Piece =
        Piece { points: [PiecePoint { at: [0.0; 3], texel: [0.0; 2] }; MAX_POINTS], len: 0 };

    /// Turns this piece into a triangle.
    pub(super) fn become_triangle(&mut self, points: [PiecePoint; 3]) {
        self.points[..3].copy_from_slice(&points);
        self.len = 3;
    }

    pub(super) fn points(&self) -> &[PiecePoint] {
        &self.points[..self.len]
    }

    /// The points' texels; `buffer` holds them.
    pub(super) fn texels<'b>(&self, buffer: &'b mut [[f64; 2]; MAX_POINTS]) -> &'b [[f64; 2]] {
        for (texel, point) in buffer.iter_mut().zip(self.points()) {
            *texel = point.texel;
        }
        &buffer[..self.len]
    }

    /// Smallest and largest coordinate along an axis; (inf, -inf) for an empty piece.
    pub(super) fn span(&self, axis: usize) -> [f64; 2] {
        let start = [f64::INFINITY, f64::NEG_INFINITY];
        self.points().iter().fold(start, |[low, high], p| {
            let at = p.at[axis];
            [if at < low { at } else { low }, if at > high { at } else { high }]
        })
    }

    fn push(&mut self, point: PiecePoint) {
        // Rounding may bend a polygon so that a plane crosses it more than twice; what exceeds its room is
        // then a repetition within rounding.
        if self.len < self.points.len() {
            self.points[self.len] = point;
            self.len += 1;
        }
    }

    /// Turns this piece into a copy of another: of its points, not of its room for more.
    pub(super) fn become_copy(&mut self, of: &Piece) {
        self.points[..of.len].copy_from_slice(of.points());
        self.len = of.len;
    }

    /// Turns this piece into the part of another where `sign * (at[axis] - plane) >= 0`, closed.
    pub(super) fn become_clipped(&mut self, of: &Piece, axis: usize, plane: f64, sign: f64) {
        let side = |point: &PiecePoint| sign * (point.at[axis] - plane);
        self.len = 0;
        let Some(mut a) = of.points().last() else { return };
        let mut a_side = side(a);
        for b in of.points() {
            let b_side = side(b);
            if (a_side < 0.0) != (b_side < 0.0) && a_side != 0.0 && b_side != 0.0 {
                self.push(between(a, b, axis, plane));
            }
            if b_side >= 0.0 {
                self.push(*b);
            }
            (a, a_side) = (b, b_side);
        }
    }

    /// Turns this piece into the part of another above a plane; a piece that lies in the plane counts as above,
    /// of one that touches it from below nothing does.
    pub(super) fn become_part_above(&mut self, of: &Piece, axis: usize, plane: f64) {
        let [low, high] = of.span(axis);
        if low >= plane {
            self.become_copy(of);
        } else if high <= plane {
            self.len = 0;
        } else {
            self.become_clipped(of, axis, plane, 1.0);
        }
    }

    /// Turns this piece into what [`Piece::become_part_above`] leaves of another.
    pub(super) fn become_part_below(&mut self, of: &Piece, axis: usize, plane: f64) {
        let [low, high] = of.span(axis);
        if low >= plane {
            self.len = 0;
        } else if high <= plane {
            self.become_copy(of);
        } else {
            self.become_clipped(of, axis, plane, -1.0);
        }
    }

    /// Area in the square of the unit of position.
    pub(super) fn area(&self) -> f64 {
        let Some((first, rest)) = self.points().split_first() else { return 0.0 };
        let from_first =
            |p: &PiecePoint| -> [f64; 3] { std::array::from_fn(|axis| p.at[axis] - first.at[axis]) };
        let twice = rest.windows(2).fold([0.0; 3], |sum, pair| {
            let normal = cross(from_first(&pair[0]), from_first(&pair[1]));
            std::array::from_fn(|axis| sum[axis] + normal[axis])
        });
        (twice[0] * twice[0] + twice[1] * twice[1] + twice[2] * twice[2]).sqrt() / 2.0
    }
}

/// The point of the edge where it crosses the plane; texels never leave the range of the edge's ends.
fn between(a: &PiecePoint, b: &PiecePoint, axis: usize, plane: f64) -> PiecePoint {
    let share = (plane - a.at[axis]) / (b.at[axis] - a.at[axis]);
    let mix = |a: f64, b: f64| {
        // As `clamp` does, without its branches.
        let (mixed, [low, high]) = (a + share * (b - a), if b < a { [b, a] } else { [a, b] });
        let mixed = if mixed < low { low } else { mixed };
        if mixed > high { high } else { mixed }
    };
    let mut at: [f64; 3] = std::array::from_fn(|i| mix(a.at[i], b.at[i]));
    at[axis] = plane;
    PiecePoint { at, texel: std::array::from_fn(|i| mix(a.texel[i], b.texel[i])) }
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
