//! From the bytes of a .gltf or .glb to its JSON as typed records, guarded: container lengths,
//! version, required extensions, and how many objects the JSON may unfold into.

use gltf::json::Root;
use serde_json::Value;

use crate::import::error::ImportError;
use crate::import::files::Files;
use crate::import::limits;

/// Extensions that a file may require: read, or without any effect on shape, cut and leaf colour.
const SUPPORTED: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// What one can do about a required extension.
const ADVICE: &[(&str, &str)] = &[
    ("KHR_draco_mesh_compression", "; decode it first, for example with `gltf-transform copy IN OUT`"),
    ("KHR_texture_basisu", "; convert its KTX2 textures to PNG or JPEG first"),
];

const MAGIC: &[u8; 4] = b"glTF";
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// The parsed JSON and the binary chunk of a GLB.
pub struct Document {
    /// Typed, but not validated: indices may point anywhere.
    pub root: Root,
    /// The BIN chunk.
    pub binary: Option<Vec<u8>>,
}

/// Whether the bytes start like a GLB.
pub fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Parses a .gltf or .glb.
pub fn parse(files: &mut Files, mut bytes: Vec<u8>) -> Result<Document, ImportError> {
    let mut binary = None;
    if is_glb(&bytes) {
        let chunks = split_glb(files, &bytes)?;
        binary = chunks.binary.map(|range| bytes[range].to_vec());
        bytes.truncate(chunks.json.end);
        bytes.drain(..chunks.json.start);
    }
    let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
    files.limit("bytes of JSON", json.len() as u64, limits::JSON_BYTES)?;
    count_json(files, json)?;
    let syntax = |error: serde_json::Error| ImportError::Syntax {
        file: files.file.clone(),
        message: format!("the JSON is not a glTF 2.0: {error}"),
    };
    check_version(files, &serde_json::from_slice::<Preamble>(json).map_err(syntax)?)?;
    let root = match serde_json::from_slice::<Root>(json) {
        Ok(root) => root,
        // gltf-json takes objects alone for extras, which may be anything. Rare, so only now.
        Err(error) => without_extras(json).ok_or_else(|| syntax(error))?,
    };
    Ok(Document { root, binary })
}

fn without_extras(json: &[u8]) -> Option<Root> {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(map) => {
                map.remove("extras");
                map.values_mut().for_each(strip);
            }
            Value::Array(list) => list.iter_mut().for_each(strip),
            _ => {}
        }
    }
    let mut value: Value = serde_json::from_slice(json).ok()?;
    strip(&mut value);
    serde_json::from_value(value).ok()
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

/// Refuses JSON that would unfold into far more memory than it has bytes. (Its depth is bounded by
/// serde_json.)
fn count_json(files: &Files, json: &[u8]) -> Result<(), ImportError> {
    let (mut objects, mut values) = (0u64, 0u64);
    let (mut in_string, mut escaped) = (false, false);
    for &byte in json {
        if in_string {
            in_string = escaped || byte != b'"';
            escaped = !escaped && byte == b'\\';
        } else {
            match byte {
                b'"' => in_string = true,
                b'{' | b'[' => objects += 1,
                b',' => values += 1,
                _ => {}
            }
        }
    }
    files.limit("objects and arrays in the JSON", objects, limits::JSON_OBJECTS)?;
    files.limit("values in the JSON", values, limits::JSON_VALUES)
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
        return Err(ImportError::UnsupportedVersion { file: files.file.clone(), found: version.clone() });
    }
    match preamble.extensions_required.iter().find(|name| !SUPPORTED.contains(&name.as_str())) {
        None => Ok(()),
        Some(name) => Err(ImportError::RequiredExtension {
            file: files.file.clone(),
            name: name.clone(),
            advice: ADVICE.iter().find(|(known, _)| known == name).map_or("", |(_, advice)| advice),
        }),
    }
}
