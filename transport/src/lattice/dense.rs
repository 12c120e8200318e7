//! Light at every site, empty ones too, from the light that non-empty sites send.
//!
//! Each direction is followed through the lattice: directions with a z part plane by plane, the others
//! row by row within the plane. What is carried along a direction with an x or y part is kept in an array
//! that moves with the light, so that following it costs no copying: only non-empty sites write.

use flb_format::direction::{DIRECTIONS, MOVING};

use super::kernel::Lanes;
use super::sites::{LatticeSite, Sites};

/// One lane's field and the light that it stands for: boundary light f_i = `[i = base]`, or 1 from everywhere for base
/// 0.
pub(super) struct Output<'a> {
    /// Index into [`Lanes`].
    pub lane: usize,
    /// 0..=18.
    pub base: usize,
    /// phi, `[z][y][x]`.
    pub phi: &'a mut [f32],
}

/// Whether the boundary of a base sends light along direction m.
pub(super) fn is_lit(base: usize, m: usize) -> bool {
    base == 0 || base == m
}

/// phi of a base at the boundary, and everywhere where nothing is in the way.
pub(super) fn boundary_light(base: usize) -> f32 {
    if base == 0 { MOVING as f32 } else { 1.0 }
}

/// Writes phi of several lanes, plane by plane so that what a plane's sites send is read from memory once.
/// `rows[domain]` as [`sites::Domain`](super::sites::Domain) says.
///
/// Rounding can leave a sum of nearly nothing just below 0; light is never negative, so it ends at 0.
pub(super) fn write(sites: &Sites, rows: &[&[Lanes]], outputs: &mut [Output]) {
    let n = sites.lattice;
    let mut sent = vec![Sent::default(); outputs.len()];
    let directions = |cz: i32, outputs: &[Output]| {
        let of = |base: usize| {
            let mut along = (1..19).filter(|&m| DIRECTIONS[m][2] == cz);
            let next = |_| Carried::new(along.next().expect("five directions rise, five fall"), n, base);
            std::array::from_fn::<_, ACROSS, _>(next)
        };
        outputs.iter().map(|output| of(output.base)).collect::<Vec<_>>()
    };
    let interior = 1..n - 1;

    let mut rising = directions(1, outputs);
    let mut level: Vec<usize> = (1..19).filter(|&m| DIRECTIONS[m][2] == 0).collect();
    level.retain(|&m| DIRECTIONS[m][1] != 0);
    for z in interior.clone() {
        let places = &sites.planes[z];
        gather(places, rows, outputs, |m| DIRECTIONS[m][2] >= 0, &mut sent);
        for ((output, rising), sent) in outputs.iter_mut().zip(&mut rising).zip(&sent) {
            let plane = &mut output.phi[z * n * n..][..n * n];
            arrive(rising, plane, z - 1, |_, light| light);
            rising.iter_mut().for_each(|carried| carried.cross_plane(z - 1, places, sent));
            for &m in &level {
                cross_rows(plane, n, m, is_lit(output.base, m), places, &sent[m - 1]);
            }
            for m in [1, 2] {
                cross_columns(plane, n, m, is_lit(output.base, m), places, &sent[m - 1]);
            }
        }
    }
    drop(rising);
    let mut falling = directions(-1, outputs);
    for z in interior.rev() {
        let (step, places) = (n - 2 - z, &sites.planes[z]);
        gather(places, rows, outputs, |m| DIRECTIONS[m][2] < 0, &mut sent);
        for ((output, falling), sent) in outputs.iter_mut().zip(&mut falling).zip(&sent) {
            let plane = &mut output.phi[z * n * n..][..n * n];
            arrive(falling, plane, step, |phi, light| (phi + light).max(0.0));
            falling.iter_mut().for_each(|carried| carried.cross_plane(step, places, sent));
        }
    }
    outputs.iter_mut().for_each(|output| hold_boundary(output.phi, n, boundary_light(output.base)));
}

/// Directions that cross planes upwards; as many cross them downwards.
const ACROSS: usize = 5;

/// What the sites of a plane send, `[m - 1][place]`.
type Sent = [Vec<f32>; 18];

/// Sorts what the sites of a plane send along the directions asked for by lane and direction, `[output]`. The light of
/// a site lies together.
fn gather(
    places: &[LatticeSite],
    rows: &[&[Lanes]],
    outputs: &[Output],
    wanted: impl Fn(usize) -> bool,
    sent: &mut [Sent],
) {
    let wanted: Vec<usize> = (0..MOVING).filter(|m| wanted(m + 1)).collect();
    sent.iter_mut().flatten().for_each(|sent| sent.resize(places.len(), 0.0));
    for (at, place) in places.iter().enumerate() {
        let of_site = &rows[place.domain as usize][place.site as usize * MOVING..][..MOVING];
        for (output, sent) in outputs.iter().zip(sent.iter_mut()) {
            wanted.iter().for_each(|&m| sent[m][at] = of_site[m].0[output.lane]);
        }
    }
}

/// Sets the outermost layer.
pub(super) fn hold_boundary(phi: &mut [f32], n: usize, light: f32) {
    for (z, plane) in phi.chunks_mut(n * n).enumerate() {
        if z == 0 || z == n - 1 {
            plane.fill(light);
            continue;
        }
        for (y, row) in plane.chunks_mut(n).enumerate() {
            if y == 0 || y == n - 1 {
                row.fill(light);
            }
            row[0] = light;
            row[n - 1] = light;
        }
    }
}

/// Light of one direction as it arrives at a plane, in a frame that moves with it: the light at (x, y)
/// of plane `step` is at (x - cx step + margin, y - cy step + margin).
struct Carried {
    m: usize,
    /// `[v][u]`, u fastest.
    light: Vec<f32>,
    width: usize,
    margin: [usize; 2],
}

impl Carried {
    fn new(m: usize, n: usize, base: usize) -> Carried {
        let [cx, cy, _] = DIRECTIONS[m];
        let size = |c: i32| if c == 0 { n } else { 2 * n };
        // Light with a positive part moves on from u = x - step, which falls to x - n.
        let margin = [cx, cy].map(|c| if c > 0 { n } else { 0 });
        let light = vec![if is_lit(base, m) { 1.0 } else { 0.0 }; size(cx) * size(cy)];
        Carried { m, light, width: size(cx), margin }
    }

    /// What arrives at sites 1..n - 1 of a row of plane `step`.
    fn arriving(&self, n: usize, step: usize, y: usize) -> &[f32] {
        let [u, v] = self.shift(step);
        &self.light[(y + v) * self.width + u..][1..n - 1]
    }

    /// Lets the plane's non-empty sites replace the light.
    fn cross_plane(&mut self, step: usize, places: &[LatticeSite], sent: &Sent) {
        let [u, v] = self.shift(step);
        for (place, sent) in places.iter().zip(&sent[self.m - 1]) {
            let at = (usize::from(place.y) + v) * self.width + usize::from(place.x) + u;
            self.light[at] = *sent;
        }
    }

    fn shift(&self, step: usize) -> [usize; 2] {
        let shift = |axis: usize| {
            (self.margin[axis] as isize - DIRECTIONS[self.m][axis] as isize * step as isize) as usize
        };
        [shift(0), shift(1)]
    }
}

/// Combines the inner sites of a plane with the light that the directions of one rise (or fall) bring, all in one pass.
fn arrive(carried: &[Carried; ACROSS], plane: &mut [f32], step: usize, combine: impl Fn(f32, f32) -> f32) {
    let n = plane.len().isqrt();
    for y in 1..n - 1 {
        let [a, b, c, d, e] = carried.each_ref().map(|carried| carried.arriving(n, step, y));
        let light = a.iter().zip(b).zip(c).zip(d).zip(e);
        for (phi, ((((a, b), c), d), e)) in plane[y * n..][1..n - 1].iter_mut().zip(light) {
            *phi = combine(*phi, a + b + c + d + e);
        }
    }
}

/// A direction with a y but no z part: row by row, in the same moving frame.
fn cross_rows(plane: &mut [f32], n: usize, m: usize, lit: bool, places: &[LatticeSite], sent: &[f32]) {
    let [cx, cy, _] = DIRECTIONS[m];
    if places.is_empty() {
        if lit {
            plane.iter_mut().for_each(|phi| *phi += 1.0);
        }
        return;
    }
    let margin = if cx > 0 { n } else { 0 };
    let mut light = vec![if lit { 1.0 } else { 0.0 }; 2 * n];
    let mut left = 0..places.len();
    for step in 0..n - 2 {
        let y = if cy > 0 { 1 + step } else { n - 2 - step };
        let u = (margin as isize - cx as isize * step as isize) as usize;
        add(&mut plane[y * n..][1..n - 1], &light[u + 1..u + n - 1]);
        let of_row = if cy > 0 {
            let start = left.start;
            left.start += places[left.clone()].partition_point(|p| usize::from(p.y) <= y);
            start..left.start
        } else {
            let end = left.end;
            left.end = left.start + places[left.clone()].partition_point(|p| usize::from(p.y) < y);
            left.end..end
        };
        for (place, sent) in places[of_row.clone()].iter().zip(&sent[of_row]) {
            light[u + usize::from(place.x)] = *sent;
        }
    }
}

/// Directions +x and -x: constant between the non-empty sites of a row.
fn cross_columns(plane: &mut [f32], n: usize, m: usize, lit: bool, places: &[LatticeSite], sent: &[f32]) {
    let boundary = if lit { 1.0 } else { 0.0 };
    if lit {
        plane.iter_mut().for_each(|phi| *phi += boundary);
    }
    let mut sent = sent.iter();
    for of_row in places.chunk_by(|a, b| a.y == b.y) {
        let row = &mut plane[usize::from(of_row[0].y) * n..][..n];
        for ((at, place), sent) in of_row.iter().enumerate().zip(&mut sent) {
            // From this site, exclusive, to the next one downstream, inclusive.
            let x = usize::from(place.x);
            let run = if m == 1 {
                x + 1..of_row.get(at + 1).map_or(n - 1, |next| usize::from(next.x) + 1)
            } else {
                let next = if at == 0 { 1 } else { usize::from(of_row[at - 1].x) };
                next..x
            };
            let light = sent - boundary;
            row[run].iter_mut().for_each(|phi| *phi += light);
        }
    }
}

fn add(sums: &mut [f32], values: &[f32]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += value;
    }
}
