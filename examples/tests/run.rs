//! Every example runs, and says what it is to show.

use std::process::Command;

fn run(program: &str) -> String {
    // Drivers in software complain where it is not set.
    let runtime = std::env::temp_dir();
    let output = Command::new(program).env("XDG_RUNTIME_DIR", runtime).output();
    let output = output.expect("it was built for this test");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && err.is_empty(), "{out}{err}");
    out.into_owned()
}

/// The numbers behind the colon of lines that hold `word`.
fn numbers(text: &str, word: &str) -> Vec<Vec<f64>> {
    let of_line = |line: &str| {
        let values = line.rsplit([':', 'm', '[']).next().unwrap_or_default();
        let words = values.split([' ', ',', ']']).filter(|word| !word.is_empty() && *word != "up");
        words.filter_map(|word| word.parse().ok()).collect()
    };
    text.lines().filter(|line| line.contains(word)).map(of_line).collect()
}

#[test]
fn a_plant_is_baked_in_memory_and_is_darker_inside_than_the_light_outside() {
    let text = run(env!("CARGO_BIN_EXE_bake_in_memory"));
    for stage in ["voxelise", "downsample", "crown", "solve"] {
        assert!(text.contains(&format!("fern: {stage}")), "{text}");
    }
    let lit = numbers(&text, "above the ground");
    assert_eq!(lit.len(), 3, "{text}");
    assert!(lit.iter().flatten().all(|band| (0.0..1.5).contains(band) && *band > 0.0), "{text}");
}

#[test]
fn a_file_is_asked_for_light_under_three_suns() {
    let text = run(env!("CARGO_BIN_EXE_light_at_a_point"));
    let lit = numbers(&text, "m up");
    assert_eq!(lit.len(), 9, "{text}");
    assert!(lit.iter().all(|bands| bands.len() == 3 && bands.iter().all(|band| *band > 0.0)), "{text}");
}

#[test]
fn a_streamed_forest_is_never_black_and_ends_final() {
    let text = run(env!("CARGO_BIN_EXE_stream_a_forest"));
    for frame in 0..5 {
        assert!(text.contains(&format!("frame {frame}:")), "{text}");
    }
    let lit = numbers(&text, "light");
    assert!(lit.iter().all(|bands| bands.len() == 3 && bands.iter().all(|band| *band > 0.0)), "{text}");
}

#[test]
fn the_forest_of_an_engine_has_light_from_its_first_frames_on_and_more_of_a_rising_sun() {
    let text = run(env!("CARGO_BIN_EXE_forest_of_an_engine"));
    let lit = numbers(&text, "light");
    assert_eq!(lit.len(), 6, "{text}");
    assert!(lit.iter().all(|bands| bands.len() == 3 && bands.iter().all(|band| *band > 0.0)), "{text}");
    assert!(lit[5].iter().zip(&lit[0]).all(|(last, first)| *last > 2.0 * first), "{text}");
    assert!(text.lines().all(|line| line.contains("60 plants")), "{text}");
}

#[test]
fn the_forest_on_a_gpu_has_the_light_of_the_cpu() {
    let text = run(env!("CARGO_BIN_EXE_forest_on_a_gpu"));
    let lit = numbers(&text, "light");
    assert_eq!(lit.len(), 5, "{text}");
    assert!(lit.iter().all(|bands| bands.len() == 3 && bands.iter().all(|band| *band > 0.0)), "{text}");
    assert!(lit[4].iter().zip(&lit[0]).all(|(last, first)| *last > 1.5 * first), "{text}");
    for line in text.lines() {
        let apart = line.split("written, ").nth(1).and_then(|rest| rest.split(' ').next());
        let apart: f32 = apart.expect("how far").parse().expect("a number");
        assert!(apart < 0.002, "{line}");
    }
}
