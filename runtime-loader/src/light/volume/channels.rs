//! Values at the sites near geometry, in 8 bits each between the least and the most of their block of 4^3.

use std::sync::Arc;

use flb_format::blocks::{At, BlockMap, EDGE, Shared, TEXELS, coarse};
use flb_format::sample::{corners, site_of};

/// Texels of a block along an edge.
const ALONG: u32 = EDGE as u32;
/// Largest code of a value.
const MAX_CODE: f32 = 255.0;

/// Channels of values over a lattice.
#[derive(Debug, Clone)]
pub(super) struct Channels {
    /// For its block map.
    shared: Arc<Shared>,
    count: usize,
    /// `[block][channel]`: the least value, and a step of the codes.
    ranges: Vec<[f32; 2]>,
    /// `[block][z][y][x][channel]`
    codes: Vec<u8>,
    /// `[z][y][x][channel]`: values where no block is stored, every 16 sites.
    coarse: Vec<f32>,
}

impl Channels {
    /// Values of so many channels: `block` tells those of a stored block's texels, `[z][y][x][channel]`.
    pub(super) fn fill(
        shared: Arc<Shared>,
        count: usize,
        mut block: impl FnMut([usize; 3], &mut [f32]),
    ) -> Channels {
        let blocks = shared.map.len();
        let mut ranges = Vec::with_capacity(blocks * count);
        let mut codes = vec![0; blocks * TEXELS * count];
        let mut values = vec![0.0; TEXELS * count];
        for (rank, codes) in codes.chunks_exact_mut(TEXELS * count).enumerate() {
            block(shared.map.first_texel(rank), &mut values);
            for channel in 0..count {
                let (range, coded) = code(values[channel..].iter().step_by(count).copied());
                ranges.push(range);
                codes[channel..].iter_mut().step_by(count).zip(coded).for_each(|(code, coded)| *code = coded);
            }
        }
        Channels { shared, count, ranges, codes, coarse: Vec::new() }
    }

    /// With the values at points in lattice coordinates, for where no block is stored.
    pub(super) fn with_coarse(self, mut value: impl FnMut([f64; 3], &mut [f32])) -> Channels {
        let edge = coarse::edge(&self.shared.map);
        let stride = f64::from(coarse::COARSE_EDGE);
        let mut all = vec![0.0; edge.pow(3) as usize * self.count];
        for (site, values) in (0..).zip(all.chunks_exact_mut(self.count)) {
            value(site_of(site, edge).map(|at| stride * (f64::from(at) + 0.5)), values);
        }
        Channels { coarse: all, ..self }
    }

    pub(super) fn size_bytes(&self) -> usize {
        size_of_val(&self.ranges[..]) + self.codes.len() + size_of_val(&self.coarse[..])
    }

    /// [`Channels::size_bytes`] of so many channels.
    pub(super) fn bytes_of(map: &BlockMap, count: usize) -> usize {
        count * (map.len() * (size_of::<[f32; 2]>() + TEXELS) + 4 * coarse::edge(map).pow(3) as usize)
    }

    /// Blocks that are stored.
    pub(super) fn map(&self) -> &BlockMap {
        &self.shared.map
    }

    /// `[block][channel]`: the least value, and a step of the codes.
    pub(super) fn ranges(&self) -> &[[f32; 2]] {
        &self.ranges
    }

    /// `[block][z][y][x][channel]`
    pub(super) fn codes(&self) -> &[u8] {
        &self.codes
    }

    /// `[z][y][x][channel]`, every 16 sites.
    pub(super) fn coarse(&self) -> &[f32] {
        &self.coarse
    }

    /// Number of channels.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Adds each channel at a point in lattice coordinates to `out`.
    pub(super) fn add(&self, point: [f64; 3], out: &mut [f32]) {
        let at = At::of(self.shared.map.lattice(), point);
        let first = at.texel.map(|texel| texel / ALONG);
        match self.shared.map.rank(first).filter(|_| at.straddled() == 0) {
            Some(rank) => self.add_inside(rank as usize, &at, out),
            None => self.add_corners(&at, out),
        }
    }

    /// All corners lie in one block.
    fn add_inside(&self, rank: usize, at: &At, out: &mut [f32]) {
        let codes = &self.codes[rank * TEXELS * self.count..][..TEXELS * self.count];
        let corners = corners(at.part).map(|(upper, weight)| {
            let texel: [u32; 3] = std::array::from_fn(|axis| at.texel[axis] + upper[axis] as u32);
            (&codes[number_in_block(texel) * self.count..][..self.count], weight)
        });
        let ranges = &self.ranges[rank * self.count..][..self.count];
        for (channel, ([least, step], out)) in ranges.iter().zip(out).enumerate() {
            let mut code = 0.0;
            for (codes, weight) in &corners {
                code += weight * f32::from(codes[channel]);
            }
            *out += least + step * code;
        }
    }

    /// Corners lie in several blocks, some of which may not be stored.
    fn add_corners(&self, at: &At, out: &mut [f32]) {
        for (upper, weight) in corners(at.part) {
            let texel: [u32; 3] = std::array::from_fn(|axis| at.texel[axis] + upper[axis] as u32);
            let Some(rank) = self.shared.map.rank(texel.map(|texel| texel / ALONG)) else {
                self.add_coarse(texel, weight, out);
                continue;
            };
            let codes = &self.codes[(rank as usize * TEXELS + number_in_block(texel)) * self.count..];
            let ranges = &self.ranges[rank as usize * self.count..];
            for ((out, code), [least, step]) in out.iter_mut().zip(codes).zip(ranges) {
                *out += weight * (least + step * f32::from(*code));
            }
        }
    }

    /// What stands in for a texel where no block is stored. No surface of the mesh asks for it.
    #[cold]
    fn add_coarse(&self, texel: [u32; 3], weight: f32, out: &mut [f32]) {
        let edge = coarse::edge(&self.shared.map);
        let stride = coarse::COARSE_EDGE as f32;
        let place = texel.map(|x| ((x as f32 + 0.5) / stride - 0.5).max(0.0).min((edge - 1) as f32));
        let first = place.map(|x| x as u32);
        let part = std::array::from_fn(|axis| place[axis] - first[axis] as f32);
        for (upper, share) in corners(part) {
            let at: [u32; 3] = std::array::from_fn(|axis| (first[axis] + upper[axis] as u32).min(edge - 1));
            let values = &self.coarse[((at[2] * edge + at[1]) * edge + at[0]) as usize * self.count..];
            out.iter_mut().zip(values).for_each(|(out, value)| *out += weight * share * value);
        }
    }
}

/// The place of a texel in its block.
fn number_in_block(texel: [u32; 3]) -> usize {
    let [x, y, z] = texel.map(|texel| (texel % ALONG) as usize);
    (z * EDGE + y) * EDGE + x
}

/// Least value and step of a block's codes, and the codes.
fn code(values: impl Iterator<Item = f32> + Clone) -> ([f32; 2], impl Iterator<Item = u8>) {
    let least = values.clone().fold(f32::INFINITY, f32::min);
    let most = values.clone().fold(f32::NEG_INFINITY, f32::max);
    let step = (most - least) / MAX_CODE;
    let scale = if step > 0.0 { 1.0 / step } else { 0.0 };
    ([least, step], values.map(move |value| libm::roundf((value - least) * scale).min(MAX_CODE) as u8))
}
