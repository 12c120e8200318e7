//! From triangles to surface area per site: each triangle is cut at the faces of the sites, and each piece's
//! area, times its present share and the share that counts, is added in whole units. Layer by layer of sites along z.

use std::sync::atomic::{AtomicUsize, Ordering};

use flb_format::progress::{Cancelled, Progress};
use rayon::prelude::*;

use super::Scene;
use super::occupancy::{AREA_UNITS_PER_SITE_FACE, SiteArea};
use super::piece::{MAX_POINTS, Piece, PiecePoint};
use super::triangle::{CutTriangle, Snapped, UNITS};

/// Areas of all sites with surface in them, sorted by site.
pub(super) fn measure(scene: &Scene, progress: &Progress<'_>) -> Result<Vec<SiteArea>, Cancelled> {
    let units_per_site = i64::from(scene.voxels_per_site()) * UNITS;
    let layers = scene.layers(units_per_site);
    let edge = scene.grid.lattice as usize;
    let done = AtomicUsize::new(0);
    let areas = (0..layers.count())
        .into_par_iter()
        .with_max_len(1)
        .map_init(
            || (vec![[0u64; 2]; edge * edge], Room::new()),
            |(sums, room), z| {
                let mut layer = Layer { edge, sums, touched: Vec::new() };
                for &triangle in layers.of(z) {
                    if let Some(triangle) = scene.snapped(triangle as usize) {
                        layer.add(&triangle, units_per_site as f64, z as f64, room);
                    }
                }
                progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / layers.count() as f64)?;
                Ok(layer.finish(z))
            },
        )
        .collect::<Result<Vec<Vec<SiteArea>>, Cancelled>>()?;
    Ok(areas.concat())
}

/// Room for the parts of one triangle after the other.
struct Room {
    layer: [Piece; 2],
    rows: [Piece; 3],
    sites: [Piece; 3],
}

impl Room {
    fn new() -> Room {
        Room { layer: [Piece::EMPTY; 2], rows: [Piece::EMPTY; 3], sites: [Piece::EMPTY; 3] }
    }
}

/// One layer of sites while it fills.
struct Layer<'s> {
    edge: usize,
    /// `[y][x][leaf, wood]`; all 0 between layers.
    sums: &'s mut Vec<[u64; 2]>,
    /// Places that are no longer 0.
    touched: Vec<u32>,
}

impl Layer<'_> {
    fn add(&mut self, triangle: &Snapped, units_per_site: f64, z: f64, room: &mut Room) {
        let points = std::array::from_fn(|i| PiecePoint {
            at: triangle.vertices[i].map(|c| c as f64 / units_per_site),
            texel: triangle.cut.as_ref().map_or([0.0; 2], |cut| cut.texels[i]),
        });
        let Room { layer: [layer, other], rows, sites } = room;
        let (mut layer, mut other) = (layer, other);
        layer.become_triangle(points);
        let [low, high] = layer.span(2);
        if low < z {
            other.become_part_above(layer, 2, z);
            std::mem::swap(&mut layer, &mut other);
        }
        if high >= z + 1.0 {
            other.become_part_below(layer, 2, z + 1.0);
            std::mem::swap(&mut layer, &mut other);
        }
        for_each_slab(layer, 1, rows, |y, row| {
            for_each_slab(row, 0, sites, |x, piece| {
                let area = piece.area() * triangle.counted * present_share(piece, triangle.cut.as_ref());
                let units = libm::round(area * AREA_UNITS_PER_SITE_FACE) as u64;
                self.add_units(y * self.edge + x, triangle.wood, units);
            });
        });
    }

    fn add_units(&mut self, place: usize, wood: bool, units: u64) {
        if units == 0 {
            return;
        }
        let sums = &mut self.sums[place];
        if *sums == [0; 2] {
            self.touched.push(place as u32);
        }
        let sum = &mut sums[usize::from(wood)];
        *sum = sum.saturating_add(units);
    }

    fn finish(mut self, z: usize) -> Vec<SiteArea> {
        self.touched.sort_unstable();
        let site_areas = self.touched.iter().map(|&place| {
            let [leaf, wood] = std::mem::take(&mut self.sums[place as usize]);
            SiteArea { site: (z * self.edge * self.edge) as u32 + place, leaf, wood }
        });
        site_areas.collect()
    }
}

/// Cuts a piece at the whole coordinates of an axis and visits the parts with their lower coordinate.
fn for_each_slab(piece: &Piece, axis: usize, room: &mut [Piece; 3], mut visit: impl FnMut(usize, &Piece)) {
    if piece.points().is_empty() {
        return;
    }
    let [low, high] = piece.span(axis);
    let mut at = libm::floor(low);
    if high <= at + 1.0 {
        return visit(at as usize, piece);
    }
    let [rest, above, below] = room;
    let (mut rest, mut above) = (rest, above);
    rest.become_copy(piece);
    while high > at + 1.0 {
        below.become_clipped(rest, axis, at + 1.0, -1.0);
        above.become_clipped(rest, axis, at + 1.0, 1.0);
        visit(at as usize, below);
        std::mem::swap(&mut rest, &mut above);
        at += 1.0;
    }
    visit(at as usize, rest);
}

/// The present share of a piece. Above 0 only where the piece overlaps a present texel, so a site with area
/// has an occupied voxel.
fn present_share(piece: &Piece, cut: Option<&CutTriangle>) -> f64 {
    let Some(CutTriangle { cut, within, .. }) = cut else { return 1.0 };
    cut.share(piece.texels(&mut [[0.0; 2]; MAX_POINTS]), within)
}
