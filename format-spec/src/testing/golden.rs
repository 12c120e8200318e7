//! The golden files of the format: sound, small, of every codec.

macro_rules! files {
    ($($name:literal)*) => {
        &[$(($name, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/golden/", $name, ".flb")))),*]
    };
}

/// All golden files of this version and those before, by name: `raw-f32`, `v0.1/raw-f32`.
pub static GOLDEN: &[(&str, &[u8])] = files! {
    "classed" "classed-all-blocks" "classed-first" "directions" "haar" "haar-paper" "haar-paper-exact"
    "haar-paper-zstd" "leaning" "left-out" "mesh" "physical" "physical-single" "raw-f16" "raw-f32" "shared"
    "v0.1/haar-paper" "v0.1/haar-paper-exact" "v0.1/haar-paper-zstd" "v0.1/left-out" "v0.1/physical"
    "v0.1/physical-single" "v0.1/raw-f16" "v0.1/raw-f32"
};

/// The golden file of this name.
///
/// # Panics
/// If there is none.
pub fn golden(name: &str) -> Vec<u8> {
    let found = GOLDEN.iter().find(|(other, _)| *other == name);
    found.unwrap_or_else(|| panic!("no golden file {name}")).1.to_vec()
}
