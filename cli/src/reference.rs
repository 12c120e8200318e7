//! Documents against clap: the command-line page of the book is what `--help` prints, and every command and flag that a
//! document shows is one that `flb` takes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::{Command, CommandFactory};

use crate::args::Cli;

/// Columns that help is wrapped at, as on a wide terminal.
const WIDTH: usize = 100;

const PAGE: &str = "docs/book/src/command-line.md";

const HEAD: &str = "\
# Command line

What `flb --help` and `flb COMMAND --help` print. A test writes this page; do not edit it:
`FLB_WRITE_DOCS=1 cargo test -p flb --bin flb reference`.
";

/// Flags that documents show of other programs: cargo, its test harness, docker.
const OTHERS: [&str; 11] = [
    "--bench",
    "--cap-add",
    "--example",
    "--features",
    "--lib",
    "--no-default-features",
    "--nocapture",
    "--prefix",
    "--profile",
    "--test",
    "--workspace",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn cli() -> Command {
    let mut command = Cli::command().term_width(WIDTH);
    command.build();
    command
}

/// The page, made anew.
fn page() -> String {
    let mut text = HEAD.to_owned();
    for (title, command) in with_all_below("flb", &cli()) {
        let help = command.clone().term_width(WIDTH).render_long_help().to_string();
        let lines: Vec<&str> = help.trim_end().lines().map(str::trim_end).collect();
        text += &format!("\n## {title}\n\n```text\n{}\n```\n", lines.join("\n"));
    }
    text
}

/// A command and those below it, each by the words that call it.
fn with_all_below<'c>(words: &str, command: &'c Command) -> Vec<(String, &'c Command)> {
    let below = command.get_subcommands().filter(|one| one.get_name() != "help");
    let below = below.flat_map(|one| with_all_below(&format!("{words} {}", one.get_name()), one));
    std::iter::once((words.to_owned(), command)).chain(below).collect()
}

/// Every Markdown file of ours: its path from the root and its text.
fn documents() -> Vec<(String, String)> {
    fn add(folder: &Path, from_root: &str, found: &mut Vec<(String, String)>) {
        for entry in std::fs::read_dir(folder).expect("the checkout can be listed") {
            let entry = entry.expect("an entry");
            let name = entry.file_name().into_string().expect("names are text");
            let path = format!("{from_root}{name}");
            if entry.file_type().expect("a type").is_dir() {
                if name != "target" && !name.starts_with('.') {
                    add(&entry.path(), &format!("{path}/"), found);
                }
            } else if name.ends_with(".md") {
                found.push((path, std::fs::read_to_string(entry.path()).expect("documents are text")));
            }
        }
    }
    let mut found = Vec::new();
    for start in ["README.md", "ARCHITECTURE.md", "SECURITY.md", "CONTRIBUTING.md", "CHANGELOG.md"] {
        found.push((start.to_owned(), std::fs::read_to_string(root().join(start)).expect(start)));
    }
    add(&root().join("docs"), "docs/", &mut found);
    found.retain(|(path, _)| path != PAGE);
    found
}

/// The lines of shell blocks that call `flb`, continued lines joined.
fn commands(text: &str) -> Vec<String> {
    let (mut found, mut inside, mut open) = (Vec::new(), false, String::new());
    for line in text.lines() {
        if line.starts_with("```") {
            inside = line == "```sh";
        } else if inside {
            open += line.trim_end_matches('\\');
            if !line.ends_with('\\') {
                found.push(std::mem::take(&mut open));
            }
        }
    }
    found.retain(|line| line.starts_with("flb "));
    found
}

/// The words of a line of shell: quotes taken away, a comment left out.
fn words(line: &str) -> Vec<String> {
    let (mut found, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for sign in line.chars() {
        match (quote, sign) {
            (Some(end), _) if sign == end => quote = None,
            (Some(_), _) => word.get_or_insert_default().push(sign),
            (None, '\'' | '"') => {
                quote = Some(sign);
                word.get_or_insert_default();
            }
            (None, ' ') => found.extend(word.take()),
            (None, '#') if word.is_none() => break,
            (None, _) => word.get_or_insert_default().push(sign),
        }
    }
    found.extend(word);
    found
}

/// Pieces of text between single back quotes, outside of blocks.
fn code(text: &str) -> Vec<String> {
    let (mut prose, mut inside) = (String::new(), false);
    for line in text.lines() {
        if line.starts_with("```") {
            inside = !inside;
        } else if !inside {
            prose += line;
            prose.push(' ');
        }
    }
    prose.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The long flags of a command, those of every command included.
fn flags(command: &Command) -> BTreeSet<String> {
    let names = |one: &clap::Arg| {
        one.get_long()
            .into_iter()
            .chain(one.get_visible_aliases().unwrap_or_default())
            .map(|name| format!("--{name}"))
            .collect::<Vec<_>>()
    };
    command.get_arguments().flat_map(names).collect()
}

/// `--flag` of `--flag=VALUE` and `--flag[=BOOL]`.
fn flag(word: &str) -> &str {
    word.split(['=', '[']).next().unwrap_or(word)
}

/// What is wrong with the commands and flags of a document.
fn faults(text: &str) -> Vec<String> {
    let command = cli();
    let mut found = Vec::new();
    for line in commands(text) {
        if let Err(error) = command.clone().try_get_matches_from(words(&line))
            && error.use_stderr()
        {
            found.push(format!("{line}: {}", error.to_string().lines().next().unwrap_or_default()));
        }
    }
    let all: BTreeSet<String> =
        with_all_below("flb", &command).into_iter().flat_map(|(_, command)| flags(command)).collect();
    for piece in code(text) {
        let words = words(&piece);
        let known = match words.first().map(String::as_str) {
            Some("flb") if words.len() > 1 && !words[1].starts_with('-') => {
                let Some(mut subcommand) = command.find_subcommand(&words[1]) else {
                    found.push(format!("`{piece}`: no such command"));
                    continue;
                };
                while let Some(below) = words[2..].iter().find_map(|word| subcommand.find_subcommand(word)) {
                    subcommand = below;
                }
                flags(subcommand)
            }
            Some("flb") => all.clone(),
            Some(word) if word.starts_with("--") && word.len() > 2 => all.clone(),
            _ => continue,
        };
        let is_one = |word: &&String| word.starts_with("--") && word.len() > 2;
        for word in words.iter().filter(is_one).map(|word| flag(word)) {
            if !known.contains(word) && !OTHERS.contains(&word) && !["--help", "--version"].contains(&word) {
                found.push(format!("`{piece}`: no such flag"));
            }
        }
    }
    found
}

/// Rows of tables whose first cell is a flag: the flag and its default, as written.
fn rows(text: &str) -> Vec<(String, String)> {
    let cells = |line: &str| line.split(" | ").map(str::to_owned).collect::<Vec<_>>();
    let of_flag = text.lines().filter(|line| line.starts_with("| `--"));
    of_flag
        .map(|line| {
            let cells = cells(line.trim_start_matches("| "));
            let name = cells[0].trim_matches('`').split(' ').next().unwrap_or_default();
            (flag(name).to_owned(), cells[1].clone())
        })
        .collect()
}

/// What is wrong with a table of flags of `flb bake`.
fn table_faults(text: &str) -> Vec<String> {
    let command = cli();
    let bake = command.find_subcommand("bake").expect("there is flb bake");
    let mut found = Vec::new();
    for (flag, default) in rows(text) {
        let Some(argument) = bake.get_arguments().find(|one| one.get_long() == Some(&flag[2..])) else {
            found.push(format!("{flag}: flb bake has no such flag"));
            continue;
        };
        let help =
            argument.get_long_help().or(argument.get_help()).map(ToString::to_string).unwrap_or_default();
        let of_clap = argument.get_default_values().first().map(|value| value.to_string_lossy().into_owned());
        let takes_value = argument.get_num_args().is_some_and(|range| range.takes_values());
        let is_right = match (default.strip_prefix('`').and_then(|value| value.strip_suffix('`')), of_clap) {
            (Some(value), Some(known)) => value == known,
            (Some(value), None) => help.contains(&format!("[default: {value}")),
            // A word that is no value: "off", "the preset's", ...
            (None, Some(_)) => default == "off" && !takes_value,
            (None, None) => default != "the preset's" || help.contains("the preset's"),
        };
        if !is_right {
            found.push(format!("{flag}: the default is not {default}"));
        }
    }
    found
}

#[test]
fn the_command_line_page_is_what_help_prints() {
    let path = root().join(PAGE);
    let made = page();
    if std::env::var_os("FLB_WRITE_DOCS").is_some() {
        std::fs::write(&path, &made).expect("the page can be written");
    }
    let kept = std::fs::read_to_string(&path).expect("the page is there");
    for (number, (kept, made)) in kept.lines().zip(made.lines()).enumerate() {
        assert_eq!(kept, made, "{PAGE}, line {}; FLB_WRITE_DOCS=1 writes it anew", number + 1);
    }
    assert_eq!(
        kept.len(),
        made.len(),
        "{PAGE} is not as long as it must be; FLB_WRITE_DOCS=1 writes it anew"
    );
}

/// Where the page on meshes begins with what the code writes.
const TABLES: &str = "### glTF 2.0\n";

#[test]
fn the_tables_of_what_is_read_of_a_mesh_are_those_of_the_code() {
    let path = root().join("docs/book/src/meshes.md");
    let kept = std::fs::read_to_string(&path).expect("the page is there");
    let by_hand = kept.find(TABLES).map_or(kept.as_str(), |at| &kept[..at]);
    let made = format!("{by_hand}{}", flb_scene::import::known::page::markdown());
    if std::env::var_os("FLB_WRITE_DOCS").is_some() {
        std::fs::write(&path, &made).expect("the page can be written");
    }
    let kept = std::fs::read_to_string(&path).expect("the page is there");
    assert!(kept == made, "meshes.md; FLB_WRITE_DOCS=1 writes its tables anew");
}

#[test]
fn every_command_and_flag_of_a_document_is_one_that_flb_takes() {
    let documents = documents();
    let shown: usize = documents.iter().map(|(_, text)| commands(text).len()).sum();
    assert!(shown > 40, "only {shown} commands were found");
    let found: Vec<String> = documents
        .iter()
        .flat_map(|(path, text)| faults(text).into_iter().map(move |fault| format!("{path}: {fault}")))
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn planted_commands_and_flags_are_found() {
    let text = "```sh\nflb bake a.glb -o a.flb --latice 32\nflb info \\\n    a.flb   # fine\nflb brake a.glb\n```\n\
        See `flb pack --solver`, `--latice N`, `flb brake` and `--lattice N`.\n";
    let found = faults(text);
    assert_eq!(found.len(), 5, "{found:#?}");
    assert!(
        found[0].starts_with("flb bake a.glb -o a.flb --latice 32: error: unexpected argument"),
        "{found:?}"
    );
    assert!(found[1].starts_with("flb brake"), "{found:?}");
    let rest =
        ["`flb pack --solver`: no such flag", "`--latice N`: no such flag", "`flb brake`: no such command"];
    assert_eq!(found[2..], rest);
}

#[test]
fn the_tables_of_flags_are_those_of_the_bake() {
    let settings = include_str!("../../docs/book/src/settings.md");
    assert!(rows(settings).len() > 20, "{:?}", rows(settings));
    assert_eq!(table_faults(settings), Vec::<String>::new());
    // Every kind of suns has its row.
    for suns in <flb_transport::ordinates::NamedSuns as clap::ValueEnum>::value_variants() {
        let begins = format!("| `{}` | {} |", suns.name(), suns.basis().items());
        assert!(settings.lines().any(|line| line.starts_with(&begins)), "no row {begins}");
    }
}

#[test]
fn planted_rows_of_flags_are_found() {
    let text = "| `--voxels N` | `512` | x |\n| `--suns KIND` | the preset's | x |\n| `--colour C` | off | x |\n\
        | `--codec C` | `haar` | x |\n| `--monte-carlo SUNS` | off | x |\n";
    let faults = table_faults(text);
    let expected = [
        "--voxels: the default is not `512`",
        "--colour: flb bake has no such flag",
        "--codec: the default is not `haar`",
        "--monte-carlo: the default is not off",
    ];
    assert_eq!(faults, expected);
}
