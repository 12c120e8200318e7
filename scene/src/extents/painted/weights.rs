//! Colours of vertices that are weights of wind: they bend a plant by its height and make its leaves flutter.

use super::Painted;
use crate::Mesh;
use crate::sheets::blades;

/// A channel runs where its least and its most in a blade are this far apart.
const MIN_RUN: f32 = 0.8;
/// Share of the blades in which it does.
const MIN_RUNNING: f64 = 0.6;
/// A phase is the same all over a blade, up to this, in this share of the blades..
const EVEN: f32 = 0.02;
const MIN_EVEN: f64 = 0.9;
/// ..and lies in so many tenths from 0 to 1 over all of them.
const MIN_TENTHS: usize = 9;
/// Beside a phase a channel that runs so far is a weight.
const MIN_ALONG: f32 = 0.2;
/// Fewer blades tell nothing.
const MIN_BLADES: usize = 12;
/// Least correlation of a channel with the height.
const MIN_OF_HEIGHT: f64 = 0.98;
/// Two channels are one, rising or falling together, where their correlation is this at least, either way.
const MIN_ONE: f64 = 0.9;
/// A channel that changes by less, as a standard deviation, is the same everywhere.
const SAME: f64 = 0.02;

/// Kind of weights that colours of the vertices of these triangles look like.
pub(super) fn look(mesh: &Mesh, triangles: &[u32], moments: &Moments) -> Option<Painted> {
    // Blends of two colours are tints, from the root to the tip or from below to above; so are shades of grey.
    if moments.is_blend() {
        return None;
    }
    let follows = |channel: &usize| {
        moments.most[*channel] - moments.least[*channel] >= f64::from(MIN_RUN)
            && moments.correlation(0, *channel) >= MIN_OF_HEIGHT
    };
    if (1..4).any(|channel| follows(&channel)) {
        return Some(Painted::Height);
    }
    of_blades(mesh, triangles)
}

/// Whether a channel runs from 0 to 1 in most blades, or one is random by blade and another runs along them.
fn of_blades(mesh: &Mesh, triangles: &[u32]) -> Option<Painted> {
    let blades = blades(mesh, triangles);
    let count = blades.iter().max().map_or(0, |last| *last as usize + 1);
    let mut spans = vec![[[f32::INFINITY, f32::NEG_INFINITY]; 3]; count];
    for (&triangle, &blade) in triangles.iter().zip(&blades) {
        for vertex in mesh.triangles[triangle as usize] {
            for (span, value) in spans[blade as usize].iter_mut().zip(mesh.colors[vertex as usize]) {
                *span = [span[0].min(value), span[1].max(value)];
            }
        }
    }
    // Not every number is one of a blade.
    let spans: Vec<_> = spans.into_iter().filter(|span| span[0][0] <= span[0][1]).collect();
    if spans.len() < MIN_BLADES {
        return None;
    }
    let share = |is: &dyn Fn([f32; 2]) -> bool, channel: usize| {
        spans.iter().filter(|span| is(span[channel])).count() as f64 / spans.len() as f64
    };
    let runs = |least: f32| move |[low, high]: [f32; 2]| high - low >= least;
    if (0..3).any(|channel| share(&runs(MIN_RUN), channel) >= MIN_RUNNING) {
        return Some(Painted::Runs);
    }
    let is_phase = |channel: &usize| {
        let is_even = |[low, high]: [f32; 2]| high - low <= EVEN;
        let tenths = (0..10u8).filter(|tenth| {
            let within = |[low, _]: [f32; 2]| (10.0 * low) as u8 == *tenth || (*tenth == 9 && low >= 1.0);
            share(&within, *channel) > 0.0
        });
        share(&is_even, *channel) >= MIN_EVEN && tenths.count() >= MIN_TENTHS
    };
    let phase = (0..3).find(is_phase)?;
    let runs_along = |channel: usize| channel != phase && share(&runs(MIN_ALONG), channel) >= MIN_RUNNING;
    (0..3).any(runs_along).then_some(Painted::Phases)
}

/// Sums over corners: of height, red, green and blue.
pub(super) struct Moments {
    count: f64,
    sum: [f64; 4],
    products: [[f64; 4]; 4],
    least: [f64; 4],
    most: [f64; 4],
}

impl Moments {
    pub(super) fn of(mesh: &Mesh, triangles: &[u32]) -> Moments {
        let corners = triangles.iter().flat_map(|&triangle| mesh.triangles[triangle as usize]);
        let values = corners.map(|vertex| {
            let [red, green, blue] = mesh.colors[vertex as usize].map(f64::from);
            [f64::from(mesh.positions[vertex as usize][1]), red, green, blue]
        });
        let mut sums = Moments {
            count: 0.0,
            sum: [0.0; 4],
            products: [[0.0; 4]; 4],
            least: [f64::INFINITY; 4],
            most: [f64::NEG_INFINITY; 4],
        };
        for value in values {
            sums.count += 1.0;
            for (at, own) in value.into_iter().enumerate() {
                sums.sum[at] += own;
                sums.least[at] = sums.least[at].min(own);
                sums.most[at] = sums.most[at].max(own);
                for (sum, other) in sums.products[at].iter_mut().zip(value) {
                    *sum += own * other;
                }
            }
        }
        sums
    }

    /// Whether the colours are blends of two: all channels that change do so together. One channel that changes alone
    /// is a blend where the others are not both none, or both all.
    pub(super) fn is_blend(&self) -> bool {
        let changes = |channel: &usize| self.covariance(*channel, *channel) > SAME * SAME;
        let changing: Vec<usize> = (1..4).filter(changes).collect();
        let together = |a: usize, b: usize| self.correlation(a, b).abs() > MIN_ONE;
        match changing.as_slice() {
            [] => true,
            [_] => self.mean(1) > self.mean(3),
            [a, b] => together(*a, *b),
            _ => together(1, 2) && together(2, 3) && together(3, 1),
        }
    }

    fn mean(&self, channel: usize) -> f64 {
        self.sum[channel] / self.count.max(1.0)
    }

    fn covariance(&self, a: usize, b: usize) -> f64 {
        self.products[a][b] / self.count - self.sum[a] / self.count * (self.sum[b] / self.count)
    }

    /// -1..=1; 0 where one of both does not change.
    fn correlation(&self, a: usize, b: usize) -> f64 {
        let both = self.covariance(a, a) * self.covariance(b, b);
        if both > 1e-12 { self.covariance(a, b) / libm::sqrt(both) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::soup;

    /// Sixty blades from 1 m up, of two triangles each, painted by blade, corner's place along the blade, and height.
    fn painted(paint: impl Fn(f32, f32, f32) -> [f32; 3]) -> Option<Painted> {
        let blades = (0..60).map(|at| (at as f32 * 0.618).fract()).map(|place| {
            let (x, y) = (4.0 * place, 1.0 + (7.0 * place).fract());
            [
                [[x, y, 0.0], [x + 0.1, y, 0.0], [x, y, 0.1]],
                [[x + 0.1, y, 0.0], [x + 0.1, y, 0.1], [x, y, 0.1]],
            ]
        });
        let blades: Vec<_> = blades.flatten().collect();
        let mut mesh = soup(&blades);
        mesh.colors = mesh
            .positions
            .iter()
            .map(|[_, y, z]| paint(((y - 1.0) * 97.0).fract(), z * 10.0, y - 1.0))
            .collect();
        let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        look(&mesh, &all, &Moments::of(&mesh, &all))
    }

    #[test]
    fn weights_of_wind_are_no_colours() {
        assert_eq!(painted(|blade, along, _| [blade, along, 0.5]), Some(Painted::Runs));
        assert_eq!(painted(|blade, _, height| [blade, 0.5, height]), Some(Painted::Height));
        assert_eq!(painted(|blade, along, _| [blade, 0.5 * along, 0.9]), Some(Painted::Phases));
    }

    #[test]
    fn tints_and_shades_are() {
        assert_eq!(painted(|blade, along, _| [0.6 + 0.3 * blade, 0.7 + 0.2 * along, 0.4]), None);
        assert_eq!(painted(|_, along, _| [along; 3]), None, "a shade from the stem to the tip");
        assert_eq!(painted(|_, _, height| [0.1 + 0.9 * height; 3]), None, "a shade from below to above");
        assert_eq!(painted(|_, _, _| [0.5, 0.7, 0.3]), None);
        assert_eq!(painted(|_, along, _| [along, 1.0 - along, 0.05]), None, "red tips");
        assert_eq!(painted(|_, _, height| [1.0, 0.9 * height, 0.1]), None, "from red to yellow");
    }
}
