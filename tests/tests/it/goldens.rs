//! Every stage of the flow in ARCHITECTURE.md has a golden: the table names tests, and they are there.

use crate::documents::{File, files};

/// Stages and the tests that are named in the last cell of their rows.
fn goldens(architecture: &str) -> Vec<(&str, Vec<&str>)> {
    let rows = architecture.lines().skip_while(|line| !line.starts_with("| stage | turns |")).skip(2);
    let row = |line| {
        let line: &str = line;
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        let tests = cells.get(4).map_or(Vec::new(), |cell| cell.split('`').skip(1).step_by(2).collect());
        (cells[0], tests)
    };
    rows.take_while(|line| line.starts_with('|')).map(row).collect()
}

/// Whether `module::test` is a test in a file of that module.
fn is_there(test: &str, sources: &[File]) -> bool {
    let Some((module, name)) = test.rsplit_once("::") else { return false };
    let end = format!("/{}.rs", module.replace("::", "/"));
    let head = format!("#[test]\nfn {name}()");
    sources.iter().any(|file| file.path.ends_with(&end) && file.text.contains(&head))
}

/// Stages without a golden, and goldens that are not there.
fn missing(architecture: &str, sources: &[File]) -> Vec<String> {
    let mut found = Vec::new();
    for (stage, tests) in goldens(architecture) {
        if tests.is_empty() {
            found.push(format!("{stage} has no golden"));
        }
        let gone = tests.iter().filter(|test| !is_there(test, sources));
        found.extend(gone.map(|test| format!("{stage}: no test {test}")));
    }
    found
}

#[test]
fn every_stage_of_the_flow_has_a_golden() {
    let architecture = include_str!("../../../ARCHITECTURE.md");
    let (sources, _) = files(&[".rs"]);
    assert!(goldens(architecture).len() >= 13, "{:?}", goldens(architecture));
    assert_eq!(missing(architecture, &sources), Vec::<String>::new());
}

#[test]
fn a_planted_stage_without_a_golden_is_found() {
    let table = "| stage | turns | where | why | golden |\n|---|---|---|---|---|\n| a | b | c | d |\n\
                 | e | f | g | h | `x::y`, `goldens::every_stage_of_the_flow_has_a_golden` |\n\n| i | j |\n";
    let (sources, _) = files(&["goldens.rs"]);
    assert_eq!(missing(table, &sources), ["a has no golden", "e: no test x::y"]);
}
