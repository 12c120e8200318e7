//! `--help` and `--version` work everywhere and tell the whole story.

use crate::flb::Folder;

mod flb;

#[test]
fn help_of_every_command_exits_0() {
    let folder = Folder::new();
    let top = folder.flb(&["--help"]).expect_code(0);
    for command in [
        "bake",
        "bake-scene",
        "plan",
        "materials",
        "pack",
        "migrate",
        "info",
        "validate",
        "torture",
        "diff",
        "extract",
        "render",
        "stream",
        "view",
        "grow",
        "scatter",
        "scene",
        "trade",
        "doctor",
    ] {
        assert!(top.stdout.contains(&format!("  {command} ")), "{command} is not in: {}", top.stdout);
        let run = folder.flb(&[command, "--help"]).expect_code(0);
        assert!(run.stdout.contains("Usage: flb ") && run.stderr.is_empty(), "{command}: {}", run.stdout);
        let schema = format!("cli/schema/{command}.json");
        // The words may be wrapped in the terminal's width.
        let words = run.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(&schema), "{command} names its schema: {}", run.stdout);
    }
    let page = include_str!("../../docs/book/src/errors.md");
    for code in ["0", "1", "2", "3", "4", "5", "6", "70", "130"] {
        assert!(top.stdout.contains(&format!("\n  {code} ")), "exit code {code} is not in: {}", top.stdout);
        assert!(
            page.contains(&format!("\n| {code} | ")),
            "exit code {code} is not in docs/book/src/errors.md"
        );
    }
    let run = folder.flb(&["--version"]).expect_code(0);
    assert_eq!(run.stdout, concat!("flb ", env!("CARGO_PKG_VERSION"), "\n"));
}
