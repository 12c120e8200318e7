//! The papers' model stands behind one wall: which of the two models made a light is asked at the doors of a room
//! alone, and the rest of the room asks for what follows from it (docs/decisions/one-wall.md).

use crate::comments::rooms;
use crate::unsafe_code::sources;

/// Files that tell the models apart, by what each decides.
const DOORS: [(&str, &str); 8] = [
    ("format-spec/src/model.rs", "what a file holds"),
    ("baker/src/bake.rs", "which solve a bake is"),
    ("baker/src/bake/settings.rs", "how it is solved"),
    ("runtime-loader/src/light.rs", "whether the light of some suns can be loaded alone"),
    ("render/src/shading.rs", "how surfaces are coloured, and the units of pictures"),
    ("eval/src/trade/transport.rs", "what is tried"),
    ("farm/src/recipe/solve.rs", "settings of a bake, by name"),
    ("cli/src/bake/model.rs", "flags and messages of a bake"),
];

/// Files that are of one model alone, and make or refuse it by name.
const BEHIND: [&str; 5] = [
    "baker/src/bake/paper.rs",
    "baker/src/bake/physical.rs",
    "baker/src/scene_light/entry.rs",
    "runtime-loader/src/sampler.rs",
    "runtime-loader/src/physical.rs",
];

/// Bound of the files that may tell the models apart, doors and those behind them.
const MAX_FILES: usize = 20;

/// What names a model in code: a variant, a flag, and looking whether parts of one are there.
const ASKS: [&str; 6] =
    ["::Paper", "::Physical", "is_paper", "is_physical", "optics().is_", "physical().is_"];

/// Numbers of the lines that tell the models apart, but for tests. `.is_some_and` asks for a part of a model, not
/// whether it is that one.
fn asking(text: &str) -> Vec<usize> {
    let end = text.find("#[cfg(test)]\nmod tests {").unwrap_or(text.len());
    let lines = (1..).zip(text[..end].lines());
    let asks = |(_, line): &(usize, &str)| {
        let code = line.split("//").next().unwrap_or_default().replace(".is_some_and(", "");
        ASKS.iter().any(|ask| names(&code, ask))
    };
    lines.filter(asks).map(|(number, _)| number).collect()
}

/// Whether code has a word: `surfaces::PhysicalSky` is no variant, and a file of a model is no type.
fn names(code: &str, ask: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(ask).any(|(at, _)| {
        let (before, after) = (&code[..at], &code[at + ask.len()..]);
        let owner: String = before.chars().rev().take_while(|c| is_word(*c)).collect();
        match ask.strip_prefix("::") {
            Some(_) => owner.ends_with(char::is_uppercase) && !after.starts_with(is_word),
            None if ask.ends_with('_') => true,
            None => owner.is_empty() && !after.starts_with(is_word),
        }
    })
}

/// Places beside the doors that tell the models apart, one sentence each.
fn breaches(sources: &[(String, String)], rooms: &[&str]) -> Vec<String> {
    let is_shipped = |path: &str| {
        let mut parts = path.split('/');
        let is_room = parts.next().is_some_and(|room| rooms.contains(&room)) && parts.next() == Some("src");
        is_room && !parts.any(|part| ["tests", "tests.rs"].contains(&part))
    };
    let is_known = |path: &str| BEHIND.contains(&path) || DOORS.iter().any(|(door, _)| *door == path);
    let beside = sources.iter().filter(|(path, _)| is_shipped(path) && !is_known(path));
    let told = |path: &str, line| {
        format!("{path}:{line}: asks which model it is, expected what follows from the model, from a door")
    };
    beside.flat_map(|(path, text)| asking(text).into_iter().map(move |line| told(path, line))).collect()
}

#[test]
fn models_are_told_apart_at_the_doors_alone() {
    let (sources, rooms) = (sources(), rooms(include_str!("../../../ARCHITECTURE.md")));
    assert!(rooms.contains(&"format-spec") && rooms.contains(&"cli"), "{rooms:?}");
    assert_eq!(breaches(&sources, &rooms), Vec::<String>::new());
    // A door that asks nothing any more is none.
    for path in BEHIND.into_iter().chain(DOORS.map(|(door, _)| door)) {
        let (_, text) = sources.iter().find(|(source, _)| source == path).expect("a file of the repository");
        assert!(!asking(text).is_empty() || text.contains(".physical()"), "{path}");
    }
    let page = include_str!("../../../docs/decisions/one-wall.md");
    for (door, _) in DOORS {
        assert!(page.contains(&format!("`{door}`")), "the page lacks {door}");
    }
    const { assert!(DOORS.len() + BEHIND.len() <= MAX_FILES) };
}

#[test]
fn planted_questions_are_found() {
    let planted = "\
//! Of Model::Paper, in words.
use crate::physical::Physical;
fn a(model: &Model) -> bool {
    matches!(model, Model::Paper { .. })
}
fn b(meta: &SpeciesMeta) -> f32 {
    if meta.physical().is_none() { 1.0 } else { 2.0 }
}
fn c(look: &Look) -> bool {
    look.is_physical
}
fn d(meta: &SpeciesMeta) -> bool {
    meta.physical().is_some_and(|(_, light)| light.field == FieldKind::Total) // not is_paper
}
fn e() -> f32 {
    Sky::PhysicalSky.height(paper::Paper::new())
}
#[cfg(test)]
mod tests {
    fn f() -> Shading {
        Shading::Paper
    }
}
";
    let place = |path: &str| (path.to_owned(), planted.to_owned());
    let sources = ["stage/src/a.rs", "stage/src/a/tests.rs", "tests/src/b.rs", "render/src/shading.rs"];
    let found = breaches(&sources.map(place), &["stage", "render"]);
    let lines: Vec<&str> = found.iter().map(|told| told.split(": ").next().unwrap_or_default()).collect();
    assert_eq!(lines, ["stage/src/a.rs:4", "stage/src/a.rs:7", "stage/src/a.rs:10"]);
}
