//! Bands by their names: pictures, skies, `judge`, `extract` and scenes show red as red, in whatever order a file has
//! its bands and whatever bands are beside them.

use crate::flb::{FEW, Folder, Run};
use crate::picture::{pixels, rms};

const QUICK: [&str; 8] = ["--lattice", "16", "--voxels", "64", "--quality", "draft", FEW[0], FEW[1]];
const SMALL: [&str; 4] = ["--size", "64x64", "--samples", "4"];

/// A species file with a set of surfaces for each band. Those of the colours differ, as leaves' do.
fn species(bands: &[&str]) -> String {
    let surface = |name: &&str| {
        let [leaf, passes, wood] = match *name {
            "R" => [0.3, 0.05, 0.1],
            "G" => [0.12, 0.15, 0.2],
            "B" => [0.04, 0.02, 0.3],
            _ => [0.45, 0.45, 0.4],
        };
        format!(
            "[[surfaces]]\nname = \"{name}\"\nleaf = {{ reflectance = {leaf}, transmittance = {passes} }}\n\
             wood = {{ reflectance = {wood} }}\n"
        )
    };
    // The oak's own bark is another colour, of which the fields need fewer components.
    ["wood_colour = \"measured\"\n".to_owned()].into_iter().chain(bands.iter().map(surface)).collect()
}

/// `oak.glb` with red leaves, whose texture is an albedo, and a file for each list of bands.
fn baked(files: &[(&str, &[&str])]) -> Folder {
    let folder = Folder::new();
    folder.flb(&["grow", "oak", "--autumn", "--triangles", "1500", "-o", "oak.glb"]).expect_code(0);
    for (file, bands) in files {
        folder.write("species.toml", species(bands));
        let words = [&["bake", "oak.glb", "--species", "species.toml", "-o", file], &QUICK[..]].concat();
        folder.flb(&words).expect_code(0);
    }
    folder
}

fn render(folder: &Folder, file: &str, output: &str, more: &[&str]) -> Run {
    let words = [&["render", file, "-o", output, "--force", "--sun", "135,40"], &SMALL[..], more].concat();
    folder.flb(&words)
}

/// Largest difference of two pictures.
fn apart(a: &[u8], b: &[u8]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().expect("pixels")
}

const SCENE: &str = "[[species]]\nname = \"oak\"\nfile = \"oak.glb\"\nlight = \"LIGHT\"\n\
                     [[instance]]\nspecies = \"oak\"\nposition_m = [0.0, 0.0, 0.0]\n\
                     [camera]\nposition_m = [0.0, 4.0, 14.0]\nlook_at_m = [0.0, 3.0, 0.0]\nfov_deg = 45.0\nheight_px = 64\n";

#[test]
fn the_order_of_bands_in_a_file_changes_no_picture() {
    let orders: [(&str, &[&str]); 5] = [
        ("rgb.flb", &["R", "G", "B"]),
        ("bgr.flb", &["B", "G", "R"]),
        ("grb.flb", &["G", "R", "B"]),
        ("rgbn.flb", &["R", "G", "B", "NIR"]),
        ("nbrg.flb", &["NIR", "B", "R", "G"]),
    ];
    let folder = baked(&orders);
    let mesh = ["--mesh", "oak.glb"];
    let ways: [&[&str]; 3] = [&[], &["--sky", "clear"], &["--path-traced"]];
    for more in ways {
        let [expected, other] = [("rgb.flb", "a.png"), ("bgr.flb", "b.png")].map(|(file, output)| {
            render(&folder, file, output, &[&mesh, more].concat()).expect_code(0);
            pixels(&folder.read(output))
        });
        // As large as the difference would be with the bands in the order of the file.
        let swapped: Vec<u8> =
            expected.as_chunks::<3>().0.iter().flat_map(|[r, g, b]| [*b, *g, *r]).collect();
        assert!(apart(&expected, &swapped) > 60, "{more:?}: the colours of the plant differ");
        assert!(apart(&expected, &other) <= 2, "{more:?}: {}", apart(&expected, &other));
        for (file, _) in &orders[2..] {
            render(&folder, file, "c.png", &[&mesh, more].concat()).expect_code(0);
            let found = pixels(&folder.read("c.png"));
            // Four bands are coded together in another way, to the same error.
            assert!(apart(&expected, &found) <= 12, "{file}, {more:?}: {}", apart(&expected, &found));
        }
    }
    let scene = |file: &str, output: &str| {
        folder.write("scene.toml", SCENE.replace("LIGHT", file));
        let words = ["render", "scene.toml", "-o", output, "--sun", "135,40", "--size", "64x64", "--force"];
        folder.flb(&words).expect_code(0);
        pixels(&folder.read(output))
    };
    let expected = scene("rgb.flb", "a.png");
    for (file, most) in [("bgr.flb", 2), ("nbrg.flb", 12)] {
        let found = scene(file, "b.png");
        assert!(apart(&expected, &found) <= most, "a scene with {file}: {}", apart(&expected, &found));
    }
    let judge = |file: &str| {
        let words = [
            "judge",
            file,
            "--mesh",
            "oak.glb",
            "--suns",
            "1",
            "--points",
            "64",
            "--samples",
            "16",
            "--json",
        ];
        let judged = folder.flb(&words).expect_code(0).json();
        let truth = judged["leaf"]["sky"]["truth"].as_array().expect("three bands").clone();
        truth.iter().map(|band| band.as_f64().expect("a number")).collect::<Vec<f64>>()
    };
    let expected = judge("rgb.flb");
    for file in ["bgr.flb", "nbrg.flb"] {
        let found = judge(file);
        let is_near = found.iter().zip(&expected).all(|(found, truth)| (found / truth - 1.0).abs() < 0.02);
        assert!(is_near, "{file}: {found:?} for {expected:?}");
    }
    let extract = |file: &str, more: &[&str]| {
        let words = ["extract", file, "--base", "0", "--format", "png", "-o", "base.png", "--force"];
        folder.flb(&[&words[..], more].concat()).expect_code(0);
        pixels(&folder.read("base.png"))
    };
    let expected = extract("rgb.flb", &[]);
    // The bands of each file are coded together, to 38 dB: both are off by 3 of 255 at most, and not by the same.
    let bgr = extract("bgr.flb", &[]);
    let coding = rms(&expected, &bgr);
    assert!(coding < 3.2, "{coding}");
    let swapped: Vec<u8> = bgr.as_chunks::<3>().0.iter().flat_map(|[r, g, b]| [*b, *g, *r]).collect();
    assert!(rms(&expected, &swapped) > (2.0 * coding).max(4.0), "{}", rms(&expected, &swapped));
    let of_four = extract("nbrg.flb", &[]);
    assert_eq!(of_four, extract("nbrg.flb", &["--show-bands", "R,G,B"]));
    assert!(rms(&expected, &of_four) < 12.0, "{}", rms(&expected, &of_four));
}

#[test]
fn bands_that_are_no_colours_are_refused_or_shown_as_the_flag_says() {
    let folder = baked(&[("nir.flb", &["NIR", "SWIR", "G"]), ("one.flb", &["NIR"])]);
    let mesh = ["--mesh", "oak.glb"];
    let refusal = "nir.flb: species \"oak\" has the bands NIR, SWIR, G; a picture needs R, G and B; \
                   --show-bands NIR,SWIR,G shows those as red, green and blue";
    folder.write("scene.toml", SCENE.replace("LIGHT", "nir.flb"));
    let extract = ["extract", "nir.flb", "--base", "0", "--format", "png", "-o", "base.png", "--force"];
    let judge = ["judge", "nir.flb", "--mesh", "oak.glb", "--suns", "1", "--points", "64", "--samples", "2"];
    let scene = ["render", "scene.toml", "-o", "x.png", "--sun", "135,40", "--size", "32x32", "--force"];
    let plant =
        [&["render", "nir.flb", "-o", "x.png", "--sun", "135,40", "--force"], &SMALL[..], &mesh].concat();
    for words in [&plant[..], &scene, &judge, &extract] {
        let run = folder.flb(words).expect_code(2);
        assert!(run.stderr.contains(refusal), "{words:?}: {}", run.stderr);
        folder.flb(&[words, &["--show-bands", "NIR,SWIR,G"]].concat()).expect_code(0);
    }
    render(&folder, "one.flb", "x.png", &mesh)
        .expect_code(2)
        .says(&["has the bands NIR; a picture needs R, G and B; --show-bands NIR shows those as grey"]);
    render(&folder, "one.flb", "grey.png", &[&mesh[..], &["--show-bands", "NIR", "--path-traced"]].concat())
        .expect_code(0);
    render(&folder, "nir.flb", "first.png", &[&mesh[..], &["--show-bands", "G,NIR,NIR"]].concat())
        .expect_code(0);
    render(&folder, "nir.flb", "last.png", &[&mesh[..], &["--show-bands", "NIR,NIR,G"]].concat())
        .expect_code(0);
    let [first, last] = ["first.png", "last.png"].map(|name| pixels(&folder.read(name)));
    assert!(apart(&first, &last) > 20, "which band is red is as it was said");
    render(&folder, "nir.flb", "x.png", &[&mesh[..], &["--show-bands", "NIR,X,G"]].concat())
        .expect_code(2)
        .says(&["--show-bands: species \"oak\" has no band \"X\"; it has NIR, SWIR, G"]);
    render(&folder, "nir.flb", "x.png", &[&mesh[..], &["--show-bands", "NIR,G"]].concat())
        .expect_code(2)
        .says(&["--show-bands: found 2 names of bands, expected 1 or 3"]);
    let npy = ["extract", "nir.flb", "--base", "0", "--format", "npy", "-o", "base.npy", "--show-bands", "G"];
    folder.flb(&npy).expect_code(2).says(&["--show-bands is for --format png of a base"]);
    let words = ["bake", "oak.glb", "--species", "species.toml", "--judge", "-o", "y.flb"];
    folder.flb(&words).expect_code(2).says(&["found the bands NIR, and --judge expects"]);
}

#[test]
fn a_gpu_shows_bands_by_their_names_as_well() {
    let bands: [(&str, &[&str]); 3] =
        [("rgb.flb", &["R", "G", "B"]), ("brg.flb", &["B", "R", "G"]), ("nbrg.flb", &["NIR", "B", "R", "G"])];
    let folder = baked(&bands);
    let words = [
        "render",
        "scene.toml",
        "--backend",
        "gpu",
        "--sun",
        "135,40",
        "--size",
        "64x64",
        "-o",
        "x.png",
        "--force",
    ];
    let [expected, found] = ["rgb.flb", "brg.flb"].map(|file| {
        folder.write("scene.toml", SCENE.replace("LIGHT", file));
        folder.flb(&words).expect_code(0);
        pixels(&folder.read("x.png"))
    });
    assert!(apart(&expected, &found) <= 12, "{}", apart(&expected, &found));
    // Four bands are coded as four components, of which the GPU has room for three.
    folder.write("scene.toml", SCENE.replace("LIGHT", "nbrg.flb"));
    folder.flb(&words).expect_code(5).says(&["4 bands or components, expected 1 to 3", "draw it on the CPU"]);
}
