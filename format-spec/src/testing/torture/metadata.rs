//! Kinds 46, 48 to 50 and 60: what the metadata of the first species say, and how they say it.

use serde_json::{Map, Value, json};

use super::{Cases, PASSES};
use crate::canonical;
use crate::container::records::MAX_METADATA_BYTES;
use crate::material_surface::MATERIALS;

pub(super) fn cases(cases: &mut Cases) {
    let subject = cases.subject;
    let text = subject.container.read_metadata(&subject.file, 0).expect("the file was checked");
    let value: Value = serde_json::from_slice(&text).expect("the file was checked");
    let mut bytes = |kind, label: &str, done: &str, code: u32, text: Vec<u8>| {
        cases.rebuild(kind, label, done, code, |parts| parts.replace(0, &text));
    };
    let with = |place: &str, new: Value| {
        let mut value = value.clone();
        *value.pointer_mut(place).expect("all metadata have it") = new;
        canonical::to_bytes(&value).expect("it is canonical")
    };
    let named = |name: &str| with("/name", json!(name));
    let lattice = with("/grid/lattice", json!(0));
    bytes(46, "lattice-in-metadata", "a lattice of 0 in the metadata", 5003, lattice);
    bytes(48, "climbs", "a species named ../../etc/passwd", 5003, named("../../etc/passwd"));
    bytes(48, "dots", "a species named ..", 5003, named(".."));
    bytes(48, "backslash", "a species named a\\b", 5003, named("a\\b"));
    bytes(48, "escaped-nul", "a species whose name holds an escaped NUL", 5003, named("a\0b"));
    bytes(48, "long-name", "a species' name of 256 bytes", 5003, named(&"n".repeat(256)));
    let name = b"\"name\":\"";
    let at = text.windows(name.len()).rposition(|w| w == name).expect("all metadata have it") + name.len();
    let at_name = |bytes: &[u8]| [&text[..at], bytes, &text[at..]].concat();
    bytes(48, "not-utf-8", "a byte of FF in a name", 5001, at_name(&[0xFF]));
    bytes(48, "overlong", "an overlong slash (C0 AF) in a name", 5001, at_name(&[0xC0, 0xAF]));
    bytes(48, "raw-nul", "a NUL as it is in a name", 5001, at_name(&[0]));
    bytes(48, "lone-surrogate", "a lone surrogate in a name", 5001, at_name(b"\\ud800"));

    for (label, done, found) in [
        ("materials-no-array", "surfaces of materials that are no array", json!("red")),
        (
            "materials-no-texel",
            "a surface of a material that says not what a texel is",
            json!([{"reflectance": []}]),
        ),
        (
            "materials-bands",
            "surfaces of a material in 65 bands",
            json!([null, {"texel": "tint", "reflectance": vec![0.5; 65], "transmittance": vec![0.5; 65]}]),
        ),
    ] {
        let mut value = value.clone();
        value["settings"][MATERIALS] = found;
        bytes(60, label, done, 5015, canonical::to_bytes(&value).expect("it is canonical"));
    }
    let nested = (0..40).fold(json!([]), |inner, _| json!([inner]));
    bytes(49, "nested-40", "a setting nested 40 deep", 5002, with_text(&text, &nested.to_string()));
    let half = MAX_METADATA_BYTES as usize / 2;
    let deep = ["[".repeat(half), "]".repeat(half)].concat().into_bytes();
    bytes(49, "nested-524288", "nothing but 524288 nested arrays", 5002, deep);
    bytes(49, "never-closed", "1048576 arrays that are not closed", 5001, vec![b'['; 2 * half]);
    let first = text.iter().position(|byte| *byte == b':').expect("an object with members") + 1;
    let twice = [&text[..first], b"0,", &text[1..]].concat();
    bytes(49, "twice", "a name twice in the outermost object", 5002, twice);
    let again = with_text(&text, "{\"a\":1,\"a\":1}");
    bytes(49, "twice-deeper", "a name twice in an object in it", 5002, again);
    bytes(50, "many-keys", "40000 keys of one length in the settings, which pass", PASSES, flooded(&value));
}

/// With another member that has this value, behind all others: `~` sorts behind letters.
fn with_text(text: &[u8], value: &str) -> Vec<u8> {
    [&text[..text.len() - 1], b",\"~torture\":", value.as_bytes(), b"}"].concat()
}

/// Keys are kept in trees, which no choice of keys makes slow.
fn flooded(value: &Value) -> Vec<u8> {
    let mut value = value.clone();
    let keys: Map<String, Value> =
        (0..40_000u64).map(|i| (format!("{:016}", i * 65_536), json!(0))).collect();
    value["settings"] = Value::Object(keys);
    canonical::to_bytes(&value).expect("it is canonical")
}
