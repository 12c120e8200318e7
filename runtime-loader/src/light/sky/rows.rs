//! The sky over a plant as rows of four reals, which a shader reads.

use flb_format::beam::MAX_MEANS;

use super::beams::{HARMONICS, PARTS};
use super::{OfSites, SkyLight, with};

/// Rows besides those of bases: of the fluence, of places without matter, of the harmonics.
pub(crate) const OTHER_ROWS: usize = 1 + 6 + PARTS * HARMONICS;

/// The bases and the rows of a sky, in the order of gpu/sky.wgsl.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SkyRows {
    /// Bases of the sun.
    pub of_sun: usize,
    /// Bases of the near beam.
    pub of_near: usize,
    /// The even sky's, the sun's, the near beam's.
    pub bases: Vec<u8>,
    pub rows: Vec<[f32; 4]>,
}

impl SkyLight<'_> {
    /// The rows of a sky of beams.
    pub(crate) fn rows(&self) -> Option<SkyRows> {
        let OfSites::Beams(_, factors) = &self.sites else { return None };
        let mut bases = vec![0];
        bases.extend(self.bases.iter().map(|of| of.base));
        bases.extend(self.near.clone());
        let [red, green, blue] = self.mean;
        let mut rows = vec![[red, green, blue, 0.0]];
        rows.extend(self.bases.iter().map(|of| with(of.even, of.beyond)));
        let near: [f32; MAX_MEANS] = self.open.near;
        rows.push(near);
        rows.extend([0, 1, 2, 3].map(|part| with(self.open.even[part], self.open.sky.map(|of| of[part]))));
        let of_near = |band: usize| self.open.beyond[band][0] / near[0] + self.mean[band];
        rows.push(with(1.0, [0, 1, 2].map(of_near)));
        for quarter in 0..HARMONICS / 4 {
            for part in 0..PARTS {
                rows.extend(
                    factors
                        .0
                        .iter()
                        .map(|of| -> [f32; 4] { std::array::from_fn(|k| of[part][4 * quarter + k]) }),
                );
            }
        }
        Some(SkyRows { of_sun: self.bases.len(), of_near: self.near.len(), bases, rows })
    }
}
