//! Species of the model `physical` that break a promise.

use flb_format::records::*;

use super::content::{Case, relayout, set_first_page};
use super::{Parts, forge, golden_file};

const PHYSICAL: &str = "physical";

/// Replaces pieces of the first metadata text, each of which must be there. The first species has harmonics.
fn metadata(changes: &[(&str, &str)]) -> Vec<u8> {
    forge(PHYSICAL, |parts| {
        let mut text = String::from_utf8(parts.stored(0, 0).to_vec()).expect("metadata are UTF-8");
        for (from, to) in changes {
            assert!(text.contains(from), "{from} is not in {text}");
            text = text.replacen(from, to, 1);
        }
        parts.sections[0].page_bytes = MAX_PAGE_BYTES;
        set_first_page(parts, 0, text.as_bytes());
    })
}

/// Without the first section of a kind and item.
fn without(kind: u32, item: u32) -> Vec<u8> {
    forge(PHYSICAL, |parts| {
        let section = parts.find(kind, item);
        parts.sections.remove(section);
        parts.tables.remove(section);
        relayout(parts);
    })
}

/// With another item on the last section of a kind of a species.
fn last_item(name: &str, kind: u32, species: u32, item: u32) -> Vec<u8> {
    forge(name, |parts| {
        let is_it = |s: &SectionEntry| s.key.kind == kind && s.key.species == species;
        let last = parts.sections.iter().rposition(is_it).expect("it is there");
        parts.sections[last].key.item = item;
    })
}

pub(crate) fn physical_cases() -> Vec<Case> {
    let shares = |share: &str| format!("[{}]", [share; 32].join(","));
    let angles = {
        let mut parts = Parts::of(&golden_file(PHYSICAL));
        let text = String::from_utf8(parts.stored(0, 0).to_vec()).expect("metadata are UTF-8");
        let start = text.find("\"leaf_angles\":").expect("there");
        text[start..=start + text[start..].find(']').expect("it ends")].to_owned()
    };
    let angles = |value: &str| metadata(&[(&angles, &format!("\"leaf_angles\":{value}"))]);
    let feature = |name, bits| forge(name, |parts| parts.header.required_features = bits);
    let suns = "{\"degree\":1,\"kind\":\"harmonics\",\"reaches\":[1,3,8]}";
    let last_base = 3;
    vec![
        (1010, "feature bit 1 (physical) is false, but the metadata say true", feature(PHYSICAL, 0)),
        (1010, "feature bit 1 (physical) is true, but the metadata say false", feature("raw-f32", 2)),
        (1010, "feature bit 1 (physical) is false", feature("raw-f16", FEATURE_RAW_F16)),
        (
            1010,
            "feature bit 2 (raw-f16) is false, but the codecs of bases say true",
            feature("raw-f16", FEATURE_PHYSICAL),
        ),
        (
            1010,
            "feature bit 2 (raw-f16) is true, but the codecs of bases say false",
            feature(PHYSICAL, FEATURE_PHYSICAL | FEATURE_RAW_F16),
        ),
        (2007, "item is 6, expected", last_item(PHYSICAL, KIND_MEDIUM, 0, 6)),
        (2007, "item is 256, expected", last_item("raw-f32", KIND_BASE, 0, 256)),
        (2007, "item is 19, expected 0 to 18, as the metadata say", last_item("raw-f32", KIND_BASE, 0, 19)),
        (2007, "item is 19, expected 0 to 18, as the metadata say", last_item(PHYSICAL, KIND_BASE, 1, 19)),
        (2007, "item is 9, expected 0 to 8, as the metadata say", last_item(PHYSICAL, KIND_BASE, 0, 9)),
        (2007, "item is 4, expected 0 to 3, as the metadata say", last_item("raw-f32", KIND_MEDIUM, 0, 4)),
        (2008, "species 0 has no leaf_extinction", without(KIND_MEDIUM, 4)),
        (2008, "species 0 has no wood_extinction", without(KIND_MEDIUM, 5)),
        (2008, "species 0 has no base 8", without(KIND_BASE, 8)),
        (2008, "species 0 has no base 3", without(KIND_BASE, last_base)),
        (2008, "species 0 has no base 9", metadata(&[("\"degree\":1", "\"degree\":2")])),
        (5003, "model is physicas, expected", metadata(&[("\"physical\"", "\"physicas\"")])),
        (5003, "`surfaces` present", metadata(&[("\"physical\"", "\"paper\"")])),
        (5003, "unknown field `also`", metadata(&[("\"light\":{", "\"light\":{\"also\":1,")])),
        (5003, "light is 7, expected an object", {
            forge(PHYSICAL, |parts| {
                let text = String::from_utf8(parts.stored(0, 0).to_vec()).expect("metadata are UTF-8");
                let (start, end) =
                    (text.find("\"light\":").expect("there"), text.find("\"model\"").expect("there"));
                let text = format!("{}\"light\":7,{}", &text[..start], &text[end..]);
                set_first_page(parts, 0, text.as_bytes());
            })
        }),
        (5003, "unknown variant `both`", metadata(&[("\"scattered\",\"leaf", "\"both\",\"leaf")])),
        (5003, "light.ordinates is 51, expected 18, 50 or 110", {
            metadata(&[("\"ordinates\":50", "\"ordinates\":51")])
        }),
        (5003, "light.rays is 0, expected 1 to 8", metadata(&[("\"rays\":2", "\"rays\":0")])),
        (5003, "light.rays is 9, expected 1 to 8", metadata(&[("\"rays\":2", "\"rays\":9")])),
        (5003, "light.suns.degree is 0, expected 1 to 3", metadata(&[("\"degree\":1", "\"degree\":0")])),
        (5003, "light.suns.degree is 4, expected 1 to 3", metadata(&[("\"degree\":1", "\"degree\":4")])),
        (5003, "light.suns of kind", metadata(&[("[1,3,8]", "[1,3,9]")])),
        (5003, "light.suns of kind", metadata(&[(suns, "{\"degree\":1,\"kind\":\"lattice18\"}")])),
        (5003, "light.suns is \"lattice18\", expected an object", metadata(&[(suns, "\"lattice18\"")])),
        (5003, "light.leaf_angles are 32 shares", angles(&shares("0.03125"))),
        (5003, "light.leaf_angles are 32 shares that sum to 0.99", angles(&shares("0.031"))),
        (5003, "light.leaf_angles are 1 shares", angles("[1]")),
        (5003, "light.leaf_angles are \"flat\"", angles("\"flat\"")),
        (5003, "light.error.suns_rms is -0.5, expected", {
            metadata(&[("\"suns_rms\":0.0125", "\"suns_rms\":-0.5")])
        }),
        (5003, "light.error.solver is -1", metadata(&[("\"solver\":0.0001", "\"solver\":-1")])),
        (5003, "metadata is", metadata(&[("\"held_out\":30", "\"held_out\":-1")])),
        (
            5003,
            "metadata is",
            metadata(&[("\"held_out\":30", "\"held_out\":30,\"monte_carlo\":{\"bias\":0}")]),
        ),
        (5003, "light.error.monte_carlo is null", {
            metadata(&[("\"held_out\":30", "\"held_out\":30,\"monte_carlo\":null")])
        }),
        (5003, "surfaces[0].leaf.reflectance is 1.5, expected a share", {
            metadata(&[("\"reflectance\":0.0625", "\"reflectance\":1.5")])
        }),
        (5003, "surfaces[0].leaf.reflectance + transmittance is 1.25, expected at most 1", {
            metadata(&[("\"reflectance\":0.0625", "\"reflectance\":0.875")])
        }),
        (5003, "surfaces[1].name is red, expected a name that no band before", {
            metadata(&[("near infrared", "red")])
        }),
        (5003, "left_out.bases is {5}, expected []", {
            metadata(&[(
                "\"light\":",
                "\"left_out\":{\"bands\":[],\"bases\":[5],\"reason\":\"r\"},\"light\":",
            )])
        }),
        (5006, "wood_extinction of species 0", {
            forge(PHYSICAL, |parts| {
                let section = parts.find(KIND_MEDIUM, 5);
                let stored = parts.stored(section, 0);
                let end = stored.len();
                stored[end - 4..].copy_from_slice(&f32::INFINITY.to_le_bytes());
            })
        }),
        (5007, "is kept, expected a magnitude above 0.01", {
            forge(PHYSICAL, |parts| {
                let base = parts.base(); // base 0 of `physical`: the threshold itself, not 18 times it
                let stored = parts.stored(base, 0);
                let end = stored.len();
                stored[end - 8..].fill(0);
            })
        }),
    ]
}
