//! `--help` works everywhere and tells the whole story.

use crate::flb::Folder;
use crate::schema::commands;

#[test]
fn help_of_every_command_exits_0() {
    let folder = Folder::new();
    let top = folder.flb(&["--help"]).expect_code(0);
    // Names stand two columns in, what they do further right.
    let lines = top.stdout.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = lines.take_while(|line| !line.is_empty()).filter_map(|line| line.strip_prefix("  "));
    let names = names.filter(|line| !line.starts_with(' ')).filter_map(|line| line.split(' ').next());
    let mut listed: Vec<&str> = names.filter(|name| *name != "help").collect();
    listed.sort_unstable();
    let commands = commands();
    // A command below another has a schema of its own, or is in that of the one above it.
    let (top_level, below): (Vec<&str>, Vec<&str>) =
        commands.iter().map(String::as_str).partition(|command| listed.contains(command));
    assert_eq!(listed, top_level, "every command has a schema, and every schema a command");
    let nested = below.iter().map(|command| {
        let mut above =
            listed.iter().filter_map(|top| Some([*top, command.strip_prefix(top)?.strip_prefix('-')?]));
        above.next_back().unwrap_or_else(|| panic!("{command}.json is of no command")).to_vec()
    });
    for words in top_level.iter().map(|command| vec![*command]).chain(nested) {
        let command = words.join("-");
        let run = folder.flb_with(&words, &["--help"]).expect_code(0);
        assert!(run.stdout.contains("Usage: flb ") && run.stderr.is_empty(), "{command}: {}", run.stdout);
        let schema = format!("cli/schema/{command}.json");
        // The words may be wrapped in the terminal's width.
        let words = run.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(&schema), "{command} names its schema: {}", run.stdout);
    }
    let page = include_str!("../../../docs/book/src/errors.md");
    for code in ["0", "1", "2", "3", "4", "5", "6", "70", "75", "130"] {
        assert!(top.stdout.contains(&format!("\n  {code} ")), "exit code {code} is not in: {}", top.stdout);
        assert!(
            page.contains(&format!("\n| {code} | ")),
            "exit code {code} is not in docs/book/src/errors.md"
        );
    }
    let run = folder.flb(&["-V"]).expect_code(0);
    assert_eq!(run.stdout, concat!("flb ", env!("CARGO_PKG_VERSION"), "\n"));
}
