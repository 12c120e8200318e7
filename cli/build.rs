//! Tells the compiler what `flb --version` says: the commit, the features, the target and the profile.
//!
//! It runs again where the commit changes, not at every build: it looks at `HEAD`, the ref that it names and
//! `packed-refs`. No other crate learns of the commit, and no file that `flb` writes holds it.

use std::env;
use std::path::Path;

#[path = "src/commit.rs"]
mod commit;

/// The variable whose value goes first, for packagers.
const VARIABLE: &str = "FLB_COMMIT";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/commit.rs");
    println!("cargo::rerun-if-env-changed={}", VARIABLE);
    let given = env::var(VARIABLE).ok();
    let folder = env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let found = commit::find(given.as_deref(), &Path::new(&folder).join("../.git"));
    for path in &found.watched {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    println!("cargo::rustc-env=FLB_BUILT_COMMIT={}", found.text());

    let mut features: Vec<String> = env::vars()
        .filter_map(|(name, _)| Some(name.strip_prefix("CARGO_FEATURE_")?.to_lowercase().replace('_', "-")))
        .filter(|name| name != "default")
        .collect();
    features.sort_unstable();
    let features = if features.is_empty() { "none".to_owned() } else { features.join(", ") };
    println!("cargo::rustc-env=FLB_BUILT_FEATURES={features}");
    println!("cargo::rustc-env=FLB_BUILT_TARGET={}", env::var("TARGET").expect("cargo sets it"));
    println!("cargo::rustc-env=FLB_BUILT_PROFILE={}", profile());
}

/// The name of the profile: `OUT_DIR` is `PROFILE/build/PACKAGE/out`. Where it is not, the one that it inherits from.
fn profile() -> String {
    let out = env::var("OUT_DIR").expect("cargo sets it");
    let name = |above: usize| Some(Path::new(&out).ancestors().nth(above)?.file_name()?.to_str()?.to_owned());
    let inherited = env::var("PROFILE").expect("cargo sets it");
    if name(2).as_deref() == Some("build") { name(3).unwrap_or(inherited) } else { inherited }
}
