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

use flb_baker::bake::BakeSettings;
use flb_fixtures::PlantKind;
use flb_runtime::{Library, PhysicalSampler};
use flb_scene::surface_points;
use flb_tests::default_bake::{DefaultBake, grown};
use flb_transport::monte_carlo::judge::suns;

const POINTS: u32 = 2048;
const SUNS: usize = 12;
const MOST_BANDS: usize = 64;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let (library, points) = match &words[..] {
        [path] if path.ends_with(".flb") => {
            let library = Library::open(path).expect("a file");
            let points =
                points_in(&PhysicalSampler::load(&library, 0).expect("a file of the model `physical`"));
            (library, points)
        }
        words => of_plant(words),
    };
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

/// The default bake of a built-in plant, and points of its surface.
fn of_plant(words: &[String]) -> (Library, Vec<[f32; 3]>) {
    let kind = words.first().map_or(PlantKind::Oak, |name| {
        *PlantKind::ALL.iter().find(|kind| kind.name() == name).expect("a built-in plant")
    });
    let number = |at: usize, default| words.get(at).map_or(default, |word| word.parse().expect("a number"));
    let plant = grown(kind, number(1, kind.default_triangles()));
    let settings = BakeSettings { lattice: number(2, 64), ..BakeSettings::default() };
    let baked = DefaultBake::with(plant, &settings);
    let points = surface_points(&baked.mesh, POINTS, settings.ignore_alpha).expect("good textures");
    (baked.library(), points.iter().map(|point| point.position_m).collect())
}

/// Points all over the sites that hold matter.
fn points_in(sampler: &PhysicalSampler) -> Vec<[f32; 3]> {
    let (grid, sites) = (*sampler.grid(), sampler.turbid().sites());
    let point = |i: u32| {
        let site = grid.site(sites[(i as usize).wrapping_mul(2_654_435_761) % sites.len()] as usize);
        let at = [0, 1, 2].map(|axis| f64::from(site[axis]) + f64::from(flb_runtime::offset(i, 0)[axis]));
        grid.model_from_lattice(at).map(|c| c as f32)
    };
    (0..POINTS).map(point).collect()
}
