//! Random numbers for the walks, and points that fill the source more evenly than chance.

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A stream of random numbers.
pub(super) struct Draw(Pcg64Mcg);

impl Draw {
    /// The stream of a batch.
    pub(super) fn new(seed: u64, batch: u64) -> Draw {
        Draw(Pcg64Mcg::seed_from_u64(seed ^ (batch + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// 0..1, 1 excluded.
    pub(super) fn unit(&mut self) -> f64 {
        unit(self.0.next_u64())
    }

    /// A free path in units of the mean one.
    pub(super) fn free_path(&mut self) -> f64 {
        -libm::log(1.0 - self.unit())
    }

    /// An even point of the unit disc, and its squared radius, above 0.
    fn in_disc(&mut self) -> (f64, f64, f64) {
        loop {
            let (x, y) = (2.0 * self.unit() - 1.0, 2.0 * self.unit() - 1.0);
            let square = x * x + y * y;
            if square < 1.0 && square > 0.0 {
                return (x, y, square);
            }
        }
    }

    /// Cosine and sine of an even angle.
    pub(super) fn turn(&mut self) -> (f64, f64) {
        let (x, y, square) = self.in_disc();
        let radius = square.sqrt();
        (x / radius, y / radius)
    }

    /// A unit vector, all directions alike (Marsaglia, 1972).
    pub(super) fn direction(&mut self) -> DVec3 {
        let (x, y, square) = self.in_disc();
        let across = 2.0 * (1.0 - square).sqrt();
        DVec3::new(x * across, y * across, 1.0 - 2.0 * square)
    }

    /// A unit vector about `axis`, its density proportional to the cosine between them (Lambert's law).
    pub(super) fn lambert(&mut self, axis: DVec3) -> DVec3 {
        let sum = axis + self.direction();
        sum.try_normalize().unwrap_or(axis)
    }
}

fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

/// Points of the unit cube in `D` dimensions, 5 at most: Halton's sequence (1960), moved by a random shift. Each point
/// alone is even, whatever its index, so means over them have no bias. (Multiples of square roots, or of the powers of
/// one number, are cheaper, and in some planes emptier than chance would leave them.)
pub(super) struct Even<const D: usize> {
    shift: [f64; D],
    index: u64,
}

impl<const D: usize> Even<D> {
    pub(super) fn new(draw: &mut Draw) -> Even<D> {
        Even { shift: std::array::from_fn(|_| draw.unit()), index: 0 }
    }

    pub(super) fn point(&mut self) -> [f64; D] {
        self.index += 1;
        std::array::from_fn(|axis| {
            let moved = self.shift[axis] + mirrored(self.index, [2, 3, 5, 7, 11][axis]);
            moved - moved.floor()
        })
    }
}

/// The digits of an index in a base, mirrored at the point: 0..1.
fn mirrored(mut index: u64, base: u64) -> f64 {
    let (mut mirrored, mut place) = (0.0, 1.0);
    while index > 0 {
        place /= base as f64;
        mirrored += place * (index % base) as f64;
        index /= base;
    }
    mirrored
}
