//! The commit that a build is of, from the files of git: no program is called, and a source archive has none.
//!
//! ```text
//! .git -HEAD, or through `gitdir:` of a worktree-> ref -loose or packed-> hash
//! ```
//!
//! `build.rs` includes this file; the command itself holds only what it found.

use std::fs;
use std::path::{Path, PathBuf};

/// Digits of a hash that are told.
const DIGITS: usize = 12;

/// What was found, and the files that it depends on.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Commit {
    /// `None` in a source archive.
    pub hash: Option<String>,
    /// A change of one of them can be another commit. All of them exist: cargo takes a missing one for a change.
    pub watched: Vec<PathBuf>,
}

impl Commit {
    /// One line for `--version`.
    pub(crate) fn text(&self) -> String {
        match &self.hash {
            Some(hash) => format!("commit {hash}"),
            None => "unknown commit".to_owned(),
        }
    }
}

/// The commit that was given, else the one that `git` (a folder, or a file that names one) is at.
pub(crate) fn find(given: Option<&str>, git: &Path) -> Commit {
    // A line of its own is all that goes on: no control characters, no blanks.
    let is_one_word =
        |text: &&str| (1..=64).contains(&text.len()) && text.chars().all(|c| c.is_ascii_graphic());
    if let Some(given) = given.map(str::trim).filter(is_one_word) {
        return Commit { hash: Some(given.to_owned()), watched: Vec::new() };
    }
    let mut found = Commit::default();
    let hash = look(git, &mut found.watched);
    found.hash = hash.map(|hash| hash[..DIGITS].to_owned());
    found
}

fn look(git: &Path, watched: &mut Vec<PathBuf>) -> Option<String> {
    // A worktree has a file that names its folder, and there a file that names what all worktrees share.
    let folder = match fs::read_to_string(git) {
        Ok(text) => git.parent()?.join(text.strip_prefix("gitdir:")?.trim()),
        Err(_) => git.to_owned(),
    };
    let shared = fs::read_to_string(folder.join("commondir"));
    let shared = shared.map_or_else(|_| folder.clone(), |path| folder.join(path.trim()));
    let head = read(&folder.join("HEAD"), watched)?;
    let Some(name) = head.trim().strip_prefix("ref:").map(str::trim) else { return hash(&head) };
    for place in [&folder, &shared] {
        if let Some(text) = read(&place.join(name), watched) {
            return hash(&text);
        }
    }
    // The next commit writes a file of its own, here or in a folder that is made for it.
    let above = shared.join(name).ancestors().find(|path| path.is_dir()).map(Path::to_owned);
    watched.extend(above);
    let packed = read(&shared.join("packed-refs"), watched)?;
    packed.lines().find_map(|line| line.strip_suffix(name)?.strip_suffix(' ').and_then(hash))
}

/// A file that is there is watched.
fn read(path: &Path, watched: &mut Vec<PathBuf>) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    watched.push(path.to_owned());
    Some(text)
}

/// SHA-1 or SHA-256.
fn hash(text: &str) -> Option<String> {
    let text = text.trim();
    let is_hash = [40, 64].contains(&text.len()) && text.chars().all(|c| c.is_ascii_hexdigit());
    is_hash.then(|| text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const OLD: &str = "0123456789abcdef0123456789abcdef01234567";
    const NEW: &str = "89abcdef0123456789abcdef0123456789abcdef";

    fn write(root: &Path, files: &[(&str, &str)]) {
        for (path, text) in files {
            let path = root.join(path);
            fs::create_dir_all(path.parent().expect("it lies in the root")).expect("the folder is writable");
            fs::write(path, text).expect("the folder is writable");
        }
    }

    fn found(files: &[(&str, &str)]) -> (Option<String>, Vec<String>) {
        let root = tempfile::tempdir().expect("a folder");
        write(root.path(), files);
        let found = find(None, &root.path().join("tree/.git"));
        assert!(found.watched.iter().all(|path| path.exists()), "{:?}", found.watched);
        let name = |path: &PathBuf| path.file_name().expect("a name").to_string_lossy().into_owned();
        (found.hash, found.watched.iter().map(name).collect())
    }

    fn is(hash: &str, watched: &[&str], files: &[(&str, &str)]) {
        let watched = watched.iter().map(|name| (*name).to_owned()).collect();
        assert_eq!(found(files), (Some(hash[..DIGITS].to_owned()), watched), "{files:?}");
    }

    #[test]
    fn a_checkout_is_at_the_ref_that_head_names() {
        let head = ("tree/.git/HEAD", "ref: refs/heads/a/b\n");
        let packed =
            format!("# pack-refs with: peeled\n{NEW} refs/heads/x/a/b\n{OLD} refs/heads/a/b\n^{NEW}\n");
        let packed = ("tree/.git/packed-refs", packed.as_str());
        let new = format!("{NEW}\n");
        let loose = ("tree/.git/refs/heads/a/b", new.as_str());
        is(NEW, &["HEAD", "b"], &[head, packed, loose]);
        // As after a clone: nothing but the folder of refs says that a commit came.
        is(OLD, &["HEAD", "heads", "packed-refs"], &[head, packed, ("tree/.git/refs/heads/main", OLD)]);
        // A shallow clone differs in a file that is not looked at.
        is(NEW, &["HEAD", "b"], &[head, loose, ("tree/.git/shallow", OLD)]);
        is(OLD, &["HEAD"], &[("tree/.git/HEAD", OLD), loose]);
    }

    #[test]
    fn a_worktree_is_at_its_own_head() {
        let new = format!("{NEW}\n");
        let files = [
            ("tree/.git", "gitdir: ../main/.git/worktrees/tree\n"),
            ("main/.git/HEAD", "ref: refs/heads/main\n"),
            ("main/.git/refs/heads/main", OLD),
            ("main/.git/refs/heads/side", new.as_str()),
            ("main/.git/worktrees/tree/HEAD", "ref: refs/heads/side\n"),
            ("main/.git/worktrees/tree/commondir", "../..\n"),
        ];
        is(NEW, &["HEAD", "side"], &files);
    }

    #[test]
    fn a_source_archive_and_a_folder_that_is_no_repository_have_none() {
        assert_eq!(found(&[("tree/Cargo.toml", "")]), (None, Vec::new()));
        assert_eq!(found(&[("tree/.git", "no link\n")]).0, None);
        assert_eq!(found(&[("tree/.git/HEAD", "garbage\n")]).0, None);
        assert_eq!(found(&[("tree/.git/HEAD", "ref: refs/heads/none\n")]).0, None);
        assert_eq!(Commit::default().text(), "unknown commit");
    }

    #[test]
    fn what_is_given_goes_first_if_it_is_one_word() {
        let root = tempfile::tempdir().expect("a folder");
        write(root.path(), &[(".git/HEAD", OLD)]);
        let git = root.path().join(".git");
        assert_eq!(find(Some(" v0.1.0-debian1\n"), &git).text(), "commit v0.1.0-debian1");
        for none in ["", " ", "two words", "a\nb", "\u{1b}[31m"] {
            assert_eq!(find(Some(none), &git).text(), format!("commit {}", &OLD[..DIGITS]), "{none:?}");
        }
    }
}
