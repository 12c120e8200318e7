//! Closed shells of leaf: a blade that was given a thickness, a needle that is a tube.
//!
//! ```text
//! leaves -same points-> parts -edges of two triangles-> pieces -area, volume, holes-> thin, thick or open
//! ```
//!
//! The windings of a piece need not agree: they are brought to agree over its edges, and the sign of the volume tells
//! which side is outside. Its holes are closed by fans for that, and if these are large it is no shell.

use glam::DVec3;
use rayon::prelude::*;

use super::points::points;
use super::union::Union;
use super::{corners, set};
use crate::Mesh;
use crate::mesh::sides::{Sheets, Side};

/// So many triangles less than points has a part that may be closed, at most: a spike without a foot has one less.
/// Closed ones have nearly twice as many as points, a tube without ends as many, a card half.
const FEWER_TRIANGLES: u32 = 1;

/// Area of all holes, as a share of the area, up to which a piece is closed.
const HOLES: f64 = 0.1;

/// Mean thickness up to which a shell is one leaf, as a share of its own longest edge and of the plant's.
const THIN: [f64; 2] = [0.1, 0.02];

/// Mean thickness from which a shell has an inside that can be told, as a share of its longest edge and of the largest
/// coordinate. What is thinner is two sheets that lie on each other.
const HOLLOW: [f64; 2] = [1e-5, 1e-6];

/// No neighbour.
const NONE: u32 = u32::MAX;

/// Gives the triangles of thin shells their outer side, and sums up the thick ones.
pub(super) fn find(mesh: &Mesh, leaves: &[u32], longest_m: f64, found: &mut Sheets) {
    let (points, count) = points(mesh, leaves);
    let parts = closed_parts(&points, count);
    if parts.is_empty() {
        return;
    }
    let edges = Edges::of(&points, &parts);
    let pieces = Pieces::of(&edges, &parts);
    let measures = measure(mesh, leaves, &points, &parts, &edges, &pieces, count);
    for (piece, measure) in measures.iter().enumerate() {
        let shape = measure.shape(longest_m);
        if shape == Shape::Open {
            continue;
        }
        if shape == Shape::Thick {
            found.thick.area_m2 += measure.area_m2;
            found.thick.thickness_m = found.thick.thickness_m.max(measure.thickness_m());
            continue;
        }
        for &place in pieces.of_piece(piece) {
            let outwards = pieces.turned[place as usize] == (measure.volume_m3 < 0.0);
            let side = if outwards { Side::Front } else { Side::Back };
            set(found, mesh, leaves[parts[place as usize] as usize], side);
        }
        found.shells.triangles += pieces.of_piece(piece).len() as u64;
        found.shells.area_m2 += measure.area_m2;
    }
}

/// Indices of the leaves whose part, all that shares points, may be closed; ascending.
fn closed_parts(points: &[[u32; 3]], count: usize) -> Vec<u32> {
    let mut union = Union::new(count);
    for &[a, b, c] in points {
        union.join(a, b);
        union.join(b, c);
    }
    // `[lowest point of the part]`: points, triangles.
    let mut sizes = vec![[0u32; 2]; count];
    (0..count as u32).for_each(|point| sizes[union.root(point) as usize][0] += 1);
    points.iter().for_each(|corners| sizes[union.root(corners[0]) as usize][1] += 1);
    let may_be_closed = |corners: &[u32; 3], union: &mut Union| {
        let [of_points, of_triangles] = sizes[union.root(corners[0]) as usize];
        of_triangles + FEWER_TRIANGLES >= of_points
    };
    (0u32..)
        .zip(points)
        .filter(|(_, corners)| may_be_closed(corners, &mut union))
        .map(|(leaf, _)| leaf)
        .collect()
}

/// What lies beyond the edges of triangles.
struct Edges {
    /// `[place][edge]`: the place of the only other triangle there, and whether both run along it in one direction.
    beyond: Vec<[(u32, bool); 3]>,
    /// Place and edge of those that an odd number of triangles has: the borders of holes.
    borders: Vec<(u32, u8)>,
}

impl Edges {
    fn of(points: &[[u32; 3]], parts: &[u32]) -> Edges {
        let mut all: Vec<(u64, u32, u8)> = parts
            .par_iter()
            .enumerate()
            .flat_map_iter(|(place, &leaf)| {
                let corners = points[leaf as usize];
                (0..3u8).map(move |edge| {
                    let [a, b] = ends(corners, edge);
                    (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), place as u32, edge)
                })
            })
            .collect();
        all.par_sort_unstable();
        let mut beyond = vec![[(NONE, false); 3]; parts.len()];
        let mut borders = Vec::new();
        for run in all.chunk_by(|a, b| a.0 == b.0) {
            if let &[(_, this, edge), (_, other, of_other)] = run {
                let from = |place: u32, edge: u8| ends(points[parts[place as usize] as usize], edge)[0];
                let alike = from(this, edge) == from(other, of_other);
                beyond[this as usize][usize::from(edge)] = (other, alike);
                beyond[other as usize][usize::from(of_other)] = (this, alike);
            } else if run.len() % 2 == 1 {
                borders.extend(run.iter().map(|&(_, place, edge)| (place, edge)));
            }
        }
        Edges { beyond, borders }
    }
}

/// The ends of an edge, as a triangle runs along it.
fn ends(corners: [u32; 3], edge: u8) -> [u32; 2] {
    [corners[usize::from(edge)], corners[usize::from(edge + 1) % 3]]
}

/// Triangles that hold together over edges.
struct Pieces {
    /// `[place]`: its piece.
    piece: Vec<u32>,
    /// `[place]`: whether its winding has to be turned to agree with the first of its piece.
    turned: Vec<bool>,
    /// Places, piece by piece.
    order: Vec<u32>,
    /// Where each piece starts in `order`, and the end of the last.
    starts: Vec<u32>,
    /// `[piece]`: whether its windings can be brought to agree.
    agrees: Vec<bool>,
}

impl Pieces {
    fn of(edges: &Edges, parts: &[u32]) -> Pieces {
        let mut pieces = Pieces {
            piece: vec![NONE; parts.len()],
            turned: vec![false; parts.len()],
            order: Vec::with_capacity(parts.len()),
            starts: vec![0],
            agrees: Vec::new(),
        };
        for first in 0..parts.len() as u32 {
            if pieces.piece[first as usize] != NONE {
                continue;
            }
            let piece = pieces.agrees.len() as u32;
            let mut agrees = true;
            let mut at = pieces.order.len();
            pieces.piece[first as usize] = piece;
            pieces.order.push(first);
            while let Some(&this) = pieces.order.get(at) {
                at += 1;
                for &(other, alike) in edges.beyond[this as usize].iter().filter(|(other, _)| *other != NONE)
                {
                    let turned = pieces.turned[this as usize] != alike;
                    if pieces.piece[other as usize] == NONE {
                        pieces.piece[other as usize] = piece;
                        pieces.turned[other as usize] = turned;
                        pieces.order.push(other);
                    }
                    agrees &= pieces.turned[other as usize] == turned;
                }
            }
            pieces.agrees.push(agrees);
            pieces.starts.push(pieces.order.len() as u32);
        }
        pieces
    }

    fn of_piece(&self, piece: usize) -> &[u32] {
        &self.order[self.starts[piece] as usize..self.starts[piece + 1] as usize]
    }
}

/// What a piece is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    Open,
    Thin,
    Thick,
}

/// A piece in numbers.
#[derive(Debug, Clone, Copy)]
struct Measure {
    agrees: bool,
    area_m2: f64,
    /// Above 0 where the winding of its first triangle looks outwards.
    volume_m3: f64,
    /// Of the fans that close its holes.
    holes_m2: f64,
    low: DVec3,
    high: DVec3,
}

impl Measure {
    fn thickness_m(&self) -> f64 {
        2.0 * self.volume_m3.abs() / self.area_m2
    }

    fn shape(&self, plant_m: f64) -> Shape {
        let longest_m = (self.high - self.low).max_element();
        let largest_m = self.high.abs().max(self.low.abs()).max_element();
        let is_closed = self.agrees && self.area_m2 > 0.0 && self.holes_m2 <= HOLES * self.area_m2;
        let thickness_m = self.thickness_m();
        if !is_closed || thickness_m < (HOLLOW[0] * longest_m).max(HOLLOW[1] * largest_m) {
            return Shape::Open;
        }
        let most_m = (THIN[0] * longest_m).min(THIN[1] * plant_m);
        if thickness_m <= most_m { Shape::Thin } else { Shape::Thick }
    }
}

fn measure(
    mesh: &Mesh,
    leaves: &[u32],
    points: &[[u32; 3]],
    parts: &[u32],
    edges: &Edges,
    pieces: &Pieces,
    count: usize,
) -> Vec<Measure> {
    let origin = |piece: usize| corners(mesh, leaves[parts[pieces.of_piece(piece)[0] as usize] as usize])[0];
    let of_piece = |piece: usize| {
        let from = origin(piece);
        let (low, high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let agrees = pieces.agrees[piece];
        let mut measure = Measure { agrees, area_m2: 0.0, volume_m3: 0.0, holes_m2: 0.0, low, high };
        for &place in pieces.of_piece(piece) {
            let [a, b, c] = corners(mesh, leaves[parts[place as usize] as usize]);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            (measure.low, measure.high) = (measure.low.min(low), measure.high.max(high));
            let cross = (b - a).cross(c - a);
            let volume = (a - from).dot(cross) / 6.0;
            measure.area_m2 += cross.length() / 2.0;
            measure.volume_m3 += if pieces.turned[place as usize] { -volume } else { volume };
        }
        measure
    };
    let mut measures: Vec<Measure> =
        (0..pieces.agrees.len()).into_par_iter().with_min_len(64).map(of_piece).collect();
    // Borders that share points belong to one hole.
    let mut union = Union::new(count);
    let of_border = |&(place, edge): &(u32, u8)| ends(points[parts[place as usize] as usize], edge);
    edges.borders.iter().map(of_border).for_each(|[a, b]| union.join(a, b));
    let mut borders: Vec<(u32, u32, u32, u8)> = edges
        .borders
        .iter()
        .map(|border| (pieces.piece[border.0 as usize], union.root(of_border(border)[0]), border.0, border.1))
        .collect();
    borders.sort_unstable();
    for hole in borders.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let piece = hole[0].0 as usize;
        let line = |&(_, _, place, edge): &(u32, u32, u32, u8)| {
            let corners = corners(mesh, leaves[parts[place as usize] as usize]);
            let [a, b] = [corners[usize::from(edge)], corners[usize::from(edge + 1) % 3]];
            if pieces.turned[place as usize] { [b, a] } else { [a, b] }
        };
        let (mut middle, mut length) = (DVec3::ZERO, 0.0);
        for [a, b] in hole.iter().map(line) {
            middle += a.distance(b) * (a + b) / 2.0;
            length += a.distance(b);
        }
        middle /= length;
        for [a, b] in hole.iter().map(line) {
            // The fan runs along the edge against the triangle.
            let cross = (a - b).cross(middle - b);
            measures[piece].holes_m2 += cross.length() / 2.0;
            measures[piece].volume_m3 += (b - origin(piece)).dot(cross) / 6.0;
        }
    }
    measures
}
