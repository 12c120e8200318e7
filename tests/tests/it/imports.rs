//! No crate imports upward: the table of rooms in ARCHITECTURE.md, held against `cargo metadata`. No file imports one
//! that imports it back.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand};

/// What each of our packages may depend on, of ours: the table of rooms in ARCHITECTURE.md. Dev-dependencies are free:
/// they ship nothing.
fn may_import(architecture: &str) -> BTreeMap<String, BTreeSet<String>> {
    let mut found = BTreeMap::<String, BTreeSet<String>>::new();
    let of_rooms = architecture.lines().skip_while(|line| !line.starts_with("| folder | package |")).skip(2);
    for line in of_rooms.take_while(|line| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        let [_, package, _, imports] = cells[..] else { panic!("a row of four cells, not {line}") };
        let imports = match imports {
            "nothing of ours" => BTreeSet::new(),
            "all of the above" => found.keys().cloned().collect(),
            "all" => continue,
            _ => imports.split(", ").map(|name| name.trim_matches('`').to_owned()).collect(),
        };
        found.insert(package.trim_matches('`').to_owned(), imports);
    }
    found
}

fn rules() -> BTreeMap<String, BTreeSet<String>> {
    may_import(include_str!("../../../ARCHITECTURE.md"))
}

/// Packages from outside that only some of ours may know.
const ONLY_IN: &[(&str, &[&str])] = &[
    ("gltf", &["flb-scene"]),
    ("memmap2", &["flb-runtime"]),
    ("object_store", &["flb-runtime"]),
    ("obvhs", &["flb-scene", "flb-render"]),
    ("rkyv", &["flb-baker"]),
    ("reqwest", &["flb-runtime"]),
    ("tokio", &["flb-runtime"]),
    ("pollster", &["flb-gpu", "flb-view", "flb-examples"]),
    // Opening it; the solver on it, light on it, pictures, and windows.
    ("wgpu", &["flb-gpu", "flb-transport", "flb-runtime", "flb-render-gpu", "flb-view", "flb-examples"]),
    ("egui", &["flb-view"]),
    ("winit", &["flb-view", "flb-examples"]),
];

fn metadata() -> Metadata {
    MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml"))
        .no_deps()
        .other_options(vec!["--offline".to_owned(), "--locked".to_owned()])
        .exec()
        .expect("cargo metadata works in a checkout that has just been built")
}

/// Per package, the names that it depends on in what it ships.
fn shipped_dependencies(metadata: &Metadata) -> BTreeMap<String, BTreeSet<String>> {
    let shipped = |package: &cargo_metadata::Package| {
        let normal = package.dependencies.iter().filter(|d| d.kind != DependencyKind::Development);
        (package.name.to_string(), normal.map(|d| d.name.clone()).collect())
    };
    metadata.workspace_packages().into_iter().map(shipped).collect()
}

/// Every breach of the rules, one sentence each.
fn breaches(dependencies: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let (rules, mut found) = (rules(), Vec::new());
    for (package, imports) in dependencies.iter().filter(|(package, _)| *package != "flb-tests") {
        let Some(allowed) = rules.get(package) else {
            found.push(format!("{package} has no row in ARCHITECTURE.md"));
            continue;
        };
        let ours = imports.iter().filter(|name| dependencies.contains_key(*name));
        found.extend(
            ours.filter(|name| !allowed.contains(*name)).map(|name| format!("{package} imports {name}")),
        );
        let outside = ONLY_IN
            .iter()
            .filter(|(name, owners)| imports.contains(*name) && !owners.contains(&package.as_str()));
        found.extend(outside.map(|(name, owners)| {
            format!("{package} imports {name}, which belongs to {}", owners.join(" and "))
        }));
    }
    found
}

#[test]
fn no_crate_imports_upward() {
    let dependencies = shipped_dependencies(&metadata());
    assert!(dependencies.contains_key("flb-format"), "found {dependencies:?}");
    assert_eq!(breaches(&dependencies), Vec::<String>::new());
}

#[test]
fn no_crate_ships_what_is_there_for_tests() {
    let dependencies = shipped_dependencies(&metadata());
    assert!(dependencies.contains_key("flb-testkit"), "found {dependencies:?}");
    let ship = dependencies.iter().filter(|(_, imports)| imports.contains("flb-testkit"));
    assert_eq!(ship.map(|(package, _)| package).collect::<Vec<_>>(), Vec::<&String>::new());
}

#[test]
fn the_table_of_rooms_is_read_whole() {
    let rules = rules();
    assert_eq!(rules["flb-format"], BTreeSet::new());
    assert!(
        rules["flb-stage"].contains("flb-render-gpu") && !rules["flb-stage"].contains("flb"),
        "{rules:?}"
    );
    assert!(rules["flb"].contains("flb-fixtures") && !rules["flb"].contains("flb"), "{rules:?}");
    let packages = shipped_dependencies(&metadata());
    let stray: Vec<_> =
        rules.keys().filter(|name| *name != "flb-fuzz" && !packages.contains_key(*name)).collect();
    assert_eq!(stray, Vec::<&String>::new(), "rows of packages that are not there");
    // No room imports one of its own floor or above.
    let mut below = BTreeSet::new();
    for floor in floors(include_str!("../../../ARCHITECTURE.md")) {
        for room in &floor {
            let allowed = &rules[room];
            assert!(
                allowed.iter().all(|name| below.contains(name) || name == "flb-fixtures"),
                "{room}: {allowed:?}"
            );
        }
        below.extend(floor);
    }
}

/// Packages by floor, the lowest first, as the drawing of rooms has them.
fn floors(architecture: &str) -> Vec<Vec<String>> {
    let folders: BTreeMap<&str, &str> = architecture
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once("/` | `"))
        .filter_map(|(folder, rest)| Some((folder, rest.split_once('`')?.0)))
        .collect();
    let drawn = architecture.lines().filter_map(|line| line.strip_prefix("floor "));
    let mut found: Vec<Vec<String>> = drawn
        .map(|line| line.split_whitespace().skip(1).map(|folder| folders[folder].to_owned()).collect())
        .collect();
    found.reverse();
    assert_eq!(found.len(), 7, "{found:?}");
    found
}

#[test]
fn a_planted_upward_import_is_found() {
    let mut dependencies = shipped_dependencies(&metadata());
    dependencies.get_mut("flb-format").expect("exists").insert("flb-baker".to_owned());
    dependencies.get_mut("flb-packer").expect("exists").insert("gltf".to_owned());
    dependencies.get_mut("flb-render").expect("exists").insert("wgpu".to_owned());
    assert_eq!(
        breaches(&dependencies),
        [
            "flb-format imports flb-baker",
            "flb-packer imports gltf, which belongs to flb-scene",
            "flb-render imports wgpu, which belongs to flb-gpu and flb-transport and flb-runtime and flb-render-gpu and flb-view and flb-examples"
        ]
    );
}

/// Files of a crate by the path of their module, those of tests left out.
fn modules(source: &Path) -> BTreeMap<Vec<String>, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![source.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the checkout") {
            let path = entry.expect("an entry of it").path();
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            if stem == "tests" {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let within = folder.strip_prefix(source).expect("it lies below").iter();
                let mut module: Vec<String> =
                    within.map(|part| part.to_string_lossy().into_owned()).collect();
                if !(module.is_empty() && (stem == "lib" || stem == "main")) {
                    module.push(stem);
                }
                found.insert(module, std::fs::read_to_string(&path).expect("a text"));
            }
        }
    }
    found
}

/// The paths of a `use`, its braces taken apart.
pub(crate) fn paths(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((before, inside)) = tree.strip_suffix('}').and_then(|tree| tree.split_once('{')) else {
        return vec![tree.split(" as ").next().unwrap_or_default().trim().to_owned()];
    };
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in inside.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        match c {
            ',' if depth == 0 => parts.push(String::new()),
            c => parts.last_mut().expect("one at least").push(c),
        }
    }
    let parts = parts.iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(|part| paths(part)).map(|path| format!("{before}{path}")).collect()
}

/// The modules that a module's `use`s lead to; neither those above it nor those below.
fn uses(module: &[String], text: &str, all: &BTreeMap<Vec<String>, String>) -> BTreeSet<Vec<String>> {
    let shipped = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let mut found = BTreeSet::new();
    for statement in shipped.split(';') {
        let Some(at) = statement.find("use ").filter(|at| {
            let before = statement[..*at].trim_end_matches("pub ").trim_end_matches("pub(super) ");
            before.trim_end_matches("pub(crate) ").ends_with(['\n', ' ']) || before.is_empty()
        }) else {
            continue;
        };
        for path in paths(&statement[at + 4..]) {
            let mut words = path.split("::").map(str::trim).peekable();
            let mut full = module.to_vec();
            match words.peek() {
                Some(&"crate") => full.clear(),
                Some(&"self" | &"super") => {}
                Some(word) if all.contains_key(&[module, &[(*word).to_owned()]].concat()) => {}
                // A crate.
                _ => continue,
            }
            for word in words {
                match word {
                    "crate" | "self" => {}
                    "super" => drop(full.pop()),
                    word => full.push(word.to_owned()),
                }
            }
            while !all.contains_key(&full) && full.pop().is_some() {}
            if !module.starts_with(&full) {
                found.insert(full);
            }
        }
    }
    found
}

/// Every set of modules of which each leads to all others, by their `use`s.
fn circles(all: &BTreeMap<Vec<String>, String>) -> Vec<Vec<String>> {
    let uses: BTreeMap<_, _> = all.iter().map(|(module, text)| (module, uses(module, text, all))).collect();
    let reach = |from: &Vec<String>| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(module) = open.pop() {
            open.extend(uses[&module].iter().filter(|next| seen.insert((*next).clone())).cloned());
        }
        seen
    };
    let reached: BTreeMap<_, _> = all.keys().map(|module| (module, reach(module))).collect();
    let mut found = BTreeSet::new();
    for (module, to) in &reached {
        if to.contains(*module) {
            let circle = to.iter().filter(|other| reached[*other].contains(*module));
            found.insert(circle.map(|module| module.join("::")).collect::<Vec<_>>());
        }
    }
    found.into_iter().collect()
}

/// A record knows its digest, and the digest is over records: taking them apart would cost more than it brings.
const MAY_CIRCLE: [&str; 2] = ["container::digest", "container::records"];

#[test]
fn no_file_imports_one_that_imports_it_back() {
    for package in metadata().workspace_packages() {
        let folder = package.manifest_path.parent().expect("a folder").join("src");
        if folder.exists() {
            let mut found = circles(&modules(folder.as_std_path()));
            found.retain(|circle| *circle != MAY_CIRCLE);
            assert_eq!(found, Vec::<Vec<String>>::new(), "{}", package.name);
        }
    }
}

#[test]
fn a_planted_circle_is_found() {
    let module = |name: &str, text: &str| (vec![name.to_owned()], text.to_owned());
    let all = BTreeMap::from([
        module("a", "use super::b::{c::D, E};\n"),
        module("b", "pub use crate::{f::G, h};\n"),
        module("f", "use std::fs;\nuse super::a;\n"),
        module("h", "#[cfg(test)]\nmod tests {\n    use super::super::b;\n}\n"),
        // Through a module below, by its name alone; a child may use what is above it.
        module("p", "mod q;\nuse q::R;\n"),
        (vec!["p".to_owned(), "q".to_owned()], "use super::S;\nuse crate::t::U;\n".to_owned()),
        module("t", "use crate::p::V;\n"),
    ]);
    assert_eq!(circles(&all), [vec!["a", "b", "f"], vec!["p", "p::q", "t"]]);
}
