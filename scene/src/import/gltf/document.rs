//! From the bytes of a .gltf or .glb to its JSON as typed records, guarded: container lengths,
//! version, required extensions, and how many objects the JSON may unfold into.

use gltf::json::Root;

use crate::import::error::{ImportError, excerpt, quoted};
use crate::import::files::Files;
use crate::import::known::gltf::advice_against;
use crate::import::known::warn_of_unread;
use crate::import::limits;

const MAGIC: &[u8; 4] = b"glTF";
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// The parsed JSON and the binary chunk of a GLB.
pub(super) struct Document {
    /// Typed, but not validated: indices may point anywhere.
    pub root: Root,
    /// The BIN chunk.
    pub binary: Option<Vec<u8>>,
    /// Transform of each node, as precise as the JSON has it; empty where no node lies so far off that the f32s of
    /// `root` lose something.
    pub transforms: Vec<NodeTransform>,
    /// Memory that was held for `root`.
    pub held_bytes: u64,
}

/// The transform of a node, in f64.
#[derive(Debug, Clone, Copy, Default, serde::Deserialize)]
#[serde(default)]
pub(super) struct NodeTransform {
    /// Column-major.
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    /// A quaternion x, y, z, w.
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

#[derive(serde::Deserialize)]
struct Transforms {
    #[serde(default)]
    nodes: Vec<NodeTransform>,
}

/// Coordinates of nodes beyond this lose more than 4e-6 m in an f32.
const NEAR: f32 = 100.0;

/// The transforms in f64, where that tells more.
fn far_transforms(files: &mut Files, root: &Root, json: &[u8]) -> Result<Vec<NodeTransform>, ImportError> {
    let is_far = |x: &f32| x.abs() > NEAR;
    let lies_far = root.nodes.iter().any(|node| {
        let matrix = node.matrix.as_ref().map_or(&[][..], |matrix| &matrix[12..15]);
        node.translation.iter().flatten().chain(matrix).any(is_far)
    });
    if !lies_far {
        return Ok(Vec::new());
    }
    files.room_for("transforms of nodes", (root.nodes.len() * 2 * size_of::<NodeTransform>()) as u64)?;
    // What these records cannot hold, those of the whole file have taken.
    Ok(serde_json::from_slice::<Transforms>(json).map_or_else(|_| Vec::new(), |transforms| transforms.nodes))
}

/// Whether the bytes start like a GLB.
pub(crate) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Parses a .gltf or .glb.
pub(super) fn parse(files: &mut Files, mut bytes: Vec<u8>) -> Result<Document, ImportError> {
    let mut binary = None;
    if is_glb(&bytes) {
        let chunks = split_glb(files, &bytes)?;
        let json_bytes = chunks.json.len() as u64;
        files.limit("bytes of JSON", json_bytes, limits::JSON_BYTES)?;
        files.room_for("a copy of the JSON", bytes.len() as u64 + json_bytes)?;
        let json = bytes[chunks.json].to_vec();
        binary = chunks.binary.map(|range| {
            bytes.truncate(range.end);
            bytes.drain(..range.start);
            bytes.shrink_to_fit();
            bytes
        });
        bytes = json;
    }
    let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
    files.limit("bytes of JSON", json.len() as u64, limits::JSON_BYTES)?;
    let held_bytes = count_json(files, json)?;
    let json_bytes = json.len();
    // Beside the records, whose texts take as much again: the JSON itself, and what lies behind it.
    let beside = json_bytes + binary.as_ref().map_or(0, Vec::len);
    files.room_for("the JSON", held_bytes + beside as u64)?;
    files.hold("the JSON", held_bytes)?;
    let syntax = |error: serde_json::Error| ImportError::Syntax {
        file: files.file.clone(),
        message: format!("the JSON is not a glTF 2.0: {}", excerpt(error.to_string())),
    };
    check_version(files, &serde_json::from_slice::<Preamble>(json).map_err(syntax)?)?;
    let (root, transforms) = match serde_json::from_slice::<Root>(json) {
        Ok(root) => {
            let transforms = far_transforms(files, &root, json)?;
            (root, transforms)
        }
        // gltf-json takes objects alone for extras, which may be anything. Rare, so only now.
        Err(error) => {
            bytes.drain(..bytes.len() - json_bytes);
            blank_extras(&mut bytes);
            let root = serde_json::from_slice(&bytes).map_err(|_| syntax(error))?;
            let transforms = far_transforms(files, &root, &bytes)?;
            (root, transforms)
        }
    };
    warn_of_unread(files, json_of(&bytes, json_bytes));
    Ok(Document { root, binary, transforms, held_bytes })
}

/// The JSON at the end of what was read, behind a byte order mark.
fn json_of(bytes: &[u8], length: usize) -> &[u8] {
    &bytes[bytes.len() - length..]
}

/// Replaces every member `extras` by an empty one of another name, in place: they may be large and of any kind.
fn blank_extras(json: &mut [u8]) {
    const NAME: &[u8] = b"\"extras\"";
    const INSTEAD: &[u8] = b"\"_\":0";
    let mut at = 0;
    while at < json.len() {
        if json[at] != b'"' {
            at += 1;
            continue;
        }
        let end = value_end(json, at);
        let colon = end + json[end..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        if &json[at..end] != NAME || json.get(colon) != Some(&b':') {
            at = end;
            continue;
        }
        let space = json[colon + 1..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let end = value_end(json, (colon + 1 + space).min(json.len()));
        json[at..end].fill(b' ');
        json[at..][..INSTEAD.len()].copy_from_slice(INSTEAD);
        at = end;
    }
}

/// Where the JSON value that starts at `at` ends; for what is no JSON, some place not before `at`.
fn value_end(json: &[u8], at: usize) -> usize {
    let (mut depth, mut strings) = (0u32, Strings::default());
    for (i, &byte) in json.iter().enumerate().skip(at) {
        if !strings.hold(byte) {
            match byte {
                b'"' => {}
                b'{' | b'[' => depth += 1,
                b'}' | b']' if depth == 0 => return i,
                b'}' | b']' => depth -= 1,
                b',' | b':' if depth == 0 => return i,
                _ if byte.is_ascii_whitespace() && depth == 0 => return i,
                _ => continue,
            }
        }
        // A text or a list ends with its last byte, not with what follows.
        if !strings.inside && depth == 0 {
            return i + 1;
        }
    }
    json.len()
}

/// Which bytes of JSON lie within its strings.
#[derive(Default)]
struct Strings {
    inside: bool,
    escaped: bool,
}

impl Strings {
    /// Whether the next byte lies within a string, as its closing quote does and its opening one does not.
    fn hold(&mut self, byte: u8) -> bool {
        let held = self.inside;
        self.inside = if held { self.escaped || byte != b'"' } else { byte == b'"' };
        self.escaped = held && !self.escaped && byte == b'\\';
        held
    }
}

struct Chunks {
    json: std::ops::Range<usize>,
    binary: Option<std::ops::Range<usize>>,
}

/// GLB: 12 bytes of header (magic, version, length), then chunks of length, type and data.
fn split_glb(files: &mut Files, bytes: &[u8]) -> Result<Chunks, ImportError> {
    let word = |offset: usize| -> Option<u32> {
        Some(u32::from_le_bytes(bytes.get(offset..offset.checked_add(4)?)?.try_into().ok()?))
    };
    let short = |place: &str, needed: usize| {
        files.malformed(place, format!("{} bytes in the file", bytes.len()), format!("at least {needed}"))
    };
    let version = word(4).ok_or_else(|| short("GLB header", 12))?;
    if version != 2 {
        return Err(ImportError::UnsupportedVersion {
            file: files.file.clone(),
            found: format!("{version} (GLB)"),
        });
    }
    let length = word(8).ok_or_else(|| short("GLB header", 12))? as usize;
    if length > bytes.len() || length < 12 {
        return Err(files.malformed(
            "GLB header, length",
            length,
            format!("12..={} (the file)", bytes.len()),
        ));
    }
    if length < bytes.len() {
        files.warn(format!("{} bytes after the GLB's end are ignored", bytes.len() - length));
    }
    let mut chunks: Vec<(u32, std::ops::Range<usize>)> = Vec::new();
    let mut offset = 12;
    while offset < length && chunks.len() < 2 {
        let place = format!("GLB chunk {} at byte {offset}", chunks.len());
        let (Some(size), Some(kind)) = (word(offset), word(offset + 4)) else {
            return Err(files.malformed(
                place,
                format!("{} bytes", length - offset),
                "8 bytes of chunk header",
            ));
        };
        let start = offset + 8;
        let end = start.checked_add(size as usize).filter(|&end| end <= length);
        let Some(end) = end else {
            let left = length.saturating_sub(start);
            return Err(files.malformed(place, format!("a length of {size}"), format!("at most {left}")));
        };
        chunks.push((kind, start..end));
        offset = end;
    }
    match chunks.as_slice() {
        [(CHUNK_JSON, json)] => Ok(Chunks { json: json.clone(), binary: None }),
        [(CHUNK_JSON, json), (kind, binary)] => {
            Ok(Chunks { json: json.clone(), binary: (*kind == CHUNK_BIN).then(|| binary.clone()) })
        }
        [] => Err(files.malformed("GLB", "no chunk", "a JSON chunk")),
        [(kind, _), ..] => {
            Err(files.malformed("GLB chunk 0", format!("type {kind:#010x}"), "0x4e4f534a (JSON)"))
        }
    }
}

/// The memory that JSON will take, at most, once it is parsed; refuses what would unfold into far too much. (Its
/// depth is bounded by serde_json.)
fn count_json(files: &Files, json: &[u8]) -> Result<u64, ImportError> {
    let (mut objects, mut arrays, mut values) = (0u64, 0u64, 0u64);
    let mut strings = Strings::default();
    for &byte in json.iter().filter(|&&byte| !strings.hold(byte)) {
        match byte {
            b'{' => objects += 1,
            b'[' => arrays += 1,
            b',' => values += 1,
            _ => {}
        }
    }
    files.limit("objects and arrays in the JSON", objects + arrays, limits::JSON_OBJECTS)?;
    files.limit("values in the JSON", values, limits::JSON_VALUES)?;
    Ok(json.len() as u64
        + objects * limits::JSON_OBJECT_BYTES
        + arrays * limits::JSON_ARRAY_BYTES
        + values * limits::JSON_VALUE_BYTES)
}

/// What must be known before the rest is even looked at.
#[derive(serde::Deserialize)]
struct Preamble {
    asset: Asset,
    #[serde(default, rename = "extensionsRequired")]
    extensions_required: Vec<String>,
}

#[derive(serde::Deserialize)]
struct Asset {
    version: String,
    #[serde(rename = "minVersion")]
    min_version: Option<String>,
}

fn check_version(files: &Files, preamble: &Preamble) -> Result<(), ImportError> {
    let version = preamble.asset.min_version.as_ref().unwrap_or(&preamble.asset.version);
    if version.split('.').next() != Some("2") {
        return Err(ImportError::UnsupportedVersion { file: files.file.clone(), found: quoted(version) });
    }
    let mut required = preamble.extensions_required.iter();
    match required.find_map(|name| Some((name, advice_against(name)?))) {
        None => Ok(()),
        Some((name, advice)) => {
            let name = format!("{}, which is not supported", quoted(name));
            Err(ImportError::RequiredExtension { file: files.file.clone(), name, advice })
        }
    }
}
