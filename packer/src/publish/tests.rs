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
    publish(&path, false, |out| out.write_all(b"whole")).expect("it is written");
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
    let error = publish(&path, true, full).expect_err("the disk is full");
    assert!(error.to_string().starts_with(&format!("cannot write {}: ", path.display())), "{error}");
    assert_eq!(fs::read(&path).expect("it is there"), b"old");
    assert_eq!(names(folder.path()), ["a.flb"]);
}

#[test]
fn an_existing_file_is_replaced_only_by_force() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    fs::write(&path, b"old").expect("writable");
    let error = publish(&path, false, |out| out.write_all(b"new")).expect_err("it exists");
    assert_eq!(error.to_string(), format!("{} exists; --force replaces it", path.display()));
    assert_eq!(fs::read(&path).expect("it is there"), b"old");
    publish(&path, true, |out| out.write_all(b"new")).expect("force");
    assert_eq!(fs::read(&path).expect("it is there"), b"new");
}

#[test]
fn a_file_that_appears_during_the_write_is_not_overwritten() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    let error = publish(&path, false, |out| {
        fs::write(&path, b"theirs")?;
        out.write_all(b"ours")
    });
    assert!(matches!(error, Err(PackError::Exists { .. })), "{error:?}");
    assert_eq!(fs::read(&path).expect("it is there"), b"theirs");
    assert_eq!(names(folder.path()), ["a.flb"]);
}

#[test]
fn folders_missing_folders_and_nameless_paths_are_refused() {
    let folder = folder();
    let write =
        |path: &Path| publish(path, true, |out| out.write_all(b"x")).expect_err("refused").to_string();
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
    let error = publish(Path::new("/dev/null"), true, |out| out.write_all(b"x")).expect_err("a device");
    assert!(error.to_string().contains("is a pipe, socket or device"), "{error}");
    let link = folder.path().join("link.flb");
    std::os::unix::fs::symlink(folder.path().join("none"), &link).expect("links work");
    let error = publish(&link, true, |out| out.write_all(b"x")).expect_err("it leads nowhere");
    assert!(error.to_string().contains("a link that leads nowhere"), "{error}");
    fs::write(folder.path().join("none"), b"old").expect("writable");
    publish(&link, true, |out| out.write_all(b"new")).expect("it leads to a file");
    assert_eq!(fs::read(folder.path().join("none")).expect("it is there"), b"new");
    assert!(fs::symlink_metadata(&link).expect("the link stays").is_symlink());
}

#[test]
fn an_output_that_is_an_input_is_refused_under_any_name() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    fs::write(&path, b"old").expect("writable");
    let detour = folder.path().join("../").join(folder.path().file_name().expect("a name")).join("a.flb");
    let error = refuse_inputs(&detour, &[&path]).expect_err("the same file");
    assert!(error.to_string().contains("is the input"), "{error}");
    refuse_inputs(&folder.path().join("b.flb"), &[&path]).expect("another file");
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
    publish(&path, false, |out| {
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
    publish(&path, true, |out| {
        out.write_all(b"first, ")?;
        publish(&path, true, |out| out.write_all(b"second")).expect("it is written meanwhile");
        assert_eq!(fs::read(&path)?, b"second");
        assert_eq!(names(folder.path()).len(), 2, "the other one's temporary file is in use");
        out.write_all(b"and last")
    })
    .expect("its file was not taken away");
    assert_eq!(fs::read(&path).expect("it is there"), b"first, and last");
    assert_eq!(names(folder.path()), ["a.flb"]);
}

#[test]
fn a_temporary_file_that_was_taken_for_left_behind_is_given_up() {
    let folder = folder();
    let path = folder.path().join(".a.flb.flb-abcdefgh.tmp");
    let file = fs::File::create(&path).expect("writable");
    assert!(left_behind::claim(&file).expect("it can be looked at"), "nobody else has it");
    left_behind::remove(folder.path(), "a.flb");
    assert!(path.exists(), "its writer lives");
    let late = fs::File::open(&path).expect("readable");
    assert!(!left_behind::claim(&late).expect("it can be looked at"), "somebody holds it");
    drop(file);
    left_behind::remove(folder.path(), "a.flb");
    assert!(!path.exists());
    #[cfg(unix)]
    assert!(!left_behind::claim(&late).expect("it can be looked at"), "it has no name any more");
}
