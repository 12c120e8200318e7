//! Files that other programs cut and overwrite while they are read.

use std::io::{BufRead, BufReader, Lines, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use flb_runtime::Library;

use crate::forest::{BASES, field, forest};

const LATTICE: u32 = 32;
/// Set for the child that reads.
const CHANGING: &str = "FLB_TEST_CHANGING_FILE";

fn write(path: &Path, bytes: &[u8]) {
    // In place: what publishes by renaming is never seen half done.
    let mut file =
        std::fs::OpenOptions::new().write(true).create(true).truncate(false).open(path).expect("a file");
    file.write_all(bytes).and_then(|()| file.set_len(bytes.len() as u64)).expect("room on the disk");
}

/// Reads the file again and again, of a library that was opened once and of one opened each time; says what came of it,
/// one word a line. Ends with its standard input.
fn read_on(path: &Path) {
    let right = [1, 2].map(|seed| BASES.map(|base| field(LATTICE, base, seed)));
    let kept = Library::open(path).expect("the file is whole at first");
    let (ended, end) = std::sync::mpsc::channel::<()>();
    std::thread::spawn(move || {
        let _ = std::io::stdin().read_line(&mut String::new());
        drop(ended);
    });
    let read = |library: &Library| -> &'static str {
        let field = |base: u8| library.container().read_field(library.source(), 0, base);
        let found: Result<Vec<_>, _> = BASES.into_iter().map(field).collect();
        match found {
            Ok(found) if found == right[0] => "right",
            Ok(found) if found == right[1] => "right of the other file",
            Ok(_) => "WRONG",
            Err(_) => "error",
        }
    };
    while end.try_recv() == Err(std::sync::mpsc::TryRecvError::Empty) {
        println!("kept {}", read(&kept));
        println!("opened {}", Library::open(path).map_or("error", |library| read(&library)));
    }
}

struct Reader {
    child: Child,
    lines: Lines<BufReader<ChildStdout>>,
    stdin: Option<ChildStdin>,
    words: Vec<String>,
}

impl Reader {
    fn start(test: &str, path: &Path) -> Reader {
        let mut child = Command::new(std::env::current_exe().expect("a path"))
            .args([test, "--exact", "--nocapture"])
            .env(CHANGING, path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("this program starts");
        let lines = BufReader::new(child.stdout.take().expect("piped")).lines();
        let stdin = child.stdin.take();
        Reader { child, lines, stdin, words: Vec::new() }
    }

    /// Reads on until the child says this. Fails where the child ends.
    fn wait_for(&mut self, word: &str) {
        loop {
            let line =
                self.lines.next().unwrap_or_else(|| panic!("the reader ended before it said {word:?}"));
            let line = line.expect("words");
            // The test runner writes before the first word without an end of line.
            self.words.push(line.clone());
            if line.ends_with(word) {
                return;
            }
        }
    }

    /// Everything that the child said, once it has ended well.
    fn end(mut self) -> Vec<String> {
        drop(self.stdin.take());
        self.words.extend(self.lines.by_ref().map_while(Result::ok));
        let status = self.child.wait().expect("it ends");
        assert!(status.success(), "the reader ended with {status}");
        self.words
    }
}

#[test]
fn a_file_cut_and_overwritten_under_positioned_reads_gives_errors_or_right_data() {
    if let Some(path) = std::env::var_os(CHANGING) {
        return read_on(Path::new(&path));
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("oak.flb");
    let (good, other) = (forest(&["oak"], LATTICE, 1), forest(&["oak"], LATTICE, 2));
    write(&path, &good);
    let name = "changing::a_file_cut_and_overwritten_under_positioned_reads_gives_errors_or_right_data";
    let mut reader = Reader::start(name, &path);
    reader.wait_for("kept right");
    let cut = |length: usize| good[..length].to_vec();
    let zeroed = [&good[..good.len() / 2], &vec![0; good.len() - good.len() / 2][..]].concat();
    for bad in [cut(good.len() / 2), cut(100), cut(0), cut(good.len() - 1), zeroed, other.clone()] {
        write(&path, &bad);
        reader.wait_for("kept error");
        write(&path, &good);
        reader.wait_for("kept right");
    }
    // And many changes without waiting, so that they fall into the middle of reads.
    for i in 0..400 {
        match i % 4 {
            0 => write(&path, &good[..good.len() * (i + 1) / 401]),
            2 => write(&path, &other),
            _ => write(&path, &good),
        }
    }
    write(&path, &good);
    reader.wait_for("opened right");
    let words = reader.end();
    // What was opened as one file never becomes the other.
    let wrong = |line: &&String| line.contains("WRONG") || line.ends_with("kept right of the other file");
    assert_eq!(words.iter().filter(wrong).count(), 0);
    assert!(words.iter().any(|line| line.ends_with("opened error")));
}

#[test]
fn a_file_overwritten_under_a_mapping_gives_errors_never_wrong_data() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("oak.flb");
    let (good, other) = (forest(&["oak"], LATTICE, 1), forest(&["oak"], LATTICE, 2));
    assert_eq!(good.len(), other.len());
    write(&path, &good);
    let library = Library::open_mapped(&path).expect("a good file");
    let read = |base: u8| library.container().read_field(library.source(), 0, base);
    assert_eq!(read(4).expect("a good file"), field(LATTICE, 4, 1));
    write(&path, &other);
    for base in BASES {
        let message = read(base).expect_err("the page is another").to_string();
        assert!(message.contains("page 0 of base") && message.contains("digest"), "{message}");
    }
    write(&path, &good);
    assert_eq!(read(4).expect("as it was"), field(LATTICE, 4, 1));
    write(&path, &good[..good.len() - 1]);
    let message = read(4).expect_err("the file is shorter").to_string();
    assert!(
        message.contains(&format!(
            "the file is {} bytes long, and was {} when it was mapped",
            good.len() - 1,
            good.len()
        )),
        "{message}"
    );
}

#[test]
fn a_file_cut_before_it_is_opened_is_refused_by_both_ways_to_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("oak.flb");
    let good = forest(&["oak"], LATTICE, 1);
    for length in [0, 7, 100, 5000, good.len() / 2, good.len() - 1] {
        write(&path, &good[..length]);
        for library in [Library::open_mapped(&path), Library::open(&path)] {
            let message = library.err().expect("refused").to_string();
            assert!(message.contains("oak.flb: FLB-1"), "{length} bytes: {message}");
        }
    }
}
