//! Figures 4.5 and 5.1 of Steele's dissertation, which no command of `flb` draws: light sampled at the nearest site,
//! and how many of neighbouring fragments share a block. `scripts/papers` calls it.
//!
//! `cargo run --release -p flb-tests --example figures -- PLANT.flb PLANT.glb OUT` takes a `paper` file.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use flb_format::sun::towards_sun;
use flb_format::{Daylight, Grid, Placement, Transform};
use flb_render::forest::{Eye, Forest, Fragment, Search, View};
use flb_render::picture::png_of;
use flb_render::{Indirect, LightQuery, Lighting, Look, Picture, Shading, Species};
use flb_runtime::{Library, SpeciesLight};
use flb_scene::rays::TriangleHit;
use flb_scene::{ClassRules, ClassedMesh, ImportSettings, Mesh, PlantReader};

/// Pixels along an edge of the picture.
const EDGE: u32 = 240;
/// Sites between the first ones of neighbouring blocks: each holds one layer more (P 4.2).
const STRIDE: f64 = 3.0;
/// Pixels along the edge of a thread block of the papers' renderer, 64 threads.
const TILE: u32 = 8;
/// Factor on the ambient base, as `flb render` has it.
const SKY: f32 = 0.02;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [file, mesh, out] = &words[..] else { panic!("expected PLANT.flb PLANT.glb OUT, found {words:?}") };
    let library = Library::open(Path::new(file)).unwrap_or_else(|error| panic!("{error}"));
    let light = SpeciesLight::load(&library, 0).unwrap_or_else(|error| panic!("{error}"));
    let grid = library.container().species()[0].meta.grid;
    let reader = PlantReader::new(None, ImportSettings::default(), ClassRules::default());
    let (mesh, _) = reader.read(Path::new(mesh)).unwrap_or_else(|error| panic!("{error}"));
    let write =
        |name: &str, png: Vec<u8>| fs::write(Path::new(out).join(name), png).expect("it can be written");
    let near = Shot::new(&mesh, 0.35);
    for (name, site) in [("4.5-nearest.png", Some(&grid)), ("4.5-linear.png", None)] {
        write(name, near.lit(&light, site).to_png(0.0).expect("a picture"));
    }
    for (name, distance) in [("5.1-near.png", 0.35), ("5.1-far.png", 1.6)] {
        let (pixels, shared) = Shot::new(&mesh, distance).coherence(&mesh.mesh, &grid);
        println!(
            "{name}: {:.0} % of the fragments share a block with one before them in their tile",
            100.0 * shared
        );
        write(name, png_of([EDGE; 2], &pixels).expect("a picture"));
    }
}

/// A plant before a camera.
struct Shot<'m> {
    forest: Forest<'m>,
    view: View,
}

impl<'m> Shot<'m> {
    /// From so many sizes of the plant.
    fn new(mesh: &'m ClassedMesh, distance: f64) -> Shot<'m> {
        let species = Species { mesh: &mesh.mesh, classes: &mesh.classes, shading: Shading::Paper };
        let plant = Placement { species: 0, transform: Transform::IDENTITY };
        let forest = Forest::prepare(&[species], &[plant], None, Search::default()).expect("a sound plant");
        let [min, max] = forest.bounds_m();
        let size = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
        let middle: [f64; 3] = std::array::from_fn(|axis| (min[axis] + max[axis]) / 2.0);
        let crown = [middle[0], middle[1] + 0.1 * size, max[2]];
        let eye = Eye {
            position_m: [crown[0], crown[1], crown[2] + distance * size],
            look_at_m: crown,
            fov_deg: 40.0,
        };
        Shot { forest, view: View { eye, width: EDGE, height: EDGE, samples: 1, sky_rays: 0, time_s: 0.0 } }
    }

    /// Indirect light alone, of the site that is nearest to a point if there are sites, else between them.
    fn lit(&self, light: &SpeciesLight, nearest: Option<&Grid>) -> Picture {
        let daylight = Daylight { towards_sun: towards_sun(200.0, 50.0), sun: 1.0, sky: SKY };
        let lit = light.lit_by(&daylight, &Transform::IDENTITY).expect("all bases are there");
        let look = Look { indirect: Indirect::Only, indirect_scale: 1.0, ..Look::default() };
        let phi = |LightQuery { point, facing, .. }: LightQuery, out: &mut [f32; 3]| {
            let point = nearest.map_or(point, |grid| middle_of_site(grid, point));
            lit.at_facing(point, facing, out);
        };
        let lighting = Lighting::of(daylight);
        self.forest.render(&self.view, &lighting, &look, &phi, &|_| Ok(())).expect("a finite light")
    }

    /// Green where a fragment's block was asked for before in its tile, red where not; and the share of the green ones.
    fn coherence(&self, mesh: &Mesh, grid: &Grid) -> (Vec<u8>, f64) {
        let fragments = self.forest.trace(&self.view, &|_| Ok(())).expect("a sound view");
        let mut asked = HashSet::new();
        let (mut pixels, mut counts) = (Vec::new(), [0, 0]);
        for (y, x) in (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (y, x))) {
            let color = match fragments.at(x, y, 0) {
                Some(Fragment::Plant { found, .. }) => {
                    let block = block_of(grid, point_of(mesh, &found));
                    let is_first = asked.insert(([x / TILE, y / TILE], block));
                    counts[usize::from(is_first)] += 1;
                    if is_first { [200, 40, 30] } else { [50, 160, 60] }
                }
                _ => [255; 3],
            };
            pixels.extend(color);
        }
        (pixels, f64::from(counts[0]) / f64::from(counts[0] + counts[1]))
    }
}

fn point_of(mesh: &Mesh, found: &TriangleHit) -> [f32; 3] {
    let [a, b, c] = mesh.triangles[found.triangle as usize].map(|vertex| mesh.positions[vertex as usize]);
    let [u, v] = found.weights;
    std::array::from_fn(|axis| a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis]))
}

/// The block that holds the eight sites around a point.
fn block_of(grid: &Grid, point: [f32; 3]) -> [i64; 3] {
    std::array::from_fn(|axis| {
        let below = (f64::from(point[axis]) - grid.origin_m[axis]) / grid.spacing_m - 0.5;
        (below.floor() / STRIDE).floor() as i64
    })
}

fn middle_of_site(grid: &Grid, point: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| {
        let site = ((f64::from(point[axis]) - grid.origin_m[axis]) / grid.spacing_m).floor();
        (grid.origin_m[axis] + (site + 0.5) * grid.spacing_m) as f32
    })
}
