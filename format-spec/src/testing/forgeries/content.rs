//! Contents that break a promise: metadata and stored numbers.

use serde_json::Value;

use super::{List, base, piece};
use crate::canonical;
use crate::container::records::*;
use crate::material_surface::MATERIALS;

const RAW: &str = "raw-f32";

pub(super) fn add(list: &mut List) {
    texts(list);
    members(list);
    materials(list);
    numbers(list);
}

/// Pieces of the first metadata replaced, or all of them.
fn texts(list: &mut List) {
    let mut raw = list.of(RAW);
    let text = raw.text();
    raw.swap(5001, "metadata is not JSON", "{\"bounds_m\"", "[\"bounds_m\"");
    raw.metadata(5001, "metadata is not JSON", "{\"a\":1e400}");
    raw.swap(5002, "departs from the canonical form", "\"total\":12", "\"total\": 1");
    raw.swap(5002, "departs from the canonical form", "\"leaf\":8,\"total\"", "\"zeaf\":8,\"total\"");
    raw.swap(5002, "departs", "\"sigma_a\":0.109", "\"sigma_a\":1.090");
    raw.metadata(5003, "metadata is 0", "0");
    raw.swap(5003, "metadata is unknown field `leag`", "\"leaf\":8", "\"leag\":8");
    raw.swap(5003, "model is papes, expected \"paper\"", "\"paper\"", "\"papes\"");
    raw.swap(5003, "sources.name is \"../ere.glb\"", "sphere.glb", "../ere.glb");
    raw.swap(5003, "sources.blake3 is", "abcdef0123", "ABCDEF0123");
    raw.swap(5003, "triangles.total is 10, expected at least leaf + wood", "\"total\":12", "\"total\":10");
    let words = "sigma_a is 9.109, expected a share from 0 to 1";
    raw.swap(5003, words, "\"sigma_a\":0.109", "\"sigma_a\":9.109");
    raw.swap(5003, "grid.spacing_m is 0, expected metres", "\"spacing_m\":0.125", "\"spacing_m\":0");
    raw.swap(5003, "bounds_m.min[0] is 3", "\"min\":[-0.75", "\"min\":[3");
    let optics = piece(&text, "\"optics\":[", "],\"settings");
    raw.swap(5003, "optics is 0 bands", optics, "\"optics\":[],\"settings");
    let (words, triangles) =
        ("triangles is [12,8,4], expected an object", piece(&text, "\"triangles\":{", "}"));
    raw.swap(5003, words, triangles, "\"triangles\":[12,8,4]");
    let (words, leaf) = ("optics[0].leaf is [0.1,0.2], expected an object", piece(&text, "\"leaf\":{", "}"));
    raw.swap(5003, words, leaf, "\"leaf\":[0.1,0.2]");
}

/// Members put in that a sound file may have.
fn members(list: &mut List) {
    let mut raw = list.of(RAW);
    let mut with = |name: &str, words: &'static str, value: &str| {
        raw.swap(5003, words, "\"model\":", &format!("\"{name}\":{value},\"model\":"));
    };
    with("mesh_blake3", "mesh_blake3 is ABCDEF01", &format!("\"{}\"", "ABCDEF01".repeat(8)));
    with("mesh_blake3", "expected 64 lower-case hexadecimal digits", &format!("\"{}\"", "0".repeat(63)));
    with("mesh_blake3", "mesh_blake3 is , expected 64", "\"\"");
    with("mesh_blake3", "metadata is invalid type: null, expected a string", "null");
    with("mesh_blake3", "metadata is invalid type: sequence, expected a string", "[]");
    with("mean_light", "mean_light is [], expected an object", "[]");
    with("mean_light", "missing field `sun`", r#"{"sky":[]}"#);
    with("mean_light", "unknown field `more`", r#"{"more":1,"sky":[],"sun":[]}"#);
    let words = "mean_light.sky is 1 numbers, expected one for each band";
    with("mean_light", words, r#"{"sky":[1],"sun":[]}"#);
    let words = "mean_light.sun[3] is 2 numbers, expected one for each band";
    with("mean_light", words, r#"{"sky":[],"sun":[[1,1,1],[1,1,1],[1,1,1],[1,1]]}"#);
    let words = "mean_light.sun is 2 harmonics, expected 0, 1, 4, 9 or 16 harmonics";
    with("mean_light", words, r#"{"sky":[1,1,1],"sun":[[1,1,1],[1,1,1]]}"#);
    with("mean_light", "invalid type: string \"1\", expected f64", r#"{"sky":[1,1,"1"],"sun":[]}"#);
    with("mean_light", "mean_light is null, expected an object", "null");
    with("left_out", "left_out is null, expected an object", "null");
    with("left_out", "left_out is [], expected an object", "[]");
    with("left_out", "missing field `reason`", r#"{"bands":[],"bases":[5]}"#);
    with("left_out", "unknown field `more`", r#"{"bands":[],"bases":[5],"more":1,"reason":"r"}"#);
    let mut left_out = |words: &'static str, bands: &str, bases: &str, reason: &str| {
        with("left_out", words, &format!(r#"{{"bands":{bands},"bases":{bases},"reason":"{reason}"}}"#));
    };
    left_out("bases [5, 4]: expected numbers from 0 to 18, ascending", "[]", "[5,4]", "r");
    left_out("bases [5, 5]: expected", "[]", "[5,5]", "r");
    left_out("bases [19]: expected", "[]", "[19]", "r");
    left_out("left_out.bases is [], expected a base or a band", "[]", "[]", "r");
    let words = "left_out.bands[0] is G, expected a name that no band of the species";
    left_out(words, "[\"G\"]", "[5]", "r");
    left_out("left_out.bands[1] is X", "[\"X\",\"X\"]", "[5]", "r");
    left_out("left_out.bands[0] is \"/\"", "[\"/\"]", "[5]", "r");
    left_out("left_out.reason is \"\", expected 1 to 1000 bytes", "[]", "[5]", "");
    left_out("left_out.reason is \"\\n\"", "[]", "[5]", "\\n");
    left_out("left_out.reason is \"xxx", "[]", "[5]", &"x".repeat(1001));
    let present = r#""left_out":{"bands":[],"bases":[1,5],"reason":"r"},"model":"#;
    let words =
        "base 1 of species 0 at byte 704: base 1 is present, but the metadata say that it was left out: r";
    raw.swap(5009, words, "\"model\":", present);
    let mut sky_averages = |words: &'static str, value: &str| {
        raw.swap(5003, words, "\"sources\":", &format!("\"sky_averages\":{value},\"sources\":"));
    };
    sky_averages("sky_averages is 2 numbers, expected one for each band", "[1,1]");
    sky_averages("metadata is invalid type: null, expected a sequence", "null");
}

fn materials(list: &mut List) {
    let mut raw = list.of(RAW);
    let value: Value = serde_json::from_str(&raw.text()).expect("metadata are JSON");
    for (words, found) in [
        (
            "settings.surfaces.materials[1].reflectance: 0 values, expected ",
            r#"[null,{"reflectance":[],"texel":"tint","transmittance":[]}]"#,
        ),
        (
            "species 0: settings.surfaces.materials: unknown variant `paint`",
            r#"[{"reflectance":[],"texel":"paint","transmittance":[]}]"#,
        ),
    ] {
        let mut value = value.clone();
        value["settings"][MATERIALS] = serde_json::from_str(found).expect("JSON");
        raw.metadata(5015, words, canonical::to_bytes(&value).expect("it is canonical"));
    }
}

fn numbers(list: &mut List) {
    for (words, density) in [
        ("page 0 of density of species 0", 0.0),
        ("expected a number above 0", -0.5),
        ("is NaN, expected a number above 0", f32::NAN),
        ("is 158456330000000000000000000000", 2.0 * MAX_MAGNITUDE),
    ] {
        list.of(RAW).payload((KIND_MEDIUM, 0), 5006, words, |values| set_last(values, density));
    }
    list.of("haar-paper").payload((KIND_BASE, 0), 5006, "is NaN", |values| set_last(values, f32::NAN));
    // Base 0: 18 times the threshold of 0.01.
    list.of("haar-paper").payload(
        (KIND_BASE, 0),
        5007,
        "is kept, expected a magnitude above 0.17",
        |values| {
            let at = values.len() - 12;
            values[at..].fill(0);
        },
    );
    list.of("raw-f16").forge(5006, "value 4 is -inf", |parts| {
        let base = base(parts);
        parts.stored(base, 1)[8..10].copy_from_slice(&0xFC00u16.to_le_bytes());
    });
    list.of("haar-paper").rebuild(5004, "name \"sphere\" is taken by species 0", |parts| {
        assert_eq!(parts.sections[1].key.kind, KIND_METADATA);
        let text = parts.stored(0, 0).to_vec();
        parts.set_payload(1, 0, &text);
    });
}

fn set_last(values: &mut [u8], value: f32) {
    let at = values.len() - 4;
    values[at..].copy_from_slice(&value.to_le_bytes());
}
