//! No crate imports upward: the table of rooms in ARCHITECTURE.md, held against `cargo metadata`.

use std::collections::{BTreeMap, BTreeSet};

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
    may_import(include_str!("../../ARCHITECTURE.md"))
}

/// Packages from outside that only some of ours may know.
const ONLY_IN: &[(&str, &[&str])] = &[
    ("gltf", &["flb-scene"]),
    ("memmap2", &["flb-runtime"]),
    ("object_store", &["flb-runtime"]),
    ("obvhs", &["flb-render"]),
    ("rkyv", &["flb-baker"]),
    ("reqwest", &["flb-runtime"]),
    ("tokio", &["flb-runtime"]),
    ("pollster", &["flb-gpu", "flb-view"]),
    // Opening it; the solver on it, light on it, pictures, and a window.
    ("wgpu", &["flb-gpu", "flb-transport", "flb-runtime", "flb-render-gpu", "flb-view"]),
    ("egui", &["flb-view"]),
    ("winit", &["flb-view"]),
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
fn the_table_of_rooms_is_read_whole() {
    let rules = rules();
    assert_eq!(rules["flb-format"], BTreeSet::new());
    assert!(rules["flb-view"].contains("flb-render-gpu") && !rules["flb-view"].contains("flb"), "{rules:?}");
    assert!(rules["flb"].contains("flb-fixtures") && !rules["flb"].contains("flb"), "{rules:?}");
    let packages = shipped_dependencies(&metadata());
    let stray: Vec<_> =
        rules.keys().filter(|name| *name != "flb-fuzz" && !packages.contains_key(*name)).collect();
    assert_eq!(stray, Vec::<&String>::new(), "rows of packages that are not there");
    // No room imports one of its own floor or above.
    let mut below = BTreeSet::new();
    for floor in floors(include_str!("../../ARCHITECTURE.md")) {
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
    assert_eq!(found.len(), 6, "{found:?}");
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
            "flb-render imports wgpu, which belongs to flb-gpu and flb-transport and flb-runtime and flb-render-gpu and flb-view"
        ]
    );
}
