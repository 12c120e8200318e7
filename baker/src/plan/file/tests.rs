use super::*;
use crate::plan::{Need, OnScreen};

fn outline(species: &[&str]) -> Outline {
    let need = |name: &&str| Need {
        name: (*name).to_owned(),
        instances: 1,
        bases: [0, 4].into_iter().collect(),
        on_screen: Some(OnScreen { size_px: 100.0, distance_m: 3.0, wanted: 32, lattice: 32 }),
    };
    Outline {
        reason: "a test".to_owned(),
        bands: Some(vec!["G".to_owned()]),
        any_upright: [0, 4, 9].into_iter().collect(),
        has_sun: true,
        species: species.iter().map(need).collect(),
    }
}

/// Reads a file of this name and text back.
fn read(name: &str, text: &[u8]) -> Result<Plan, ImportError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("a temporary file");
    Plan::read(&path)
}

const TOML: &str = r#"schema = 1
reason = "a test"
bands = ["G"]

[[species]]
name = "fir"
bases = [0, 4]
lattice = 32

[[species]]
name = "oak"
bases = [0, 4]
lattice = 32
"#;

#[test]
fn a_plan_is_written_in_one_way_and_read_back_from_both_kinds() {
    let plan = Plan::of(&outline(&["oak", "fir"])).expect("it has bases");
    assert_eq!(plan, Plan::of(&outline(&["fir", "oak"])).expect("it has bases"));
    assert_eq!(plan.to_toml(), TOML);
    assert_eq!(read("p.toml", TOML.as_bytes()).expect("its own file"), plan);
    assert_eq!(read("p.JSON", &plan.to_json()).expect("its own file"), plan);
    let json = String::from_utf8(plan.to_json()).expect("JSON is UTF-8");
    assert!(
        json.starts_with(r#"{"bands":["G"],"reason":"a test","schema":1,"species":[{"bases":[0,4],"#),
        "{json}"
    );
    let every = Plan::of(&outline(&[])).expect("it has bases");
    assert_eq!(every.to_toml(), "schema = 1\nreason = \"a test\"\nbands = [\"G\"]\nbases = [0, 4, 9]\n");
    assert_eq!(read("p.toml", every.to_toml().as_bytes()).expect("its own file"), every);
}

#[test]
fn a_species_has_its_share_or_the_plan_says_which_it_knows() {
    let plan = Plan::of(&outline(&["oak", "fir"])).expect("it has bases");
    let share = plan.share("oak").expect("it is there");
    assert_eq!((share.bases.len(), share.lattice), (2, Some(32)));
    let error = plan.share("ash").expect_err("it is not there").to_string();
    assert_eq!(error, "species \"ash\" is not in the plan, which has: fir, oak");
    let share = Plan::of(&outline(&[])).expect("it has bases").share("ash").expect("any name");
    assert_eq!((share.bases.len(), share.lattice), (3, None));
}

#[test]
fn a_plan_for_nothing_is_no_plan() {
    let mut nothing = outline(&["oak"]);
    nothing.species[0].bases = BaseSet::NONE;
    let error = Plan::of(&nothing).expect_err("nothing").to_string();
    assert_eq!(error, "species \"oak\" needs no base at all (a test): there is nothing to bake");
    let nothing = Outline { any_upright: BaseSet::NONE, ..outline(&[]) };
    assert!(
        Plan::of(&nothing).expect_err("nothing").to_string().starts_with("the plan needs no base at all")
    );
}

#[test]
fn plan_files_that_are_wrong_are_refused_with_place_and_reason() {
    for (from, to, expected) in [
        ("schema = 1", "schema = 2", "p.toml: schema: found 2, expected 1; a newer flb"),
        ("schema = 1\n", "", "missing field `schema`"),
        ("reason", "raeson", "unknown field `raeson`"),
        ("\"a test\"", "\"\"", "p.toml: reason: found \"\""),
        ("[\"G\"]", "[]", "p.toml: bands: found 0 names, expected 1 to 64"),
        ("[\"G\"]", "[\"G\", \"G\"]", "p.toml: bands: found [\"G\", \"G\"], expected each name once"),
        ("bands =", "bases = [0]\nbands =", "p.toml: bases: found both bases and species"),
        ("\"fir\"", "\"oak\"", "p.toml: species \"oak\": found it here, expected names ascending, each once"),
        ("[0, 4]", "[]", "p.toml: species \"fir\", bases: found [], expected one base or more"),
        ("[0, 4]", "[4, 0]", "expected numbers from 0 to 18, ascending"),
        ("[0, 4]", "[0, 19]", "expected numbers from 0 to 18, ascending"),
        ("= 32", "= 33", "species \"fir\", lattice: found 33, expected a power of two"),
        ("= 32", "= 512", "species \"fir\", lattice: found 512"),
        ("[[species]]", "[species", "line 5"),
    ] {
        assert!(TOML.contains(from), "{from}");
        let message = read("p.toml", TOML.replacen(from, to, 1).as_bytes()).expect_err(to).to_string();
        assert!(message.contains(expected), "{message} for {expected}");
    }
    let message = read("p.toml", b"schema = 1\nreason = \"r\"\n").expect_err("no bases").to_string();
    assert!(message.contains("bases: found neither bases nor species"), "{message}");
    assert!(
        read("p.json", TOML.as_bytes()).expect_err("TOML is no JSON").to_string().contains("line 1 column 1")
    );
    assert!(read("p.toml", b"\xff").expect_err("no text").to_string().contains("byte 0 is not UTF-8"));
}
