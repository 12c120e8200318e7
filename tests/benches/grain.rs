//! The near beam marched from points, as forests do it, against the one prepared for all sites:
//!
//! ```text
//! cargo bench -p flb-tests --bench grain                      # the default bake of the built-in oak at lattice 64
//! cargo bench -p flb-tests --bench grain -- FILE.flb          # points all over the sites that hold matter
//! cargo bench -p flb-tests --bench grain -- PLANT TRIANGLES [LATTICE]
//! ```
//!
//! For each number of offsets: how far a point's light is off (rms, % of the mean), and how far the mean is. At points
//! of the plant's surface, even by area, under a dozen suns without a sky.

use flb_runtime::samplers::PhysicalSampler;
use flb_tests::benched::{Benched, benched};
use flb_transport::monte_carlo::judge::suns;

const POINTS: u32 = 2048;
const SUNS: usize = 12;
const MAX_BANDS: usize = 64;

fn main() {
    let Benched { library, points } = benched(POINTS);
    let sampler = PhysicalSampler::load(&library, 0).expect("a file of the model `physical`");
    let (near, marcher) = (sampler.near(), sampler.marcher());
    println!(
        "lattice {}, {} sites that hold matter\n",
        sampler.grid().lattice,
        sampler.turbid().sites().len()
    );
    println!("| offsets | a point, rms | the mean |\n|---:|---:|---:|");
    for count in [1, 4, 16, 64] {
        let (mut square, mut bias, mut whole, mut samples) = (0.0, 0.0, 0.0, 0.0);
        for (first_seed, towards_sun) in (0..).step_by(POINTS as usize).zip(suns(SUNS)) {
            let terms = sampler.terms(towards_sun).expect("a direction");
            let prepared = sampler.prepare(&near, terms, flb_format::beam::BEAM_RAYS);
            for (seed, point) in (first_seed..).zip(&points) {
                let offsets: Vec<[f32; 3]> =
                    (0..count).map(|i| flb_runtime::samplers::offset(seed, i)).collect();
                let marched = marcher.near(*point, terms.towards_sun, &offsets);
                let [mut found, mut expected] = [[0.0; MAX_BANDS]; 2];
                let bands = sampler.bands();
                sampler.fluence_of(&terms, marched, 1.0, 0.0, *point, &mut found[..bands]);
                sampler.fluence(&prepared, 1.0, 0.0, *point, &mut expected[..bands]);
                for (found, expected) in found[..bands].iter().zip(&expected[..bands]) {
                    let off = f64::from(found - expected);
                    (square, bias) = (square + off * off, bias + off);
                    (whole, samples) = (whole + f64::from(*expected), samples + 1.0);
                }
            }
        }
        let mean: f64 = whole / samples;
        let (rms, of_mean) = ((square / samples).sqrt() / mean, bias / whole);
        println!("| {count} | {:.1} % | {:+.1} % |", 100.0 * rms, 100.0 * of_mean);
    }
}
