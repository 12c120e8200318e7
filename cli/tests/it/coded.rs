//! What coding costs the eye: a forest in coded light beside the same in fields as they were solved.

use crate::flb::{Folder, MODELS};
use crate::picture::{pixels, rms};

const PLANTS: [&str; 3] = ["oak", "spruce", "shrub"];

/// Most that two pictures may differ, root mean square of values from 0 to 1. (The papers: 0.0084 and 0.0136.)
const MAX_OFF: f64 = 0.004;

/// Pictures of forty plants of three species, baked by a model and stored by a codec: in all light, and in baked light
/// alone.
fn pictures(folder: &Folder, model: &[&str], coding: &[&str]) -> [Vec<u8>; 2] {
    let mut species: Vec<String> = Vec::new();
    for plant in PLANTS {
        let [mesh, file] = ["glb", "flb"].map(|extension| format!("{plant}.{extension}"));
        let lattice = ["--lattice", "32", "--voxels", "256", "--cache", "cache"];
        let bake = [&["bake", &mesh, "-o", &file, "--force"], &lattice[..], model].concat();
        let run = folder.flb_with(&bake, coding);
        assert!(run.code == 0 || run.code == 3, "{}", run.stderr);
        species.extend(["--species".to_owned(), format!("{plant}={mesh},{file}")]);
    }
    let species: Vec<&str> = species.iter().map(String::as_str).collect();
    let scatter = ["scatter", "--count", "40", "--area", "60,40", "-o", "stand.toml", "--force"];
    folder.flb_with(&scatter, &species).expect_code(0);
    ["light", "indirect"].map(|show| {
        let render = ["render", "stand.toml", "--size", "160x90", "--samples", "4", "-o", "a.png", "--force"];
        folder.flb_with(&render, &["--show", show]).expect_code(0);
        pixels(&folder.read("a.png"))
    })
}

#[test]
fn a_forest_in_coded_light_looks_as_in_fields_that_were_not_coded() {
    for model in MODELS {
        let folder = Folder::with_plants(&PLANTS);
        let uncoded = pictures(&folder, model, &["--codec", "raw-f32"]);
        let coded = pictures(&folder, model, &[]);
        let small = pictures(&folder, model, &["--target-psnr", "20"]);
        for (indirect, uncoded) in uncoded.iter().enumerate() {
            let [off, far] = [&coded, &small].map(|pictures| rms(&pictures[indirect], uncoded) / 255.0);
            println!("{model:?} {indirect}: {off:.5}; at 20 dB {far:.5}");
            assert!(off < MAX_OFF, "{model:?} {indirect}: {off}");
            assert!(far > 2.0 * off && far > 0.0, "{model:?} {indirect}: {far} at 20 dB, {off} by default");
        }
    }
}
