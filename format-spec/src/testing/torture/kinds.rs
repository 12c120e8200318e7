//! The 60 kinds of bad input, and those of them that are no file.

/// Names of the kinds, 1 first.
pub static KINDS: [&str; 60] = [
    "empty file",
    "1 to 127 bytes",
    "cut in header or tables",
    "cut in the last page",
    "trailing bytes",
    "line ends converted",
    "high bits stripped",
    "bytes swapped",
    "polyglot",
    "future major version",
    "unknown required feature",
    "unknown optional section",
    "reserved byte set",
    "wrong digest",
    "digest zeroed",
    "file length short or long",
    "table inside the header",
    "place past the end",
    "offset + length wraps",
    "count x size wraps",
    "count 0 or 2^32 - 1",
    "unsorted table",
    "duplicate key",
    "overlap",
    "shared bytes",
    "data over the table",
    "off by one",
    "misaligned",
    "non-zero padding",
    "excess padding",
    "unknown codec",
    "frame that claims 2^63",
    "frame without a size",
    "several or skippable frames",
    "huge window",
    "decodes short or long",
    "dictionary",
    "bomb in one page",
    "bomb of many pages",
    "page of a sibling",
    "page of an earlier build",
    "old tables, new data",
    "server that ignores ranges",
    "NaN, -0, subnormal, infinity",
    "product of sizes overflows",
    "a size of 0",
    "place that leads on",
    "bad text in names",
    "deep or repeated JSON",
    "flood of keys",
    "rolled-back tables",
    "two files in one",
    "unfinished file",
    "cut or replaced while mapped",
    "output is input",
    "pipe, folder, device",
    "disk full",
    "sound digests, lying content",
    "single flipped bit",
    "surfaces of materials that are none",
];

/// A kind that is a condition of a server, a disk or a process, and no bytes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Condition {
    /// Number of the kind in [`KINDS`].
    pub kind: u8,
    /// Test of the condition: file of the repository, and name.
    pub carried_by: &'static str,
}

/// The kinds that no file can carry, and the tests that do.
pub const CONDITIONS: [Condition; 9] = [
    carried(42, "runtime-loader/tests/it/remote.rs: a_file_replaced_between_requests_is_found"),
    carried(
        43,
        "runtime-loader/tests/it/remote.rs: a_server_without_ranges_is_refused_before_its_body_is_read",
    ),
    carried(
        54,
        "runtime-loader/tests/it/changing.rs: a_file_overwritten_under_a_mapping_gives_errors_never_wrong_data",
    ),
    carried(
        54,
        "runtime-loader/tests/it/changing.rs: a_file_cut_and_overwritten_under_positioned_reads_gives_errors_or_right_data",
    ),
    carried(55, "cli/tests/it/outputs.rs: an_output_that_is_an_input_is_refused_even_with_force"),
    carried(
        56,
        "files/src/publish/tests.rs: devices_and_dangling_links_are_refused_and_good_links_are_followed",
    ),
    carried(57, "files/src/publish/tests.rs: a_failed_write_leaves_the_old_file_and_no_rubbish"),
    carried(58, "cli/tests/it/outputs.rs: a_cache_is_reused_and_changes_nothing"),
    carried(59, "format-spec/tests/it/corruption.rs: every_flipped_bit_of_header_and_tables_is_refused"),
];

const fn carried(kind: u8, carried_by: &'static str) -> Condition {
    Condition { kind, carried_by }
}
