//! A volume as words for the GPU of any engine, and the shaders that read them.
//!
//! | word | content |
//! |---|---|
//! | 0 | [`VERSION`] |
//! | 1 | sites of the lattice along an edge, N |
//! | 2..5 | middle of the lattice in model space, metres, three f32 |
//! | 5 | sites in a metre, f32 |
//! | 6 | where the block map begins: of each 32 blocks in Morton order the bits, then how many are stored before |
//! | 7 | where the ranges begin: of each stored block the least light, then a step of the codes, each three f32 |
//! | 8 | where the codes begin: of each stored block 64 texels `[z][y][x]`, red in the lowest 8 bits, green, blue |
//! | 9 | where the coarse light begins: of each 16^3 sites `[z][y][x]` three f32 |
//! | 10 | values of the coarse light along an edge, N / 16; 0 where all blocks are stored |
//! | 11 | least light, f32: 0 of the model `physical` |
//! | 12..16 | 0 |
//!
//! Places are in words from the first one of the volume, so that it may lie anywhere in a buffer. Words are of the
//! machine's byte order, which is that of its GPU. Light of fewer than three bands is 0 in the others.

use flb_format::blocks::{TEXELS, coarse};

use super::LightVolume;

/// Words of the head.
const HEAD: usize = 16;
/// Channels of a texel.
const RGB: usize = 3;

/// First word of a volume: the version of its layout.
pub const VERSION: u32 = 1;

/// Reads volumes in WGSL: `flb_volume(volume, point_m)`, and forests: `flb_light(forest, plant, point_m)`; one storage
/// buffer in binding 0 of group 0.
pub const WGSL: &str = include_str!("volume.wgsl");
/// [`WGSL`] in HLSL (shader model 5.1), made by naga: `flb_volumes` is a `ByteAddressBuffer`, `t0`.
pub const HLSL: &str = include_str!("../../../shaders/volume.hlsl");
/// [`WGSL`] in the Metal shading language (2.0), made by naga: functions take `flb_volumes` and the sizes of buffers.
pub const MSL: &str = include_str!("../../../shaders/volume.metal");
/// [`WGSL`] in GLSL (4.50), made by naga, behind the head of a fragment shader of its own: take its functions over.
pub const GLSL: &str = include_str!("../../../shaders/volume.glsl");

impl LightVolume {
    /// Number of [`LightVolume::words`].
    pub fn word_count(&self) -> usize {
        let map = self.channels.map();
        HEAD + 2 * map.words().len()
            + (2 * RGB + TEXELS) * map.len()
            + RGB * coarse::edge(map).pow(3) as usize
    }

    /// The volume for a GPU. `None` for light of more than three bands.
    pub fn words(&self) -> Option<Vec<u32>> {
        let (bands, channels) = (self.bands(), &self.channels);
        if bands > RGB {
            return None;
        }
        let map = channels.map();
        let lattice = self.grid.lattice;
        let middle_m = self.grid.model_from_lattice([f64::from(lattice) / 2.0; 3]);
        let sites_per_m = (1.0 / self.grid.spacing_m) as f32;
        let rgb = |values: &[f32]| {
            let value = |band: usize| values.get(band).copied().unwrap_or_default();
            [0, 1, 2].map(|band| value(band).to_bits())
        };
        let mut body: Vec<u32> = Vec::new();
        let begins = |body: &Vec<u32>| (HEAD + body.len()) as u32;
        let of_map = begins(&body);
        body.extend(map.words().iter().flatten());
        let of_ranges = begins(&body);
        for ranges in channels.ranges().chunks_exact(bands) {
            let [least, step] = [0, 1].map(|end| ranges.iter().map(|range| range[end]).collect::<Vec<f32>>());
            body.extend(rgb(&least).into_iter().chain(rgb(&step)));
        }
        let of_codes = begins(&body);
        debug_assert_eq!(channels.codes().len(), TEXELS * bands * map.len());
        body.extend(
            channels
                .codes()
                .chunks_exact(bands)
                .map(|codes| codes.iter().rev().fold(0, |word, code| word << 8 | u32::from(*code))),
        );
        let of_coarse = begins(&body);
        channels.coarse().chunks_exact(bands).for_each(|light| body.extend(rgb(light)));
        let least = if self.is_bounded { 0.0 } else { f32::MIN };
        let [x, y, z] = middle_m.map(|x| (x as f32).to_bits());
        let mut words = vec![VERSION, lattice, x, y, z, sites_per_m.to_bits()];
        words.extend([of_map, of_ranges, of_codes, of_coarse, coarse::edge(map), least.to_bits()]);
        words.resize(HEAD, 0);
        words.append(&mut body);
        debug_assert_eq!(words.len(), self.word_count());
        Some(words)
    }
}

#[cfg(test)]
pub(crate) mod tests;
