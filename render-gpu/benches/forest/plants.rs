//! What stands in the benchmark's scenes: grown plants, where they stand, and a file of light.

use flb_fixtures::{PlantKind, grow};
use flb_format::matter::Class;
use flb_format::meta::Bounds;
use flb_format::sun::towards_sun;
use flb_format::{Field, Grid, Medium, Placement, Transform};
use flb_runtime::Library;
use flb_scene::{MaterialClass, Mesh};
use flb_testkit::{crown, grown};

/// Of the materials of [`mesh`].
pub(crate) const CLASSES: [MaterialClass; 2] = [MaterialClass::Wood, MaterialClass::Leaf];
const LATTICE: u32 = 64;

/// A grown plant, as import reads it back.
pub(crate) fn mesh(kind: PlantKind, seed: u64, triangles: u32) -> Mesh {
    let plant = grow(kind, seed, triangles).expect("a count within the limits");
    grown::mesh(&plant, [1.0; 4])
}

/// Evenly spread over a square: the additive sequence of the plastic number.
pub(crate) fn stand(count: usize, species: usize, edge_m: f64) -> Vec<Placement> {
    (0..count)
        .map(|i| {
            let share = |step: f64| (0.5 + step * i as f64).fract();
            let [sin, _, minus_cos] = towards_sun(360.0 * share(0.618_033_988_75), 0.0);
            let rotation = [[-minus_cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, -minus_cos]];
            let [x, z] = [share(0.754_877_666_25), share(0.569_840_290_99)].map(|at| (at - 0.5) * edge_m);
            let scale = 0.8 + 0.4 * share(0.819_172_513_4);
            Placement {
                species: i % species,
                transform: Transform { rotation, position_m: [x, 0.0, z], scale },
            }
        })
        .collect()
}

/// A crown of 16 m made by a formula, shells with gaps and light that falls off inwards, at the default quality.
pub(crate) fn library() -> Library {
    let grid = Grid { lattice: LATTICE, origin_m: [-8.0, -1.0, -8.0], spacing_m: 0.25 };
    let mut medium = Medium::empty(grid);
    let mut bases: Vec<(u8, Field)> = (0..19).map(|base| (base, Field::zeros(LATTICE, 3))).collect();
    for site in 0..grid.sites() {
        let at = grid.site(site).map(|c| f64::from(c) - 31.5);
        let r = length(at);
        let bumps = wave(0.9 * at[0]) * wave(0.7 * at[1]) * wave(0.8 * at[2]);
        if r < 30.0 && bumps > 0.2 {
            (medium.density[site], medium.class[site]) = (0.5, Class::Leaf);
        }
        for (base, field) in &mut bases {
            let towards = at[usize::from(*base) % 3] * if *base % 2 == 1 { -1.0 } else { 1.0 };
            let light = (1.0 + towards / 64.0) * (1.0 + 0.2 * bumps) * if *base == 0 { 9.0 } else { 0.5 };
            for b in 0..3 {
                field.values_mut()[b * grid.sites() + site] = (light * (1.0 - 0.2 * b as f64)) as f32;
            }
        }
    }
    let bounds_m = Bounds { min: [-8.0, -1.0, -8.0], max: [8.0, 15.0, 8.0] };
    let bytes = crown::bytes(bounds_m, medium, bases);
    Library::from_source("crown", Box::new(bytes)).expect("it was written")
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// A triangle wave of period 4.
fn wave(x: f64) -> f64 {
    1.0 - ((x.rem_euclid(4.0)) - 2.0).abs()
}
