//! `flb --version` tells one build from another, and no file that `flb` writes does.

use crate::flb::Folder;

#[test]
fn the_long_version_names_commit_features_target_and_profile() {
    let folder = Folder::new();
    let short = folder.flb(&["-V"]).expect_code(0).stdout;
    assert_eq!(short, concat!("flb ", env!("CARGO_PKG_VERSION"), "\n"));
    let long = folder.flb(&["--version"]).expect_code(0).stdout;
    let lines: Vec<&str> = long.lines().collect();
    let [version, commit, features, target, profile] = lines[..] else { panic!("five lines, not {long}") };
    assert_eq!(version, short.trim_end());
    assert!(
        commit == "unknown commit" || commit.strip_prefix("commit ").is_some_and(|id| !id.is_empty()),
        "{long}"
    );
    for (feature, is_on) in [
        ("gpu", cfg!(feature = "gpu")),
        ("remote", cfg!(feature = "remote")),
        ("view", cfg!(feature = "view")),
    ] {
        let listed = features.strip_prefix("features ").expect(&long).split(", ");
        assert_eq!(listed.filter(|name| *name == feature).count(), usize::from(is_on), "{long}");
    }
    assert!(target.starts_with("target ") && target.contains(std::env::consts::ARCH), "{long}");
    assert!(profile.strip_prefix("profile ").is_some_and(|name| !name.is_empty()), "{long}");
}

#[test]
fn no_file_holds_the_commit() {
    let folder = Folder::with_card();
    let long = folder.flb(&["--version"]).expect_code(0).stdout;
    let Some(commit) = long.lines().find_map(|line| line.strip_prefix("commit ")) else { return };
    // Seven digits would be enough to name it.
    let sought = &commit.as_bytes()[..commit.len().min(7)];
    let bytes = folder.read("card.flb");
    assert!(!bytes.windows(sought.len()).any(|window| window == sought), "{commit} is in card.flb");
    let info = folder.flb(&["info", "card.flb", "--json"]).expect_code(0).stdout;
    assert!(info.contains(concat!("flb ", env!("CARGO_PKG_VERSION"))) && !info.contains(commit), "{info}");
}
