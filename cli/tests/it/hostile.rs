//! Meshes made to harm, at their full size: each ends in a clear error (or in a warning, where the plant's shape does
//! not depend on it) within 1 GiB of address space, which the system enforces on the command here.
#![cfg(target_os = "linux")]

use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use serde_json::{Value, json};

use crate::flb::{Folder, Run};

/// Kilobytes of address space: 1 GiB.
const MEMORY_KB: u32 = 1 << 20;
/// Seconds of processor time after which a run counts as endless. Every case takes a few, at most.
const ENDLESS_S: u32 = 120;

/// Runs `flb materials` on a file of the folder, within the limits.
fn materials(folder: &Folder, file: &str) -> Run {
    within_limit(folder, &["materials", file])
}

fn within_limit(folder: &Folder, words: &[&str]) -> Run {
    folder.flb_under(&[format!("-v {MEMORY_KB}"), format!("-t {ENDLESS_S}")], words)
}

/// A file by pieces, so that no test holds in memory what it forbids the command to hold.
fn write(path: &Path, pieces: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>) {
    let mut out = BufWriter::new(File::create(path).expect("a temporary file"));
    pieces(&mut out).and_then(|()| out.flush()).expect("it can be written");
}

/// A GLB of this JSON and a chunk of so many zero bytes, which take no room on the disk.
fn write_glb(path: &Path, json: &str, binary_bytes: u32) {
    let json_bytes = json.len().next_multiple_of(4);
    write(path, |out| {
        let total = 12 + 8 + json_bytes as u32 + 8 + binary_bytes;
        out.write_all(b"glTF")?;
        for word in [2, total, json_bytes as u32, 0x4E4F_534A] {
            out.write_all(&word.to_le_bytes())?;
        }
        write!(out, "{json:json_bytes$}")?;
        out.write_all(&binary_bytes.to_le_bytes())?;
        out.write_all(&0x004E_4942u32.to_le_bytes())?;
        let end = out.stream_position()? + u64::from(binary_bytes);
        out.get_ref().set_len(end)?;
        out.seek(SeekFrom::Start(end)).map(drop)
    });
}

/// A glTF whose last member is written by `pieces`.
fn write_gltf(path: &Path, json: &Value, pieces: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>) {
    let text = json.to_string();
    write(path, |out| {
        write!(out, "{},", &text[..text.len() - 1])?;
        pieces(out)?;
        out.write_all(b"}")
    });
}

fn repeat(out: &mut impl Write, text: &str, times: usize) -> std::io::Result<()> {
    let piece = text.repeat(1000);
    for _ in 0..times / 1000 {
        out.write_all(piece.as_bytes())?;
    }
    out.write_all(text.repeat(times % 1000).as_bytes())
}

/// A triangle at the end of the member that [`write_gltf`] adds: everything but nodes.
fn parts() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"componentType": 5126, "count": 3, "type": "VEC3"}],
    })
}

#[test]
fn json_that_unfolds_stays_within_the_limit() {
    let folder = Folder::new();
    // A piece repeated, in a member of its own; how the run ends, and the words of the message.
    let table: [(&str, &str, &str, usize, &str, i32, &str); 11] = [
        ("empty nodes", "\"nodes\":[", "{},", 1_040_000, "{}]", 6, "bytes of memory, with the JSON"),
        ("as many as fit", "\"nodes\":[", "{},", 400_000, "{}]", 1, "no triangle is left"),
        ("materials", "\"materials\":[", "{},", 400_000, "{}]", 1, "no triangle is left"),
        (
            "small maps",
            "\"nodes\":[{\"extensions\":{\"x\":[",
            "{\"a\":1},",
            400_000,
            "{}]}}]",
            1,
            "no triangle is left",
        ),
        (
            "short texts",
            "\"nodes\":[{\"extensions\":{\"x\":[",
            "\"a\",",
            4_000_000,
            "1]}}]",
            1,
            "no triangle is left",
        ),
        (
            "more of them",
            "\"nodes\":[{\"extensions\":{\"x\":[",
            "\"a\",",
            8_000_000,
            "1]}}]",
            6,
            "bytes of memory",
        ),
        (
            "lists",
            "\"nodes\":[{\"extensions\":{\"x\":[",
            "[1],",
            1_000_000,
            "1]}}]",
            1,
            "no triangle is left",
        ),
        ("one long name", "\"nodes\":[{\"name\":\"", "long", 40_000_000, "\"}]", 1, "no triangle is left"),
        (
            "one long URI",
            "\"buffers\":[{\"byteLength\":1,\"uri\":\"",
            "long",
            40_000_000,
            "\"}]",
            6,
            "file's name",
        ),
        (
            "base64",
            "\"buffers\":[{\"byteLength\":1,\"uri\":\"data:;base64,",
            "AAAA",
            40_000_000,
            "\"}]",
            1,
            "no triangle",
        ),
        ("extras", "\"extras\":[", "\"a\",[],", 500_000, "1]", 1, "no triangle is left"),
    ];
    for (name, start, piece, times, end, code, words) in table {
        write_gltf(&folder.path("a.gltf"), &parts(), |out| {
            out.write_all(start.as_bytes())?;
            repeat(out, piece, times)?;
            out.write_all(end.as_bytes())
        });
        eprintln!("{name}");
        materials(&folder, "a.gltf").expect_code(code).says(&["a.gltf", words]);
    }
}

#[test]
fn meshes_that_fill_memory_stay_within_the_limit() {
    let folder = Folder::new();
    let corners = |count: u64, mode: u32| {
        json!({
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"mode": mode, "attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 12 * count}],
            "buffers": [{"byteLength": 12 * count}],
        })
    };
    for (count, mode, code, words) in [
        (7_000_000, 4, 1, "none of which has an area"),
        (25_000_000, 4, 6, "bytes of memory, with vertices"),
        (8_000_000, 5, 6, "bytes of memory, with triangles"),
        (32_000_000, 4, 6, "triangles: 10666666 is over"),
    ] {
        write_glb(&folder.path("a.glb"), &corners(count, mode).to_string(), 12 * count as u32);
        materials(&folder, "a.glb").expect_code(code).says(&["a.glb", words]);
    }
    let mut instanced = corners(3, 4);
    let instances = json!({"componentType": 5126, "count": 1_040_000, "type": "VEC3"});
    instanced["accessors"].as_array_mut().expect("a list").push(instances);
    instanced["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}});
    write_glb(&folder.path("a.glb"), &instanced.to_string(), 36);
    materials(&folder, "a.glb").expect_code(2).says(&["a.glb: holds 1040000 instances"]);
    let whole = ["materials", "a.glb", "--gltf-mesh", "*"];
    within_limit(&folder, &whole).expect_code(1).says(&["none of which has an area"]);
    let scene = ["scene", "a.glb", "-o", "a.toml"];
    within_limit(&folder, &scene)
        .expect_code(6)
        .says(&["a scene of 1040000 plants", "limit of 67108864 bytes"]);
    let mut packed = corners(3, 4);
    packed["bufferViews"][0]["extensions"] = json!({"EXT_meshopt_compression":
        {"buffer": 0, "byteLength": 36, "byteStride": 16, "count": 20_000_000, "mode": "ATTRIBUTES"}});
    write_glb(&folder.path("a.glb"), &packed.to_string(), 36);
    materials(&folder, "a.glb").expect_code(1).says(&["packed bytes that do not decode"]);
    // 2^32 vertices, and a buffer of so many.
    write_glb(&folder.path("a.glb"), &corners(1 << 32, 4).to_string(), 36);
    materials(&folder, "a.glb").expect_code(1).says(&["buffers[0]: found 36 bytes"]);
    let mut cut = corners(3, 4);
    cut["accessors"][0]["count"] = json!(1u64 << 32);
    write_glb(&folder.path("a.glb"), &cut.to_string(), 36);
    materials(&folder, "a.glb").expect_code(6).says(&["4294967296 is over the limit"]);
}

#[test]
fn an_obj_that_fills_memory_stays_within_the_limit() {
    let folder = Folder::new();
    let most = 8 << 20;
    write(&folder.path("a.obj"), |out| {
        repeat(out, "v 0 0 1\n", most)?;
        repeat(out, "vt 0\n", most)?;
        repeat(out, "vn 0 0 1\n", most)?;
        for i in (1..=most).step_by(3) {
            writeln!(out, "f {i}/{i}/{i} {0}/{0}/{0} {1}/{1}/{1}", (i + 1).min(most), (i + 2).min(most))?;
        }
        Ok(())
    });
    materials(&folder, "a.obj").expect_code(6).says(&["a.obj", "bytes of memory, with "]);
    // More text than is read, which takes no room on the disk: one endless line, then lines without end.
    File::create(folder.path("a.obj")).and_then(|file| file.set_len(3 << 30)).expect("a sparse file");
    materials(&folder, "a.obj").expect_code(6).says(&["a.obj", "bytes of line 1"]);
    write(&folder.path("a.obj"), |out| repeat(out, "v 0 0 1\n", most + 1));
    materials(&folder, "a.obj").expect_code(6).says(&["a.obj", "v lines: 8388609 is over"]);
    let name = "n".repeat(1000);
    write(&folder.path("a.obj"), |out| {
        out.write_all(b"v 0 0 0\nv 1 0 0\nv 0 1 0\n")?;
        (0..66_000).try_for_each(|i| writeln!(out, "usemtl {name}{i}\nf 1 2 3"))
    });
    materials(&folder, "a.obj").expect_code(6).says(&["a.obj", "materials: 65537 is over"]);
}

/// A PNG of zeros, row by row.
fn write_png(path: &Path, width: u32, height: u32, color: png::ColorType, depth: png::BitDepth) {
    write(path, |out| {
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.set_compression(png::Compression::Fast);
        let row = vec![0; (color.samples() * depth as usize * width as usize).div_ceil(8)];
        let mut writer = encoder.write_header()?;
        let mut stream = writer.stream_writer()?;
        (0..height).try_for_each(|_| stream.write_all(&row))?;
        stream.finish()?;
        Ok(())
    });
}

#[test]
fn images_that_unfold_stay_within_the_limit() {
    use png::{BitDepth, ColorType};
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl leaf\nmap_Kd a.png\n");
    folder.write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl leaf\nf 1 2 3\n");
    let image = folder.path("a.png");
    for (width, height, color, depth, code, words) in [
        (16384, 5120, ColorType::Rgb, BitDepth::Eight, 0, ""),
        (16384, 5120, ColorType::Rgba, BitDepth::Eight, 0, ""),
        (8192, 8192, ColorType::Grayscale, BitDepth::One, 0, ""),
        (
            16384,
            5120,
            ColorType::Rgba,
            BitDepth::Sixteen,
            6,
            "bytes of memory, with the decoding of the image",
        ),
        (16384, 5121, ColorType::Rgb, BitDepth::Eight, 6, "texels of all images"),
        (16385, 1, ColorType::Rgb, BitDepth::Eight, 6, "texels along an edge"),
    ] {
        write_png(&image, width, height, color, depth);
        materials(&folder, "a.obj").expect_code(code).says(&[words]);
    }
    // Sizes that are claimed and not there, in each format that is read.
    let claims: [(&str, Vec<u8>); 5] = [
        ("PNG", claimed_png(0x7FFF_FFFF)),
        (
            "JPEG",
            [
                b"\xFF\xD8\xFF\xC2\x00\x11\x08\xFF\xFF\xFF\xFF\x03\x01\x22\x00\x02\x11\x01\x03\x11\x01"
                    .as_slice(),
                &[0; 64],
            ]
            .concat(),
        ),
        (
            "WebP",
            [b"RIFF\xFF\xFF\xFF\x7FWEBPVP8L\xFF\xFF\xFF\x7F\x2F\xFF\xFF\xFF\x0F".as_slice(), &[0; 64]]
                .concat(),
        ),
        (
            "BMP",
            [
                b"BM\xFF\xFF\xFF\x7F\0\0\0\0\x36\0\0\0\x28\0\0\0\xFF\xFF\xFF\x7F\xFF\xFF\xFF\x7F\x01\0\x20\0"
                    .as_slice(),
                &[0; 64],
            ]
            .concat(),
        ),
        ("empty", Vec::new()),
    ];
    for (name, bytes) in claims {
        folder.write("a.png", bytes);
        let run = materials(&folder, "a.obj");
        assert!(
            [0, 6].contains(&run.code) && run.stderr.contains("a.png"),
            "{name}: {}: {}",
            run.code,
            run.stderr
        );
    }
}

/// Signature and header of a square PNG, and image data that end at once.
fn claimed_png(edge: u32) -> Vec<u8> {
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = edge.to_be_bytes().to_vec();
    header.extend(edge.to_be_bytes());
    header.extend([8, 6, 0, 0, 0]);
    for (kind, data) in [(b"IHDR", header.as_slice()), (b"IDAT", &[]), (b"IEND", &[])] {
        let start = bytes.len() + 4;
        bytes.extend((data.len() as u32).to_be_bytes());
        bytes.extend(kind);
        bytes.extend(data);
        let crc = crc32(&bytes[start..]);
        bytes.extend(crc.to_be_bytes());
    }
    bytes
}

/// The checksum of PNG chunks.
fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = !0u32;
    for &byte in bytes {
        crc ^= u32::from(byte);
        (0..8).for_each(|_| crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()));
    }
    !crc
}

#[test]
fn the_limit_of_memory_is_enforced_here() {
    // Were the limit not applied, the tests above could not fail.
    let folder = Folder::new();
    let output = std::process::Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY_KB} && ulimit -v")])
        .current_dir(folder.path(""))
        .output()
        .expect("the shell starts");
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), MEMORY_KB.to_string());
}
