//! What a file is that is none of those that are read, by its first bytes: what a person who downloads and clones
//! meshes finds in their place.

/// First bytes, in lower case where they are letters, and what begins with them.
const KINDS: [(&[u8], &str); 9] = [
    (b"version https://git-lfs", "a Git LFS pointer in place of the file (git lfs pull fetches it)"),
    (b"pk\x03\x04", "a ZIP archive"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"7z\xbc\xaf", "a 7z archive"),
    (b"rar!", "a RAR archive"),
    (b"<!doctype html", "an HTML page"),
    (b"<html", "an HTML page"),
    (b"kaydara fbx", "an FBX"),
    (b"blender", "a Blender file"),
];

/// Bytes that tell.
pub(super) const LENGTH: usize = 32;

/// The kind of a file, if it is one of these.
pub(super) fn kind_of(start: &[u8]) -> Option<&'static str> {
    let lower: Vec<u8> = start.iter().take(LENGTH).map(u8::to_ascii_lowercase).collect();
    KINDS.iter().find(|(first, _)| lower.starts_with(first)).map(|(_, kind)| *kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_in_place_of_others_are_known() {
        assert!(
            kind_of(b"version https://git-lfs.github.com/spec/v1\n").is_some_and(|kind| kind.contains("LFS"))
        );
        assert_eq!(kind_of(b"<!DOCTYPE html><html>"), Some("an HTML page"));
        assert_eq!(kind_of(b"PK\x03\x04\x14"), Some("a ZIP archive"));
        for other in [&b"glTF"[..], b"# obj", b"v 0 0 0", b"", b"{\"asset\""] {
            assert_eq!(kind_of(other), None);
        }
    }
}
