//! All ways to find what a ray meets, against each other and against looking at everything.

use flb_format::{Placement, Transform};

use super::*;
use crate::forest::{fragments::Fragment, placed::WorldRay, trace::PlantHit};

/// Plants of all kinds, turned any way, scaled, some on the same spot, some coincident.
fn stand(count: u32, tilted: bool) -> Vec<Placement> {
    let mut instances: Vec<Placement> = (0..count)
        .map(|i| {
            let [x, z] = crate::r2_sequence(1, i).map(f64::from);
            let [turn, size] = crate::r2_sequence(2, i).map(f64::from);
            let turned = DMat3::from_rotation_y(turn * std::f64::consts::TAU);
            let tilt = DMat3::from_rotation_x(if tilted { size * 2.0 - 1.0 } else { 0.0 });
            Placement {
                species: i as usize % 3,
                transform: Transform {
                    rotation: (tilt * turned).transpose().to_cols_array_2d(),
                    position_m: [40.0 * x - 20.0, turn - 0.5, 40.0 * z - 20.0],
                    scale: 0.5 + size,
                },
            }
        })
        .collect();
    instances.extend_from_within(..3);
    instances
}

fn meshes() -> [Mesh; 3] {
    [grown(PlantKind::Oak, 2_000), grown(PlantKind::Spruce, 1_500), grown(PlantKind::Shrub, 800)]
}

pub(super) fn ways() -> Vec<Search> {
    let (models, grids) =
        ([ModelSearch::Tree, ModelSearch::Grid], [InstanceSearch::Tree, InstanceSearch::Grid]);
    models
        .into_iter()
        .flat_map(|model| grids.map(|primary| (model, primary)))
        .flat_map(|(model, primary)| grids.map(|shadow| Search { model, primary, shadow }))
        .collect()
}

fn prepared<'a>(meshes: &'a [Mesh], instances: &[Placement], search: Search) -> Forest<'a> {
    let classes: &[MaterialClass] = &[MaterialClass::Wood, MaterialClass::Leaf];
    let species: Vec<Species> = meshes.iter().map(|mesh| paper(mesh, classes)).collect();
    let ground = Ground { land: Land::Plane { height_m: 0.0 }, color: [0.3; 3], fades_at_m: None };
    Forest::prepare(&species, instances, Some(ground), search).unwrap()
}

/// The nearest plant by looking at every instance.
fn nearest_of_all(forest: &Forest, ray: &WorldRay) -> Option<PlantHit> {
    let mut best: Option<PlantHit> = None;
    for (index, placed) in (0u32..).zip(&forest.instances) {
        let model = &forest.models[placed.placement.species];
        let Some(inside) = placed.enter(ray, &model.hull) else { continue };
        let Some(found) = model.find(inside.ray, f32::INFINITY) else { continue };
        let distance_m = placed.world_distance(&inside, found.distance);
        if best.as_ref().is_none_or(|met| distance_m < met.distance_m) {
            best = Some(PlantHit { distance_m, instance: index, found });
        }
    }
    best
}

#[test]
fn every_way_finds_the_same_triangles_at_the_same_distances_and_the_same_shadows() {
    let meshes = meshes();
    let ask = |LightQuery { instance, point, .. }: LightQuery, phi: &mut [f32; 3]| {
        *phi = [0.01 * instance as f32, 0.02 * point[1].abs(), 0.1];
    };
    // From outside, from within the stand, and from above it.
    let eyes = [[0.0, 6.0, 60.0], [2.0, 1.7, 3.0], [1.0, 50.0, 1.0]];
    for (tilted, position_m) in [(false, eyes[0]), (true, eyes[1]), (false, eyes[1]), (true, eyes[2])] {
        let instances = stand(40, tilted);
        let eye = Eye { position_m, look_at_m: [0.0, 5.0, 0.0], fov_deg: 50.0 };
        let view = View { eye, width: 60, height: 50, samples: 2, sky_rays: 1, time_s: 0.0 };
        let daylight = Setup { sun: [0.7, 0.5, 0.2], ..Setup::default() };
        let mut first = None;
        for search in ways() {
            let forest = prepared(&meshes, &instances, search);
            let fragments = forest.trace(&view, &|_| Ok(())).unwrap();
            let picture = forest
                .relight(&fragments, &daylight.lighting(), &daylight.look(), &ask, &|_| Ok(()))
                .unwrap();
            let all: Vec<Fragment> =
                fragments.squares().flat_map(|square| square.fragments.iter().copied()).collect();
            let (expected, expected_picture) = first.get_or_insert((all.clone(), picture.clone()));
            let differs = all.iter().zip(expected.iter()).position(|(a, b)| a != b);
            assert_eq!(differs, None, "{search:?} from {position_m:?}");
            assert!(&picture == expected_picture, "{search:?} from {position_m:?}: shadows differ");
            assert!(fragments.counts()[0] > 500, "{:?}", fragments.counts());
        }
    }
}

#[test]
fn the_tree_finds_what_looking_at_every_instance_finds() {
    let meshes = meshes();
    let forest = prepared(&meshes, &stand(60, true), Search::default());
    let mut met = 0;
    for i in 0..4_000 {
        let [x, z] = crate::r2_sequence(3, i).map(|v| f64::from(v) * 60.0 - 30.0);
        let [u, v] = crate::r2_sequence(4, i).map(f64::from);
        let direction = DVec3::new(u - 0.5, 0.3 - v, libm::sin(f64::from(i))).normalize();
        let ray = WorldRay { origin: DVec3::new(x, 12.0 * v, z), direction };
        let expected = nearest_of_all(&forest, &ray);
        assert_eq!(forest.nearest(&ray), expected, "ray {i}");
        assert_eq!(forest.is_hidden(&ray), expected.is_some(), "ray {i}");
        met += usize::from(expected.is_some());
    }
    assert!(met > 1_000, "{met}");
}

#[test]
fn of_two_plants_on_the_same_spot_the_first_is_seen() {
    let meshes = meshes();
    let twice = [at_m([0.0; 3]), at_m([0.0; 3])];
    for search in ways() {
        let forest = prepared(&meshes, &twice, search);
        let fragments = forest.trace(&view([0.0, 5.0, 0.0]), &|_| Ok(())).unwrap();
        let all = fragments.squares().flat_map(|square| &square.fragments);
        let instances: Vec<u32> = all
            .filter_map(|fragment| match fragment {
                Fragment::Plant { instance, .. } => Some(*instance),
                _ => None,
            })
            .collect();
        assert!(instances.len() > 50 && instances.iter().all(|instance| *instance == 0), "{search:?}");
    }
}

#[test]
fn a_picture_does_not_depend_on_the_threads() {
    let meshes = meshes();
    let forest = prepared(&meshes, &stand(20, false), Search::default());
    let view = View { width: 70, height: 45, samples: 3, sky_rays: 2, ..view([0.0, 5.0, 0.0]) };
    let shoot = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| super::shoot(&forest, &view, &Setup { indirect: Indirect::On, ..plain() }))
    };
    assert_eq!(shoot(1), shoot(5));
}
