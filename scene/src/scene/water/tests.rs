use super::*;
use crate::import::ImportError;
use crate::scene::tests::{SCENE, parse};

fn water(text: &str) -> Result<Option<Water>, ImportError> {
    parse(&format!("{text}\n{SCENE}")).map(|scene| scene.water)
}

#[test]
fn water_has_a_height_above_a_level_ground_and_waves_if_it_is_told_of_a_wind() {
    let found = |text: &str| water(text).expect(text);
    assert_eq!(found(""), None);
    let lake = Water { height_m: 0.0, color: [0.01, 0.035, 0.04], waves: None };
    assert_eq!(found("water.height_m = 0"), Some(lake));
    let milk = Water { height_m: -2.5, color: [0.0, 0.5, 1.0], waves: None };
    assert_eq!(found("water = { height_m = -2.5, colour = [0, 0.5, 1] }\nground.height_m = -3"), Some(milk));
    let pond =
        found("water = { height_m = 0, waves = { wind_m_s = 2.5, seed = 9, time_s = 4, step_s = 0.04 } }");
    let waves = Waves { wind_m_s: 2.5, seed: 9, ..Waves::default() };
    assert_eq!(pond, Some(Water { waves: Some(MovingWaves { waves, time_s: 4.0, step_s: 0.04 }), ..lake }));
    // Where a height map is lower is not known before it is read.
    let map = "height_map = \"h.png\", origin_m = [-5, 1, -6], size_m = [10, 12], height_m = [0, 2.5]";
    assert_eq!(found(&format!("water.height_m = 0\nground = {{ {map} }}")), Some(lake));
    for (text, expected) in [
        ("water = {}", "missing field `height_m`"),
        ("water = { height_m = 1, depth_m = 3 }", "unknown field `depth_m`"),
        ("water.height_m = nan", "forest.toml: line 1, water.height_m: found NaN, expected -1000000000 to"),
        ("water.height_m = 2e9", "line 1, water.height_m: found 2000000000"),
        (
            "water = { height_m = 1, colour = [0, -0.1, 0] }",
            "line 1, water.colour: found -0.1, expected 0 to 1",
        ),
        ("water = { height_m = 1, colour = [0, 0] }", "line 1"),
        ("water = { height_m = 1, waves = {} }", "missing field `wind_m_s`"),
        ("water = { height_m = 1, waves = { wind_m_s = 3, wind = 2 } }", "unknown field `wind`"),
        (
            "water = { height_m = 1,\nwaves = { wind_m_s = 40 } }",
            "line 2, water.waves.wind_m_s: found 40, expected 0.5 to 30",
        ),
        (
            "water = { height_m = 1, waves = { wind_m_s = 12, steepness = 3 } }",
            "line 1, water.waves.steepness: found 3, expected at most 1.",
        ),
        (
            "water = { height_m = 1, waves = { wind_m_s = 3, step_s = inf } }",
            "line 1, water.waves.step_s: found inf, expected -1000000000 to",
        ),
        (
            "water.height_m = 0\nground.height_m = 0",
            "line 1, water.height_m: found 0, expected above the level ground at 0",
        ),
        (
            "ground = {}\nwater.height_m = -1",
            "line 2, water.height_m: found -1, expected above the level ground at 0",
        ),
    ] {
        let message = water(text).expect_err(text).to_string();
        assert!(message.contains(expected), "{message} for {expected}");
    }
}
