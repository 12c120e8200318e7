//! The near beam of one sun in a few bits a site.
//!
//! Means over a site's own light (the beam in it, what is scattered once) differ from site to site, and get 4 bits each
//! between the least and the most of their block of 4^3. The mean over a cube of 17 sites is smooth, and gets 8 bits a
//! block. All are coded by their square roots, as dark places count as much as bright ones.

use flb_format::beam::MAX_MEANS;

use crate::near_beam::MediumSites;
use crate::near_beam::sites::AroundBlocks;

/// Largest code of a site.
const MAX_SITE_CODE: f32 = 15.0;
/// Largest code of a bound and of a block.
const MAX_BLOCK_CODE: f32 = 255.0;

/// Near beam of one sun.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turn {
    /// Each with its number among the means.
    fine: Vec<(usize, Fine)>,
    smooth: Vec<(usize, Smooth)>,
}

/// A mean that differs from site to site.
#[derive(Debug, Clone, PartialEq)]
struct Fine {
    /// Largest value of all sites.
    most: f32,
    /// Least and most of each block.
    bounds: Vec<[u8; 2]>,
    /// Two places a byte, the first in the low half.
    codes: Vec<u8>,
}

/// A mean that is smooth.
#[derive(Debug, Clone, PartialEq)]
struct Smooth {
    most: f32,
    /// `[block]`
    codes: Vec<u8>,
}

impl Turn {
    /// Codes the means of a sun, `[mean][place]`. With `single` the second is smooth.
    pub(super) fn of(sites: &MediumSites, single: bool, means: &[&[f32]]) -> Turn {
        let (mut fine, mut smooth) = (Vec::new(), Vec::new());
        for (j, values) in means.iter().enumerate() {
            match single && j == 1 {
                true => smooth.push((j, Smooth::of(sites, values))),
                false => fine.push((j, Fine::of(sites, values))),
            }
        }
        Turn { fine, smooth }
    }

    pub(super) fn size_bytes(&self) -> usize {
        let fine: usize = self.fine.iter().map(|(_, fine)| 2 * fine.bounds.len() + fine.codes.len()).sum();
        fine + self.smooth.iter().map(|(_, smooth)| smooth.codes.len()).sum::<usize>()
    }

    /// Means around a point that is near sites with matter.
    pub(super) fn sample(&self, around: &AroundBlocks) -> [f32; MAX_MEANS] {
        let mut means = [0.0; MAX_MEANS];
        for (j, fine) in &self.fine {
            means[*j] = around.sites.mean(|[place, block]| fine.at(place as usize, block as usize));
        }
        for (j, smooth) in &self.smooth {
            means[*j] = around.blocks.mean(|block| smooth.at(block as usize));
        }
        means
    }
}

impl Fine {
    fn of(sites: &MediumSites, values: &[f32]) -> Fine {
        let most = largest(values);
        let root = |place: usize| root_code(values[place], most);
        let mut bounds = vec![[u8::MAX, 0]; sites.block_count()];
        for place in 0..values.len() {
            let [low, high] = &mut bounds[sites.block_of(place)];
            *low = (*low).min(libm::floorf(root(place)) as u8);
            *high = (*high).max(libm::ceilf(root(place)) as u8);
        }
        let mut codes = vec![0; values.len().div_ceil(2)];
        for place in 0..values.len() {
            let [low, high] = bounds[sites.block_of(place)].map(f32::from);
            let share = if high > low { (root(place) - low) / (high - low) } else { 0.0 };
            codes[place / 2] |= (libm::roundf(share * MAX_SITE_CODE) as u8) << (4 * (place % 2));
        }
        Fine { most, bounds, codes }
    }

    fn at(&self, place: usize, block: usize) -> f32 {
        let code = (self.codes[place / 2] >> (4 * (place % 2))) & 0xF;
        let [low, high] = self.bounds[block].map(f32::from);
        value(low + (high - low) * (f32::from(code) / MAX_SITE_CODE), self.most)
    }
}

impl Smooth {
    /// The mean of each block's sites.
    fn of(sites: &MediumSites, values: &[f32]) -> Smooth {
        let mut sums = vec![(0.0_f32, 0_u32); sites.block_count()];
        for (place, value) in values.iter().enumerate() {
            let (sum, count) = &mut sums[sites.block_of(place)];
            (*sum, *count) = (*sum + value, *count + 1);
        }
        let means: Vec<f32> = sums.iter().map(|(sum, count)| sum / *count as f32).collect();
        let most = largest(&means);
        let codes = means.iter().map(|mean| libm::roundf(root_code(*mean, most)) as u8).collect();
        Smooth { most, codes }
    }

    fn at(&self, block: usize) -> f32 {
        value(f32::from(self.codes[block]), self.most)
    }
}

/// The square root of a value, from 0 to [`MAX_BLOCK_CODE`] for the largest.
fn root_code(value: f32, most: f32) -> f32 {
    libm::sqrtf((value / most).clamp(0.0, 1.0)) * MAX_BLOCK_CODE
}

/// The value of a code of a root.
fn value(code: f32, most: f32) -> f32 {
    let root = code / MAX_BLOCK_CODE;
    most * root * root
}

/// Largest of some values; 1 where all are 0.
fn largest(values: &[f32]) -> f32 {
    let most = values.iter().copied().fold(0.0, f32::max);
    if most > 0.0 { most } else { 1.0 }
}
