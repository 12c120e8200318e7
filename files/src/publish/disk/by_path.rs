//! A folder by its path, where there are no folders by handle.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use super::{A_LINK, Found};
use crate::guard::{self, Id};

pub(super) struct Handle {
    folder: PathBuf,
}

impl Handle {
    pub(super) fn open(folder: &Path) -> io::Result<Handle> {
        match fs::metadata(folder)?.is_dir() {
            true => Ok(Handle { folder: folder.to_owned() }),
            false => Err(io::ErrorKind::NotADirectory.into()),
        }
    }

    pub(super) fn replaces(&mut self, name: &OsStr) -> io::Result<Option<Found>> {
        let found = match fs::symlink_metadata(self.folder.join(name)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            found => found?,
        };
        let other_kind = match found.file_type() {
            kind if kind.is_file() => None,
            kind if kind.is_dir() => Some("a folder"),
            kind if kind.is_symlink() => Some(A_LINK),
            _ => Some("a pipe, socket or device"),
        };
        let id = guard::id(&self.folder.join(name), &found);
        Ok(Some(Found { id, other_kind, read_only: found.permissions().readonly().then_some(0o444) }))
    }

    /// Which file has a name now.
    pub(super) fn id(&self, name: &OsStr) -> io::Result<Option<Id>> {
        let path = self.folder.join(name);
        match fs::symlink_metadata(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            found => Ok(guard::id(&path, &found?)),
        }
    }

    pub(super) fn create(&self, name: &OsStr) -> io::Result<File> {
        OpenOptions::new().read(true).write(true).create_new(true).open(self.folder.join(name))
    }

    pub(super) fn takes_unnamed_file(&self) -> io::Result<bool> {
        Ok(false)
    }

    pub(super) fn open_existing(&self, name: &OsStr) -> io::Result<File> {
        OpenOptions::new().read(true).write(true).open(self.folder.join(name))
    }

    /// An open file keeps its name here.
    pub(super) fn is_named(&self, _file: &File, name: &OsStr) -> io::Result<bool> {
        fs::exists(self.folder.join(name))
    }

    pub(super) fn rename(&self, from: &OsStr, to: &OsStr) -> io::Result<()> {
        fs::rename(self.folder.join(from), self.folder.join(to))
    }

    pub(super) fn rename_new(&self, from: &OsStr, to: &OsStr) -> io::Result<()> {
        fs::hard_link(self.folder.join(from), self.folder.join(to))?;
        self.remove(from)
    }

    pub(super) fn remove(&self, name: &OsStr) -> io::Result<()> {
        fs::remove_file(self.folder.join(name))
    }

    pub(super) fn names(&self, most: usize, wanted: impl Fn(&OsStr) -> bool) -> io::Result<Vec<OsString>> {
        let names = fs::read_dir(&self.folder)?.map_while(Result::ok).map(|entry| entry.file_name());
        Ok(names.filter(|name| wanted(name)).take(most).collect())
    }

    /// Only Unix flushes folders.
    pub(super) fn sync(&self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn files_of_a_folder_by_path_are_made_renamed_and_removed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut handle = Handle::open(folder.path()).expect("a folder");
        let [a, b, c] = ["a", "b", "c"].map(OsStr::new);
        handle.create(a).and_then(|mut file| file.write_all(b"a")).expect("a new file");
        assert_eq!(handle.create(a).expect_err("it is there").kind(), io::ErrorKind::AlreadyExists);
        handle.rename_new(a, b).expect("a new name");
        handle.create(a).expect("its name is free");
        assert_eq!(handle.rename_new(a, b).expect_err("there is one").kind(), io::ErrorKind::AlreadyExists);
        handle.rename(b, a).expect("it is replaced");
        assert_eq!(handle.names(9, |_| true).expect("a list"), ["a"]);
        assert!(handle.names(0, |_| true).expect("a list").is_empty());
        let file = handle.open_existing(a).expect("it is there");
        assert!(handle.is_named(&file, a).expect("it can be asked") && !handle.is_named(&file, b).unwrap());
        assert!(handle.replaces(b).expect("it can be asked").is_none());
        let found = handle.replaces(a).expect("it can be asked").expect("it is there");
        assert!(found.other_kind.is_none() && found.read_only.is_none());
        assert_eq!((handle.id(a).expect("it can be asked"), handle.id(b).unwrap()), (found.id, None));
        fs::create_dir(folder.path().join("c")).expect("a folder");
        let found = handle.replaces(c).expect("it can be asked").expect("it is there");
        assert_eq!(found.other_kind, Some("a folder"));
        assert!(!handle.takes_unnamed_file().expect("it can be asked"));
        handle.sync().and_then(|()| handle.remove(a)).expect("it is removed");
        assert!(Handle::open(&folder.path().join("none")).is_err());
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }
}
