//! A folder by its file descriptor (Unix): what its path leads to may change, the folder does not.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use rustix::fd::OwnedFd;
use rustix::fs::{
    Access, AtFlags, Dir, FileType, Gid, Mode, OFlags, RawMode, RenameFlags, Stat, Uid, XattrFlags, accessat,
    fchmod, fchown, fgetxattr, fremovexattr, fsetxattr, fstat, fsync, linkat, open, openat, renameat,
    renameat_with, statat, unlinkat,
};
use rustix::io::{Errno, retry_on_intr};

use super::{A_LINK, Found};
use crate::guard::Id;

/// Of a new file, less the umask.
const NEW_MODE: RawMode = 0o666;
/// Linux keeps the access list of a file under this name.
const ACCESS_LIST: &str = "system.posix_acl_access";
/// Bytes of an access list; longer ones are not kept.
const MAX_ACCESS_LIST_BYTES: usize = 4096;
const ANY_WRITE: RawMode = 0o222;

pub(super) struct Handle {
    folder: OwnedFd,
    /// What is replaced, and its access list.
    replaced: Option<(Stat, Option<Vec<u8>>)>,
}

impl Handle {
    pub(super) fn open(folder: &Path) -> io::Result<Handle> {
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
        Ok(Handle { folder: retry_on_intr(|| open(folder, flags, Mode::empty()))?, replaced: None })
    }

    pub(super) fn replaces(&mut self, name: &OsStr) -> io::Result<Option<Found>> {
        let stat = match statat(&self.folder, name, AtFlags::SYMLINK_NOFOLLOW) {
            Err(Errno::NOENT) => return Ok(None),
            found => found?,
        };
        let id = Some(id_of(&stat));
        let other_kind = match FileType::from_raw_mode(stat.st_mode) {
            FileType::RegularFile => None,
            FileType::Directory => Some("a folder"),
            FileType::Symlink => Some(A_LINK),
            _ => Some("a pipe, socket or device"),
        };
        let mode: RawMode = stat.st_mode & 0o7777;
        let other_kind = match fstat(&self.folder)?.st_dev == stat.st_dev {
            false if other_kind.is_none() => Some("mounted there from elsewhere"),
            _ => other_kind,
        };
        let may_write = match accessat(&self.folder, name, Access::WRITE_OK, AtFlags::EACCESS) {
            // Asked of a link, it says what that leads to.
            Err(Errno::ROFS) if other_kind.is_none() => return Err(Errno::ROFS.into()),
            access => access.is_ok(),
        };
        // Root may write anything; a file that no one may write says that it is to stay all the same.
        let is_open = mode & ANY_WRITE != 0 && (other_kind.is_some() || may_write);
        let read_only = (!is_open).then_some(mode as _);
        if other_kind.is_none() {
            let access_list = self.access_list(name);
            self.replaced = Some((stat, access_list));
        }
        Ok(Some(Found { id, other_kind, read_only }))
    }

    /// Which file has a name now; of a link, the link.
    pub(super) fn id(&self, name: &OsStr) -> io::Result<Option<Id>> {
        match statat(&self.folder, name, AtFlags::SYMLINK_NOFOLLOW) {
            Err(Errno::NOENT) => Ok(None),
            found => Ok(Some(id_of(&found?))),
        }
    }

    fn access_list(&self, name: &OsStr) -> Option<Vec<u8>> {
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let file = openat(&self.folder, name, flags, Mode::empty()).ok()?;
        let mut list = vec![0; MAX_ACCESS_LIST_BYTES];
        let length = fgetxattr(&file, ACCESS_LIST, &mut list[..]).ok()?;
        list.truncate(length);
        Some(list)
    }

    pub(super) fn create(&self, name: &OsStr) -> io::Result<File> {
        let mode = match &self.replaced {
            // Whole only below: nothing of a private file is ever readable by others.
            Some((stat, _)) => Mode::from_raw_mode(stat.st_mode & 0o600),
            None => Mode::from_raw_mode(NEW_MODE),
        };
        let flags = OFlags::RDWR | OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let mode = mode | Mode::WUSR | Mode::RUSR;
        let file = retry_on_intr(|| openat(&self.folder, name, flags, mode))?;
        if let Some((replaced, access_list)) = &self.replaced
            && let Err(error) = adopt(&file, replaced, access_list.as_deref())
        {
            let _ = self.remove(name);
            return Err(error);
        }
        Ok(file.into())
    }

    #[cfg(target_os = "linux")]
    pub(super) fn takes_unnamed_file(&self) -> io::Result<bool> {
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        match retry_on_intr(|| openat(&self.folder, ".", flags, Mode::RUSR | Mode::WUSR)) {
            Ok(_) => Ok(true),
            Err(Errno::OPNOTSUPP | Errno::ISDIR | Errno::INVAL | Errno::NOENT) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }

    #[cfg(not(target_os = "linux"))]
    pub fn takes_unnamed_file(&self) -> io::Result<bool> {
        Ok(false)
    }

    pub(super) fn open_existing(&self, name: &OsStr) -> io::Result<File> {
        // For a lock; some file systems lock only what is open for writing.
        let flags = OFlags::RDWR | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        Ok(retry_on_intr(|| openat(&self.folder, name, flags, Mode::empty()))?.into())
    }

    pub(super) fn is_named(&self, file: &File, name: &OsStr) -> io::Result<bool> {
        let open = fstat(file)?;
        match statat(&self.folder, name, AtFlags::SYMLINK_NOFOLLOW) {
            Err(Errno::NOENT) => Ok(false),
            named => named
                .map(|named| (named.st_dev, named.st_ino) == (open.st_dev, open.st_ino))
                .map_err(Into::into),
        }
    }

    pub(super) fn rename(&self, from: &OsStr, to: &OsStr) -> io::Result<()> {
        Ok(retry_on_intr(|| renameat(&self.folder, from, &self.folder, to))?)
    }

    pub(super) fn rename_new(&self, from: &OsStr, to: &OsStr) -> io::Result<()> {
        match retry_on_intr(|| renameat_with(&self.folder, from, &self.folder, to, RenameFlags::NOREPLACE)) {
            // A file system that cannot: a second name, which fails where there is one, and then the first goes.
            Err(Errno::INVAL | Errno::NOSYS | Errno::NOTSUP) => {
                linkat(&self.folder, from, &self.folder, to, AtFlags::empty())?;
                Ok(unlinkat(&self.folder, from, AtFlags::empty())?)
            }
            renamed => Ok(renamed?),
        }
    }

    pub(super) fn remove(&self, name: &OsStr) -> io::Result<()> {
        Ok(retry_on_intr(|| unlinkat(&self.folder, name, AtFlags::empty()))?)
    }

    pub(super) fn names(&self, most: usize, wanted: impl Fn(&OsStr) -> bool) -> io::Result<Vec<OsString>> {
        let entries = Dir::read_from(&self.folder)?;
        // What cannot be listed is not removed.
        let names = entries.map_while(Result::ok);
        let names = names.map(|entry| OsStr::from_bytes(entry.file_name().to_bytes()).to_owned());
        let names = names.filter(|name| name != "." && name != ".." && wanted(name));
        Ok(names.take(most).collect())
    }

    pub(super) fn sync(&self) -> io::Result<()> {
        Ok(retry_on_intr(|| fsync(&self.folder))?)
    }
}

/// As [`guard::id`](crate::guard::id) of the same file.
fn id_of(stat: &Stat) -> Id {
    (stat.st_dev as _, stat.st_ino as _)
}

/// Gives a new file the owner, group, mode and access list of the one that it will replace. An owner or group that we
/// may not give is not given; the rights of the group are then no more than those of all others.
fn adopt(file: &OwnedFd, replaced: &Stat, access_list: Option<&[u8]>) -> io::Result<()> {
    let now = fstat(file)?;
    let mut mode: RawMode = replaced.st_mode & 0o7777;
    if now.st_uid != replaced.st_uid && fchown(file, Some(Uid::from_raw(replaced.st_uid)), None).is_err() {
        mode &= 0o1777; // it would run as us
    }
    let mut access_list = access_list;
    if now.st_gid != replaced.st_gid && fchown(file, None, Some(Gid::from_raw(replaced.st_gid))).is_err() {
        mode = narrowed(mode);
        access_list = None;
    }
    // A list that the folder gives to new files may let in others than the file that is replaced does.
    let is_bare = matches!(fremovexattr(file, ACCESS_LIST), Ok(()) | Err(Errno::NODATA | Errno::NOTSUP));
    let is_listed =
        access_list.is_some_and(|list| fsetxattr(file, ACCESS_LIST, list, XattrFlags::empty()).is_ok());
    if !is_bare || (access_list.is_some() && !is_listed) {
        // The rights of the group were the most that the list could give, and mean something else without it.
        mode = narrowed(mode);
    }
    Ok(fchmod(file, Mode::from_raw_mode(mode))?)
}

/// A mode whose group may do no more than all others.
fn narrowed(mode: RawMode) -> RawMode {
    mode & 0o5707 | ((mode >> 3) & mode & 0o7) << 3
}
