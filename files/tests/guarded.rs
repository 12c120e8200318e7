//! The guard of inputs. A file of its own: it reaches every file of the process.

use std::fs;
use std::path::Path;

use flb_files::{
    Existing, FileError, check_output, check_unread, guard_input, guard_inputs, open_own, open_regular,
    publish, publish_own,
};

fn write(path: &Path) -> Result<(), FileError> {
    publish(path, Existing::Replace, |out| out.write_all(b"new"))
}

#[test]
fn what_was_read_or_written_is_not_overwritten_once_the_guard_is_on() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [input, output, cached] = ["input", "output", "cached"].map(|name| folder.path().join(name));
    for path in [&input, &cached] {
        fs::write(path, b"old").expect("writable");
    }
    open_regular(&input).expect("it is there");
    write(&input).expect("a library may write what it has read");

    guard_inputs();
    open_regular(&input).expect("it is there");
    open_own(&cached).expect("it is there");
    let detour = folder.path().join("../").join(folder.path().file_name().expect("a name")).join("input");
    for name in [&input, &detour] {
        for refused in [write(name), check_output(name, &[], Existing::Replace)] {
            let error = refused.expect_err("it was read");
            assert!(error.is_usage(), "{error}");
            let words = format!("the output {} is the input {} itself", name.display(), input.display());
            assert_eq!(error.to_string(), words);
        }
    }
    assert_eq!(fs::read(&input).expect("it is there"), b"new");
    let named = folder.path().join("named");
    fs::write(&named, b"old").expect("writable");
    check_unread(&named).expect("it has not been read");
    guard_input(&named);
    check_unread(&named).expect_err("another input names it");
    write(&output).expect("it is new");
    let error = write(&output).expect_err("it is an output already").to_string();
    assert!(error.ends_with("named as two outputs at once"), "{error}");
    publish_own(&cached, |out| out.write_all(b"new")).expect("a cache replaces what is its own");
    write(&cached).expect_err("but it is no output");
}
