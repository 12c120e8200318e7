//! Light of one plant at budgets below what it needs, and how it comes:
//!
//! ```text
//! cargo bench -p flb-tests --bench budget -- [FILE.flb | PLANT TRIANGLES LATTICE]
//! ```
//!
//! Under a sun alone, and under a sky alone: how far the mean light over the plant is off once nothing more comes, how
//! far a point is (rms, % of the mean), and the largest change of a point from one frame to the next, where what comes
//! is blended in and where it is not; first of all the mean of some other suns. Without a file the default bake of the
//! built-in oak at lattice 64.

use std::sync::Arc;

use flb_format::sun::towards_sun;
use flb_runtime::Daylight;
use flb_runtime::stream::StreamSettings;
use flb_tests::benched::{Benched, benched};
use flb_tests::budget::streamed;

const POINTS: u32 = 2000;
/// Azimuths and elevations, degrees.
const OTHER_SUNS: [(f64, f64); 6] =
    [(0.0, 90.0), (0.0, 60.0), (60.0, 30.0), (180.0, 10.0), (250.0, 20.0), (300.0, 45.0)];

fn main() {
    let Benched { library, points } = benched(POINTS);
    let library = Arc::new(library);
    let [sun, sky] = [[1.0, 0.0], [0.0, 1.0]].map(|[sun, sky]| Daylight {
        towards_sun: towards_sun(135.0, 40.0),
        sun,
        sky,
    });
    let least = streamed(&library, &points, &sun, u64::MAX, 1).least_bytes;
    println!("least budget of the sun's light: {:.1} MB\n", least as f64 / 1e6);
    println!(
        "Of other suns:\n\n| azimuth | elevation | mean alone | at the least budget |\n|--:|--:|--:|--:|"
    );
    for (azimuth, elevation) in OTHER_SUNS {
        let other = Daylight { towards_sun: towards_sun(azimuth, elevation), ..sun };
        let off = |budget| 100.0 * streamed(&library, &points, &other, budget, 1).mean_off;
        println!("| {azimuth} | {elevation} | {:+.1} % | {:+.1} % |", off(20_000), off(least));
    }
    println!();
    println!(
        "| light | budget | level | lacks | the mean | a point, rms | largest jump, blended | at once |"
    );
    println!("|---|--:|---|--:|--:|--:|--:|--:|");
    for (name, daylight) in [("sun", &sun), ("sky", &sky)] {
        let least = streamed(&library, &points, daylight, u64::MAX, 1).least_bytes;
        for megabytes in [0.02, 0.25, least as f64 / 1e6, 1.0, 2.0, 4.0, 6.0, 8.0, 16.0, 32.0] {
            let budget = (megabytes * 1e6).ceil() as u64;
            let of = streamed(&library, &points, daylight, budget, StreamSettings::default().blend_frames);
            let at_once = streamed(&library, &points, daylight, budget, 1);
            println!(
                "| {name} | {megabytes:.2} MB | {:?} | {:.1} MB | {:+.1} % | {:.0} % | {:.0} % | {:.0} % |",
                of.level,
                of.lacks_bytes as f64 / 1e6,
                100.0 * of.mean_off,
                100.0 * of.rms,
                100.0 * of.largest_jump.0,
                100.0 * at_once.largest_jump.0
            );
        }
    }
}
