use flb_format::Codec;

use super::*;
use crate::plants::{library, library_of_three, three};
use crate::residency::{SpeciesNeed, Units};

const LINK: Link = Link { round_trip_s: 0.05, bandwidth: 10e6, connections: 6 };
const FRAME_S: f64 = 1.0 / 60.0;

fn need_of(library: &Library, bases: impl Fn(usize) -> bool) -> Need {
    let units = Units::new(library.container(), library.path()).expect("coded near geometry");
    let species = (0..units.species()).map(|species| {
        let value = |base: usize| if bases(base) { 1000.0 } else { 0.0 };
        let bases: Vec<f32> = (0..units.bases(species).len()).map(value).collect();
        SpeciesNeed {
            pixels: 1000.0,
            detail: bases.clone(),
            is_now: bases.iter().map(|need| *need > 0.0).collect(),
            bases,
            windows: None,
        }
    });
    Need { species: species.collect() }
}

fn run(library: &Arc<Library>, link: Link, need: impl Fn(usize) -> Need) -> Trace {
    replay(library, ResidencySettings::default(), link, 400, FRAME_S, need).expect("coded near geometry")
}

#[test]
fn a_faster_link_shows_the_picture_sooner_and_brings_the_same_bytes() {
    let library = library_of_three(Codec::Classed);
    let need = need_of(&library, |base| base < 5);
    let traces = [
        run(&library, LINK, |_| need.clone()),
        run(&library, Link { bandwidth: 100e6, ..LINK }, |_| need.clone()),
        run(&library, Link { bandwidth: 100e6, round_trip_s: 0.001, ..LINK }, |_| need.clone()),
    ];
    for pair in traces.windows(2) {
        assert!(pair[0].final_picture_s.expect("it ends") > pair[1].final_picture_s.expect("it ends"));
        assert!(pair[0].first_picture_s.expect("it comes") >= pair[1].first_picture_s.expect("it comes"));
    }
    for trace in &traces {
        assert!(trace.first_picture_s <= trace.final_picture_s);
        assert!(trace.failures.is_empty() && trace.stalls() == (0, 0));
        let last = trace.moments.last().expect("frames");
        assert!((last.quality - 1.0).abs() < 1e-6 && trace.mean_quality() < 1.0);
        assert!(trace.requests() > 3 && trace.bytes() > trace.opening_bytes);
        assert_eq!(trace.peak_bytes(), last.loaded_bytes);
    }
    assert!(traces[0].first_picture_s < traces[0].final_picture_s);
    // No sooner than the link can bring the bytes, after the round trips that depend on one another.
    let slow = &traces[0];
    let least = slow.bytes() as f64 / LINK.bandwidth + LINK.round_trip_s;
    let found = slow.final_picture_s.expect("it ends");
    assert!(
        found >= least && found < least + 6.0 * LINK.round_trip_s + 8.0 * FRAME_S,
        "{found} s, at least {least}"
    );
    // Block maps, then averages, then frames' ends: three round trips to the first picture.
    let first = traces[1].first_picture_s.expect("it comes");
    assert!((3.0 * 0.05..3.0 * 0.05 + 0.1).contains(&first), "{first} s");
}

#[test]
fn a_replay_is_the_same_every_time() {
    let library = library_of_three(Codec::Haar);
    let need = need_of(&library, |base| base % 2 == 0);
    let [a, b] = [0, 1].map(|_| run(&library, LINK, |_| need.clone()));
    assert_eq!(a.moments, b.moments);
}

#[test]
fn new_bases_stall_until_their_averages_are_there() {
    let library = library_of_three(Codec::Classed);
    let (first, second) = (need_of(&library, |base| base < 4), need_of(&library, |base| base >= 4));
    let trace = run(&library, LINK, |frame| if frame < 200 { first.clone() } else { second.clone() });
    let (runs, frames) = trace.stalls();
    // A round trip of 50 ms is three frames.
    assert!(runs == 1 && (3..20).contains(&frames), "{runs} stalls of {frames} frames");
    assert!(trace.moments[200].quality < 0.5 && !trace.moments[200].is_complete);
}

#[test]
fn a_pipe_brings_one_thing_after_another_and_no_sooner_than_a_round_trip() {
    let job = |bytes: u64| Job { units: Vec::new(), ranges: vec![(0, bytes)] };
    let came = |connections: usize| {
        let link = Link { round_trip_s: 1.0, bandwidth: 100.0, connections };
        let mut pipe = Pipe { link, free_s: 0.0, waiting: VecDeque::new(), open: VecDeque::new() };
        for bytes in [50, 100, 10, 20] {
            pipe.send(job(bytes), 0.0);
        }
        let at = |time_s: f64| pipe.until(time_s).iter().map(Job::bytes).collect::<Vec<_>>();
        [1.4, 1.51, 2.59, 2.61, 2.81, 4.0, 9.0].map(at)
    };
    assert_eq!(came(4), [vec![], vec![50], vec![100], vec![10], vec![20], vec![], vec![]]);
    // One at a time: each waits for a round trip of its own.
    assert_eq!(came(1), [vec![], vec![50], vec![], vec![], vec![], vec![100], vec![10, 20]]);
}

#[test]
fn what_came_with_the_tables_is_not_asked_for_again() {
    let ranges = [(0, 10), (90, 20), (100, 5), (300, 7)];
    assert_eq!(beyond(&ranges, 100), [(100, 10), (100, 5), (300, 7)]);
    let job = Job { units: Vec::new(), ranges: Vec::new() };
    let link = Link { round_trip_s: 1.0, bandwidth: 100.0, connections: 2 };
    let mut pipe = Pipe { link, free_s: 5.0, waiting: VecDeque::new(), open: VecDeque::new() };
    pipe.send(job, 0.25);
    assert_eq!((pipe.until(0.2).len(), pipe.until(0.3).len()), (0, 1), "it needs no link");
    let library = library(&three()[1..2], Codec::Classed);
    let need = need_of(&library, |_| true);
    let trace = run(&library, LINK, |_| need.clone());
    assert!(trace.bytes() <= library.container().header().file_bytes, "no byte comes twice");
}
