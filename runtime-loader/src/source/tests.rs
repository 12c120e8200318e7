use std::io::Write;

use super::*;

fn file_of(bytes: &[u8]) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(bytes).unwrap();
    file
}

/// Both kinds on the same file.
fn both(path: &Path) -> [Result<Box<dyn Source>, RuntimeError>; 2] {
    [
        FileSource::open(path).map(|s| Box::new(s) as Box<dyn Source>),
        MappedSource::open(path).map(|s| Box::new(s) as Box<dyn Source>),
    ]
}

/// A file as it is read where there are no positioned reads.
#[derive(Debug)]
struct BySeeking(FileSource);

impl Source for BySeeking {
    fn len_bytes(&self) -> io::Result<u64> {
        self.0.len_bytes()
    }

    fn read_exact_at(&self, offset_bytes: u64, buffer: &mut [u8]) -> io::Result<()> {
        read_by_seeking(&self.0.file, offset_bytes, buffer)
    }
}

/// Both kinds, and files without positioned reads, on the same file.
fn all(path: &Path) -> impl Iterator<Item = Box<dyn Source>> {
    let by_seeking = BySeeking(FileSource::open(path).expect("a file"));
    both(path).into_iter().map(Result::unwrap).chain([Box::new(by_seeking) as Box<dyn Source>])
}

#[test]
fn all_sources_read_what_a_slice_reads() {
    let bytes: Vec<u8> = (0..=255).cycle().take(10_000).collect();
    let file = file_of(&bytes);
    for source in all(file.path()) {
        assert_eq!(source.len_bytes().unwrap(), 10_000);
        for (offset, length) in
            [(0, 10_000), (0, 0), (10_000, 0), (4095, 2), (9_999, 1), (10_000, 1), (9_999, 2)]
        {
            let (mut found, mut expected) = (vec![0; length], vec![0; length]);
            let slice = bytes[..].read_exact_at(offset, &mut expected);
            assert_eq!(
                source.read_exact_at(offset, &mut found).is_ok(),
                slice.is_ok(),
                "{length} at {offset}"
            );
            if slice.is_ok() {
                assert_eq!(found, expected);
            }
        }
    }
}

#[test]
fn offsets_that_wrap_are_refused() {
    let file = file_of(b"some bytes");
    for source in all(file.path()) {
        for offset in [u64::MAX, u64::MAX - 2, 1 << 63, i64::MAX as u64] {
            assert!(source.read_exact_at(offset, &mut [0; 4]).is_err(), "at {offset}");
        }
    }
}

#[test]
fn an_empty_file_is_refused() {
    let file = file_of(b"");
    for source in both(file.path()) {
        let error = source.err().expect("refused");
        assert_eq!(error.code(), Some(1001));
        let message = error.to_string();
        assert!(
            message.ends_with("FLB-1001 file at byte 0: the file has 0 bytes, expected at least 8"),
            "{message}"
        );
    }
}

#[test]
fn folders_and_devices_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for source in both(folder.path()) {
        let message = source.err().expect("refused").to_string();
        assert!(message.ends_with("found a folder, expected a regular file"), "{message}");
    }
    if cfg!(unix) {
        for source in both(Path::new("/dev/zero")) {
            assert!(matches!(source, Err(RuntimeError::NotAFile { found: "a pipe, device or socket", .. })));
        }
    }
}

#[test]
fn a_missing_file_is_named() {
    for source in both(Path::new("/no/such/file.flb")) {
        let message = source.err().expect("refused").to_string();
        assert!(message.starts_with("/no/such/file.flb: cannot open: "), "{message}");
    }
}

#[test]
fn a_file_that_shrank_is_an_error() {
    let file = file_of(&[7; 9_000]);
    for source in both(file.path()).map(Result::unwrap) {
        assert!(source.read_exact_at(8_000, &mut [0; 100]).is_ok());
        file.as_file().set_len(5_000).unwrap();
        assert!(source.read_exact_at(8_000, &mut [0; 100]).is_err());
        file.as_file().set_len(9_000).unwrap();
    }
    let source = MappedSource::open(file.path()).unwrap();
    file.as_file().set_len(5_000).unwrap();
    let error = source.read_exact_at(0, &mut [0; 4]).unwrap_err();
    assert_eq!(error.to_string(), "the file is 5000 bytes long, and was 9000 when it was mapped");
}

#[cfg(unix)]
#[test]
fn a_pipe_is_refused_without_waiting_for_its_writer() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.flb");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo of coreutils");
    assert!(made.success());
    for source in both(&pipe) {
        let message = source.err().expect("refused").to_string();
        assert!(message.ends_with("found a pipe, device or socket, expected a regular file"), "{message}");
    }
}
