//! Mutators: libFuzzer's own changes, made where they reach deep code, with digests and lengths made to fit.
#![forbid(unsafe_code)]

use flb_format::testing::damage::damage;
use libfuzzer_sys::fuzzer_mutate;

/// How much longer one change may make a part of a file, bytes.
const GROWTH_BYTES: usize = 256;

/// A container file: mostly one page, record or table is changed and all digests are repaired, sometimes any byte is.
pub fn mutate_container(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    if !seed.is_multiple_of(16) {
        let damaged = damage(&data[..size], seed / 16, &mut change);
        if let Some(damaged) = damaged.filter(|damaged| damaged.len() <= max_size) {
            data[..damaged.len()].copy_from_slice(&damaged);
            return damaged.len();
        }
    }
    fuzzer_mutate(data, size, max_size)
}

/// A GLB: its JSON or its binary chunk is changed, and the lengths are repaired. A glTF: as it is.
pub fn mutate_gltf(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    if !seed.is_multiple_of(16)
        && let Some([mut json, mut binary]) = split_glb(&data[..size])
    {
        change(if seed & 16 == 0 { &mut json } else { &mut binary });
        let glb = join_glb(&json, &binary);
        if glb.len() <= max_size {
            data[..glb.len()].copy_from_slice(&glb);
            return glb.len();
        }
    }
    fuzzer_mutate(data, size, max_size)
}

fn change(bytes: &mut Vec<u8>) {
    let length = bytes.len();
    bytes.resize(length + GROWTH_BYTES, 0);
    let changed = fuzzer_mutate(bytes, length, length + GROWTH_BYTES);
    bytes.truncate(changed);
}

fn split_glb(bytes: &[u8]) -> Option<[Vec<u8>; 2]> {
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
    let json_end = 20usize.checked_add(word(12)?)?;
    let json = bytes.strip_prefix(b"glTF").and(bytes.get(20..json_end))?;
    Some([json.to_vec(), bytes.get(json_end + 8..).unwrap_or_default().to_vec()])
}

fn join_glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((20 + json.len() as u32 + 8 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(0x4E4F_534Au32, json), (0x004E_4942, binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(chunk);
    }
    bytes
}
