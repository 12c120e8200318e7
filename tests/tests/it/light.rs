//! The light inside baked crowns: dark where it is deep, in the sun's order, with nothing inside out.

use std::sync::LazyLock;

use flb_fixtures::PlantKind;
use flb_format::direction::DIRECTIONS;
use flb_format::matter::Class;
use flb_format::{Field, Medium};
use flb_tests::pipeline::Baked;

use crate::plants::baked;

static PLANTS: LazyLock<[&Baked; 3]> =
    LazyLock::new(|| [PlantKind::Oak, PlantKind::Spruce, PlantKind::Shrub].map(baked));

/// Density summed from the lattice's edge to each leaf site (its own left out), against `step`.
fn depths(medium: &Medium, step: [i32; 3]) -> Vec<(usize, f64)> {
    let grid = &medium.grid;
    let inside = |c: i32| (0..grid.lattice as i32).contains(&c);
    let leaf = (0..grid.sites()).filter(|site| medium.class[*site] == Class::Leaf);
    leaf.map(|site| {
        let mut at = grid.site(site).map(|c| c as i32);
        let mut depth = 0.0;
        loop {
            at = [0, 1, 2].map(|axis| at[axis] - step[axis]);
            if !at.into_iter().all(inside) {
                return (site, depth);
            }
            let [x, y, z] = at.map(|c| c as u32);
            depth += f64::from(medium.density[grid.index(x, y, z)]);
        }
    })
    .collect()
}

/// Mean of all bands over some sites.
fn mean(field: &Field, sites: &[(usize, f64)]) -> f64 {
    let bands = (0..field.bands).map(|band| field.band(band));
    let sum: f64 =
        bands.map(|values| sites.iter().map(|(site, _)| f64::from(values[*site])).sum::<f64>()).sum();
    sum / sites.len() as f64 / f64::from(field.bands)
}

/// The third of the leaf sites that is deepest gets less than this share of the light of the third that the
/// light reaches first.
const DEEP_SHARE: f64 = 0.8;

/// Shallow and deep thirds of the leaf sites.
fn thirds(mut depths: Vec<(usize, f64)>) -> [Vec<(usize, f64)>; 2] {
    depths.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let third = depths.len() / 3;
    assert!(third > 20, "a crown has many leaf sites");
    [depths[..third].to_vec(), depths[depths.len() - third..].to_vec()]
}

#[test]
fn light_of_every_direction_is_spent_on_its_way_through_the_crown() {
    for baked in PLANTS.iter() {
        for base in 1..=18u8 {
            let step = DIRECTIONS[base as usize];
            let [shallow, deep] = thirds(depths(&baked.medium, step));
            let [outer, inner] = [mean(baked.field(base), &shallow), mean(baked.field(base), &deep)];
            let name = baked.plant.kind.name();
            assert!(inner < DEEP_SHARE * outer, "{name} base {base}: outside {outer}, inside {inner}");
        }
    }
}

/// Ambient light reaches deep sites from all sides, and at lattice 32 little is absorbed on the way.
const DEEP_SHARE_AMBIENT: f64 = 0.98;

#[test]
fn ambient_light_is_darker_inside_the_crown() {
    for baked in PLANTS.iter() {
        // How deep a site is: the shortest way out of the crown along any direction.
        let mut depth = depths(&baked.medium, DIRECTIONS[1]);
        for direction in &DIRECTIONS[2..] {
            let other = depths(&baked.medium, *direction);
            depth.iter_mut().zip(other).for_each(|(least, other)| least.1 = least.1.min(other.1));
        }
        let [shallow, deep] = thirds(depth);
        let [outer, inner] = [mean(baked.field(0), &shallow), mean(baked.field(0), &deep)];
        let name = baked.plant.kind.name();
        assert!(inner < DEEP_SHARE_AMBIENT * outer, "{name}: outside {outer}, inside {inner}");
    }
}

/// A planted fault: a crown that is inside out, and light that comes from behind, must not pass.
#[test]
fn light_from_the_wrong_side_is_found() {
    let baked = &PLANTS[0];
    let opposite = |base: u8| {
        let back = DIRECTIONS[base as usize].map(|c| -c);
        (1..=18u8).find(|b| DIRECTIONS[*b as usize] == back).expect("every direction has an opposite")
    };
    for base in 1..=18u8 {
        let [shallow, deep] = thirds(depths(&baked.medium, DIRECTIONS[base as usize]));
        let wrong = baked.field(opposite(base));
        assert!(mean(wrong, &deep) > DEEP_SHARE * mean(wrong, &shallow), "base {base}");
    }
}

/// f32 sums of 18 bases.
const AMBIENT_TOLERANCE: f32 = 1e-5;

/// What the ambient base may reach inside (lighting model, section 6: up to 18.8, as sites
/// hold twice as much light on the axes; 18 outside).
const AMBIENT_MOST: f32 = 18.9;

#[test]
fn no_base_holds_more_light_than_all_of_them() {
    for baked in PLANTS.iter() {
        let (name, ambient) = (baked.plant.kind.name(), baked.field(0).values());
        assert_eq!(ambient.iter().find(|value| !(0.0..=AMBIENT_MOST).contains(*value)), None, "{name}");
        for base in 1..=18u8 {
            let light = baked.field(base).values();
            let bad = light.iter().zip(ambient.iter()).find(|(value, all)| !(0.0..=**all).contains(*value));
            assert_eq!(bad, None, "{name} base {base}");
        }
    }
}

#[test]
fn ambient_light_is_the_sum_of_all_directions() {
    for baked in PLANTS.iter() {
        for (i, value) in baked.field(0).values().iter().enumerate() {
            let sum: f32 = (1..=18).map(|base| baked.field(base).values()[i]).sum();
            assert!((sum - value).abs() <= AMBIENT_TOLERANCE * value, "value {i}: {value}, sum {sum}");
        }
    }
}
