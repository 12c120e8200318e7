//! Planted faults, which the checks of documents must find.

use std::collections::{BTreeMap, BTreeSet};

use super::citations::{missing_documents, missing_sections, unknown_works};
use super::commands::{missing_sources, missing_targets, packages};
use super::links::broken_links;
use super::text::{avoided_in_comments, wide_comments, wide_lines};
use super::{File, documents, sources};

/// A source or a document, made up.
fn planted(text: &str) -> File {
    File { path: "docs/planted.md".to_owned(), text: text.to_owned() }
}

#[test]
fn planted_links_and_citations_are_found() {
    let (_, paths) = documents();
    let page = planted(
        "[a](../README.md), [b](none.md)\n# Two words\n[c](#two-words) [d](#three) ![e](../docs)\n```\n[f](x.md)\n```\n",
    );
    let all = BTreeMap::from([("docs/planted.md", page.text.as_str())]);
    let found = broken_links(&page, &paths, &all);
    assert_eq!(found, ["docs/planted.md: no file none.md", "docs/planted.md: no heading #three"]);

    let source = planted(
        "/// See docs/none.md and SPEC.md.\nlet a = include_str!(\"../../README.md\"); // ../NONE.md\n",
    );
    let found = missing_documents(&source, &paths);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].contains("docs/none.md") && found[1].contains("NONE.md"), "{found:?}");

    let known = BTreeSet::from(["1", "2", "3", "3.1", "9"].map(str::to_owned));
    let source = planted(
        "//! As the project's lighting\n//! model, section 7, says; lighting model's, section 3. 12 bases\n\
        fn f() {} // lighting model, sections 2, 3.1 and 8)\n/// (lighting model,\n/// section 9)\n",
    );
    let found = missing_sections(&source, "lighting model", &known);
    let cites = |section: &str| format!("docs/planted.md cites lighting model, section {section}");
    assert_eq!(found, [cites("7"), cites("8")]);
}

#[test]
fn planted_works_widths_and_commands_are_found() {
    let bibliography = "# B\n- Ross, J. 1981. *X.*\n- Akenine-Möller, T. 2001. *Y.*";
    let source = planted(
        "// (Ross, 1981; Nobel and others 1999), after Akenine-Moller (2001); on 3 October 2005 it was 1981.\n",
    );
    assert_eq!(unknown_works(&source, bibliography), ["docs/planted.md cites Nobel 1999"]);

    let long = "word ".repeat(30);
    let page = planted(&format!("{long}\n| {long} |\nhttps://example.org/{}\n", "a".repeat(120)));
    assert_eq!(wide_lines(&page), ["docs/planted.md, line 1: 150 columns"]);

    let source = File {
        path: "planted.rs".to_owned(),
        text: format!(
            "let a = \"// {long}\";\nlet b = 1; // {long}\n    /// {long}\n// Nobody can; it\n// hangs on it.\n"
        ),
    };
    assert_eq!(
        wide_comments(&source),
        ["planted.rs, line 2: 164 columns", "planted.rs, line 3: 158 columns"]
    );
    assert_eq!(avoided_in_comments(&source), ["planted.rs: \"nobody\"", "planted.rs: \"hangs on\""]);

    let (_, paths) = documents();
    let page = planted("`cli/src/main.rs`, `{main,none}.rs`, `baker/src/none/`, `cli/src/`, `a * b.rs`");
    assert_eq!(
        missing_sources(&page, &paths),
        ["docs/planted.md: no none.rs", "docs/planted.md: no baker/src/none/"]
    );
    let page = planted(
        "`cargo bench -p flb-tests --bench stand` and `cargo bench -p flb-tests --bench none`, `cargo test -p flb-none`,
        `cargo test -p flb-scene surfaces_in_rgb`, `cargo test -p flb-scene --lib surfaces_in_xyz`.",
    );
    let found = missing_targets(&page, &packages(), &paths, &sources().0);
    let expected = [
        "docs/planted.md: flb-tests has no --bench none",
        "docs/planted.md: no package flb-none",
        "docs/planted.md: flb-scene has no test surfaces_in_xyz",
    ];
    assert_eq!(found, expected);

    let page = planted(
        "`cargo test -p flb-tests --test it` and `--test it scene_light` bound it. `cargo test -p flb --test it none` or
        `cargo test -p flb --test it -- faults::` `cargo test -p flb-format --test it forged::a_base_that forged::a_none
        none::a` `cargo test -p flb --test none`.",
    );
    let found = missing_targets(&page, &packages(), &paths, &sources().0);
    let expected = [
        "docs/planted.md: flb has no module none of --test it",
        "docs/planted.md: flb-format has no test forged::a_none",
        "docs/planted.md: flb-format has no module none of --test it",
        "docs/planted.md: flb has no --test none",
    ];
    assert_eq!(found, expected);
}
