//! What an interrupted write leaves behind. A file of its own: the call reaches every write of the process.

use std::sync::mpsc;

use flb_files::{Existing, publish, stop_publishing};

#[test]
fn an_interrupted_write_leaves_no_temporary_file_and_goes_no_further() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.flb");
    std::fs::write(&path, b"old").expect("writable");
    let files = || std::fs::read_dir(folder.path()).expect("it can be listed").count();
    let (begun, begins) = mpsc::channel();
    let (go_on, waits) = mpsc::channel::<()>();
    let (ended, ends) = mpsc::channel();
    let output = path.clone();
    std::thread::spawn(move || {
        let outcome = publish(&output, Existing::Replace, |out| {
            out.write_all(b"half of it")?;
            begun.send(()).expect("the test waits");
            waits.recv().expect("the test goes on");
            Ok(())
        });
        ended.send(outcome.is_ok()).expect("the test waits");
    });
    begins.recv().expect("it begins");
    assert_eq!(files(), 2, "the old file and the temporary one");
    stop_publishing();
    assert_eq!(files(), 1);
    go_on.send(()).expect("it waits");
    let waited = ends.recv_timeout(std::time::Duration::from_millis(200));
    assert_eq!(waited, Err(mpsc::RecvTimeoutError::Timeout), "it waits for the end of the process");
    assert_eq!((std::fs::read(&path).expect("it is there"), files()), (b"old".to_vec(), 1));
}
