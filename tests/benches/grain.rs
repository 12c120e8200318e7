//! The near beam marched from points, as forests do it, against the one prepared for all sites:
//!
//! ```text
//! cargo bench -p flb-tests --bench grain -- [FILE.flb]
//! ```
//!
//! For each number of offsets: how far a point's light is off (rms, % of the mean), and how far the mean is. At points
//! all over the sites that hold matter, under a dozen suns without a sky. Without a file the default bake of the
//! built-in oak at lattice 64.

use flb_baker::bake::BakeSettings;
use flb_fixtures::PlantKind;
use flb_runtime::{Library, PhysicalSampler};
use flb_tests::default_bake::{DefaultBake, grown};
use flb_transport::monte_carlo::judge::suns;

const POINTS: usize = 2048;
const SUNS: usize = 12;
const MOST_BANDS: usize = 64;

fn main() {
    let library = match std::env::args().skip(1).find(|word| !word.starts_with("--")) {
        Some(path) => Library::open(path).expect("a file"),
        None => {
            let plant = grown(PlantKind::Oak, PlantKind::Oak.default_triangles());
            DefaultBake::with(plant, &BakeSettings { lattice: 64, ..BakeSettings::default() }).library()
        }
    };
    let sampler = PhysicalSampler::load(&library, 0).expect("a file of the model `physical`");
    let (near, marcher, grid) = (sampler.near(), sampler.marcher(), *sampler.grid());
    let sites = sampler.turbid().sites();
    let points: Vec<[f32; 3]> = (0..POINTS)
        .map(|i| {
            let site = grid.site(sites[i.wrapping_mul(2_654_435_761) % sites.len()] as usize);
            let part = |axis: usize| f64::from(flb_runtime::offset(i as u32, 0)[axis]);
            let at = [0, 1, 2].map(|axis| f64::from(site[axis]) + part(axis));
            grid.model_from_lattice(at).map(|c| c as f32)
        })
        .collect();
    println!("lattice {}, {} sites that hold matter\n", grid.lattice, sites.len());
    println!("| offsets | a point, rms | the mean |\n|---:|---:|---:|");
    for count in [1, 4, 16, 64] {
        let (mut square, mut bias, mut whole, mut samples) = (0.0, 0.0, 0.0, 0.0);
        for towards_sun in suns(SUNS) {
            let terms = sampler.terms(towards_sun).expect("a direction");
            let prepared = sampler.prepare(&near, terms, flb_format::beam::BEAM_RAYS);
            for (seed, point) in (0u32..).zip(&points) {
                let offsets: Vec<[f32; 3]> = (0..count).map(|i| flb_runtime::offset(seed, i)).collect();
                let marched = marcher.near(*point, terms.towards_sun, &offsets);
                let [mut found, mut expected] = [[0.0; MOST_BANDS]; 2];
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
