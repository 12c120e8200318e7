//! What every site of a lattice sends along each direction, held once and updated in place.
//!
//! A site finds the 18 values that arrive at it, and puts the 18 that it sends into the very same places, each where
//! the opposite one was (Bailey, Myre, Walsh, Lilja and Saar 2009, the AA pattern). So light that was sent waits at the
//! sender, in the slot of the opposite direction, after one update, and at the receiver, in its own slot, after the
//! next. No two sites ever touch the same place in one update: sites go in any order, planes on all cores.
//!
//! An empty site only exchanges opposite values. All sites do that, a row at a time; then those that hold matter
//! find what arrives where they have to put what they send.

use std::ops::Range;

use flb_format::direction::DIRECTIONS;
use rayon::prelude::*;

use super::super::dense;
use super::super::kernel::{Gain, LANES, Lanes};
use super::MOVING;
use super::matter::{Run, SiteList};

/// Values between one slot's plane and the next, so that the same row of all 18 does not fall into the same set of
/// the first-level cache: 3 of its 64 lines on.
const PAD: usize = 48;

/// Rows whose opposite light is exchanged before their matter has its turn: few enough that they are still in the
/// second-level cache then, many enough that memory is read in long pieces, two at a time.
const ROW_GROUP: usize = 16;

/// The light of one solve.
pub(super) struct Light {
    /// N.
    n: usize,
    base: usize,
    /// `[z][m - 1][y][x]`, x fastest, [`PAD`] unused values after each `[y][x]`.
    slots: Vec<f32>,
    side: Side,
}

/// Where to find what a site sent along m.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    /// In its slot opposite to m.
    Sender,
    /// In slot m of the site that it goes to.
    Receiver,
}

/// Where the sites of a plane put what they send, `[m - 1]`: one plane of one slot, `[y][x]`. None beyond the lattice.
type Places<'a> = [Option<&'a mut [f32]>; MOVING];

impl Side {
    /// Steps in x, y, z from a site to where it puts what it sends along m, and the slot's index.
    fn place(self, m: usize) -> ([isize; 3], usize) {
        match self {
            // Directions 1 and 2 are opposite to each other, and so on.
            Side::Sender => ([0; 3], (m - 1) ^ 1),
            Side::Receiver => (DIRECTIONS[m].map(|c| c as isize), m - 1),
        }
    }
}

impl Light {
    pub(super) fn new(n: usize) -> Light {
        Light { n, base: 0, slots: vec![0.0; n * MOVING * (n * n + PAD)], side: Side::Sender }
    }

    /// Boundary light in the outermost layer, none inside.
    pub(super) fn darken(&mut self, base: u8) {
        self.base = usize::from(base);
        self.side = Side::Sender;
        let (n, base) = (self.n, self.base);
        self.planes().into_par_iter().enumerate().for_each(|(z, mut places)| {
            places.iter_mut().flatten().for_each(|place| place.fill(0.0));
            (0..n).for_each(|y| hold_boundary(&mut places, Side::Sender, n, [y, z], base));
        });
    }

    /// One iteration. Sums of (phi - before)^2 and of phi^2 over the non-empty sites.
    pub(super) fn update(&mut self, matter: &mut SiteList, gains: &[Gain; 2]) -> [f64; 2] {
        self.side = if self.side == Side::Sender { Side::Receiver } else { Side::Sender };
        let (n, base, side) = (self.n, self.base, self.side);
        let planes = self.planes().into_par_iter().zip(&mut matter.planes).enumerate();
        let update = |(z, (mut places, runs)): (usize, (Places, &mut Vec<Run>))| {
            let mut sums = [0.0; 2];
            let mut runs = runs.iter_mut().peekable();
            for rows in (0..n).step_by(ROW_GROUP).map(|y| y..(y + ROW_GROUP).min(n)) {
                if is_inside(n, z) {
                    exchange_opposite(&mut places, side, n, rows.start.max(1)..rows.end.min(n - 1));
                }
                rows.clone().for_each(|y| hold_boundary(&mut places, side, n, [y, z], base));
                while let Some(run) = runs.next_if(|run| run.y < rows.end) {
                    let of_run = collide(&mut places, side, n, run, gains);
                    sums.iter_mut().zip(of_run).for_each(|(sum, part)| *sum += part);
                }
            }
            sums
        };
        let sums: Vec<[f64; 2]> = planes.map(update).collect();
        [0, 1].map(|k| sums.iter().map(|sums| sums[k]).sum::<f64>())
    }

    /// Carries light through empty sites all the way, direction by direction in the order of travel. What leaves the
    /// plant last would else not have reached the lattice's far ends.
    pub(super) fn cross_empty_sites(&mut self, matter: &SiteList) {
        let (n, side) = (self.n, self.side);
        let mut slots: [Vec<&mut [f32]>; MOVING] = Default::default();
        for (at, plane) in self.slots.chunks_mut(n * n + PAD).enumerate() {
            slots[at % MOVING].push(plane);
        }
        by_direction(slots, side).into_par_iter().enumerate().for_each(|(at, mut planes)| {
            let m = at + 1;
            let [cx, cy, cz] = DIRECTIONS[m].map(|c| c as isize);
            let ([dx, dy, dz], _) = side.place(m);
            let order = |c: isize, at: usize| if c < 0 { n - 1 - at } else { at };
            let mut of_matter = vec![];
            for z in (1..n - 1).map(|at| order(cz, at)) {
                for y in (1..n - 1).map(|at| order(cy, at)) {
                    let runs = &matter.planes[z];
                    let runs = &runs[runs.partition_point(|run| run.y < y)..];
                    let runs = runs.iter().take_while(|run| run.y == y);
                    let sites = runs.flat_map(|run| run.lanes().map(|lane| run.x + lane));
                    let to = z.wrapping_add_signed(dz);
                    // Of x = 0; sites of a row are neighbours.
                    let start = (y.wrapping_add_signed(dy) * n).wrapping_add_signed(dx);
                    let at = |x: usize| start.wrapping_add(x);
                    let upstream = |x: usize| at(x).wrapping_add_signed(-cx - cy * n as isize);
                    of_matter.clear();
                    of_matter.extend(sites.map(|x| (x, planes[to][at(x)])));
                    if cz != 0 {
                        let from = to.wrapping_add_signed(-cz);
                        let [to, from] = planes.get_disjoint_mut([to, from]).expect("different planes");
                        to[at(1)..at(n - 1)].copy_from_slice(&from[upstream(1)..upstream(n - 1)]);
                    } else if cy != 0 {
                        planes[to].copy_within(upstream(1)..upstream(n - 1), at(1));
                    } else {
                        let mut of_matter = of_matter.iter();
                        let of_matter: &mut dyn Iterator<Item = &(usize, f32)> =
                            if cx > 0 { &mut of_matter } else { &mut of_matter.rev() };
                        let mut of_matter = of_matter.peekable();
                        for x in (1..n - 1).map(|at| order(cx, at)) {
                            if of_matter.next_if(|site| site.0 == x).is_none() {
                                planes[to][at(x)] = planes[to][upstream(x)];
                            }
                        }
                    }
                    of_matter.iter().for_each(|&(x, sent)| planes[to][at(x)] = sent);
                }
            }
        });
    }

    /// Puts the sum of the light that arrives at each site inside into `phi`, `[z][y][x]`. Rounding can leave a sum of
    /// nearly nothing just below 0; light is never negative, so it ends at 0.
    pub(super) fn gather(&self, phi: &mut [f32]) {
        let (n, side) = (self.n, self.side);
        phi.par_chunks_mut(n).enumerate().for_each(|(row, phi)| {
            let (y, z) = (row % n, row / n);
            if !is_inside(n, y) || !is_inside(n, z) {
                return;
            }
            let phi = &mut phi[1..n - 1];
            phi.fill(0.0);
            for (m, c) in DIRECTIONS.iter().enumerate().skip(1) {
                let (d, slot) = side.place(m);
                let [x, y, z]: [usize; 3] = std::array::from_fn(|axis| {
                    [1, y, z][axis].wrapping_add_signed(d[axis] - c[axis] as isize)
                });
                let arriving = &self.slots[(z * MOVING + slot) * (n * n + PAD) + y * n + x..];
                phi.iter_mut().zip(arriving).for_each(|(phi, light)| *phi += light);
            }
            phi.iter_mut().for_each(|phi| *phi = phi.max(0.0));
        });
    }

    /// The places of each plane z.
    fn planes(&mut self) -> Vec<Places<'_>> {
        let (n, side) = (self.n, self.side);
        let mut slots: Vec<_> = self.slots.chunks_mut(n * n + PAD).map(Some).collect();
        let mut take = |z: usize, m: usize| {
            let ([_, _, dz], slot) = side.place(m);
            slots.get_mut(z.checked_add_signed(dz)? * MOVING + slot)?.take()
        };
        (0..n).map(|z| std::array::from_fn(|at| take(z, at + 1))).collect()
    }
}

fn is_inside(n: usize, c: usize) -> bool {
    c > 0 && c < n - 1
}

/// From slots to directions, `[m - 1]`.
fn by_direction<T: Default>(mut slots: [T; MOVING], side: Side) -> Vec<T> {
    (1..=MOVING).map(|m| std::mem::take(&mut slots[side.place(m).1])).collect()
}

/// Where in `places[m - 1]` site x of row y puts what it sends.
#[inline(always)]
fn index(side: Side, n: usize, m: usize, y: usize, x: usize) -> usize {
    let ([dx, dy, _], _) = side.place(m);
    (y * n + x).wrapping_add_signed(dy * n as isize + dx)
}

/// Lets the sites of inner rows pass on what arrives at them. Their ends get it wrong, and are held at the boundary's
/// light afterwards.
fn exchange_opposite(places: &mut Places, side: Side, n: usize, rows: Range<usize>) {
    let count = rows.len() * n - 2;
    for (pair, places) in places.as_chunks_mut().0.iter_mut().enumerate() {
        let [Some(there), Some(back)] = places else { continue };
        let m = 2 * pair + 1;
        let there = &mut there[index(side, n, m, rows.start, 1)..][..count];
        let back = &mut back[index(side, n, m + 1, rows.start, 1)..][..count];
        exchange(there, back);
    }
}

/// Exchanges two rows of values. In pieces that fit registers: the standard library's way is value by value.
#[inline(never)]
fn exchange(a: &mut [f32], b: &mut [f32]) {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks_mut::<16>(), b.as_chunks_mut::<16>());
    for (a, b) in a.iter_mut().zip(b) {
        (*a, *b) = (*b, *a);
    }
    a_rest.swap_with_slice(b_rest);
}

/// Lets the sites of row (y, z) that are in the outermost layer send the boundary's light. What they would send
/// out of the lattice has no place, or one that is never read.
fn hold_boundary(places: &mut Places, side: Side, n: usize, [y, z]: [usize; 2], base: usize) {
    for (m, place) in (1..=MOVING).zip(places) {
        let Some(place) = place else { continue };
        let light = if dense::is_lit(base, m) { 1.0 } else { 0.0 };
        let ([dx, dy, _], _) = side.place(m);
        let Some(row) = y.checked_add_signed(dy).filter(|row| *row < n) else { continue };
        let row = &mut place[row * n..][..n];
        if !is_inside(n, y) || !is_inside(n, z) {
            row.fill(light);
            continue;
        }
        for x in [0, n - 1].iter().filter_map(|x: &usize| x.checked_add_signed(dx)).filter(|x| *x < n) {
            row[x] = light;
        }
    }
}

/// Lets the non-empty sites of a run of an inner row collide.
fn collide(places: &mut Places, side: Side, n: usize, run: &mut Run, gains: &[Gain; 2]) -> [f64; 2] {
    let start = |m: usize| index(side, n, m, run.y, run.x);
    let mut light: [Lanes; MOVING] = std::array::from_fn(|at| {
        let place = places[at].as_ref().expect("a plane inside has neighbours");
        Lanes(*place[start(at + 1)..].first_chunk::<LANES>().expect("a run is inside"))
    });
    let sums = run.collide(gains, &mut light);
    for (m, (place, light)) in (1..=MOVING).zip(places.iter_mut().zip(&light)) {
        let place = place.as_mut().expect("a plane inside has neighbours");
        place[index(side, n, m, run.y, run.x)..][..LANES].copy_from_slice(&light.0);
    }
    sums
}
