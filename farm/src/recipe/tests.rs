use flb_baker::bake::BakeSettings;
use flb_format::{Purpose, Quality};
use flb_packer::EncodeSettings;

use super::*;

fn recipe(text: &str) -> Recipe {
    toml::from_str(text).expect("a recipe")
}

#[test]
fn an_empty_recipe_is_the_default_bake() {
    let recipe = Recipe::default();
    assert_eq!(recipe.bake_settings(Machine::Cpu), Ok(BakeSettings::default()));
    assert_eq!(recipe.encode_settings(), Ok(EncodeSettings::default()));
    for quality in Quality::ALL.into_iter().chain([Quality::Papers]) {
        let recipe = Recipe { quality: Some(quality), ..Recipe::default() };
        assert_eq!(recipe.bake_settings(Machine::Cpu), Ok(BakeSettings::of(quality)), "{quality}");
    }
}

#[test]
fn a_purpose_stands_for_a_quality_and_a_lattice_that_other_words_change() {
    let lattice = |text: &str| recipe(text).bake_settings(Machine::Cpu).expect(text).lattice;
    for purpose in Purpose::ALL {
        let recipe = Recipe { purpose: Some(purpose), ..Recipe::default() };
        assert_eq!(recipe.bake_settings(Machine::Cpu), Ok(BakeSettings::of_purpose(purpose)), "{purpose}");
        let coding = EncodeSettings::of(purpose.quality(), recipe.codec());
        assert_eq!(recipe.encode_settings(), Ok(coding), "{purpose}");
    }
    assert_eq!((lattice("for = 'games'"), lattice("for = 'games'\nlattice = 32")), (64, 32));
    assert_eq!(recipe("for = 'stills'").bake_settings(Machine::Cpu), Ok(BakeSettings::default()));
    // A species' own word goes before that of its library, whichever of the two it is.
    let (games, fine) = (recipe("for = 'games'"), recipe("quality = 'fine'"));
    assert_eq!((fine.over(&games), games.over(&fine)), (fine.clone(), games.clone()));
    assert_eq!(recipe("lattice = 32").over(&games).purpose, Some(Purpose::Games));
    let unknown = toml::from_str::<Recipe>("for = 'game'").expect_err("no such purpose").to_string();
    assert!(unknown.contains("found \"game\", expected one of games, stills, film"), "{unknown}");
}

#[test]
fn a_recipe_goes_through_text_unchanged() {
    let text = "quality = 'fine'\nlattice = 64\nsuns = 'ico42'\nfield = 'total'\nleaf_angles = 'planophile'\ncodec = 'haar'\n\
                target_psnr = 50.0\ncompress = false\n";
    let read = recipe(text);
    assert_eq!(recipe(&toml::to_string(&read).expect("words and numbers")), read);
    let base = recipe("lattice = 32\nvoxels = 256\nquality = 'draft'");
    let over = read.over(&base);
    assert_eq!((over.lattice, over.voxels, over.quality), (Some(64), Some(256), Some(Quality::Fine)));
    assert_eq!(base.over(&base), base);
}

#[test]
fn settings_that_cannot_be_are_refused_by_their_names() {
    let cases = [
        ("lattice = 48", "lattice is 48, expected a power of two, 16 to 256"),
        ("lattice = 64\nvoxels = 100", "voxels is 100, expected a multiple of the lattice, 64, up to 4096"),
        ("ordinates = 20", "ordinates is 20, expected 18, 50 or 110"),
        ("rays = 9", "rays is 9, expected 1 to 8"),
        ("tolerance = 2.0", "tolerance is 2, expected a number between 0 and 1"),
        ("max_sweeps = 0", "max_sweeps is 0, expected 1 or more"),
        ("steps = 10", "steps is for model = \"paper\"; the physical model goes until its tolerance is met"),
        (
            "model = 'paper'\nsuns = 'sh1'",
            "suns is for model = \"physical\"; the paper model has no such choice",
        ),
        (
            "model = 'paper'\nsteps = 9\ntolerance = 0.1",
            "steps with tolerance, which goes until the tolerance is met",
        ),
        ("model = 'physical'\nquality = 'papers'", "quality = \"papers\" is of the papers' model"),
        ("for = 'film'\nquality = 'draft'", "quality = \"draft\" with for = \"film\": expected one of them"),
        ("monte_carlo = 23", "monte_carlo is 23, expected 0 to 22"),
        ("threshold = 0.1\ncodec = 'haar'", "threshold is for codec = \"haar-paper\", not for haar"),
        ("threshold = -1.0", "threshold is -1, expected a number from 0 up"),
        ("near_geometry = true", "near_geometry is for codec = \"haar-paper\", not for classed"),
        (
            "codec = 'raw-f16'\ntarget_psnr = 40.0",
            "target_psnr is for codec = \"classed\" and haar, not for raw-f16",
        ),
    ];
    for (text, expected) in cases {
        let recipe = recipe(text);
        let bake = recipe.bake_settings(Machine::Cpu).map(drop);
        let error = bake.and(recipe.encode_settings().map(drop)).expect_err(text).to_string();
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
    }
    let error = recipe("lattice = 48").bake_settings(Machine::Cpu).expect_err("48");
    let flags = error.spelled(|key, _| format!("--{key}"));
    assert_eq!(flags, "--lattice is 48, expected a power of two, 16 to 256");
}
