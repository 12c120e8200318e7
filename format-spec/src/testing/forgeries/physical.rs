//! Species of the model `physical` that break a promise. The first has harmonics.

use super::{List, piece};
use crate::container::records::*;

const PHYSICAL: &str = "physical";
const RAW: &str = "raw-f32";

pub(super) fn add(list: &mut List) {
    let mut feature =
        |golden, words, bits| list.of(golden).header(1010, words, |h| h.required_features = bits);
    feature(PHYSICAL, "feature bit 1 (physical) is false, but the metadata say true", 0);
    feature(RAW, "feature bit 1 (physical) is true, but the metadata say false", FEATURE_PHYSICAL);
    feature("raw-f16", "feature bit 1 (physical) is false", FEATURE_RAW_F16);
    let words = "feature bit 2 (raw-f16) is false, but the codecs of bases say true";
    feature("raw-f16", words, FEATURE_PHYSICAL);
    let words = "feature bit 2 (raw-f16) is true, but the codecs of bases say false";
    feature(PHYSICAL, words, FEATURE_PHYSICAL | FEATURE_RAW_F16);
    let words = "feature bit 4 (leaning) is false, but the metadata say true";
    feature("leaning", words, FEATURE_PHYSICAL);
    let words = "feature bit 4 (leaning) is true, but the metadata say false";
    feature(PHYSICAL, words, FEATURE_PHYSICAL | FEATURE_LEANING);
    items(list);
    light(list);
    leaning(list);
    let mut of = list.of(PHYSICAL);
    of.payload((KIND_MEDIUM, 5), 5006, "wood_extinction of species 0", |values| {
        let at = values.len() - 4;
        values[at..].copy_from_slice(&f32::INFINITY.to_le_bytes());
    });
    // Base 0: the threshold itself, not 18 times it.
    of.payload((KIND_BASE, 0), 5007, "is kept, expected a magnitude above 0.01", |page| {
        let at = page.len() - 8;
        page[at..].fill(0);
    });
}

/// Sections that are missing, and items that no species of the model has.
fn items(list: &mut List) {
    // On the last section of a kind of a species.
    let mut item = |golden, kind, species, item, words| {
        list.of(golden).forge(2007, words, |parts| {
            let is_it = |s: &SectionEntry| s.key.kind == kind && s.key.species == species;
            let last = parts.sections.iter().rposition(is_it).expect("it is there");
            parts.sections[last].key.item = item;
        });
    };
    item(PHYSICAL, KIND_MEDIUM, 0, 6, "item is 6, expected");
    item(RAW, KIND_BASE, 0, 256, "item is 256, expected");
    item(RAW, KIND_BASE, 0, 19, "item is 19, expected 0 to 18, as the metadata say");
    item(PHYSICAL, KIND_BASE, 1, 19, "item is 19, expected 0 to 18, as the metadata say");
    item(PHYSICAL, KIND_BASE, 0, 9, "item is 9, expected 0 to 8, as the metadata say");
    item(RAW, KIND_MEDIUM, 0, 4, "item is 4, expected 0 to 3, as the metadata say");
    let mut of = list.of(PHYSICAL);
    of.without(KIND_MEDIUM, 0, 4, 2008, "species 0 has no leaf_extinction");
    of.without(KIND_MEDIUM, 0, 5, 2008, "species 0 has no wood_extinction");
    of.without(KIND_BASE, 0, 8, 2008, "species 0 has no base 8");
    of.without(KIND_BASE, 0, 3, 2008, "species 0 has no base 3");
    of.swap(2008, "species 0 has no base 9", "\"degree\":1", "\"degree\":2");
}

/// What the metadata say of light and surfaces.
fn light(list: &mut List) {
    let mut of = list.of(PHYSICAL);
    let text = of.text();
    let mut swap = |words, from: &str, to: &str| of.swap(5003, words, from, to);
    swap("model is physicas, expected", "\"physical\"", "\"physicas\"");
    swap("`surfaces` present", "\"physical\"", "\"paper\"");
    swap("unknown field `also`", "\"light\":{", "\"light\":{\"also\":1,");
    swap("light is 7, expected an object", piece(&text, "\"light\":", "\"model\""), "\"light\":7,\"model\"");
    swap("unknown variant `both`", "\"scattered\",\"leaf", "\"both\",\"leaf");
    swap("light.ordinates is 51, expected 18, 50 or 110", "\"ordinates\":50", "\"ordinates\":51");
    swap("light.rays is 0, expected 1 to 8", "\"rays\":2", "\"rays\":0");
    swap("light.rays is 9, expected 1 to 8", "\"rays\":2", "\"rays\":9");
    swap("light.suns.degree is 0, expected 1 to 3", "\"degree\":1", "\"degree\":0");
    swap("light.suns.degree is 4, expected 1 to 3", "\"degree\":1", "\"degree\":4");
    swap("light.suns of kind", "[1,3,8]", "[1,3,9]");
    let suns = "{\"degree\":1,\"kind\":\"harmonics\",\"reaches\":[1,3,8]}";
    swap("light.suns of kind", suns, "{\"degree\":1,\"kind\":\"lattice18\"}");
    swap("light.suns is \"lattice18\", expected an object", suns, "\"lattice18\"");
    let angles = piece(&text, "\"leaf_angles\":", "]");
    let shares = |share: &str| format!("\"leaf_angles\":[{}]", [share; 32].join(","));
    swap("light.leaf_angles are 32 shares", angles, &shares("0.03125"));
    swap("light.leaf_angles are 32 shares that sum to 0.99", angles, &shares("0.031"));
    swap("light.leaf_angles are 1 shares", angles, "\"leaf_angles\":[1]");
    swap("light.leaf_angles are \"flat\"", angles, "\"leaf_angles\":\"flat\"");
    swap("light.error.suns_rms is -0.5, expected", "\"suns_rms\":0.0125", "\"suns_rms\":-0.5");
    swap("light.error.solver is -1", "\"solver\":0.0001", "\"solver\":-1");
    swap("metadata is", "\"held_out\":30", "\"held_out\":-1");
    swap("metadata is", "\"held_out\":30", "\"held_out\":30,\"monte_carlo\":{\"bias\":0}");
    let null = "\"held_out\":30,\"monte_carlo\":null";
    swap("light.error.monte_carlo is null", "\"held_out\":30", null);
    let words = "surfaces[0].leaf.reflectance is 1.5, expected a share";
    swap(words, "\"reflectance\":0.0625", "\"reflectance\":1.5");
    let words = "surfaces[0].leaf.reflectance + transmittance is 1.25, expected at most 1";
    swap(words, "\"reflectance\":0.0625", "\"reflectance\":0.875");
    swap("surfaces[1].name is red, expected a name that no band before", "near infrared", "red");
    let left_out = "\"left_out\":{\"bands\":[],\"bases\":[5],\"reason\":\"r\"},\"light\":";
    swap("left_out.bases is {5}, expected []", "\"light\":", left_out);
}

/// Near beams that lean in light that cannot.
fn leaning(list: &mut List) {
    let mut of = list.of("leaning");
    let text = of.text();
    let words = "light.suns.leaning is true, expected";
    let angles = piece(&text, "\"leaf_angles\":", "]");
    of.swap(5003, words, angles, "\"leaf_angles\":\"spherical\"");
    of.swap(5003, words, "\"scattered\",\"leaf", "\"total\",\"leaf");
    let leaning = "\"leaning\":true";
    of.swap(5003, "light.suns of kind", leaning, "\"leaning\":false");
    of.swap(5003, "expected a boolean", leaning, "\"leaning\":1");
}
