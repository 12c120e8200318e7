//! The whole light of a plant under one sun and sky as a volume: what an engine keeps in a texture.
//!
//! A sample of [`InstanceLight`] adds up all stored fields and the near beam. A [`LightVolume`] has them added up once,
//! in 8 bits a band at the sites near geometry, and a sample reads eight of these. It is of one direction of the sun in
//! the frame of the model: plants that stand at a few yaws share as many volumes, and a sun that moves on takes new
//! ones.

mod channels;
mod fields;
mod near_texels;
pub mod words;

use std::sync::Arc;

use flb_format::Grid;
use flb_format::blocks::{BlockMap, EDGE};
use flb_format::sample::site_of;

use crate::InstanceLight;
use channels::Channels;
pub use fields::FieldVolume;
use near_texels::NearTexels;

/// The whole light of a plant under one sun and sky ([`InstanceLight::volume`]).
#[derive(Debug, Clone)]
pub struct LightVolume {
    grid: Grid,
    is_bounded: bool,
    /// One for each band.
    channels: Channels,
}

impl LightVolume {
    /// Values per point.
    pub fn bands(&self) -> usize {
        self.channels.count()
    }

    /// Memory that it takes, bytes, without the block map, which it shares with the species.
    pub fn size_bytes(&self) -> usize {
        self.channels.size_bytes()
    }

    /// Memory that a volume of so many bands takes over blocks.
    pub(crate) fn bytes_of(map: &BlockMap, bands: usize) -> usize {
        Channels::bytes_of(map, bands)
    }

    /// Light per band at a point of the model at rest, metres, as [`InstanceLight::at`] has it, but for the rounding to
    /// 8 bits and the near beam, which is interpolated with the rest. A point outside the lattice takes the light of
    /// the nearest point of it; a coordinate that is NaN counts as the lower end.
    ///
    /// # Panics
    /// If `out` is shorter than the bands.
    pub fn at(&self, point_m: [f32; 3], out: &mut [f32]) {
        let out = &mut out[..self.bands()];
        out.fill(0.0);
        self.channels.add(self.grid.lattice_from_model(point_m.map(f64::from)), out);
        if self.is_bounded {
            out.iter_mut().for_each(|light| *light = light.max(0.0));
        }
    }
}

impl InstanceLight<'_> {
    /// The light at all sites near geometry, added up once: from then on a sample costs what one of a texture does
    /// ([`LightVolume::at`]). Neighbours' shade and an uneven sky are in it, where the light has them. `None` where the
    /// file's codec does not store blocks near geometry (`classed` and `haar` do), or nothing of it is loaded.
    ///
    /// Where the light needs a near beam, make it of light that is [`InstanceLight::prepared`]: a volume of marches
    /// takes long and has their grain.
    pub fn volume(&self) -> Option<LightVolume> {
        let shared = Arc::clone(self.species.shared()?);
        let (grid, bands) = (*self.species.grid(), self.bands());
        let model = |point: [f64; 3]| grid.model_from_lattice(point).map(|x| x as f32);
        let near = NearTexels::of(self);
        let mut cursor = self.cursor();
        let block = |first: [usize; 3], out: &mut [f32]| cursor.block(first, &near.of_block(first), out);
        let channels = Channels::fill(shared, bands, block);
        let channels = channels.with_coarse(|point, out| self.at(model(point), out));
        Some(LightVolume { grid, is_bounded: self.species.is_bounded(), channels })
    }
}

/// A texel of a block by its number.
pub(super) fn texel_at(first: [usize; 3], number: usize) -> [usize; 3] {
    let inside = site_of(number, EDGE as u32);
    std::array::from_fn(|axis| first[axis] + inside[axis] as usize)
}

#[cfg(test)]
mod tests;
