//! A plant in a clay pot with the sun behind: the wall that a viewer sees has the light of the sky alone.
//!
//! `FLB_WRITE_GOLDEN=1 cargo test -p flb-tests --test it pot::` writes the golden picture anew.

use std::sync::LazyLock;

use flb_fixtures::{PlantKind, grow, potted};
use flb_format::sun::towards_sun;
use flb_render::Picture;
use flb_scene::{ClassRules, PlantReader};
use flb_tests::default_bake::DefaultBake;
use flb_tests::pipeline::{SEED, import_glb};
use flb_tests::portrait::light_of;

use crate::beside_paths::{check_golden, relit_and_traced};

static POT: LazyLock<DefaultBake> = LazyLock::new(|| {
    let glb = potted(grow(PlantKind::Shrub, SEED, 6_000).expect("a good count")).to_glb();
    let wood = ["clay", "soil"].map(str::to_owned).to_vec();
    let reader =
        PlantReader { rules: ClassRules { wood, ..ClassRules::default() }, ..PlantReader::default() };
    let (classed, _) = reader.class(import_glb("pot", &glb)).expect("a pattern names every material");
    DefaultBake::of_plant(reader.plant("pot".to_owned(), classed))
});

/// Columns and rows of the pot's outer wall below its rim.
const WALL: [std::ops::Range<usize>; 2] = [42..56, 80..90];

fn of_wall(picture: &Picture) -> [f64; 3] {
    let [columns, rows] = WALL;
    let pixels =
        rows.flat_map(|row| columns.clone().map(move |column| row * picture.width as usize + column));
    let mut sum = [0.0; 3];
    for pixel in pixels {
        for (sum, value) in sum.iter_mut().zip(&picture.rgb[3 * pixel..][..3]) {
            *sum += f64::from(*value);
        }
    }
    sum
}

#[test]
fn a_pot_before_the_sun_has_the_light_of_paths_on_its_wall_and_is_golden() {
    let pictures = relit_and_traced(&POT, towards_sun(0.0, 20.0));
    for (name, of, bound) in [("all", light_of as fn(&Picture) -> [f64; 3], 0.08), ("wall", of_wall, 0.04)] {
        let [ours, truth] = pictures.each_ref().map(of);
        println!("{name}: {:.3?}", [0, 1, 2].map(|band| ours[band] / truth[band]));
        for band in 0..3 {
            assert!((ours[band] / truth[band] - 1.0).abs() < bound, "{name}: {ours:?}, traced {truth:?}");
        }
    }
    check_golden("pot", &pictures);
}
