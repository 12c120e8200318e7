//! What benches of baked light run on: a file, or a built-in plant.

use flb_baker::bake::BakeSettings;
use flb_fixtures::PlantKind;
use flb_runtime::Library;
use flb_runtime::samplers::PhysicalSampler;
use flb_scene::surface_points::surface_points;

use crate::default_bake::{DefaultBake, grown};

/// Light, and points to ask for it at.
pub struct Benched {
    /// Of one species of the model `physical`.
    pub library: Library,
    /// Of a built-in plant on its surface, even by area; of a file all over its sites, by their extinction.
    pub points: Vec<[f32; 3]>,
}

/// What the words of the command name: `FILE.flb`, or `[PLANT [TRIANGLES [LATTICE]]]`, the default bake of a built-in
/// plant: of the oak at lattice 64.
///
/// # Panics
/// For words that are none of these, and a file of another model.
pub fn benched(points: u32) -> Benched {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    match &words[..] {
        [path] if path.ends_with(".flb") => {
            let library = Library::open(path).expect("a file");
            let points = points_in(&library, points);
            Benched { library, points }
        }
        words => of_plant(words, points),
    }
}

fn of_plant(words: &[String], points: u32) -> Benched {
    let kind = words.first().map_or(PlantKind::Oak, |name| {
        *PlantKind::ALL.iter().find(|kind| kind.name() == name).expect("a built-in plant")
    });
    let number = |at: usize, default| words.get(at).map_or(default, |word| word.parse().expect("a number"));
    let plant = grown(kind, number(1, kind.default_triangles()));
    let settings = BakeSettings { lattice: number(2, 64), ..BakeSettings::default() };
    let baked = DefaultBake::with(plant, &settings);
    let points = surface_points(&baked.mesh, points, settings.ignore_alpha).expect("good textures");
    Benched { library: baked.library(), points: points.iter().map(|point| point.position_m).collect() }
}

fn points_in(library: &Library, count: u32) -> Vec<[f32; 3]> {
    let sampler = PhysicalSampler::load(library, 0).expect("a file of the model `physical`");
    let (grid, sites) = (*sampler.grid(), sampler.turbid().sites());
    let mut sum = 0.0;
    let ends: Vec<f64> = sites
        .iter()
        .map(|site| {
            sum += f64::from(sampler.turbid().extinction(*site as usize));
            sum
        })
        .collect();
    let point = |i: u32| {
        let at = sum * (f64::from(i) + 0.5) / f64::from(count);
        let site = grid.site(sites[ends.partition_point(|end| *end < at)] as usize);
        let at = [0, 1, 2]
            .map(|axis| f64::from(site[axis]) + f64::from(flb_runtime::samplers::offset(i, 0)[axis]));
        grid.model_from_lattice(at).map(|c| c as f32)
    };
    (0..count).map(point).collect()
}
