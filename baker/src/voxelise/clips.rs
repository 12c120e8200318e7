//! Clips one piece to many voxels, and keeps what voxels of the same x share.

use super::piece::{Piece, PiecePoint};

/// How far a voxel is grown, in voxels, before a triangle is clipped to it.
pub(super) const GROWN: f64 = 1.0 / (1u64 << 20) as f64;

/// Slabs of voxels that are kept.
const SLABS: usize = 8;

/// A piece and its parts; one for many pieces, so that the room for points is made once.
pub(super) struct Clips {
    piece: Piece,
    /// The x of the part at `x % SLABS` of `in_slab`.
    slab: [Option<i64>; SLABS],
    in_slab: [Piece; SLABS],
    in_row: Piece,
    in_voxel: Piece,
    halfway: Piece,
}

impl Clips {
    /// Of no piece.
    pub(super) fn new() -> Clips {
        let empty = Piece::EMPTY;
        Clips {
            piece: empty,
            slab: [None; SLABS],
            in_slab: [empty; SLABS],
            in_row: empty,
            in_voxel: empty,
            halfway: empty,
        }
    }

    /// Takes another piece.
    pub(super) fn take(&mut self, points: [PiecePoint; 3]) {
        self.piece.become_triangle(points);
        self.slab = [None; SLABS];
    }

    /// The piece inside a grown voxel.
    pub(super) fn within(&mut self, [x, y, z]: [i64; 3]) -> &Piece {
        let at = x.rem_euclid(SLABS as i64) as usize;
        let slab = &mut self.in_slab[at];
        if self.slab[at] != Some(x) {
            self.slab[at] = Some(x);
            if !clip(&self.piece, slab, &mut self.halfway, 0, x) {
                slab.become_copy(&self.piece);
            }
        }
        let row = if clip(slab, &mut self.in_row, &mut self.halfway, 1, y) { &self.in_row } else { slab };
        if clip(row, &mut self.in_voxel, &mut self.halfway, 2, z) { &self.in_voxel } else { row }
    }
}

/// Turns `to` into the part of a piece in the grown slab of voxels `at` along an axis; false, and nothing
/// done, where that is the whole piece.
fn clip(piece: &Piece, to: &mut Piece, halfway: &mut Piece, axis: usize, at: i64) -> bool {
    let (below, above) = (at as f64 - GROWN, at as f64 + 1.0 + GROWN);
    let [low, high] = piece.span(axis);
    match (low < below, high > above) {
        (false, false) => return false,
        (true, false) => to.become_clipped(piece, axis, below, 1.0),
        (false, true) => to.become_clipped(piece, axis, above, -1.0),
        (true, true) => {
            halfway.become_clipped(piece, axis, below, 1.0);
            to.become_clipped(halfway, axis, above, -1.0);
        }
    }
    true
}
