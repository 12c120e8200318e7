//! No crate imports upward: the rules of ARCHITECTURE.md, checked against `cargo metadata`.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand};

/// What each of our packages may depend on, of ours. Dev-dependencies are free: they ship nothing.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("flb-format", &[]),
    ("flb-files", &[]),
    ("flb-gpu", &[]),
    ("flb-scene", &["flb-files", "flb-format"]),
    ("flb-transport", &["flb-format", "flb-gpu"]),
    ("flb-baker", &["flb-format", "flb-scene", "flb-transport"]),
    ("flb-packer", &["flb-files", "flb-format"]),
    ("flb-inspector", &["flb-format"]),
    ("flb-runtime", &["flb-files", "flb-format", "flb-gpu"]),
    ("flb-render", &["flb-format", "flb-scene"]),
    ("flb-view", &["flb-format", "flb-gpu", "flb-runtime", "flb-render", "flb-render-gpu"]),
    ("flb-render-gpu", &["flb-format", "flb-scene", "flb-gpu", "flb-render", "flb-runtime"]),
    ("flb-fixtures", &["flb-format"]),
    // `flb grow` is a product feature, so the command alone may import the plants.
    (
        "flb",
        &[
            "flb-files",
            "flb-format",
            "flb-scene",
            "flb-transport",
            "flb-baker",
            "flb-packer",
            "flb-inspector",
            "flb-runtime",
            "flb-gpu",
            "flb-render",
            "flb-render-gpu",
            "flb-view",
            "flb-fixtures",
        ],
    ),
];

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
    let mut found = Vec::new();
    for (package, imports) in dependencies.iter().filter(|(package, _)| *package != "flb-tests") {
        let Some((_, allowed)) = MAY_IMPORT.iter().find(|(name, _)| name == package) else {
            found.push(format!("{package} has no rule in MAY_IMPORT"));
            continue;
        };
        let ours = imports.iter().filter(|name| dependencies.contains_key(*name));
        found.extend(
            ours.filter(|name| !allowed.contains(&name.as_str()))
                .map(|name| format!("{package} imports {name}")),
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
