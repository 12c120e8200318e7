//! The near beam of single points, by marching the extinction from them towards the sun.
//!
//! The mean over a cube weighs places by their extinction. For every offset, candidates are looked up all over the
//! cube, one is drawn in proportion to its extinction, and a ray goes from there; offsets count as much as the
//! extinction that they found (self-normalised importance resampling; Talbot, Cline and Egbert 2005). Light that was
//! scattered once is followed back: any way, as far as light of that way comes, and from there towards the sun. Offsets
//! come from the caller; with a low-discrepancy set the error of the mean falls nearly with their number. Candidates
//! and choices are found in integers, so that a GPU (`gpu/near.wgsl`) makes the same ones.

use std::borrow::Cow;
use std::f32::consts::PI;

use flb_format::beam::{MAX_MEANS, means, reaches};
use flb_format::matter::TurbidMedium;
use flb_format::sample::corners;

use crate::extinction::{Extinction, Ray, Travel};

/// The means where one beam lights all around and nothing scatters.
pub(crate) fn everywhere(beam: f32, single: bool) -> [f32; MAX_MEANS] {
    std::array::from_fn(|j| if j <= reaches(single).len() { beam } else { 0.0 })
}

/// Beyond this optical depth less than 1e-8 is left: nothing.
const DARK: f32 = 18.5;
/// The last place within a site, so that it is still of the site when rounded with the site's number, up to 255.
const LAST_WITHIN: f32 = 1.0 - 1.0 / 65_536.0;
/// By which an offset becomes those of where light scattered once comes to, and of where in a site it was scattered:
/// times these, [`STEP`] is nearly a step of the same sequence along other axes.
const FROM: [u32; 3] = [129, 181, 235];
const WITHIN: [u32; 3] = [5379, 4695, 8115];
/// Places of a cube that are looked up for each offset.
pub(crate) const CANDIDATES: u32 = 16;
/// Steps of the additive sequence that fills the unit cube, in 2^-32: powers of the root of x^4 = x + 1 (R3, M. Roberts
/// 2018).
const STEP: [u32; 3] = [3_518_319_155, 2_882_110_345, 2_360_945_575];

/// Finds the near beam of a species at points, for any sun, without preparing one.
///
/// Price: a call makes four marches for every offset (two of light scattered once), and 16 lookups for every offset and
/// cube. A march takes a step per site that the ray crosses, and per empty block of 4^3.
pub struct Marcher<'e> {
    extinction: Cow<'e, Extinction>,
    /// Whether the fields need light scattered once.
    single: bool,
}

impl<'e> Marcher<'e> {
    /// Makes a marcher for a medium; `single` says whether the fields need light scattered once.
    pub fn new(turbid: &TurbidMedium, single: bool) -> Marcher<'static> {
        Marcher { extinction: Cow::Owned(Extinction::of(turbid)), single }
    }

    /// Makes a marcher that borrows an extinction; `single` says whether the fields need light scattered once.
    pub fn of(extinction: &'e Extinction, single: bool) -> Marcher<'e> {
        Marcher { extinction: Cow::Borrowed(extinction), single }
    }

    /// Memory that its extinction takes.
    pub fn size_bytes(&self) -> usize {
        self.extinction.size_bytes()
    }

    /// Estimates the means of the near beam (SPEC.md, section 10.4) between the sites around a point of model space,
    /// for a sun along the unit vector `towards_sun`: each from one place an offset, which lies in one of those of the
    /// eight sites that hold matter, chosen by their trilinear weights, or in the cube around it. So their mean over
    /// many offsets is what [`PreparedSun`](super::PreparedSun) has there. Offsets are points of the unit cube, each
    /// coordinate from 0 to below 1, as they follow each other in an additive sequence. Where none of the eight sites
    /// holds matter, and without any offset, the place is the point itself; near_j is near_0 where no matter was found
    /// in a cube and without any offset, and then no light is scattered once. Means that the fields do not have are 0.
    pub fn near(
        &self,
        point_model_m: [f32; 3],
        towards_sun: [f64; 3],
        offsets: &[[f32; 3]],
    ) -> [f32; MAX_MEANS] {
        let point = self.extinction.lattice_from_model(point_model_m);
        let sun = self.extinction.ray(point, towards_sun.map(|c| c as f32));
        if offsets.is_empty() {
            return everywhere(self.transmittance(point, &sun), self.single);
        }
        let (around, n) = (Around::new(&self.extinction, point), self.extinction.grid().lattice as i32);
        let reaches = reaches(self.single);
        let (mut beam, mut once) = (0.0, 0.0);
        let (mut light, mut found) = ([0.0; MAX_MEANS], [0.0; MAX_MEANS]);
        for offset in offsets {
            let place = around.place(*offset);
            beam += self.transmittance(place, &sun);
            if self.single {
                once += self.scattered_once(around.place(other(*offset, FROM)), &sun, *offset);
            }
            let site = place.map(|c| (c.max(0.0) as i32).min(n - 1));
            for (mean, reach) in reaches.iter().enumerate() {
                let reach = *reach as i32;
                let cube = site.map(|c| [(c - reach).max(0), (c + reach + 1).min(n)]);
                if let Some((place, matter)) = self.draw(cube, *offset, offsets.len() as u32) {
                    light[mean] += matter * self.transmittance(place, &sun);
                    found[mean] += matter;
                }
            }
        }
        let mut near = everywhere(beam / offsets.len() as f32, self.single);
        for (mean, near) in near[1..].iter_mut().take(reaches.len()).enumerate() {
            if found[mean] > 0.0 {
                *near = light[mean] / found[mean];
            }
        }
        if self.single {
            near[means(true) - 1] = once / offsets.len() as f32;
        }
        near
    }

    /// Share of the sun's light that comes to a point, in lattice coordinates, unscattered.
    fn transmittance(&self, point: [f32; 3], sun: &Ray) -> f32 {
        match self.extinction.travel(&Ray { point, ..*sun }, DARK) {
            Travel::Out { depth } => libm::expf(-depth),
            Travel::Stopped { .. } => 0.0,
        }
    }

    /// Light that comes to a point, in lattice coordinates, along one way after one scattering, drawn by the offset:
    /// the ways are even, and how far off the light was scattered goes by the optical depth.
    fn scattered_once(&self, point: [f32; 3], sun: &Ray, offset: [f32; 3]) -> f32 {
        let [u, v, w] = offset;
        let z = 2.0 * u - 1.0;
        let (sin, cos) = libm::sincosf(2.0 * PI * v);
        let across = (1.0 - z * z).max(0.0).sqrt();
        let back = [across * cos, across * sin, z];
        match self.extinction.travel(&self.extinction.ray(point, back), -libm::log1pf(-w)) {
            Travel::Out { .. } => 0.0,
            Travel::Stopped { t } => {
                // Any place of the site, as its light is taken as even.
                let within = other(offset, WITHIN);
                let place = |axis: usize| libm::floorf(point[axis] + t * back[axis]) + within[axis];
                self.transmittance(std::array::from_fn(place), sun)
            }
        }
    }

    /// A place in a box of sites, by density of extinction, and how much of that its candidates have. Those of all
    /// offsets, which are `count`, are one sequence.
    fn draw(&self, range: [[i32; 2]; 3], offset: [f32; 3], count: u32) -> Option<([f32; 3], f32)> {
        let mut digits = offset.map(digits);
        let mut choice = choice(digits);
        let (mut place, mut matter) = ([0.0; 3], 0.0_f32);
        for _ in 0..CANDIDATES {
            let candidate: [f32; 3] = std::array::from_fn(|axis| {
                let [low, high] = range[axis];
                low as f32 + (high - low) as f32 * part(digits[axis])
            });
            let site = std::array::from_fn(|axis| (candidate[axis] as u32).min(range[axis][1] as u32 - 1));
            let depth = self.extinction.depth(site);
            if depth > 0.0 {
                matter += depth;
                // What is left of the choice is even again.
                let share = depth / matter;
                if choice < share {
                    place = candidate;
                    choice /= share;
                } else {
                    choice = (choice - share) / (1.0 - share);
                }
            }
            digits = std::array::from_fn(|axis| digits[axis].wrapping_add(STEP[axis].wrapping_mul(count)));
        }
        (matter > 0.0).then_some((place, matter))
    }
}

/// Those of the eight sites around a point that hold matter.
struct Around {
    /// Lattice coordinates.
    point: [f32; 3],
    /// The first site.
    low: [i32; 3],
    /// Trilinear, `[z][y][x]`; 0 of sites without matter.
    weights: [f32; 8],
}

impl Around {
    fn new(extinction: &Extinction, point: [f32; 3]) -> Around {
        let last = (extinction.grid().lattice - 1) as f32;
        // Written so that a NaN is the lower end.
        let at = point.map(|c| (c - 0.5).max(0.0).min(last));
        let low = at.map(|c| c.min(last - 1.0) as i32);
        let part: [f32; 3] = std::array::from_fn(|axis| at[axis] - low[axis] as f32);
        let weights = corners(part).map(|(upper, weight)| {
            let site = std::array::from_fn(|axis| low[axis] as u32 + upper[axis] as u32);
            if extinction.depth(site) > 0.0 { weight } else { 0.0 }
        });
        Around { point, low, weights }
    }

    /// A place in one of the sites: as many offsets lead to each as its weight says, even all over it.
    fn place(&self, offset: [f32; 3]) -> [f32; 3] {
        let w = &self.weights;
        let planes = [w[0] + w[1] + (w[2] + w[3]), w[4] + w[5] + (w[6] + w[7])];
        if planes[0] + planes[1] == 0.0 {
            return self.point;
        }
        let (z, within_z) = split(planes, offset[2]);
        let (y, within_y) = split([w[4 * z] + w[4 * z + 1], w[4 * z + 2] + w[4 * z + 3]], offset[1]);
        let (x, within_x) = split([w[4 * z + 2 * y], w[4 * z + 2 * y + 1]], offset[0]);
        let [low_x, low_y, low_z] = self.low.map(|c| c as f32);
        [low_x + x as f32 + within_x, low_y + y as f32 + within_y, low_z + z as f32 + within_z]
    }
}

/// Which of two weights a number from 0 to below 1 falls to, and where in it, from 0 to below 1.
fn split([low, high]: [f32; 2], number: f32) -> (usize, f32) {
    let share = low / (low + high);
    let (which, within) =
        if number < share { (0, number / share) } else { (1, (number - share) / (1.0 - share)) };
    (which, within.min(LAST_WITHIN))
}

/// Another offset made of one, as good as a second sequence: its digits times large odd numbers.
fn other(offset: [f32; 3], times: [u32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| part(digits(offset[axis]).wrapping_mul(times[axis])))
}

/// In 2^-32.
fn digits(part: f32) -> u32 {
    (part * 16_777_216.0) as u32 * 256
}

/// Places of a pixel from which the mean light around its points is estimated: each of its rays has an even share, and
/// one at least. Four are 56 % off at a point, of the sun's scattered light alone (`cargo bench -p flb-tests --bench
/// grain`).
const PIXEL_OFFSETS: usize = 4;

/// Offsets for each ray of a picture of so many rays a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayOffsets(usize);

impl RayOffsets {
    /// Chooses the offsets for pictures of so many rays a pixel.
    pub fn new(rays: u32) -> RayOffsets {
        RayOffsets(PIXEL_OFFSETS.div_ceil(rays.max(1) as usize))
    }

    /// Offsets of a ray.
    pub(crate) fn count(self) -> usize {
        self.0
    }

    /// Whether several rays make a pixel, each with a part of its offsets.
    pub(crate) fn are_of_several_rays(self) -> bool {
        self.0 < PIXEL_OFFSETS
    }

    /// Calls with the offsets of a seed, for [`Marcher::near`].
    pub fn with<T>(self, seed: u32, call: impl FnOnce(&[[f32; 3]]) -> T) -> T {
        let mut offsets = [[0.0; 3]; PIXEL_OFFSETS];
        let offsets = &mut offsets[..self.0];
        (0..).zip(&mut *offsets).for_each(|(number, one)| *one = offset(seed, number));
        call(offsets)
    }
}

/// The seed of a point's offsets: one of its own, so that the errors of neighbours do not add up.
pub fn seed_of(point_model_m: [f32; 3]) -> u32 {
    point_model_m.iter().fold(0, |seed, coordinate| mixed(seed ^ coordinate.to_bits()))
}

/// A bijective 32-bit mix (two rounds of xorshift-multiply), that of `flb_scene::sampling::hash` and of its twin in
/// WGSL.
fn mixed(value: u32) -> u32 {
    let mut v = value.wrapping_add(0x9e37_79b9);
    v = (v ^ (v >> 16)).wrapping_mul(0x21f0_aaad);
    v = (v ^ (v >> 15)).wrapping_mul(0x735a_2d97);
    v ^ (v >> 15)
}

/// Offset of a number, for [`Marcher::near`]: of an additive sequence that a seed turns. `flb_near` of a GPU has the
/// same.
pub fn offset(seed: u32, number: u32) -> [f32; 3] {
    std::array::from_fn(|axis| {
        let turn = hash(seed.wrapping_add(axis as u32));
        part(turn.wrapping_add(STEP[axis].wrapping_mul(number)))
    })
}

/// From 0 to below 1.
fn part(digits: u32) -> f32 {
    (digits >> 8) as f32 / 16_777_216.0
}

/// A pseudo-random number in [0, 1) made of an offset.
fn choice(digits: [u32; 3]) -> f32 {
    part(hash(digits[0] ^ digits[1].rotate_left(11) ^ digits[2].rotate_left(22)))
}

/// The finaliser of MurmurHash3 (Appleby 2008).
fn hash(mut h: u32) -> u32 {
    h = (h ^ (h >> 16)).wrapping_mul(0x85EB_CA6B);
    h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}
