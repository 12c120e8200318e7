//! Names that a neighbour swaps while they are written, under the guard. A file of its own: the guard reaches every
//! file of the process.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::Write;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use flb_files::{Existing, FileError, guard_inputs, open_own, open_regular, publish, publish_own};
use rustix::fs::{CWD, RenameFlags, renameat_with};

/// Writes while a neighbour swaps names. Without a guard some in a hundred of them replaced what a link leads to.
const ROUNDS: usize = 1000;

fn new(out: &mut dyn Write) -> std::io::Result<()> {
    out.write_all(b"new")
}

/// Lets a file and a link to `precious` swap names without end while `write` writes to the first name.
fn while_swapped(folder: &Path, precious: &Path, write: impl Fn(&Path)) {
    let [name, other, made] = ["output", "other", "made"].map(|name| folder.join(name));
    let is_over = AtomicBool::new(false);
    let is_replaced = thread::scope(|scope| {
        scope.spawn(|| {
            for swap in 0u32.. {
                if is_over.load(Ordering::Relaxed) {
                    return;
                }
                let _ = renameat_with(CWD, &name, CWD, &other, RenameFlags::EXCHANGE);
                // Pauses of many lengths, and none that keeps the folder busy.
                (0..swap * 37 % 4000).for_each(|_| std::hint::spin_loop());
            }
        });
        let is_replaced = (0..ROUNDS).any(|_| {
            // What was written may have replaced either.
            let made_plain = fs::write(&made, b"old").and_then(|()| fs::rename(&made, &name));
            let made_link = symlink(precious, &made).and_then(|()| fs::rename(&made, &other));
            write(&name);
            made_plain.and(made_link).is_err() || !fs::read(precious).is_ok_and(|found| found == b"precious")
        });
        is_over.store(true, Ordering::Relaxed);
        is_replaced
    });
    assert!(!is_replaced);
}

#[test]
fn what_a_link_leads_to_stays_whenever_a_neighbour_puts_it_in_the_place_of_an_artefact() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let precious = folder.path().join("precious");
    fs::write(&precious, b"precious").expect("writable");
    while_swapped(folder.path(), &precious, |name| {
        let _ = publish_own(name, new);
    });
}

#[test]
fn an_input_stays_whenever_a_neighbour_puts_a_link_to_it_in_the_place_of_an_output() {
    guard_inputs();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let input = folder.path().join("input");
    fs::write(&input, b"precious").expect("writable");
    open_regular(&input).expect("it is there");
    // Whether it is written or refused is the neighbour's matter.
    while_swapped(folder.path(), &input, |name| drop(publish(name, Existing::Replace, new)));
}

#[test]
fn an_input_that_is_moved_onto_the_name_during_the_work_is_refused_and_stays() {
    guard_inputs();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [input, output, other] = ["input", "output", "other"].map(|name| folder.path().join(name));
    for own in [false, true] {
        for path in [&input, &output] {
            fs::write(path, b"input").expect("writable");
        }
        open_regular(&input).expect("it is there");
        let swap = |out: &mut dyn Write| {
            fs::rename(&input, &output)?;
            symlink(&output, &input)?; // as its name leads there still
            new(out)
        };
        let refused =
            if own { publish_own(&output, swap) } else { publish(&output, Existing::Replace, swap) };
        let error = refused.expect_err("it is an input");
        assert!(matches!(error, FileError::OutputIsInput { .. }), "{error}");
        assert_eq!(fs::read(&output).expect("it is there"), b"input");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2, "nothing is left behind");
        fs::remove_file(&input).and_then(|()| fs::remove_file(&output)).expect("ours");
    }
    // A link that comes meanwhile is replaced itself.
    fs::write(&input, b"input").expect("writable");
    open_regular(&input).expect("it is there");
    publish(&other, Existing::Keep, new).expect("it is new");
    let link = |out: &mut dyn Write| {
        let _ = fs::remove_file(&output); // it may not be there yet
        symlink(&input, &output)?;
        new(out)
    };
    publish(&output, Existing::Replace, link).expect("the link goes");
    assert_eq!(fs::read(&input).expect("it is there"), b"input");
    assert_eq!(fs::read(&output).expect("it is there"), b"new");
}

#[test]
fn an_input_that_was_read_through_a_link_is_refused_after_the_link_is_gone() {
    guard_inputs();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [input, link, output] = ["input", "link", "output"].map(|name| folder.path().join(name));
    fs::write(&input, b"input").and_then(|()| symlink(&input, &link)).expect("writable");
    open_regular(&link).expect("it is there");
    fs::remove_file(&link).and_then(|()| symlink(&input, &output)).expect("links work");
    publish(&output, Existing::Replace, new).expect_err("it is an input");
    // Its number may go to another file, which is an input too, or none.
    for round in 0..50 {
        let (first, second) =
            (folder.path().join(format!("a{round}")), folder.path().join(format!("b{round}")));
        fs::write(&first, b"first").expect("writable");
        open_regular(&first).expect("it is there");
        fs::remove_file(&first).expect("it is ours");
        fs::write(&second, b"second").expect("writable");
        publish(&second, Existing::Replace, new).expect("it is no input");
        open_regular(&second).expect("it is there");
        publish(&second, Existing::Replace, new).expect_err("it is an input");
    }
}

#[test]
fn an_input_in_a_cache_is_not_replaced_by_an_artefact_of_its_name() {
    guard_inputs();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [input, hard, output, artefact] =
        ["light-1.artefact", "light-2.artefact", "light-3.artefact", "light-4.artefact"]
            .map(|name| folder.path().join(name));
    fs::write(&input, b"input").and_then(|()| fs::hard_link(&input, &hard)).expect("writable");
    open_own(&input).expect("the cache takes it for an artefact");
    publish_own(&artefact, new).expect("it is new");
    open_own(&artefact).expect("it is there");
    publish_own(&artefact, new).expect("a cache replaces what is its own");
    open_regular(&input).expect("it is there");
    publish(&output, Existing::Keep, new).expect("it is new");
    for name in [&input, &hard, &output] {
        let error = publish_own(name, new).expect_err("it is the user's");
        assert!(error.is_usage(), "{error}");
    }
    assert_eq!(fs::read(&input).expect("it is there"), b"input");
    let link = folder.path().join("light-5.artefact");
    symlink(&artefact, &link).expect("links work");
    let error = open_own(&link).expect_err("a link").to_string();
    assert_eq!(error, "found a link, expected a regular file");
    let error = publish(&artefact, Existing::Replace, new).expect_err("it is no output");
    assert!(error.is_usage(), "{error}");
}
