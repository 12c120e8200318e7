//! Two readers, one specification: `reader.py` and this crate agree on every golden file, to the bit.

use std::path::Path;
use std::process::{Command, Output};

use flb_format::container::digest;
use flb_format::container::records::{KIND_BASE, MEDIUM_ITEMS, STORED_ZSTD};
use flb_format::container::verify::hexadecimal;
use flb_format::error::ErrorClass;
use flb_format::testing::forgeries::sound_blocks;
use flb_format::testing::{Digests, GOLDEN, Parts, check, golden};
use flb_format::{Container, Field, canonical};
use serde_json::{Value, json};

use crate::said::bad_files;

fn run_reader(path: &Path) -> Output {
    let reader = concat!(env!("CARGO_MANIFEST_DIR"), "/reader.py");
    // FLB_PYTHON names another interpreter, for instance one with the package zstandard.
    let python = std::env::var("FLB_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    Command::new(&python)
        .args(["-B", reader])
        .arg(path)
        .output()
        .unwrap_or_else(|error| panic!("this test needs Python 3.10 or later as {python}: {error}"))
}

fn lacks_zstd(output: &Output) -> bool {
    let talk = String::from_utf8_lossy(&output.stderr);
    output.status.code() == Some(5) && talk.contains("install the Python package zstandard")
}

fn golden_path(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden").join(format!("{name}.flb"))
}

/// What reader.py prints, from this crate's decode.
#[allow(clippy::ptr_arg, reason = "an unsized slice makes no &dyn Source")]
fn summary(bytes: &Vec<u8>) -> Value {
    let container = Container::open(bytes).expect("golden files open");
    let text = |bytes: Vec<u8>| json!(format!("{:016x}", digest::plain(&bytes)));
    let floats = |values: &[f32]| text(values.iter().flat_map(|v| v.to_le_bytes()).collect());
    let species: Vec<Value> = container
        .species()
        .iter()
        .enumerate()
        .map(|(i, species)| {
            let medium = container.read_medium(bytes, i).expect("golden media decode");
            let mut arrays = vec![
                floats(&medium.density),
                text(medium.class.iter().map(|class| *class as u8).collect()),
                floats(&medium.leaf_area_density),
                floats(&medium.wood_area_density),
            ];
            if species.extinction.is_some() {
                let turbid = container.read_turbid(bytes, i).expect("golden media decode");
                arrays.extend([floats(&turbid.leaf_per_m), floats(&turbid.wood_per_m)]);
            }
            let base = |base: u8| -> Field { container.read_field(bytes, i, base).expect("bases decode") };
            json!({
                "name": species.meta.name,
                "metadata": text(container.read_metadata(bytes, i).expect("metadata are there")),
                "medium": MEDIUM_ITEMS.into_iter().map(str::to_owned).zip(arrays)
                    .collect::<serde_json::Map<_, _>>(),
                "bases": species.bases.iter().map(|b| (b.base.to_string(), floats(&base(b.base).values())))
                    .collect::<serde_json::Map<_, _>>(),
            })
        })
        .collect();
    let (major, minor) = container.format_version();
    json!({
        "format_version": format!("{major}.{minor}"),
        "root": hexadecimal(container.root()),
        "species": species,
    })
}

#[test]
fn the_python_reader_and_this_one_agree_on_every_golden_file() {
    for (name, bytes) in GOLDEN {
        let (bytes, output) = (&bytes.to_vec(), run_reader(&golden_path(name)));
        let talk = String::from_utf8_lossy(&output.stderr).into_owned();
        let container = Container::open(bytes).expect("golden files open");
        let zstd = (0..container.sections().len())
            .any(|s| container.pages(s).iter().any(|page| page.compression == STORED_ZSTD));
        if zstd && lacks_zstd(&output) {
            eprintln!("{name}: not compared, as this Python has no package zstandard");
            continue;
        }
        assert!(output.status.success(), "{name}: {talk}");
        let found: Value = serde_json::from_slice(&output.stdout).expect("reader.py prints JSON");
        assert_eq!(found, summary(bytes), "{name}");
    }
}

#[test]
fn the_python_reader_and_this_one_agree_on_blocks_that_no_writer_makes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("any.flb");
    for (i, file) in sound_blocks().into_iter().enumerate() {
        check(&file).unwrap_or_else(|error| panic!("file {i}: {error}"));
        std::fs::write(&path, &file).expect("the temporary folder is writable");
        let output = run_reader(&path);
        assert!(output.status.success(), "file {i}: {}", String::from_utf8_lossy(&output.stderr));
        let found: Value = serde_json::from_slice(&output.stdout).expect("reader.py prints JSON");
        assert_eq!(found, summary(&file), "file {i}");
    }
}

#[test]
fn the_python_reader_and_this_one_agree_on_numbers_between_two_shortest_spellings() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("ties.flb");
    #[allow(clippy::excessive_precision, reason = "exact values, so that the ties can be seen")]
    let ties = [545.67999267578125, 1.0 / 33_554_432.0, 2053053597086840.25];
    let written = canonical::to_bytes(&json!(ties)).expect("they are numbers");
    let written = String::from_utf8(written).expect("JSON is UTF-8");
    assert_eq!(written, "[545.6799926757812,2.9802322387695312e-8,2053053597086840.2]");
    let mut parts = Parts::of(&golden("raw-f32"));
    let text = String::from_utf8(parts.stored(0, 0).to_vec()).expect("metadata are UTF-8");
    let text = text.replace("\"note\":", &format!("\"nose\":{written},\"note\":"));
    parts.set_payload(0, 0, text.as_bytes());
    parts.lay_out();
    let file = parts.seal(Digests::Pages);
    std::fs::write(&path, &file).expect("the temporary folder is writable");
    let output = run_reader(&path);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).expect("reader.py prints JSON");
    assert_eq!(found, summary(&file));
}

#[test]
fn the_python_reader_finds_the_same_faults() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flipped = |at: usize| {
        let mut bytes = golden("haar-paper");
        let at = if at == usize::MAX { bytes.len() - 1 } else { at };
        bytes[at] ^= 1;
        bytes
    };
    let mut files = [0, 8, 40, 130, usize::MAX].map(flipped).to_vec();
    files.push(golden("raw-f32")[..5000].to_vec());
    let mut parts = Parts::of(&golden("haar-paper"));
    let base = parts.find(KIND_BASE, 0);
    parts.sections[base].threshold = 0.5;
    files.push(parts.seal(Digests::Pages));
    files.extend(bad_files().into_iter().map(|file| file.bytes));
    // Two at a time: starting Python takes longer than most of them.
    std::thread::scope(|scope| {
        for (i, half) in files.chunks(files.len().div_ceil(2)).enumerate() {
            let path = folder.path().join(format!("bad{i}.flb"));
            scope.spawn(move || half.iter().for_each(|bytes| assert_same_fault(&path, bytes)));
        }
    });
}

#[allow(clippy::ptr_arg, reason = "an unsized slice makes no &dyn Source")]
fn assert_same_fault(path: &Path, bytes: &Vec<u8>) {
    std::fs::write(path, bytes).expect("the temporary folder is writable");
    let error = check(bytes).expect_err("a bad file");
    let output = run_reader(path);
    let talk = String::from_utf8_lossy(&output.stderr);
    if lacks_zstd(&output) {
        eprintln!("{error}: not compared, as this Python has no package zstandard");
        return;
    }
    assert!(talk.starts_with(&format!("FLB-{} ", error.code())), "{talk} for {error}");
    let status = if error.class() == ErrorClass::Unsupported { 5 } else { 1 };
    assert_eq!(output.status.code(), Some(status), "{talk}");
}

#[test]
fn the_python_reader_stays_short_and_needs_the_standard_library_only() {
    let files = [
        include_str!("../../reader.py"),
        include_str!("../../blocks.py"),
        include_str!("../../hashes.py"),
        include_str!("../../metadata.py"),
        include_str!("../../faults.py"),
        include_str!("../../suns.py"),
    ];
    for text in files {
        assert!(text.lines().count() <= 500, "{} lines", text.lines().count());
    }
    let standard = ["array", "decimal", "json", "math", "operator", "re", "struct", "sys", "unicodedata"];
    let beside = ["blocks", "faults", "hashes", "metadata", "suns", "zstandard"];
    for line in files.iter().flat_map(|text| text.lines()) {
        let line = line.trim();
        let modules = match (line.strip_prefix("import "), line.strip_prefix("from ")) {
            (Some(modules), _) => modules.split(", ").collect(),
            (_, Some(rest)) => vec![rest.split(' ').next().expect("split gives one part at least")],
            _ => continue,
        };
        for module in modules {
            assert!(standard.contains(&module) || beside.contains(&module), "{line}");
        }
    }
}
