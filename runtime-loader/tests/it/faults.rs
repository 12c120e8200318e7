//! Files that are deleted, cut, overwritten and replaced under a forest of an engine.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use flb_format::Codec;
use flb_runtime::forest::{Forest, ForestSettings, PlantId, Report, Work};
use flb_runtime::view::Camera;
use flb_runtime::{Daylight, Library, Placement, Transform};
use flb_testkit::plants::{bytes, three};

const DAY: Daylight = Daylight { towards_sun: [0.6, 0.5, -0.62], sun: 1.2, sky: 0.3 };
/// Frame in which the file changes, and plants come into sight.
const FAULT: usize = 20;
const FRAMES: usize = 300;
/// Frames of a second.
const SECOND: usize = 60;

fn camera(frame: usize) -> Camera {
    Camera {
        position_m: [0.0, 2.0, 12.0],
        forward: [0.0, 0.0, if frame < FAULT { 1.0 } else { -1.0 }],
        up: [0.0, 1.0, 0.0],
        fov_deg: 60.0,
        width_px: 640,
        height_px: 480,
    }
}

/// What a forest told of 300 frames in which a file changes, and whether it was final in the end.
struct Told {
    retried: Vec<usize>,
    given_up: Vec<usize>,
    is_final: bool,
}

fn frames(path: &Path, mut change: impl FnMut(usize, &Path)) -> Told {
    let library = Arc::new(Library::open(path).expect("the file is whole at first"));
    let mut forest = Forest::new(library, ForestSettings::default()).expect("coded near geometry");
    let plant = |species| Placement { species, transform: Transform::IDENTITY };
    let plants: Vec<PlantId> =
        (0..3).map(|species| forest.add(&plant(species)).expect("a species")).collect();
    let mut told = Told { retried: Vec::new(), given_up: Vec::new(), is_final: false };
    for frame in 0..FRAMES {
        change(frame, path);
        let Report { retries, failures, is_final, .. } = forest.frame(&camera(frame), &DAY, Work::run);
        told.retried.extend(retries.iter().map(|_| frame));
        told.given_up.extend(failures.iter().map(|_| frame));
        told.is_final = is_final;
        let snapshot = forest.snapshot();
        for plant in &plants {
            let mut rgb = [0.0; 3];
            assert!(snapshot.at(*plant, [0.1, 2.0, 0.3], &mut rgb));
            assert!(rgb.iter().all(|band| *band > 0.0 && band.is_finite()), "frame {frame}: {rgb:?}");
        }
    }
    told
}

/// Writes over a file in place, as no `flb` does.
fn overwrite(path: &Path, bytes: &[u8]) {
    fs::write(path, bytes).expect("room on the disk");
}

#[test]
fn faults_of_a_file_are_told_within_a_second_and_no_plant_is_black() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("forest.flb");
    let good = bytes(&three(), Codec::Classed);
    let started = || fs::write(&path, &good).expect("room on the disk");
    let once = |change: &dyn Fn(&Path)| {
        started();
        frames(&path, |frame, path| {
            if frame == FAULT {
                change(path)
            }
        })
    };
    // What was opened can be read to its end, whatever the name stands for meanwhile.
    let deleted = once(&|path| fs::remove_file(path).expect("it is there"));
    let other = folder.path().join("other.flb");
    fs::write(&other, [&good[..], &good[..]].concat()).expect("room on the disk");
    let replaced = once(&|path| fs::rename(&other, path).expect("the same folder"));
    for Told { retried, given_up, is_final } in [deleted, replaced] {
        assert!(is_final && retried.is_empty() && given_up.is_empty(), "{retried:?} {given_up:?}");
    }
    // A read that fails is told, tried again, and given up.
    let cut = once(&|path| overwrite(path, &good[..5000]));
    assert!(cut.retried.iter().all(|frame| (FAULT..FAULT + SECOND).contains(frame)), "{:?}", cut.retried);
    assert!(!cut.retried.is_empty() && cut.given_up.is_empty(), "{:?}", cut.given_up);
    // Bytes that are wrong stay wrong.
    let zeroed = [&good[..good.len() / 4], &vec![0; good.len() - good.len() / 4][..]].concat();
    let overwritten = once(&|path| overwrite(path, &zeroed));
    let first = overwritten.given_up.first();
    assert!(first.is_some_and(|frame| (FAULT..FAULT + SECOND).contains(frame)), "{first:?}");
    // A file that is whole again after a while has its light.
    started();
    let mended = frames(&path, |frame, path| match frame {
        FAULT => overwrite(path, &good[..5000]),
        100 => overwrite(path, &good),
        _ => {}
    });
    assert!(mended.is_final && !mended.retried.is_empty() && mended.given_up.is_empty());
}
