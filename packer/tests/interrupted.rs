//! What an interrupted write leaves behind. A file of its own: the call reaches every write of the process.

use flb_packer::publish::{publish, remove_unfinished};

#[test]
fn an_interrupted_write_leaves_no_temporary_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.flb");
    std::fs::write(&path, b"old").expect("writable");
    let files = || std::fs::read_dir(folder.path()).expect("it can be listed").count();
    let outcome = publish(&path, true, |out| {
        out.write_all(b"half of it")?;
        assert_eq!(files(), 2, "the old file and the temporary one");
        remove_unfinished();
        assert_eq!(files(), 1);
        Ok(())
    });
    outcome.expect_err("there is nothing left to publish");
    assert_eq!(std::fs::read(&path).expect("it is there"), b"old");
    assert_eq!(files(), 1);
}
