//! Files that a pattern matches.

use std::path::{Component, Path, PathBuf};

use globset::GlobBuilder;

/// Files and folders that a pattern may be tried on.
const MAX_LOOKED_AT: usize = 1 << 20;

/// Whether a name is a pattern.
pub(crate) fn is_pattern(name: &str) -> bool {
    name.contains(['*', '?', '[', '{'])
}

/// Files below `folder` that match, by name. `*` and `?` match within a name, `**` matches folders. Links to folders
/// are not followed.
pub(crate) fn files(folder: &Path, pattern: &str) -> Result<Vec<PathBuf>, String> {
    let matcher = GlobBuilder::new(pattern).literal_separator(true).build();
    let matcher = matcher.map_err(|error| format!("{pattern:?}: {}", error.kind()))?.compile_matcher();
    // Folders in front that are no pattern are where the search begins.
    let parts: Vec<Component> = Path::new(pattern).components().collect();
    let is_plain = |part: &&Component| !is_pattern(&part.as_os_str().to_string_lossy());
    let plain: PathBuf = parts.iter().take_while(is_plain).collect();
    let depth = match pattern.contains("**") {
        true => usize::MAX,
        false => parts.len() - plain.components().count(),
    };
    let mut search = Search { found: Vec::new(), looked_at: 0 };
    search
        .look(folder, &plain, depth, &|path| matcher.is_match(path))
        .map_err(|error| format!("{pattern:?}: {error}"))?;
    search.found.sort();
    Ok(search.found.into_iter().map(|path| folder.join(path)).collect())
}

struct Search {
    found: Vec<PathBuf>,
    looked_at: usize,
}

impl Search {
    fn look(
        &mut self,
        folder: &Path,
        below: &Path,
        depth: usize,
        is_match: &dyn Fn(&Path) -> bool,
    ) -> Result<(), String> {
        let at = folder.join(below);
        let at = if at.as_os_str().is_empty() { Path::new(".") } else { &at };
        let entries = match std::fs::read_dir(at) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(format!("{}: {error}", at.display())),
        };
        for entry in entries {
            let entry = entry.map_err(|error| format!("{}: {error}", at.display()))?;
            self.looked_at += 1;
            if self.looked_at > MAX_LOOKED_AT {
                return Err(format!("more than {MAX_LOOKED_AT} files and folders to look at"));
            }
            let path = below.join(entry.file_name());
            let Ok(kind) = entry.file_type() else { continue };
            if kind.is_dir() && depth > 1 {
                self.look(folder, &path, depth - 1, is_match)?;
            } else if !kind.is_dir() && is_match(&path) && folder.join(&path).is_file() {
                self.found.push(path);
            }
        }
        Ok(())
    }
}
