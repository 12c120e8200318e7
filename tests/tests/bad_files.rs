//! Every golden file, cut at every byte of header and tables, with every bit of them flipped, and tortured: each gets
//! its code, and none takes much memory. `cli/tests/it/torture.rs` does the last under a limit of the system. A program
//! of its own: it counts the memory of its whole process.

use flb_format::container::records::HEADER_BYTES;
use flb_format::testing::GOLDEN;
use flb_format::testing::torture::{Subject, code_of_flip};
use flb_format::{Container, FormatError};
use flb_inspector::Level;
use flb_inspector::validate::check;

#[global_allocator]
static HEAP: peak_alloc::PeakAlloc = peak_alloc::PeakAlloc;

/// More than a table or a page of golden files takes, and far less than a number out of one could claim.
const SMALL_BYTES: usize = 1 << 20;
/// Of a whole check; the largest file of the torture has 256^3 sites.
const LARGE_BYTES: usize = 512 << 20;

/// What `work` gives, if it took no more memory on top of what is in use. The tests of this file take turns.
fn within<T>(limit_bytes: usize, what: &str, work: impl FnOnce() -> T) -> T {
    let before = HEAP.current_usage();
    HEAP.reset_peak_usage();
    let outcome = work();
    let taken = HEAP.peak_usage().saturating_sub(before);
    assert!(taken <= limit_bytes, "{what}: {taken} bytes, expected up to {limit_bytes}");
    outcome
}

fn code(verdict: Result<(), FormatError>) -> Option<u32> {
    verdict.err().map(|error| error.code())
}

/// One test, because memory is counted over all threads.
#[test]
fn bad_files_get_their_codes_and_take_little_memory() {
    within(SMALL_BYTES, "a planted allocation", || vec![0u8; SMALL_BYTES / 2]);
    let planted = std::panic::catch_unwind(|| within(SMALL_BYTES, "planted", || vec![0u8; 2 * SMALL_BYTES]));
    assert!(planted.is_err(), "were memory not counted, nothing below could fail");
    let mut count = 0;
    for (name, file) in GOLDEN {
        count += truncations(name, file) + flips(name, file) + tortures(name, file, count == 0);
    }
    eprintln!("{count} bad files");
    assert!(count > 1000);
}

fn truncations(name: &str, file: &[u8]) -> usize {
    let tables_end = Container::open(&file.to_vec()).expect("a golden file").header().tables_end as usize;
    for length in 0..=tables_end {
        let cut = file[..length].to_vec();
        let what = format!("{name} cut at {length}");
        let found = within(SMALL_BYTES, &what, || code(check(&cut, Level::Decode)));
        let expected = if length < HEADER_BYTES as usize { 1001 } else { 1008 };
        assert_eq!(found, Some(expected), "{what}");
    }
    tables_end + 1
}

fn flips(name: &str, file: &[u8]) -> usize {
    let mut file = file.to_vec();
    let header = *Container::open(&file).expect("a golden file").header();
    let (contents_end, tables_end) = (HEADER_BYTES + header.contents_bytes, header.tables_end as usize);
    for bit in 0..8 * tables_end {
        file[bit / 8] ^= 1 << (bit % 8);
        let expected = code_of_flip(&file, bit / 8, contents_end as usize);
        let found = within(SMALL_BYTES, "a flipped bit", || code(check(&file, Level::Decode)));
        assert_eq!(found, Some(expected), "{name}: bit {bit}");
        file[bit / 8] ^= 1 << (bit % 8);
    }
    8 * tables_end
}

fn tortures(name: &str, file: &[u8], giants: bool) -> usize {
    let subject = Subject::new(file.to_vec(), 3).expect("a golden file");
    let mut count = 0;
    subject.corrupt(&mut |case| {
        // Files that unfold are the same for every golden file, and take seconds.
        if !giants && (case.label.starts_with("giant") || case.label == "many-pages") {
            return;
        }
        let what = format!("{name}: {} {}", case.kind, case.label);
        let found = within(LARGE_BYTES, &what, || code(check(&case.bytes, Level::Decode)));
        assert_eq!(found, case.expected, "{what}: {}", case.done);
        count += usize::from(case.expected.is_some());
    });
    count
}
