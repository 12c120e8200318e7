use std::fs;
use std::io::{self, Write};

use super::*;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn names(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).expect("it can be listed");
    let mut names: Vec<_> =
        names.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_new_file_appears_whole_and_nothing_else_does() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    publish(&path, Existing::Keep, |out| out.write_all(b"whole")).expect("it is written");
    assert_eq!(fs::read(&path).expect("it is there"), b"whole");
    assert_eq!(names(folder.path()), ["a.flb"]);
}

#[test]
fn a_failed_write_leaves_the_old_file_and_no_rubbish() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    fs::write(&path, b"old").expect("writable");
    let full = |out: &mut dyn Write| {
        out.write_all(b"half")?;
        Err(io::Error::from(io::ErrorKind::StorageFull))
    };
    let error = publish(&path, Existing::Replace, full).expect_err("the disk is full");
    assert!(error.to_string().starts_with(&format!("cannot write {}: ", path.display())), "{error}");
    assert_eq!(fs::read(&path).expect("it is there"), b"old");
    assert_eq!(names(folder.path()), ["a.flb"]);
}

#[test]
fn an_existing_file_is_replaced_only_by_force() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    fs::write(&path, b"old").expect("writable");
    let error = publish(&path, Existing::Keep, |out| out.write_all(b"new")).expect_err("it exists");
    assert_eq!(error.to_string(), format!("{}: exists already; use --force to overwrite it", path.display()));
    assert_eq!(fs::read(&path).expect("it is there"), b"old");
    publish(&path, Existing::Replace, |out| out.write_all(b"new")).expect("force");
    assert_eq!(fs::read(&path).expect("it is there"), b"new");
}

#[test]
fn a_file_that_appears_during_the_write_is_not_overwritten() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    let error = publish(&path, Existing::Keep, |out| {
        fs::write(&path, b"theirs")?;
        out.write_all(b"ours")
    });
    assert!(matches!(error, Err(FileError::Exists { .. })), "{error:?}");
    assert_eq!(fs::read(&path).expect("it is there"), b"theirs");
    assert_eq!(names(folder.path()), ["a.flb"]);
}

#[test]
fn folders_missing_folders_and_nameless_paths_are_refused() {
    let folder = folder();
    let write = |path: &Path| {
        publish(path, Existing::Replace, |out| out.write_all(b"x")).expect_err("refused").to_string()
    };
    let text = write(folder.path());
    assert!(text.ends_with("is a folder, expected a regular file or a new name"), "{text}");
    assert!(write(&folder.path().join("none/a.flb")).starts_with("cannot write "));
    assert!(write(Path::new("/")).contains("is no file name"));
    assert!(names(folder.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn devices_and_dangling_links_are_refused_and_good_links_are_followed() {
    let folder = folder();
    let error =
        publish(Path::new("/dev/null"), Existing::Replace, |out| out.write_all(b"x")).expect_err("a device");
    assert!(error.to_string().contains("is a pipe, socket or device"), "{error}");
    let link = folder.path().join("link.flb");
    std::os::unix::fs::symlink(folder.path().join("none"), &link).expect("links work");
    let error = publish(&link, Existing::Replace, |out| out.write_all(b"x")).expect_err("it leads nowhere");
    assert!(error.to_string().contains("a link that leads nowhere"), "{error}");
    fs::write(folder.path().join("none"), b"old").expect("writable");
    publish(&link, Existing::Replace, |out| out.write_all(b"new")).expect("it leads to a file");
    assert_eq!(fs::read(folder.path().join("none")).expect("it is there"), b"new");
    assert!(fs::symlink_metadata(&link).expect("the link stays").is_symlink());
}

#[test]
fn what_a_killed_writer_left_is_removed_and_nothing_else() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    let others = [
        ".a.flb.abcdef.tmp",         // not ours
        ".a.flb.flb-abcdefg.tmp",    // too short
        ".a.flb.flb-abcde_gh.tmp",   // no such letter
        ".b.flb.flb-abcdefgh.tmp",   // of another output
        ".a.flb.flb-abcdefgh.tmp.x", // of another kind
        "a.flb.flb-abcdefgh.tmp",    // not hidden
    ];
    let left = ".a.flb.flb-abcdEF12.tmp";
    for name in others.iter().chain([&left]) {
        fs::write(folder.path().join(name), b"half").expect("writable");
    }
    fs::create_dir(folder.path().join(".a.flb.flb-folder12.tmp")).expect("writable");
    publish(&path, Existing::Keep, |out| {
        assert!(!folder.path().join(left).exists(), "it is gone before the disk fills");
        out.write_all(b"whole")
    })
    .expect("it is written");
    let found = names(folder.path());
    assert!(!found.contains(&left.to_owned()), "{found:?}");
    assert_eq!(found.len(), others.len() + 2, "{found:?}");
}

#[test]
fn two_writers_of_one_output_leave_each_other_alone() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    publish(&path, Existing::Replace, |out| {
        out.write_all(b"first, ")?;
        publish(&path, Existing::Replace, |out| out.write_all(b"second")).expect("it is written meanwhile");
        assert_eq!(fs::read(&path)?, b"second");
        assert_eq!(names(folder.path()).len(), 2, "the other one's temporary file is in use");
        out.write_all(b"and last")
    })
    .expect("its file was not taken away");
    assert_eq!(fs::read(&path).expect("it is there"), b"first, and last");
    assert_eq!(names(folder.path()), ["a.flb"]);
}

#[test]
fn a_temporary_file_whose_writer_lives_stays_and_one_taken_for_left_behind_is_given_up() {
    let folder = folder();
    let disk = Disk::open(folder.path(), Path::new("a.flb"), Owner::User).expect("a folder");
    let mut temporary = Temporary::create(&disk, OsStr::new("a.flb")).expect("a file");
    temporary.file().write_all(b"half").expect("writable");
    left_behind::remove(&disk, OsStr::new("a.flb"));
    assert_eq!(names(folder.path()).len(), 1, "its writer lives");
    drop(temporary);
    assert!(names(folder.path()).is_empty());
}

/// The longest name that file systems take; its temporary file's name must not be longer.
#[test]
fn names_up_to_the_longest_are_published_and_longer_ones_refused_before_the_work() {
    let folder = folder();
    for length in [237, 238, 250, 255] {
        let path = folder.path().join("n".repeat(length));
        probe(&path, Existing::Keep).expect("it can be written");
        publish(&path, Existing::Keep, |out| out.write_all(b"x")).expect("it is written");
        publish(&path, Existing::Replace, |out| out.write_all(b"y")).expect("it is replaced");
        assert_eq!(fs::read(&path).expect("it is there"), b"y");
    }
    let error =
        probe(&folder.path().join("n".repeat(256)), Existing::Keep).expect_err("too long").to_string();
    assert!(error.contains("too long"), "{error}");
    assert_eq!(names(folder.path()).len(), 4);
}

#[cfg(unix)]
#[test]
fn names_that_are_no_text_are_published() {
    use std::os::unix::ffi::OsStrExt;
    let folder = folder();
    let path = folder.path().join(OsStr::from_bytes(b"\xFFa\xFE.flb"));
    publish(&path, Existing::Keep, |out| out.write_all(b"x")).expect("it is written");
    publish(&path, Existing::Replace, |out| out.write_all(b"y")).expect("it is replaced");
    assert_eq!(fs::read(&path).expect("it is there"), b"y");
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};

    use super::*;

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).expect("it is there").permissions().mode() & 0o7777
    }

    fn set_mode(path: &Path, mode: u32) {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("it is ours");
    }

    #[test]
    fn what_replaces_a_file_has_its_mode_from_the_first_byte_on() {
        let folder = folder();
        let path = folder.path().join("a.flb");
        fs::write(&path, b"old").expect("writable");
        for kept in [0o600, 0o640, 0o664, 0o755] {
            set_mode(&path, kept);
            publish(&path, Existing::Replace, |out| {
                let temporary = names(folder.path()).into_iter().find(|name| name.starts_with('.'));
                let temporary = folder.path().join(temporary.expect("a temporary file"));
                assert_eq!(mode(&temporary), kept);
                out.write_all(b"new")
            })
            .expect("it is replaced");
            assert_eq!(mode(&path), kept);
        }
    }

    #[test]
    fn a_read_only_file_is_refused_before_the_work_and_stays() {
        let folder = folder();
        let path = folder.path().join("a.flb");
        fs::write(&path, b"old").expect("writable");
        set_mode(&path, 0o444);
        for refused in [
            probe(&path, Existing::Replace),
            publish(&path, Existing::Replace, |_| panic!("nothing is written")),
        ] {
            let error = refused.expect_err("read-only").to_string();
            assert!(
                error.ends_with("is read-only (mode 444), expected a file that may be written"),
                "{error}"
            );
        }
        assert_eq!(fs::read(&path).expect("it is there"), b"old");
    }

    #[test]
    fn what_replaces_a_file_has_its_owner_and_group_where_that_is_allowed() {
        let folder = folder();
        let path = folder.path().join("a.flb");
        fs::write(&path, b"old").expect("writable");
        // Only root may give a file away; others keep what is theirs.
        let (owner, group) = match std::os::unix::fs::chown(&path, Some(12_345), Some(12_346)) {
            Ok(()) => (12_345, 12_346),
            Err(_) => fs::metadata(&path).map(|found| (found.uid(), found.gid())).expect("it is there"),
        };
        publish(&path, Existing::Replace, |out| out.write_all(b"new")).expect("it is replaced");
        let found = fs::metadata(&path).expect("it is there");
        assert_eq!((found.uid(), found.gid()), (owner, group));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn rights_that_a_folder_gives_to_new_files_do_not_widen_those_of_what_is_replaced() {
        use rustix::fs::{XattrFlags, getxattr, setxattr};
        // Version 2, then tag, rights and number of each entry: owner, user 54321, group, the most of both, others.
        let entries = [(1u16, 7u16, !0u32), (2, 7, 54_321), (4, 5, !0), (16, 7, !0), (32, 0, !0)];
        let mut list = 2u32.to_le_bytes().to_vec();
        for (tag, rights, number) in entries {
            list.extend([tag.to_le_bytes(), rights.to_le_bytes()].concat());
            list.extend(number.to_le_bytes());
        }
        let folder = folder();
        let path = folder.path().join("a.flb");
        fs::write(&path, b"old").expect("writable");
        set_mode(&path, 0o640);
        setxattr(folder.path(), "system.posix_acl_default", &list, XattrFlags::empty())
            .expect("the file system of temporary files has access lists");
        let access = |path: &Path| getxattr(path, "system.posix_acl_access", &mut [0u8; 256][..]).is_ok();
        publish(&folder.path().join("new.flb"), Existing::Keep, |out| out.write_all(b"new"))
            .expect("it is written");
        assert!(access(&folder.path().join("new.flb")), "a new file has what the folder gives");
        publish(&path, Existing::Replace, |out| out.write_all(b"new")).expect("it is replaced");
        assert!(!access(&path) && mode(&path) == 0o640);
    }

    #[test]
    fn a_folder_that_is_swapped_for_a_link_meanwhile_gets_the_file_all_the_same() {
        let base = folder();
        let (folder, moved, other) =
            (base.path().join("out"), base.path().join("moved"), base.path().join("other"));
        fs::create_dir(&folder).and_then(|()| fs::create_dir(&other)).expect("writable");
        publish(&folder.join("a.flb"), Existing::Replace, |out| {
            fs::rename(&folder, &moved)?;
            std::os::unix::fs::symlink(&other, &folder)?;
            out.write_all(b"whole")
        })
        .expect("it is written");
        assert_eq!((names(&moved), names(&other)), (vec!["a.flb".to_owned()], vec![]));
    }
}
