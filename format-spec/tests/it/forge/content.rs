//! Contents that break a promise: metadata and stored numbers, and the file laid out anew around them.

use flb_format::canonical;
use flb_format::records::*;

use super::{Parts, forge};

const RAW: &str = "raw-f32";
const F16: &str = "raw-f16";
const HAAR: &str = "haar-paper";

/// A forged file, the code that it must get, and words that the message must hold.
pub(crate) type Case = (u32, &'static str, Vec<u8>);

/// Replaces one piece of the first metadata text by another of the same length.
pub(crate) fn metadata(from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    forge(RAW, |parts| {
        let stored = parts.stored(0, 0);
        let at = stored.windows(from.len()).position(|w| w == from.as_bytes()).expect("it is there");
        stored[at..at + to.len()].copy_from_slice(to.as_bytes());
    })
}

/// Replaces the first metadata text by any other.
pub(crate) fn metadata_text(edit: impl FnOnce(&str) -> String) -> Vec<u8> {
    forge(RAW, |parts| {
        let text = String::from_utf8(parts.stored(0, 0).to_vec()).expect("metadata are UTF-8");
        let text = edit(&text).into_bytes();
        parts.sections[0].page_bytes = MAX_PAGE_BYTES;
        set_first_page(parts, 0, &text);
    })
}

/// With a member `left_out` of this text.
fn with_left_out(member: &str) -> Vec<u8> {
    metadata_text(|text| text.replace("\"model\":", &format!("\"left_out\":{member},\"model\":")))
}

/// With a member `mesh_blake3` of this text.
fn with_mesh(member: &str) -> Vec<u8> {
    metadata_text(|text| text.replace("\"model\":", &format!("\"mesh_blake3\":{member},\"model\":")))
}

/// With a member `mean_light` of this text.
fn with_mean(member: &str) -> Vec<u8> {
    metadata_text(|text| text.replace("\"model\":", &format!("\"mean_light\":{member},\"model\":")))
}

/// With surfaces of materials of this text.
fn with_materials(member: &str) -> Vec<u8> {
    metadata_text(|text| {
        let mut value: serde_json::Value = serde_json::from_str(text).expect("metadata are JSON");
        value["settings"]["surfaces.materials"] = serde_json::from_str(member).expect("JSON");
        String::from_utf8(canonical::to_bytes(&value).expect("it is canonical")).expect("it is text")
    })
}

fn left_out(bands: &str, bases: &str, reason: &str) -> Vec<u8> {
    with_left_out(&format!(r#"{{"bands":{bands},"bases":{bases},"reason":"{reason}"}}"#))
}

/// Gives a section of one page another payload.
pub(crate) fn set_first_page(parts: &mut Parts, section: usize, payload: &[u8]) {
    let length = payload.len() as u32;
    parts.sections[section].units = length.into();
    parts.sections[section].raw_bytes = length.into();
    let page = &mut parts.tables[section][0];
    (page.raw_bytes, page.stored_bytes, page.count) = (length, length, length);
    page.offset = parts.bytes.len() as u64;
    parts.bytes.extend(payload);
    relayout(parts);
}

pub(crate) fn content_cases() -> Vec<Case> {
    let raw_value = |value: f32| {
        forge(RAW, |parts| {
            let base = parts.base();
            parts.stored(base, 1)[8..12].copy_from_slice(&value.to_le_bytes());
        })
    };
    let half_value = |bits: u16| {
        forge(F16, |parts| {
            let base = parts.base();
            parts.stored(base, 1)[8..10].copy_from_slice(&bits.to_le_bytes());
        })
    };
    let density = |value: f32| {
        forge(RAW, |parts| {
            let density = parts.find(KIND_MEDIUM, 0);
            let stored = parts.stored(density, 0);
            let end = stored.len();
            stored[end - 4..].copy_from_slice(&value.to_le_bytes());
        })
    };
    vec![
        (4003, "payload of", {
            // One value more than the masks of the density have bits, or one less.
            forge(RAW, |parts| {
                let density = parts.find(KIND_MEDIUM, 0);
                parts.stored(density, 0)[0] ^= 1;
            })
        }),
        (5006, "is 158456330000000000000000000000", density(2.0 * MAX_MAGNITUDE)),
        (5001, "metadata is not JSON", metadata("{\"bounds_m\"", "[\"bounds_m\"")),
        (5001, "metadata is not JSON", metadata("golden", "go\0den")),
        (5015, "species 0: settings.surfaces.materials: ", with_materials("\"red\"")),
        (5015, "species 0: settings.surfaces.materials: ", with_materials(r#"[{"reflectance":[0.5]}]"#)),
        (
            5015,
            "settings.surfaces.materials[1].reflectance: 0 values, expected ",
            with_materials(r#"[null,{"reflectance":[],"texel":"tint","transmittance":[]}]"#),
        ),
        (
            5015,
            "species 0: settings.surfaces.materials: ",
            with_materials(r#"[{"reflectance":[],"texel":"paint","transmittance":[]}]"#),
        ),
        (5002, "departs from the canonical form", metadata("\"total\":12", "\"total\": 1")),
        (5002, "departs from the canonical form", metadata("\"leaf\":8,\"total\"", "\"zeaf\":8,\"total\"")),
        (5003, "metadata is unknown field `leag`", metadata("\"leaf\":8", "\"leag\":8")),
        (5003, "model is papes, expected \"paper\"", metadata("\"paper\"", "\"papes\"")),
        (5003, "grid.lattice is 17, expected a power of two", metadata("\"lattice\":16", "\"lattice\":17")),
        (5003, "sources.name is \"../ere.glb\"", metadata("sphere.glb", "../ere.glb")),
        (5003, "sources.blake3 is", metadata("abcdef0123", "ABCDEF0123")),
        (
            5003,
            "triangles.total is 10, expected at least leaf + wood",
            metadata("\"total\":12", "\"total\":10"),
        ),
        (
            5003,
            "sigma_a is 9.109, expected a share from 0 to 1",
            metadata("\"sigma_a\":0.109", "\"sigma_a\":9.109"),
        ),
        (
            5003,
            "grid.spacing_m is 0, expected metres",
            metadata_text(|text| text.replace("\"spacing_m\":0.125", "\"spacing_m\":0")),
        ),
        (
            5003,
            "name is \"..\"",
            metadata_text(|text| text.replace("\"name\":\"sphere\"", "\"name\":\"..\"")),
        ),
        (
            5003,
            "optics is 0 bands",
            metadata_text(|text| {
                let (start, end) =
                    (text.find("\"optics\":[").expect("there"), text.find("],\"settings").expect("there"));
                format!("{}\"optics\":[{}", &text[..start], &text[end..])
            }),
        ),
        (5003, "bounds_m.min[0] is 3", metadata_text(|text| text.replace("\"min\":[-0.75", "\"min\":[3"))),
        (
            5002,
            "nested deeper than 32 levels",
            metadata_text(|text| {
                let deep = format!("{}{}", "[".repeat(40), "]".repeat(40));
                text.replace("\"note\":", &format!("\"deep\":{deep},\"note\":"))
            }),
        ),
        (5001, "are not closed", metadata_text(|_| "[".repeat(100_000))),
        (5002, "nested deeper", metadata_text(|_| format!("{}{}", "[".repeat(128), "]".repeat(128)))),
        (5001, "metadata is not JSON", metadata_text(|_| "{\"a\":1e400}".to_owned())),
        (5001, "metadata is not JSON", metadata_text(|_| "{\"a\":\"\\ud800\"}".to_owned())),
        (5002, "departs", metadata("\"sigma_a\":0.109", "\"sigma_a\":1.090")),
        (5003, "metadata is 0", metadata_text(|_| "0".to_owned())),
        (5003, "triangles is [12,8,4], expected an object", {
            metadata_text(|text| {
                let start = text.find("\"triangles\":{").expect("there") + 12;
                let end = start + text[start..].find('}').expect("there") + 1;
                format!("{}[12,8,4]{}", &text[..start], &text[end..])
            })
        }),
        (5003, "optics[0].leaf is [0.1,0.2], expected an object", {
            metadata_text(|text| {
                let start = text.find("\"leaf\":{").expect("there") + 7;
                let end = start + text[start..].find('}').expect("there") + 1;
                format!("{}[0.1,0.2]{}", &text[..start], &text[end..])
            })
        }),
        (5003, "mesh_blake3 is ABCDEF01", with_mesh(&format!("\"{}\"", "ABCDEF01".repeat(8)))),
        (5003, "expected 64 lower-case hexadecimal digits", with_mesh(&format!("\"{}\"", "0".repeat(63)))),
        (5003, "mesh_blake3 is , expected 64", with_mesh("\"\"")),
        (5003, "metadata is invalid type: null, expected a string", with_mesh("null")),
        (5003, "metadata is invalid type: sequence, expected a string", with_mesh("[]")),
        (5003, "mean_light is [], expected an object", with_mean("[]")),
        (5003, "missing field `sun`", with_mean(r#"{"sky":[]}"#)),
        (5003, "unknown field `more`", with_mean(r#"{"more":1,"sky":[],"sun":[]}"#)),
        (
            5003,
            "mean_light.sky is 1 numbers, expected one for each band",
            with_mean(r#"{"sky":[1],"sun":[]}"#),
        ),
        (
            5003,
            "mean_light.sun[3] is 2 numbers, expected one for each band",
            with_mean(r#"{"sky":[],"sun":[[1,1,1],[1,1,1],[1,1,1],[1,1]]}"#),
        ),
        (
            5003,
            "mean_light.sun is 2 harmonics, expected 0, 1, 4, 9 or 16 harmonics",
            with_mean(r#"{"sky":[1,1,1],"sun":[[1,1,1],[1,1,1]]}"#),
        ),
        (5003, "invalid type: string \"1\", expected f64", with_mean(r#"{"sky":[1,1,"1"],"sun":[]}"#)),
        (5003, "mean_light is null, expected an object", with_mean("null")),
        (5003, "left_out is null, expected an object", with_left_out("null")),
        (5003, "left_out is [], expected an object", with_left_out("[]")),
        (5003, "missing field `reason`", with_left_out(r#"{"bands":[],"bases":[5]}"#)),
        (5003, "unknown field `more`", with_left_out(r#"{"bands":[],"bases":[5],"more":1,"reason":"r"}"#)),
        (5003, "bases [5, 4]: expected numbers from 0 to 18, ascending", left_out("[]", "[5,4]", "r")),
        (5003, "bases [5, 5]: expected", left_out("[]", "[5,5]", "r")),
        (5003, "bases [19]: expected", left_out("[]", "[19]", "r")),
        (5003, "left_out.bases is [], expected a base or a band", left_out("[]", "[]", "r")),
        (
            5003,
            "left_out.bands[0] is G, expected a name that no band of the species",
            left_out("[\"G\"]", "[5]", "r"),
        ),
        (5003, "left_out.bands[1] is X", left_out("[\"X\",\"X\"]", "[5]", "r")),
        (5003, "left_out.bands[0] is \"/\"", left_out("[\"/\"]", "[5]", "r")),
        (5003, "left_out.reason is \"\", expected 1 to 1000 bytes", left_out("[]", "[5]", "")),
        (5003, "left_out.reason is \"\\n\"", left_out("[]", "[5]", "\\n")),
        (5003, "left_out.reason is \"xxx", left_out("[]", "[5]", &"x".repeat(1001))),
        (
            5009,
            "base 1 of species 0 at byte 704: base 1 is present, but the metadata say that it was left out: r",
            left_out("[]", "[1,5]", "r"),
        ),
        (5004, "name \"sphere\" is taken by species 0", {
            forge(HAAR, |parts| {
                let (first, second) = (parts.find(KIND_METADATA, 0), 1);
                assert_eq!(parts.sections[second].key.kind, KIND_METADATA);
                let text = parts.stored(first, 0).to_vec();
                set_first_page(parts, second, &text);
            })
        }),
        (
            5005,
            "index of block 1 is 9, the masks before it give",
            forge(HAAR, |parts| {
                let base = parts.base();
                let count = parts.tables[base][0].count as usize;
                parts.stored(base, 0)[8 * count + 4..8 * count + 8].copy_from_slice(&9u32.to_le_bytes());
            }),
        ),
        (5006, "value 2 is NaN, expected a number", raw_value(f32::NAN)),
        (5006, "value 2 is inf", raw_value(f32::NEG_INFINITY.abs())),
        (5006, "value 2 is -0, expected", raw_value(-0.0)),
        (5006, "value 2 is 158456", raw_value(MAX_MAGNITUDE * 2.0)),
        (5006, "value 4 is NaN, expected a number", half_value(0x7E01)),
        (5006, "value 4 is inf", half_value(0x7C00)),
        (5006, "value 4 is -inf", half_value(0xFC00)),
        (5006, "value 4 is -0, expected", half_value(0x8000)),
        (5006, "page 0 of density of species 0", density(0.0)),
        (5006, "expected a number above 0", density(-0.5)),
        (5006, "is NaN, expected a number above 0", density(f32::NAN)),
        (
            5006,
            "is 3, expected class 1 (leaf) or 2 (wood)",
            forge(RAW, |parts| {
                let class = parts.find(KIND_MEDIUM, 1);
                *parts.stored(class, 0).last_mut().expect("it holds classes") = 3;
            }),
        ),
        (
            5006,
            "is NaN",
            forge(HAAR, |parts| {
                let base = parts.base();
                let stored = parts.stored(base, 0);
                let end = stored.len();
                stored[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
            }),
        ),
        (
            5007,
            "is kept, expected a magnitude above 0.1",
            forge(HAAR, |parts| {
                let base = parts.base(); // base 0: 18 times the threshold of 0.01
                let stored = parts.stored(base, 0);
                let end = stored.len();
                stored[end - 12..].fill(0);
            }),
        ),
        (5008, "density 1.5, expected a density of at most 1", density(1.5)),
        (
            5008,
            "expected class 0 exactly where the density is 0",
            forge(RAW, |parts| {
                let class = parts.find(KIND_MEDIUM, 1);
                let stored = parts.stored(class, 0);
                let group = stored[..512]
                    .as_chunks::<8>()
                    .0
                    .iter()
                    .position(|m| *m != [0; 8] && m[0] & 1 == 0 && *m != [0xFF; 8]);
                let at = group.expect("a mask with some bits") * 8;
                let mask = u64::from_le_bytes(stored[at..at + 8].try_into().expect("8 bytes"));
                // One bit moves down by one: as many values, at another site.
                let low = mask & mask.wrapping_neg();
                stored[at..at + 8].copy_from_slice(&(mask ^ low ^ (low >> 1)).to_le_bytes());
            }),
        ),
    ]
}

/// Moves tables, data and every offset to where the format wants them.
pub(crate) fn relayout(parts: &mut Parts) {
    let pages: usize = parts.tables.iter().map(Vec::len).sum();
    let mut table_at = 128 + 96 * parts.sections.len() as u64;
    parts.header.section_count = parts.sections.len() as u32;
    parts.header.contents_bytes = 96 * parts.sections.len() as u64;
    parts.header.tables_end = table_at + 48 * pages as u64;
    let old = std::mem::take(&mut parts.bytes);
    parts.bytes.resize(parts.header.tables_end as usize, 0);
    for (section, table) in parts.sections.iter_mut().zip(&mut parts.tables) {
        parts.bytes.resize(parts.bytes.len().next_multiple_of(64), 0);
        section.data_offset = parts.bytes.len() as u64;
        section.table_offset = table_at;
        section.page_count = table.len() as u32;
        table_at += 48 * table.len() as u64;
        for page in table {
            parts.bytes.resize(parts.bytes.len().next_multiple_of(16), 0);
            let stored = &old[page.offset as usize..][..page.stored_bytes as usize];
            page.offset = parts.bytes.len() as u64;
            parts.bytes.extend(stored);
        }
        section.data_bytes = parts.bytes.len() as u64 - section.data_offset;
    }
    parts.header.file_bytes = parts.bytes.len() as u64;
}
