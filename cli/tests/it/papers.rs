//! What the papers' model makes, held by a golden file: the preset, the scene's own light (their +1 solve) and each
//! kind of picture.
//!
//! `FLB_WRITE_GOLDEN=1 cargo test -p flb -p flb-farm --test it papers` writes it anew.

use std::path::Path;

use crate::flb::{Folder, PAPER};
use crate::picture::pixels;

const GOLDEN: &str = "tests/golden/papers.txt";

/// A scatter of two species of the preset, with water, another sun and a picture of a sky behind.
fn stand() -> Folder {
    let flags = ["--quality", "papers", "--lattice", "16", "--voxels", "128"];
    let folder = Folder::with_baked(&["oak", "shrub"], &flags, &[0]);
    let species = ["--species", "oak=oak.glb,oak.flb*2", "--species", "shrub=shrub.glb,shrub.flb"];
    let words = ["scatter", "--count", "9", "--area", "40,30", "-o", "stand.toml"];
    folder.flb_with(&words, &species).expect_code(0);
    let sky = (0..32u8).flat_map(|pixel| [40 + 5 * pixel, 90, 200 - 4 * pixel, 129]);
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".iter().copied();
    folder.write("clouds.hdr", header.chain(sky).collect::<Vec<u8>>());
    folder
}

#[test]
fn the_preset_the_scenes_light_and_each_picture_are_as_before() {
    let folder = stand();
    let mut found: Vec<(&str, blake3::Hash)> = Vec::new();
    let digest = |name: &str| match Path::new(name).extension().is_some_and(|end| end == "png") {
        true => blake3::hash(&pixels(&folder.read(name))),
        false => blake3::hash(&folder.read(name)),
    };
    found.push(("oak.flb", digest("oak.flb")));
    folder
        .flb(&[
            "bake",
            "oak.glb",
            "-o",
            "near.flb",
            "--quality",
            "papers",
            "--near-geometry",
            "--lattice",
            "16",
            "--voxels",
            "128",
        ])
        .expect_code(0);
    found.push(("near.flb", digest("near.flb")));
    folder.flb(&["bake-scene", "stand.toml", "--lattice", "16", "-o", "stand.flb"]).expect_code(0);
    found.push(("stand.flb", digest("stand.flb")));
    let text = String::from_utf8(folder.read("stand.toml")).expect("TOML is text");
    folder.write("lake.toml", format!("{text}\n[water]\nheight_m = 0.3\nwaves = {{ wind_m_s = 4.0 }}\n"));
    let light = ["--scene-light", "stand.flb"];
    let pictures: [(&str, &str, &[&str]); 12] = [
        ("light.png", "stand.toml", &light),
        ("empty.png", "stand.toml", &["--scene-light", "stand.flb", "--scene-factor", "empty"]),
        ("direct.png", "stand.toml", &["--show", "direct"]),
        ("indirect.png", "stand.toml", &["--show", "indirect"]),
        ("base.png", "stand.toml", &["--show", "base:4"]),
        ("global.png", "stand.toml", &["--scene-light", "stand.flb", "--show", "global"]),
        ("alpha.png", "stand.toml", &["--show", "light,alpha"]),
        ("layers.exr", "stand.toml", &["--show", "light,direct,indirect,base:0,alpha"]),
        ("suns.png", "stand.toml", &["--add-sun", "10,20=0.5,0.2,0.1"]),
        ("highlight.png", "stand.toml", &["--highlight", "wood=0.5,9"]),
        ("backdrop.png", "stand.toml", &["--backdrop", "clouds.hdr"]),
        (
            "waves.png",
            "lake.toml",
            &["--backdrop", "clouds.hdr", "--find", "model=grid,camera=grid,sun=grid"],
        ),
    ];
    for (output, scene, more) in pictures {
        let words = ["render", scene, "--sun", "90,25", "--size", "48x27", "--samples", "2", "-o", output];
        folder.flb_with(&words, more).expect_code(0);
        found.push((output, digest(output)));
    }
    let lines: String = found.iter().map(|(name, digest)| format!("{name} {digest}\n")).collect();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join(GOLDEN);
    if std::env::var_os("FLB_WRITE_GOLDEN").is_some() {
        std::fs::create_dir_all(golden.parent().expect("a folder")).expect("a folder");
        std::fs::write(&golden, &lines).expect("a golden file");
    }
    let expected = std::fs::read_to_string(&golden).expect("the golden file is in the repository");
    assert_eq!(lines, expected);
    // No picture is another's.
    let mut digests: Vec<String> = found.iter().map(|(_, digest)| digest.to_string()).collect();
    digests.sort_unstable();
    digests.dedup();
    assert_eq!(digests.len(), found.len());
    let more = ["bake", "shrub.glb", "-o", "p.flb", "--lattice", "16", "--voxels", "128", "--force"];
    folder.flb_with(&more, &PAPER).expect_code(0);
    folder.flb(&["diff", "shrub.flb", "p.flb"]).expect_code(1);
}
