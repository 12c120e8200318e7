//! What BC6H would make of a field: tiles of 4 x 4 texels of three bands in 16 bytes (Direct3D 11 functional
//! specification, section 19.5).
//!
//! Only the format's mode of one line between two end points of 10 bits a band, unsigned, with 4 bits a texel for the
//! place on it. Real encoders choose among 14 modes and gain about 2 dB on pictures; their size is the same.

use flb_format::Field;
use half::f16;

/// Weights of the 16 places on the line, of 64.
const WEIGHTS: [i64; 16] = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64];
/// Texels of a tile.
const TILE: usize = 16;

/// The field with the blocks near geometry coded, others as they were.
pub(crate) fn coded(field: &Field, is_near: &[bool]) -> Field {
    let n = field.lattice as usize;
    let blocks = n / 4;
    let mut out = field.clone();
    for (block, _) in is_near.iter().enumerate().filter(|(_, near)| **near) {
        let [x, y, z] = [block % blocks, block / blocks % blocks, block / (blocks * blocks)].map(|b| 4 * b);
        for slice in 0..4 {
            let site = |t: usize| ((z + slice) * n + y + t / 4) * n + x + t % 4;
            for bands in (0..field.bands as usize).collect::<Vec<_>>().chunks(3) {
                let mut texels = [[0.0; 3]; TILE];
                for (t, texel) in texels.iter_mut().enumerate() {
                    bands
                        .iter()
                        .enumerate()
                        .for_each(|(c, band)| texel[c] = to_code(field.values()[band * n * n * n + site(t)]));
                }
                for (t, texel) in tile(&texels).iter().enumerate() {
                    bands.iter().enumerate().for_each(|(c, band)| {
                        out.values_mut()[band * n * n * n + site(t)] = from_code(texel[c])
                    });
                }
            }
        }
    }
    out
}

/// Bits of the binary16 of a value, on the format's scale of 0 to 65535. Negative light is 0 there.
fn to_code(value: f32) -> f64 {
    f64::from(f16::from_f32_const(value.max(0.0)).to_bits()) * 64.0 / 31.0
}

fn from_code(code: i64) -> f32 {
    f16::from_bits(((code * 31) >> 6) as u16).to_f32_const()
}

/// The tile as a decoder has it.
fn tile(texels: &[[f64; 3]; TILE]) -> [[i64; 3]; TILE] {
    let mean: [f64; 3] = std::array::from_fn(|c| texels.iter().map(|t| t[c]).sum::<f64>() / TILE as f64);
    let axis = principal(texels, mean);
    let along = |t: &[f64; 3]| (0..3).map(|c| (t[c] - mean[c]) * axis[c]).sum::<f64>();
    let (least, most) = texels.iter().map(along).fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
    let ends =
        [least, most].map(|end| -> [i64; 3] { std::array::from_fn(|c| quantised(mean[c] + end * axis[c])) });
    let line = WEIGHTS.map(|w| -> [i64; 3] {
        std::array::from_fn(|c| (unquantised(ends[0][c]) * (64 - w) + unquantised(ends[1][c]) * w + 32) >> 6)
    });
    texels.map(|texel| {
        let distance = |place: &[i64; 3]| (0..3).map(|c| square(place[c] as f64 - texel[c])).sum::<f64>();
        *line.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("16 places")
    })
}

/// Direction of most variance, by power iteration.
fn principal(texels: &[[f64; 3]; TILE], mean: [f64; 3]) -> [f64; 3] {
    let mut axis = [1.0, 1.0, 1.0];
    for _ in 0..8 {
        let mut next = [0.0; 3];
        for texel in texels {
            let part = (0..3).map(|c| (texel[c] - mean[c]) * axis[c]).sum::<f64>();
            (0..3).for_each(|c| next[c] += part * (texel[c] - mean[c]));
        }
        let length = next.iter().map(|v| v * v).sum::<f64>().sqrt();
        if length < 1e-9 {
            return axis.map(|_| 1.0 / 3f64.sqrt());
        }
        axis = next.map(|v| v / length);
    }
    axis
}

/// To 10 bits.
fn quantised(code: f64) -> i64 {
    ((code * 1024.0 / 65536.0 - 0.5).round() as i64).clamp(0, 1023)
}

/// The format's own way back.
fn unquantised(quantised: i64) -> i64 {
    match quantised {
        0 => 0,
        1023 => 0xFFFF,
        q => ((q << 16) + 0x8000) >> 10,
    }
}

fn square(value: f64) -> f64 {
    value * value
}
